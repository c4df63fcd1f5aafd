# SPDX-License-Identifier: BSD-3-Clause
"""An analysis in memory: all its load steps, without any file."""

from __future__ import annotations

from collections.abc import Callable

from tilth.analysis.clock import Clock
from tilth.analysis.simulation import Simulation, StepResult
from tilth.arrays import Floats
from tilth.errors import AnalysisFailed, StepFailed
from tilth.model import Model
from tilth.mpm.points import MaterialPoints


def march(
    model: Model,
    after_step: Callable[[Simulation, StepResult, float], None] | None = None,
) -> Simulation:
    """Takes all load steps of a model, halving those that fail; returns the final state.

    Args:
        after_step: is told the state, the result and the time after each converged step.

    Raises:
        AnalysisFailed: no equilibrium with the least step.
    """
    simulation = Simulation(model)
    simulation.check()
    clock = Clock(model.schedule)
    while not clock.done:
        after = clock.next_time()
        try:
            result = simulation.advance(clock.time, after, is_least=clock.is_least)
        except StepFailed as failure:
            if not clock.cut(failure.share):
                raise AnalysisFailed(f"time {after:.6g}: {failure.reason}") from failure
            continue
        clock.accept(after)
        if after_step is not None:
            after_step(simulation, result, after)
    return simulation


def initial_position(points: MaterialPoints) -> Floats:
    """Returns where the points were at the start [length], shape (n, dim)."""
    return points.position - points.displacement
