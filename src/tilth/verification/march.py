# SPDX-License-Identifier: BSD-3-Clause
"""An analysis in memory: all its load steps, without any file."""

from __future__ import annotations

from collections.abc import Callable

from tilth.analysis.clock import Clock
from tilth.analysis.initial_equilibrium import find_initial_equilibrium, has_initial_equilibrium
from tilth.analysis.load_steps import load_steps
from tilth.analysis.simulation import Simulation, StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints


def march(
    model: Model,
    after_step: Callable[[Simulation, StepResult, float], None] | None = None,
) -> Simulation:
    """Finds the equilibrium of the starting state, then takes all load steps of a model.

    Halves those that fail; returns the final state.

    Args:
        after_step: is told the state, the result and the time after each converged step.

    Raises:
        AnalysisFailed: no equilibrium at the start, or with the least step.
    """
    simulation = Simulation(model)
    simulation.check()
    if has_initial_equilibrium(model):
        find_initial_equilibrium(simulation)
    for _, result in load_steps(simulation, Clock(model.schedule)):
        if after_step is not None:
            after_step(simulation, result, result.time)
    return simulation


def initial_position(points: MaterialPoints) -> Floats:
    """Returns where the points were at the start [length], shape (n, dim)."""
    return points.position - points.displacement
