# SPDX-License-Identifier: BSD-3-Clause
"""Runs with stages that are stopped and resumed, and runs that go on from a stored stage."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import assert_same_results, run_in_pieces
from staged_problems import KINDS, staged_entries

from tilth import BadInput, Model, resume, run
from tilth.analysis.stored_run import CHECKPOINT_FORMAT
from tilth.cli import run_command
from tilth.output import read_checkpoint, read_results, write_checkpoint

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of uninterrupted runs of each kind."""
    folders = {kind: tmp_path_factory.mktemp("whole") / "out" for kind in KINDS}
    for kind, folder in folders.items():
        run(Model.from_dict(staged_entries(kind)), folder, quiet=True)
    return folders


@pytest.mark.parametrize("kind", KINDS)
def test_resumed_after_a_step_of_any_stage(
    kind: str, whole: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last step of each stage among them: the next stage begins from its checkpoint."""
    model = Model.from_dict(staged_entries(kind))
    run_in_pieces(model, tmp_path / "out", range(1, 10), monkeypatch)
    assert_same_results(whole[kind], tmp_path / "out")


SLOW = """
import sys, time
from tilth.mpm.soil import Soil
from tilth.cli import run_command
update = Soil.update
def slowly(self, *arguments):
    time.sleep(0.02)
    update(self, *arguments)
Soil.update = slowly
sys.exit(run_command(["run", sys.argv[1], "--out", sys.argv[2], "--quiet"]))
"""


@pytest.mark.parametrize("step", [1, 3, 5, 7, 9])
def test_killed_in_each_stage(step: int, whole: dict[str, Path], tmp_path: Path) -> None:
    """SIGKILL, at a moment that no part of the program knows of."""
    case, out = tmp_path / "case.toml", tmp_path / "out"
    case.write_text(as_toml(staged_entries()))
    process = subprocess.Popen(
        [sys.executable, "-c", SLOW, str(case), str(out)],
        env={**os.environ, "OMP_WAIT_POLICY": "passive"},
    )
    history, end = out / "history.csv", time.monotonic() + 60
    try:
        while not (out / "checkpoint.npz").exists() or history.read_text().count("\n") < step + 2:
            assert process.poll() is None
            assert time.monotonic() < end, "the run makes no progress"
            time.sleep(0.002)
        time.sleep(0.01 * step % 0.05)
        assert process.poll() is None
    finally:
        process.kill()
        process.wait()
    assert run_command(["resume", str(out), "--quiet"]) == 0
    assert_same_results(whole["plane_strain"], out)


@pytest.mark.parametrize("until", [1.0, 2.5, 4.0, 5.5])
def test_stopped_at_a_total_time(until: float, whole: dict[str, Path], tmp_path: Path) -> None:
    model = Model.from_dict(staged_entries())
    result = run(model, tmp_path / "out", until=until, quiet=True)
    assert not result.finished
    assert resume(tmp_path / "out", quiet=True).finished
    assert_same_results(whole["plane_strain"], tmp_path / "out")


@pytest.mark.parametrize("stage", ["weight", "dig", "fill", "press"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_run_from_a_stage_is_the_same_run(
    kind: str, stage: str, whole: dict[str, Path], tmp_path: Path
) -> None:
    model = Model.from_dict(staged_entries(kind))
    run(model, tmp_path / "new", from_stage=(whole[kind], stage), quiet=True)
    assert_same_results(whole[kind], tmp_path / "new")


def changed(**entries: Any) -> Model:
    """The staged problem with another stage "press"."""
    whole = staged_entries()
    whole["stages"][3].update(entries)
    return Model.from_dict(whole)


def test_a_changed_later_stage_runs_from_a_stored_stage(
    whole: dict[str, Path], tmp_path: Path
) -> None:
    """As if the changed case had been run from its start."""
    model = changed(factors={"footing": [[0.0, 0.0], [1.0, 0.5]]}, materials={})
    run(model, tmp_path / "new", from_stage=(whole["plane_strain"], "fill"), quiet=True)
    run(model, tmp_path / "start", quiet=True)
    assert_same_results(tmp_path / "start", tmp_path / "new")


def test_later_stages_may_bring_other_state_variables(
    whole: dict[str, Path], tmp_path: Path
) -> None:
    entries = staged_entries()
    entries["materials"]["wet"] = {
        **entries["materials"]["firm"], "pore_fluid_bulk_modulus": 5000.0
    }  # fmt: skip
    entries["stages"][3]["materials"] = {"soil": "wet"}
    model = Model.from_dict(entries)
    run(model, tmp_path / "new", from_stage=(whole["plane_strain"], "fill"), quiet=True)
    fields = [state.point_fields["excess_pore_pressure"] for state in read_results(
        tmp_path / "new" / "results.vtkhdf"
    )]  # fmt: skip
    assert np.isnan(fields[0]).all()
    assert np.isfinite(fields[-1]).any()


def test_killed_and_resumed_after_going_on(
    whole: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = Model.from_dict(staged_entries())
    run(model, tmp_path / "new", from_stage=(whole["plane_strain"], "dig"), until=3.5, quiet=True)
    resume(tmp_path / "new", quiet=True)
    assert_same_results(whole["plane_strain"], tmp_path / "new")


def earlier_schedule(entries: dict[str, Any]) -> None:
    entries["stages"][1]["schedule"] = {"steps": 3, "end": 2.0}


def earlier_load(entries: dict[str, Any]) -> None:
    entries["loads"][0]["acceleration"] = [0.0, -9.0]


def earlier_body(entries: dict[str, Any]) -> None:
    entries["bodies"][0]["points_per_cell"] = 3


def used_material(entries: dict[str, Any]) -> None:
    entries["materials"]["soil"]["density"] = 2.0


def other_track(entries: dict[str, Any]) -> None:
    entries["track"].pop()


def no_later_stage(entries: dict[str, Any]) -> None:
    del entries["stages"][3:]
    entries["boundaries"].pop()
    entries["loads"].pop()


@pytest.mark.parametrize(
    ("change", "key"),
    [
        (earlier_schedule, "stages[1]"),
        (earlier_load, "stages[0]"),
        (earlier_body, "stages[0]"),
        (used_material, "stages[0]"),
        (other_track, "track"),
        (no_later_stage, "loads"),
    ],
)
def test_a_change_before_the_stored_stage_is_refused(
    change: Any, key: str, whole: dict[str, Path], tmp_path: Path
) -> None:
    entries = staged_entries()
    change(entries)
    with pytest.raises(BadInput) as caught:
        run(
            Model.from_dict(entries), tmp_path / "new", quiet=True,
            from_stage=(whole["plane_strain"], "fill"),
        )  # fmt: skip
    assert caught.value.problems[0].key == key
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("start", "words"),
    [
        ("{folder}:fil", "did you mean `fill`?"),
        ("{folder}", "does not name a folder and a stage"),
        ("{folder}x:fill", "there is no such folder"),
        ("{folder}:wall away", "the case has no stage after 'wall away'"),
    ],
)
def test_wrong_places_to_go_on_from(
    start: str, words: str, whole: dict[str, Path], tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    case = tmp_path / "case.toml"
    case.write_text(as_toml(staged_entries()))
    start = start.format(folder=whole["plane_strain"])
    code = run_command(["run", str(case), "--from", start, "--out", str(tmp_path / "new")])
    assert code == 2
    assert words in capsys.readouterr().err


def test_it_does_not_go_on_in_the_same_folder(whole: dict[str, Path], tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(whole["plane_strain"], folder)
    with pytest.raises(BadInput, match="into the folder from which it goes on"):
        run(
            Model.from_dict(staged_entries()), folder, overwrite=True, quiet=True,
            from_stage=(folder, "fill"),
        )  # fmt: skip
    assert_same_results(whole["plane_strain"], folder)


@pytest.mark.parametrize("version", [None, 3, 99])
def test_a_checkpoint_of_another_format_is_refused(
    version: int | None, whole: dict[str, Path], tmp_path: Path
) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(whole["plane_strain"], folder)
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    del meta["format"]
    write_checkpoint(
        folder / "checkpoint.npz", arrays, meta if version is None else meta | {"format": version}
    )
    reads = rf"this version of tilth .* reads format {CHECKPOINT_FORMAT}\b"
    with pytest.raises(BadInput, match=reads):
        resume(folder, quiet=True)


def as_toml(entries: dict[str, Any]) -> str:
    """The entries as the text of a case file."""
    lines: list[str] = ["format = 1"]
    tables: list[str] = []
    for key, value in entries.items():
        if isinstance(value, list):
            for each in value:
                tables += [f"[[{key}]]", *(f"{k} = {toml(v)}" for k, v in each.items())]
        elif isinstance(value, dict):
            tables += [f"[{key}]", *(f"{k} = {toml(v)}" for k, v in value.items())]
        else:
            lines.append(f"{key} = {toml(value)}")
    return "\n".join([*lines, *tables]) + "\n"


def toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(each)}" for key, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(each) for each in value) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if not isinstance(value, str) else f'"{value}"'
