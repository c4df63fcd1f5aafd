# SPDX-License-Identifier: BSD-3-Clause
"""Runs that are stopped and resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from itertools import cycle
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from small_problems import (
    block_entries,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import Model, resume, run
from tilth.analysis.recorder import Recorder
from tilth.analysis.run import Result
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.output import read_checkpoint

STEPS = 8


def entries_of(kind: str = "plane_strain", basis: str = "gimp") -> dict[str, Any]:
    """A plastic block that is squeezed, with one step that has to be cut on the way.

    Standard points need more iterations where they cross cells, however small the step.
    """
    few = 8 if basis == "linear" else 3
    entries = block_entries(
        kind, basis, "von_mises", cells=1, loads=[weight(kind, 2.0)],
        boundaries=[*rollers(kind, sides=False), plane(
            "top", "z" if kind == "3d" else "y", 1.0, condition="prescribed",
            displacement={"z" if kind == "3d" else "y": -0.2},
        )],
        schedule={"steps": STEPS, "output_times": [0.2, 0.5, 0.6]},
    )  # fmt: skip
    entries["grid"]["cell_size"] = 0.25 if kind != "3d" else 0.5
    entries["materials"]["soil"] = material_entries("von_mises", yield_stress=25.0)
    entries["analysis"] |= {"tolerance": 1e-9, "maximum_iterations": few}
    entries["output"] = {"report": False, "deformation_gradient": True}
    entries["track"] = [
        {"name": "top", "quantity": "reaction", "boundary": "top", "component": "y"},
        {"name": "work", "quantity": "energy", "kind": "external_work"},
        {"name": "lost", "quantity": "energy", "kind": "plastic_dissipation"},
        {"name": "side", "quantity": "run_out", "axis": "x", "of": "domains"},
    ]
    return entries


def datasets(file: Path) -> dict[str, bytes]:
    """Every data set of a results file."""
    found: dict[str, bytes] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found[name] = np.asarray(item[()]).tobytes()

    with h5py.File(file) as results:
        results.visititems(take)
    return found


def assert_same_results(one: Path, other: Path) -> None:
    for name in ("history.csv", "boundaries.csv"):
        files = [folder / name for folder in (one, other) if (folder / name).exists()]
        assert len(files) != 1
        assert len({file.read_bytes() for file in files}) <= 1
    first, second = datasets(one / "results.vtkhdf"), datasets(other / "results.vtkhdf")
    assert first.keys() == second.keys()
    for name, content in first.items():
        assert content == second[name], f"{name} differs"
    arrays, meta = read_checkpoint(checkpoint_of(one))
    again, meta_again = read_checkpoint(checkpoint_of(other))
    assert meta | {"seconds": {}} == meta_again | {"seconds": {}}
    assert arrays.keys() == again.keys()
    for name, array in arrays.items():
        assert array.tobytes() == again[name].tobytes(), f"{name} differs"


def restored(simulation: Simulation) -> Simulation:
    """A simulation from the arrays of another one; all of them are the same again."""
    stored = {key: array.copy() for key, array in simulation.state.arrays().items()}
    found = Simulation.restored(simulation.setup.model, stored)
    again = found.state.arrays()
    assert again.keys() == stored.keys()
    for key, array in stored.items():
        np.testing.assert_array_equal(again[key], array, err_msg=key)
    return found


def checkpoint_of(folder: Path) -> Path:
    from tilth.output.folder import CHECKPOINT

    return folder / CHECKPOINT


class Stopped(Exception):
    """Stands for whatever ends a run from outside."""


def run_until(model: Model, folder: Path, step: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs and stops right after `step` is recorded."""
    stopped_after(step, monkeypatch, lambda: run(model, folder, quiet=True))


def run_in_pieces(
    model: Model,
    folder: Path,
    steps: Iterable[int],
    monkeypatch: pytest.MonkeyPatch,
    threads: Iterable[int | None] = (None,),
) -> Result:
    """Runs, stopped right after each of some steps and resumed; returns the result of the last one.

    threads: of the first piece, the second one and so on, again and again.
    """
    count = cycle(threads)
    first, *others = steps
    start = partial(run, model, folder, threads=next(count), quiet=True)
    stopped_after(first, monkeypatch, start)
    for step in others:
        again = partial(resume, folder, threads=next(count), quiet=True)
        stopped_after(step, monkeypatch, again)
    return resume(folder, threads=next(count), quiet=True)


def stopped_after(step: int, monkeypatch: pytest.MonkeyPatch, start: Callable[[], object]) -> None:
    """Starts a run, or goes on with one, and stops right after `step` is recorded."""
    record = Recorder.step

    def stop(self: Recorder, clock: Any, size: float, result: StepResult) -> None:
        record(self, clock, size, result)
        if clock.step == step:
            raise Stopped

    with monkeypatch.context() as patch:
        patch.setattr(Recorder, "step", stop)
        with pytest.raises(Stopped):
            start()
