# SPDX-License-Identifier: BSD-3-Clause
"""A cut in layered clay that collapses: to full gravity by relaxation and by inertia."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative

PROBLEM = "layered_cut"
"""Name of the example."""
TOE, CREST = np.array([5.0, 3.0]), np.array([5.0, 6.0])
"""Lower and upper end of the face [m]."""
FACE = 0.5
"""Width of the soil behind the face whose mean displacement is the run-out [m]."""
WEIGHT = 18e3 * 45.0
"""Of all soil [N/m]."""
SAME = 0.05
"""Largest relative difference of run-outs between two grids or two numbers of steps [-]."""


@dataclass(frozen=True)
class Outcome:
    """The cut at the end.

    Attributes:
        run_out: mean horizontal displacement of the soil behind the face [m].
        settlement: of the crest [m].
        bearing: force on the base over the weight [-].
        moving: steps by damped inertia.
    """

    run_out: float
    settlement: float
    bearing: float
    moving: int


def comparisons(long: bool) -> Iterator[Comparison]:
    """Both ways reach full gravity; long: two grids and two numbers of steps of each."""
    relaxed = outcome(example(PROBLEM))
    quantity = "relax, h 0.25 m: steps by damped inertia"
    yield at_least(quantity, relaxed.moving, 1.0, 0.0, "no equilibrium is near")
    name = "force on the base over the weight at full gravity"
    yield relative(f"relax, h 0.25 m: {name}", relaxed.bearing, 1.0, 1e-6, "equilibrium")
    model = example(PROBLEM, "inertia.toml")
    coarse = outcome(varied(model, {"grid.cell_size": 0.5}))
    yield relative(f"inertia, h 0.5 m: {name}", coarse.bearing, 1.0, 1e-2, "at rest, nearly")
    if not long:
        return
    finer = outcome(varied(example(PROBLEM), {"grid.cell_size": 0.125}))
    fewer = outcome(varied(example(PROBLEM), {"schedule.steps": 4}))
    for other, at in ((finer, "h 0.125 m"), (fewer, "h 0.25 m, 4 steps")):
        yield from same("relax", other, at, relaxed, "h 0.25 m, 5 steps")
    moved = outcome(model)
    yield from same("inertia", moved, "h 0.25 m", coarse, "h 0.5 m")
    shorter: dict[str, Any] = {"schedule.step_size": 0.5, "analysis.inertia.largest_motion": 0.1}
    yield from same("inertia", outcome(varied(model, shorter)), "half the steps", moved, "h 0.25 m")
    quantity = "run-out by inertia over that by relaxation, h 0.25 m"
    yield at_least(quantity, moved.run_out / relaxed.run_out, 1.0, 0.0, "momentum only adds")


def same(way: str, one: Outcome, at: str, other: Outcome, source: str) -> Iterator[Comparison]:
    """Compares run-out and settlement of two computations."""
    for name in ("run_out", "settlement"):
        a, b = getattr(one, name), getattr(other, name)
        quantity = f"{way}, {at}: {'settlement of the crest' if name != 'run_out' else 'run-out'}"
        yield relative(quantity, a, b, SAME, f"the same, {source}", "m")


def outcome(model: Model) -> Outcome:
    """Runs a cut to its end."""
    moving, force = 0, 0.0

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        nonlocal moving, force
        moving += result.relaxing is not None
        force = float(result.resultant("base")[1])

    points = march(model, after_step).state.points
    start, moved = initial_position(points), points.displacement
    behind = start - TOE
    face = (behind[:, 0] > -FACE) & (behind[:, 0] < 0.0) & (behind[:, 1] > 0.0)
    volume = points.initial_volume[face]
    crest = int(np.abs(start - CREST).sum(axis=1).argmin())
    return Outcome(
        run_out=_mean(moved[face, 0], volume),
        settlement=-float(moved[crest, 1]),
        bearing=force / WEIGHT,
        moving=moving,
    )


def _mean(values: Floats, weight: Floats) -> float:
    return float(values @ weight / weight.sum())
