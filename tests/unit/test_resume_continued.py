# SPDX-License-Identifier: BSD-3-Clause
"""Runs that go on with a later end, or further stages, are the run made to that end in one go."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from resumed_runs import datasets, entries_of, stopped_after
from staged_problems import staged_entries

from tilth import BadInput, Model, resume, run, steps
from tilth.analysis import continued
from tilth.cli import run_command
from tilth.output import read_checkpoint, read_history, read_results

SIZE = 0.125
Entries = dict[str, Any]


def squeezed(end: float, **changes: Any) -> Entries:
    """The block of `resumed_runs`, squeezed at a constant rate up to a time."""
    entries = entries_of()
    entries["schedule"] = {"end": end, "step_size": SIZE, "output_every": 2}
    entries["loads"][0]["factor"] = [[0.0, 0.0], [0.5, 1.0]]
    entries["boundaries"][-1]["factor"] = [[0.0, 0.0], [1.0, 1.0]]
    return entries | changes


def model_of(entries: Entries) -> Model:
    return Model.from_dict(entries)


@pytest.fixture(scope="module")
def half(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run that is finished at time 0.5."""
    folder = tmp_path_factory.mktemp("half") / "out"
    run(model_of(squeezed(0.5)), folder, quiet=True)
    return folder


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a run to time 1 in one go."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    run(model_of(squeezed(1.0)), folder, quiet=True)
    return folder


@pytest.fixture
def folder(half: Path, tmp_path: Path) -> Path:
    """A copy of the finished run."""
    return shutil.copytree(half, tmp_path / "out")


def require_same(one: Path, other: Path) -> None:
    """All files agree to the bit, apart from what tells that a run went on."""
    for name in ("history.csv", "boundaries.csv", "energies.csv", "model.json"):
        files = [path / name for path in (one, other) if (path / name).exists()]
        assert len(files) != 1
        assert len({file.read_bytes() for file in files}) <= 1, name
    assert datasets(one / "results.vtkhdf") == datasets(other / "results.vtkhdf")
    arrays, meta = read_checkpoint(one / "checkpoint.npz")
    again, meta_again = read_checkpoint(other / "checkpoint.npz")
    for each in (meta, meta_again):
        each.pop("seconds")
        each.pop("earlier_outputs", None)
        each.pop("next_model", None)
    assert meta == meta_again
    assert arrays.keys() == again.keys()
    assert all(array.tobytes() == again[name].tobytes() for name, array in arrays.items())


def test_a_finished_run_goes_on_to_a_later_end(folder: Path, whole: Path) -> None:
    result = run(model_of(squeezed(1.0)), folder, continues=True, quiet=True)
    assert result.finished
    require_same(folder, whole)
    log = (folder / "log.txt").read_text()
    assert log.count("goes on with a changed model: from time 0.5 to 1 (was 0.5)") == 1
    assert resume(folder, quiet=True).steps == 0


def test_step_by_step_and_twice(folder: Path, whole: Path) -> None:
    with steps(model_of(squeezed(0.75)), folder, continues=True) as taken:
        assert [step.number for step in taken] == [5, 6]
    run(model_of(squeezed(1.0)), folder, continues=True, quiet=True)
    require_same(folder, whole)


def test_it_goes_on_after_a_stop(
    folder: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is stopped in the middle, resumed, stopped again beside an output, and goes on."""
    later = model_of(squeezed(1.0))
    stopped_after(5, monkeypatch, lambda: run(later, folder, continues=True, quiet=True))
    assert not resume(folder, until=0.85, quiet=True).finished
    assert run(later, folder, continues=True, quiet=True).finished
    require_same(folder, whole)


@pytest.mark.parametrize("moment", ["write_checkpoint", "write_setup", "write_durably"])
def test_a_crash_while_it_begins_to_go_on_loses_nothing(
    moment: str, folder: Path, half: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before each of the files; the run is finished as before, and can go on."""

    def crash(*_: Any) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(continued, moment, crash)
        with pytest.raises(KeyboardInterrupt):
            run(model_of(squeezed(1.0)), folder, continues=True, quiet=True)
    assert (folder / "model.json").read_bytes() == (half / "model.json").read_bytes()
    assert resume(folder, quiet=True).finished
    require_same(folder, half)
    run(model_of(squeezed(1.0)), folder, continues=True, quiet=True)
    require_same(folder, whole)


def test_outputs_that_are_there_stay(half: Path, tmp_path: Path) -> None:
    """Also where the schedule with the later end would have had others."""
    folder = shutil.copytree(half, tmp_path / "out")
    entries = squeezed(1.0, schedule={"end": 1.0, "step_size": SIZE, "output_times": [0.7]})
    run(model_of(entries), folder, until=0.8, continues=True, quiet=True)
    resume(folder, quiet=True)
    assert read_results(folder / "results.vtkhdf").times == [0.0, 0.25, 0.5, 0.7, 1.0]
    assert resume(folder, quiet=True).finished


def test_an_end_beside_the_steps_by_round_off(tmp_path: Path) -> None:
    """3 x 0.1 is not 0.3: the first step from there is a whole one, not one of 6e-17."""
    entries = squeezed(0.3, schedule={"end": 0.3, "step_size": 0.1})
    run(model_of(entries), tmp_path / "out", quiet=True)
    entries["schedule"]["end"] = 0.6
    run(model_of(entries), tmp_path / "out", continues=True, quiet=True)
    run(model_of(entries), tmp_path / "whole", quiet=True)
    one, other = (read_history(tmp_path / name / "history.csv") for name in ("out", "whole"))
    for name, values in other.items():
        np.testing.assert_allclose(one[name], values, rtol=1e-9, atol=1e-12)


def at_once(keys: str, value: Any) -> Callable[[Entries], None]:
    """A change of one entry."""

    def change(entries: Any) -> None:
        *way, last = (int(key) if key.isdigit() else key for key in keys.split("."))
        for key in way:
            entries = entries[key]
        entries[last] = value

    return change


@pytest.mark.parametrize(
    ("keys", "value", "key"),
    [
        ("materials.soil.young_modulus", 1.0, "materials.soil.young_modulus"),
        ("analysis.tolerance", 1e-7, "analysis.tolerance"),
        ("bodies.0.points_per_cell", 3, "bodies[0].points_per_cell"),
        ("loads.0.acceleration", [0.0, -3.0], "loads[0].acceleration"),
        ("loads.0.factor", [[0.0, 0.0], [1.0, 1.0]], "loads[0].factor"),
        ("loads.0.factor", None, "loads[0].factor"),
        ("boundaries.0.at", 0.25, "boundaries[0].at"),
        ("track", [], "track"),
        ("output.deformation_gradient", False, "output.deformation_gradient"),
        ("loads", [], "loads"),
        ("schedule.end", 0.5, "schedule.end"),
        ("schedule.end", 0.25, "schedule.end"),
    ],
)
def test_what_has_acted_cannot_change(
    keys: str, value: Any, key: str, folder: Path, half: Path
) -> None:
    entries = squeezed(1.0)
    at_once(keys, value)(entries)
    if value is None:
        del entries["loads"][0]["factor"]
    with pytest.raises(BadInput) as caught:
        run(model_of(entries), folder, continues=True, quiet=True)
    assert caught.value.problems[0].key == key
    assert "time 0.5" in str(caught.value)
    for file in half.iterdir():
        assert (folder / file.name).read_bytes() == file.read_bytes()


def test_rows_of_tables_and_output_may_change(folder: Path, tmp_path: Path) -> None:
    """Rows after the time that is reached, title, checkpoints: the run is that of the new model."""
    entries = squeezed(1.0, title="on")
    entries["loads"][0]["factor"].append([1.0, 3.0])
    entries["output"] |= {"checkpoint_every": 2}
    entries["boundaries"][-1]["factor"] = [[0.0, 0.0], [0.5, 0.5], [0.75, 0.5], [1.0, 0.0]]
    run(model_of(entries), folder, continues=True, quiet=True)
    run(model_of(entries), tmp_path / "whole", quiet=True)
    one, other = (read_history(path / "history.csv") for path in (folder, tmp_path / "whole"))
    assert all(np.array_equal(one[name], values) for name, values in other.items())


def test_water_that_is_on_its_way_keeps_its_end(tmp_path: Path) -> None:
    """It moves from one level to another up to the end of the schedule."""
    water = {"level": 0.6, "initial_level": 0.3, "unit_weight": 10.0}
    entries = squeezed(SIZE, water=water)
    entries["schedule"] = {"end": SIZE, "step_size": SIZE}
    entries["materials"]["soil"]["saturated_density"] = 3.0
    run(model_of(entries), tmp_path / "out", quiet=True)
    entries["schedule"]["end"] = 1.0
    with pytest.raises(BadInput, match=r"schedule.end: .*the water moves to its `level`"):
        run(model_of(entries), tmp_path / "out", continues=True, quiet=True)


def test_a_changed_model_file_names_the_way(folder: Path) -> None:
    """`resume` refuses it, and accepts the same entries written in another way."""
    file = folder / "model.json"
    entries = json.loads(file.read_text())
    file.write_text(json.dumps({**entries, "schedule": {**entries["schedule"], "end": 1.0}}))
    with pytest.raises(BadInput, match=r"model\.json was changed after the run began") as caught:
        resume(folder, quiet=True)
    assert f"tilth run CASE.toml --continue {folder}" in str(caught.value)
    file.write_text(json.dumps(entries))
    assert resume(folder, quiet=True).finished


def test_the_command(folder: Path, whole: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = folder.parent / "case.json.toml"
    case.write_text(tomli_w.dumps({"format": 1, **squeezed(1.0)}))
    for more in (["--out", str(folder)], ["--overwrite"], ["--from", "x:y"]):
        assert run_command(["run", str(case), "--continue", str(folder), *more]) == 2
        assert "the run goes on in its own folder" in capsys.readouterr().err
    assert run_command(["run", str(case), "--continue", str(folder.parent / "no")]) == 2
    assert "there is no such folder" in capsys.readouterr().err
    assert run_command(["run", str(case), "--continue", str(folder), "--until", "0.3"]) == 2
    assert "already complete up to time 0.5" in capsys.readouterr().err
    assert run_command(["run", str(case), "--continue", str(folder), "--quiet"]) == 0
    require_same(folder, whole)


def test_the_keyword_stands_alone(folder: Path) -> None:
    model = model_of(squeezed(1.0))
    with pytest.raises(BadInput, match="does not go with `overwrite`"):
        run(model, folder, continues=True, overwrite=True, quiet=True)
    with pytest.raises(BadInput, match="or give a model"):
        steps(None, folder, continues=True)


def test_with_inertia(tmp_path: Path) -> None:
    """Motion, its energies and the error of the steps run through."""
    entries = squeezed(0.5)
    entries["analysis"]["inertia"] = {"scheme": "newmark", "largest_error": 1e-3}
    entries["materials"]["soil"]["density"] = 1.0
    entries["units"] = {"time": "s"}
    run(model_of(entries), tmp_path / "out", quiet=True)
    entries["schedule"]["end"] = 1.0
    run(model_of(entries), tmp_path / "out", continues=True, quiet=True)
    run(model_of(entries), tmp_path / "whole", quiet=True)
    assert (tmp_path / "out" / "energies.csv").exists()
    require_same(tmp_path / "out", tmp_path / "whole")


@pytest.mark.slow
def test_the_last_stage_goes_on_and_others_follow(tmp_path: Path) -> None:
    """Forces that were released before are; the stages' own checkpoints fit again."""
    whole = staged_entries()
    last = whole["stages"][3]
    assert last["schedule"] == {"steps": 2}
    last["factors"] = {"plate": [[0.0, 0.0], [2.0, 1.0]], "footing": [[0.0, 0.0], [1.0, 1.0]]}
    last |= {"schedule": {"end": 2.0, "steps": 4}, "release": [[0.0, 0.0], [1.0, 1.0]]}
    run(model_of(whole), tmp_path / "whole", quiet=True)
    short = json.loads(json.dumps(whole))
    del short["stages"][4:]
    short["stages"][3] |= {"schedule": {"end": 1.0, "steps": 2}}
    short["stages"][3]["factors"]["plate"] = [[0.0, 0.0], [1.0, 0.5]]
    folder = tmp_path / "out"
    run(model_of(short), folder, quiet=True)
    without = json.loads(json.dumps(whole))
    del without["stages"][3]["release"]
    with pytest.raises(BadInput) as caught:
        run(model_of(without), folder, continues=True, quiet=True)
    assert caught.value.problems[0].key == "stages[3].release"
    run(model_of(whole), folder, continues=True, quiet=True)
    require_same(folder, tmp_path / "whole")
    for stage in ("fill", "press"):
        run(model_of(whole), tmp_path / stage, from_stage=(folder, stage), quiet=True)
        require_same(tmp_path / stage, tmp_path / "whole")


@pytest.mark.slow
def test_what_new_stages_may_bring(tmp_path: Path) -> None:
    """A stage that was done is not removed or renamed; new blocks of results need a new folder."""
    whole, short = staged_entries(), staged_entries()
    for each in (whole, short):
        del each["track"][2]
    del short["stages"][2:]
    for name in ("boundaries", "loads", "bodies"):
        short[name].pop()
    folder = tmp_path / "out"
    run(model_of(short), folder, quiet=True)
    with pytest.raises(BadInput, match=f"--from {folder}:dig --out NEW") as caught:
        run(model_of(whole), folder, continues=True, quiet=True)
    assert caught.value.problems[0].key == "stages"
    renamed = json.loads(json.dumps(short))
    renamed["stages"][1]["name"] = "digging"
    with pytest.raises(BadInput, match=r"stages: are not those of the run .*\('weight', 'dig'\)"):
        run(model_of(renamed), folder, continues=True, quiet=True)
    assert resume(folder, quiet=True).finished
    more = json.loads(json.dumps(short))
    more["stages"].append({"name": "wait", "schedule": {"steps": 1}})
    run(model_of(more), folder, continues=True, quiet=True)
    run(model_of(more), tmp_path / "whole", quiet=True)
    require_same(folder, tmp_path / "whole")
