# SPDX-License-Identifier: BSD-3-Clause
"""`tilth.steps`: the run of `tilth.run`, stopped, left and changed between its steps."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from resumed_runs import STEPS, assert_same_results, entries_of
from small_problems import block_entries, rollers, weight

import tilth
from tilth.interrupt import SIGNALS
from tilth.output import read_history
from tilth.output.lock import holder_of

ROWS = [(0.75, 0.9), (1.0, 0.6)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the uninterrupted run."""
    folder = tmp_path_factory.mktemp("steps") / "whole"
    tilth.run(model(), folder, quiet=True)
    return folder


@pytest.fixture(autouse=True)
def _handlers_are_restored() -> Iterator[None]:
    before = [signal.getsignal(number) for number in SIGNALS]
    yield
    assert [signal.getsignal(number) for number in SIGNALS] == before


def model(**changes: Any) -> tilth.Model:
    return tilth.Model.from_dict(entries_of() | changes)


def test_the_bits_are_those_of_run(whole: Path, tmp_path: Path) -> None:
    numbers, handlers = [], [signal.getsignal(number) for number in SIGNALS]
    steps = tilth.steps(model(), tmp_path / "run")
    assert steps.result is None
    for step in steps:
        assert [signal.getsignal(number) for number in SIGNALS] == handlers
        numbers.append(step.number)
        history = step.history
        assert history.rows == step.number + 1
        assert history["time"][-1] == step.time
        for name, value in step.row.items():
            np.testing.assert_array_equal(history[name][-1], value)
        assert step.force("top")[1] == step.row["top"]
        assert step.factor("top") == step.time
        if step.time == 0.5:
            results = tilth.open(step.folder)
            np.testing.assert_array_equal(step.points(), results.points(0.5))
            for name in ("cauchy_stress", "displacement_y", "cauchy_stress_von_mises"):
                np.testing.assert_array_equal(step.field(name), results.field(name, 0.5))
    assert step.finished
    assert numbers == [*range(1, step.number + 1)]
    assert step.number > STEPS  # one had to be cut
    assert steps.result is not None
    assert steps.result.finished
    assert steps.result.steps == step.number
    assert_same_results(whole, tmp_path / "run")
    assert step.points().shape == (len(steps.result.points), 2)  # the state is still this one


def leave_by_stop(folder: Path) -> None:
    for step in tilth.steps(model(), folder):
        if step.number == 3:
            step.stop()
        assert step.number <= 3


def leave_by_break(folder: Path) -> None:
    for step in tilth.steps(model(), folder):
        if step.number == 3:
            break


def leave_by_error(folder: Path) -> None:
    with pytest.raises(ZeroDivisionError) as error:
        for step in tilth.steps(model(), folder):
            _ = 1 / (3 - step.number)
    assert error.value is not None  # its traceback is alive, and the run has ended all the same


def leave_by_key(folder: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        for step in tilth.steps(model(), folder):
            if step.number == 3:
                os.kill(os.getpid(), signal.SIGINT)


def leave_by_with(folder: Path) -> None:
    with tilth.steps(model(), folder) as steps:
        for step in steps:
            if step.number == 3:
                break
        assert holder_of(folder) is not None
    assert steps.result is not None
    assert not steps.result.finished
    with pytest.raises(tilth.BadInput, match="step 3 is over"):
        step.stop()


def leave_by_forgetting(folder: Path) -> None:
    steps = tilth.steps(model(), folder)
    for _ in range(3):
        next(steps)
    del steps
    gc.collect()


def leave_by_end_of_program(folder: Path) -> None:
    program = (
        "import sys, tilth\nfrom resumed_runs import entries_of\n"
        "steps = tilth.steps(tilth.Model.from_dict(entries_of()), sys.argv[1])\n"
        "third = [next(steps) for _ in range(3)]"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(folder)],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout + done.stderr == ""


SLOW = [
    leave_by_break,
    leave_by_key,
    leave_by_with,
    leave_by_forgetting,
    leave_by_end_of_program,
]


@pytest.mark.parametrize(
    "leave",
    [leave_by_stop, leave_by_error, *(pytest.param(each, marks=pytest.mark.slow) for each in SLOW)],
)
def test_a_run_that_is_left_can_be_read_and_resumed(
    leave: Any, whole: Path, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    leave(folder)
    assert holder_of(folder) is None
    results = tilth.open(folder)
    reached = results.history["time"][-1]
    assert results.history["step"][-1] == 3
    assert results.times[-1] == reached  # the last state is an output
    assert f"stopped at time {reached:.6g} as requested" in (folder / "log.txt").read_text()
    assert tilth.resume(folder, quiet=True).finished
    assert_same_results(whole, folder)


@pytest.mark.slow
def test_a_run_goes_on_step_by_step(whole: Path, tmp_path: Path) -> None:
    tilth.run(model(), tmp_path / "run", until=0.4, quiet=True)
    first = next(steps := tilth.steps(None, tmp_path / "run"))
    assert first.time > 0.4
    assert [step.number for step in steps] == [*range(first.number + 1, first.number + 1 + 4)]
    assert_same_results(whole, tmp_path / "run")
    with pytest.raises(tilth.BadInput, match="leave `overwrite`"):
        tilth.steps(None, tmp_path / "run", overwrite=True)


def test_a_run_that_never_began_leaves_nothing(tmp_path: Path) -> None:
    tilth.steps(model(), tmp_path / "run").close()
    assert not (tmp_path / "run").exists()
    steps = tilth.steps(model(), tmp_path / "run", until=2.0)
    with pytest.raises(tilth.BadInput, match="is not a time of the schedule"):
        next(steps)
    assert not (tmp_path / "run").exists()


def changed(folder: Path, stop: bool = False) -> None:
    """A run whose plate is lifted from time 0.75 on, as decided at time 0.5."""
    for step in tilth.steps(model(), folder):
        if step.time == 0.5:
            step.change_load("top", ROWS)
            assert step.factor("top") == 0.5
            if stop:
                step.stop()


def declared(rows: list[tuple[float, float]]) -> tilth.Model:
    entries = entries_of()
    (top,) = (each for each in entries["boundaries"] if each["name"] == "top")
    top["factor"] = rows
    return tilth.Model.from_dict(entries)


def test_a_changed_load_is_that_of_a_model_with_its_curve(tmp_path: Path) -> None:
    changed(tmp_path / "changed")
    tilth.run(declared([(0.0, 0.0), (0.5, 0.5), *ROWS]), tmp_path / "declared", quiet=True)
    found, expected = (read_history(tmp_path / n / "history.csv") for n in ("changed", "declared"))
    for name, column in expected.items():
        np.testing.assert_allclose(found[name], column, rtol=1e-9, atol=1e-9 * abs(column).max())
    moved = read_history(tmp_path / "changed" / "boundaries.csv")["top displacement_y [m]"]
    assert moved[-1] == pytest.approx(-0.2 * 0.6)
    one, two = (tilth.open(tmp_path / name) for name in ("changed", "declared"))
    np.testing.assert_allclose(one.points(), two.points(), rtol=0.0, atol=1e-10)
    log = (tmp_path / "changed" / "log.txt").read_text()
    assert "load changed: 'top' after step " in log
    assert "from factor 0.5 at time 0.5 to (0.75, 0.9), (1, 0.6)" in log


@pytest.mark.slow
def test_a_resumed_run_keeps_the_changed_load(tmp_path: Path) -> None:
    changed(tmp_path / "whole")
    changed(tmp_path / "stopped", stop=True)
    tilth.resume(tmp_path / "stopped", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.slow
@pytest.mark.parametrize("file", ["model.json", "checkpoint.npz"])
def test_a_change_that_is_killed_can_be_resumed(
    file: str, whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Killed before or after the model is written, the run has the one load or the other."""
    from tilth.analysis import recorder

    class Killed(BaseException):
        pass

    def kill(*arguments: Any) -> None:
        raise Killed

    steps = tilth.steps(model(), folder := tmp_path / "run")
    step = next(each for each in steps if each.time == 0.5)
    with monkeypatch.context() as patch:
        if file == "model.json":
            patch.setattr(recorder, "write_durably", kill)
        else:
            patch.setattr(recorder.RunLog, "change", kill)
        with pytest.raises(Killed):
            step.change_load("top", ROWS)
    kept = (folder / "checkpoint.npz").read_bytes(), (folder / "model.json").read_bytes()
    steps.close()
    (folder / "checkpoint.npz").write_bytes(kept[0])
    (folder / "model.json").write_bytes(kept[1])
    tilth.resume(folder, quiet=True)
    factor = tilth.open(folder).model.boundaries[-1].factor
    if file == "model.json":
        assert factor is None
        assert_same_results(whole, folder)
    else:
        assert factor == ((0.0, 0.0), (0.5, 0.5), *ROWS)


WRONG: list[tuple[dict[str, Any], str]] = [
    ({"name": "top plate"}, "there is no load, moving boundary or rigid body of this name"),
    ({"name": "low y"}, "there is no load, moving boundary"),
    ({"name": "top", "force": True}, "there is no rigid body with a force"),
    ({"name": "top", "rows": []}, "that begin after the present time"),
    ({"name": "top", "rows": [(0.01, 1.0)]}, "that begin after the present time"),
    ({"name": "top", "rows": [0.5]}, "that begin after the present time"),
    ({"name": "top", "rows": [(0.9, 1.0), (0.8, 1.0)]}, "must increase from row to row"),
    ({"name": "top", "rows": [(0.9, float("nan"))]}, "must be a finite number"),
]


def test_what_is_wrong_is_refused(tmp_path: Path) -> None:
    step = next(steps := tilth.steps(model(), tmp_path / "run"))
    before = (tmp_path / "run" / "model.json").read_bytes()
    for arguments, said in WRONG:
        with pytest.raises(tilth.BadInput) as error:
            step.change_load(**({"rows": ROWS} | arguments))
        assert said in str(error.value)
    for ask, said in (
        (lambda: step.force("plate"), "there is no boundary or rigid body"),
        (lambda: step.factor("plate"), "there is no load, moving boundary"),
        (lambda: step.field("cauchy_stres"), "did you mean"),
    ):
        with pytest.raises(tilth.BadInput, match=said):
            ask()
    steps.close()
    assert (tmp_path / "run" / "model.json").read_bytes() == before


def test_a_step_that_is_over_is_refused(tmp_path: Path) -> None:
    steps = tilth.steps(model(), tmp_path / "run", until=0.3)
    first = next(steps)
    row = dict(first.row)
    next(steps)
    assert first.row == row
    for ask in (first.points, first.stop, lambda: first.change_load("top", ROWS)):
        with pytest.raises(tilth.BadInput, match="step 1 is over: the run is at step 2"):
            ask()
    steps.close()


def test_a_load_with_a_name_is_changed_and_stages_are_refused(tmp_path: Path) -> None:
    load = weight("plane_strain", 2.0) | {"name": "gravity"}
    entries = block_entries(
        "plane_strain", "gimp", cells=1, loads=[load], schedule={"steps": 4},
        boundaries=rollers("plane_strain", sides=True), output={"report": False},
    )  # fmt: skip
    for step in tilth.steps(tilth.Model.from_dict(entries), tmp_path / "run"):
        if step.time == 0.5:
            step.change_load("gravity", [(1.0, 0.25)])
    assert step.factor("gravity") == 0.25
    del entries["schedule"]
    entries["stages"] = [{"name": "loading", "schedule": {"steps": 4}}]
    step = next(steps := tilth.steps(tilth.Model.from_dict(entries), tmp_path / "staged"))
    assert step.stage == "loading"
    with pytest.raises(tilth.BadInput, match="model with stages cannot be changed"):
        step.change_load("gravity", [(1.0, 0.25)])
    steps.close()
