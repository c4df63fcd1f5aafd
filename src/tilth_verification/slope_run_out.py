# SPDX-License-Identifier: BSD-3-Clause
"""A slope in clay that loses strength: factors of safety before and after, and the slide."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from tilth.analysis.march import march_stages
from tilth.analysis.safety import strength_reduction
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.model import Model, VonMises
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, relative
from tilth_verification.slip_circles import Slope, uniform

PROBLEM = "slope_run_out"
GROUND = [(-20.0, 7.0), (9.0, 7.0), (14.0, 2.0), (40.0, 2.0)]
"""Surface of the slope [m]."""
WEIGHT = 18e3
"""Unit weight [N/m3]."""
SLIDE = 2
"""Index of the stage of the slide."""


@dataclass
class Slide:
    """What happens to the slope.

    Attributes:
        before, at_rest: middle of the bracket of the factor of safety [-].
        run_out: largest horizontal displacement of a point in the slide [m].
        settlement: largest settlement [m].
        moving: steps by damped inertia.
    """

    before: float = 0.0
    at_rest: float = 0.0
    run_out: float = 0.0
    settlement: float = 0.0
    moving: int = 0


def comparisons(long: bool) -> Iterator[Comparison]:
    """Against slip circles and a factor of 1; long: a finer grid, and a slow loss of strength."""
    model = example(PROBLEM)
    coarse = slide(model)
    circles = circle_factor(model)
    source = "moments about the least circle"
    yield relative("factor of safety before, h 0.5 m", coarse.before, circles, 0.05, source)
    quantity = "steps by damped inertia, h 0.5 m"
    yield at_least(quantity, coarse.moving, 1.0, 0.0, "no equilibrium is near")
    rest = "what has just come to rest is at its limit"
    yield relative("factor of safety at rest, h 0.5 m", coarse.at_rest, 1.0, 0.02, rest)
    if not long:
        return
    fine = slide(varied(model, {"grid.cell_size": 0.25}))
    yield relative("factor of safety before, h 0.25 m", fine.before, circles, 0.05, source)
    yield relative("factor of safety at rest, h 0.25 m", fine.at_rest, 1.0, 0.02, rest)
    changes: dict[str, Any] = {f"stages.{SLIDE}.release": None}
    slow = slide(varied(model, changes | {f"stages.{SLIDE}.schedule": {"steps": 10}}))
    for other, name, source in (
        (fine, "h 0.25 m", "the same, h 0.5 m"),
        (slow, "strength lost in 10 steps, h 0.5 m", "at once"),
    ):
        for what, one, two in (
            ("run-out", other.run_out, coarse.run_out),
            ("settlement", other.settlement, coarse.settlement),
        ):
            yield relative(f"{what}, {name}", one, two, 0.05, source, "m")


def circle_factor(model: Model) -> float:
    """Returns the least factor of all slip circles before the slide [-]."""
    clay = model.materials["clay"]
    assert isinstance(clay, VonMises)
    strength = clay.parameter("yield_stress") / math.sqrt(3.0)
    slope = Slope(GROUND, WEIGHT, uniform(strength), uniform(0.0))
    return slope.least_factor((-4.0, 9.0), (14.0, 30.0))


def slide(model: Model) -> Slide:
    """Goes through all stages."""
    found = Slide()

    def after_step(analysis: StagedAnalysis, result: StepResult) -> None:
        found.moving += result.relaxing is not None

    def at_end(analysis: StagedAnalysis) -> None:
        simulation, time = analysis.simulation, analysis.clock.time
        for index, stage in simulation.setup.model.stage.reductions:
            result = strength_reduction(simulation, time, stage)
            middle = 0.5 * (result.factor + result.above)
            if index < SLIDE:
                found.before = middle
            else:
                found.at_rest = middle

    moved = march_stages(model, after_step, at_end=at_end).simulation.state.points.displacement
    found.run_out, found.settlement = float(moved[:, 0].max()), -float(moved[:, 1].min())
    return found
