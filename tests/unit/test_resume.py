# SPDX-License-Identifier: BSD-3-Clause
"""A resumed run ends in the same bits as one that was never interrupted."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import (
    Stopped,
    assert_same_results,
    checkpoint_of,
    datasets,
    entries_of,
    run_in_pieces,
    run_until,
    stopped_after,
)
from small_problems import (
    BASES,
    CORNER_BASES,
    KINDS,
)

import tilth.analysis.run
from tilth import BadInput, Model, resume, run
from tilth.analysis.step_result import StepResult
from tilth.cli import run_command
from tilth.output import read_checkpoint, read_history, read_results, write_checkpoint

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def model() -> Model:
    return Model.from_dict(entries_of())


@pytest.fixture(scope="module")
def uninterrupted(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("uninterrupted") / "out"
    result = run(model, folder, quiet=True)
    assert result.points.plastic[:, 0].max() > 1e-2
    return folder


def number_of_steps(folder: Path) -> int:
    return len((folder / "history.csv").read_text().splitlines()) - 2


def test_the_case_is_worth_resuming(uninterrupted: Path) -> None:
    """More steps than regular and output times: a step was cut, and grew again."""
    assert number_of_steps(uninterrupted) >= 10
    log = (uninterrupted / "log.txt").read_text()
    assert "no equilibrium" in log or "inverted" in log


@pytest.mark.parametrize("steps", [range(1, 10), [6]])
def test_resumed_after_a_step(
    steps: list[int], model: Model, uninterrupted: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    result = run_in_pieces(model, tmp_path / "out", steps, monkeypatch)
    assert result.steps == number_of_steps(uninterrupted) - steps[-1]
    assert_same_results(uninterrupted, tmp_path / "out")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_resumed_with_every_kind_and_basis(
    kind: str, basis: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where domains have corners, those in the results are the state's, also after a resume."""
    model = Model.from_dict(entries_of(kind, basis))
    points = run(model, tmp_path / "whole", quiet=True).points
    run_until(model, tmp_path / "out", 4, monkeypatch)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")
    last = read_results(tmp_path / "out" / "results.vtkhdf").snapshot(-1)
    assert ("domain_corners" in last.point_fields) == (basis in CORNER_BASES)
    if basis in CORNER_BASES:
        order = np.argsort(points.point_id)
        np.testing.assert_array_equal(last.point_fields["domain_corners"], points.corner[order])
        assert np.ptp(points.corner, axis=0).max() > 1e-4  # domains differ by now


def test_resumed_twice_and_from_rare_checkpoints(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps after the last checkpoint are dropped from all files and computed again."""
    entries = entries_of()
    entries["output"]["checkpoint_every"] = 3
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "out", 5, monkeypatch)
    assert number_of_steps(tmp_path / "out") == 5
    stopped_after(7, monkeypatch, lambda: resume(tmp_path / "out", quiet=True))
    resume(tmp_path / "out", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "out")


def test_resuming_a_finished_run_changes_nothing(uninterrupted: Path, tmp_path: Path) -> None:
    shutil.copytree(uninterrupted, tmp_path / "out")
    result = resume(tmp_path / "out", quiet=True)
    assert result.steps == 0
    assert_same_results(uninterrupted, tmp_path / "out")


def test_failure_in_the_middle_of_a_step_is_resumable(
    model: Model, uninterrupted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tilth.mpm.soil import Soil

    calls = 0
    update = Soil.update

    def fail(self: Soil, *arguments: Any) -> None:
        nonlocal calls
        calls += 1
        if calls == 20:
            raise Stopped
        update(self, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(Soil, "update", fail)
        with pytest.raises(Stopped):
            run(model, tmp_path / "out", quiet=True)
    assert 1 < number_of_steps(tmp_path / "out") < number_of_steps(uninterrupted)
    resume(tmp_path / "out", quiet=True)
    assert_same_results(uninterrupted, tmp_path / "out")


def test_keyboard_interrupt_is_logged_and_resumable(
    model: Model, uninterrupted: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    advance = tilth.analysis.simulation.Simulation.advance

    def interrupt(self: Any, before: float, after: float, *more: Any) -> StepResult:
        if before >= 0.5:
            raise KeyboardInterrupt
        return advance(self, before, after, *more)

    with monkeypatch.context() as patch:
        patch.setattr(tilth.analysis.simulation.Simulation, "advance", interrupt)
        with pytest.raises(KeyboardInterrupt):
            run(model, tmp_path / "out", quiet=True)
    assert "interrupted by the user after step" in (tmp_path / "out" / "log.txt").read_text()
    resume(tmp_path / "out", quiet=True)
    assert_same_results(uninterrupted, tmp_path / "out")


@pytest.mark.parametrize("array", ["elastic_deformation", "ghost.moved", "last step.key"])
def test_checkpoint_of_another_version_is_refused(
    array: str, uninterrupted: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    shutil.copytree(uninterrupted, folder)
    arrays, meta = read_checkpoint(folder / "checkpoint.npz")
    del arrays[array]
    write_checkpoint(folder / "checkpoint.npz", arrays, meta | {"version": "0.0.9"})
    with pytest.raises(BadInput, match=rf"no '{array}'.*another version.*0\.0\.9"):
        resume(folder)


def test_resume_needs_a_checkpoint(tmp_path: Path) -> None:
    entries = entries_of()
    entries["output"]["checkpoint_every"] = 0
    run(Model.from_dict(entries), tmp_path / "out", quiet=True)
    with pytest.raises(BadInput, match="nothing to resume"):
        resume(tmp_path / "out", quiet=True)
    with pytest.raises(BadInput, match="cannot be read"):
        resume(tmp_path, quiet=True)


# --- runs that stop at a time ---------------------------------------------------------------


@pytest.mark.parametrize("until", [1e-3, 0.125, 0.13, 0.2, 0.55, 0.7])
def test_resumed_after_a_stop(
    until: float, model: Model, uninterrupted: Path, tmp_path: Path
) -> None:
    """The steps up to the stop are those of the whole run; its state is the last output."""
    first = run(model, tmp_path / "out", until=until, quiet=True)
    assert not first.finished
    whole = read_history(uninterrupted / "history.csv")
    taken = int(np.searchsorted(whole["time"], until))
    assert first.steps == taken
    for name, values in first.history.items():
        np.testing.assert_array_equal(values, whole[name][: taken + 1])
    written = read_results(tmp_path / "out" / "results.vtkhdf")
    assert (written.steps[-1], written.times[-1]) == (taken, whole["time"][taken])
    assert "stopped at time" in (tmp_path / "out" / "log.txt").read_text()
    assert resume(tmp_path / "out", quiet=True).finished
    assert_same_results(uninterrupted, tmp_path / "out")


def test_stopped_again_and_again_without_checkpoints_of_its_own(tmp_path: Path) -> None:
    entries = entries_of()
    entries["output"]["checkpoint_every"] = 0
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run(model, tmp_path / "out", until=0.3, quiet=True)
    resume(tmp_path / "out", until=0.4, quiet=True, threads=2)
    resume(tmp_path / "out", until=0.8, quiet=True)
    last = resume(tmp_path / "out", until=1.0, quiet=True)
    assert last.finished
    whole, other = (tmp_path / name / "history.csv" for name in ("whole", "out"))
    assert whole.read_bytes() == other.read_bytes()
    assert datasets(whole.with_name("results.vtkhdf")) == datasets(
        other.with_name("results.vtkhdf")
    )


@pytest.mark.parametrize("until", [0.0, -0.1, 1.001, float("nan"), float("inf"), float("-inf")])
def test_a_stop_outside_the_schedule_is_refused(until: float, model: Model, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="not a time of the schedule, which goes from 0 to 1") as e:
        run(model, tmp_path / "out", until=until, quiet=True)
    assert e.value.key == "until"
    assert not (tmp_path / "out").exists()


def test_a_stop_in_the_past_is_refused(model: Model, tmp_path: Path) -> None:
    run(model, tmp_path / "out", until=0.3, quiet=True)
    before = datasets(tmp_path / "out" / "results.vtkhdf")
    with pytest.raises(BadInput, match=r"already complete up to time 0\.375"):
        resume(tmp_path / "out", until=0.3, quiet=True)
    with pytest.raises(BadInput, match="goes from 0 to 1"):
        resume(tmp_path / "out", until=-0.3, quiet=True)
    assert datasets(tmp_path / "out" / "results.vtkhdf") == before


# --- a process that is killed ----------------------------------------------------------------

SLOW = """
import json, sys, time
from pathlib import Path
from tilth.mpm.soil import Soil
from tilth.cli import run_command
update = Soil.update
def slowly(self, *arguments):
    time.sleep(0.005)
    update(self, *arguments)
Soil.update = slowly
sys.exit(run_command(["run", sys.argv[1], "--out", sys.argv[2], "--quiet"]))
"""


@pytest.fixture(scope="module")
def case(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("case") / "block.toml"

    def value(item: Any) -> str:
        if isinstance(item, dict):
            return "{" + ", ".join(f"{json.dumps(k)} = {value(v)}" for k, v in item.items()) + "}"
        if isinstance(item, list):
            return "[" + ", ".join(map(value, item)) + "]"
        return json.dumps(item)

    entries = model.to_dict()
    file.write_text("".join(f"{key} = {value(v)}\n" for key, v in entries.items()))
    return file


def start(case: Path, out: Path) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", SLOW, str(case), str(out)],
        env={**os.environ, "OMP_WAIT_POLICY": "passive"},
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def wait_for_steps(process: subprocess.Popen[str], out: Path, steps: int) -> None:
    end = time.monotonic() + 60
    while time.monotonic() < end:
        if checkpoint_of(out).exists() and number_of_steps(out) >= steps:
            return
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.002)
    raise AssertionError("the run makes no progress")


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_killed_at_any_moment(seed: int, case: Path, uninterrupted: Path, tmp_path: Path) -> None:
    random = np.random.default_rng(seed)
    process = start(case, tmp_path / "out")
    try:
        wait_for_steps(process, tmp_path / "out", int(random.integers(1, 7)))
        time.sleep(random.uniform(0, 0.06))
        assert process.poll() is None
    finally:
        process.kill()
        process.communicate()
    assert run_command(["resume", str(tmp_path / "out"), "--quiet"]) == 0
    assert_same_results(uninterrupted, tmp_path / "out")


def test_interrupt_key_gives_exit_code_three_and_says_how_to_go_on(
    case: Path, uninterrupted: Path, tmp_path: Path
) -> None:
    process = start(case, tmp_path / "out")
    try:
        wait_for_steps(process, tmp_path / "out", 2)
        process.send_signal(signal.SIGINT)
        error = process.communicate(timeout=60)[1]
    finally:
        process.kill()
    assert process.returncode == 3, error
    assert f"tilth resume {tmp_path / 'out'}" in error
    assert run_command(["resume", str(tmp_path / "out"), "--quiet"]) == 0
    assert_same_results(uninterrupted, tmp_path / "out")
