# SPDX-License-Identifier: BSD-3-Clause
"""An analysis in memory: all its load steps, without any file."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy

from tilth.analysis.clock import Clock
from tilth.analysis.gathering import whole_result, whole_simulation
from tilth.analysis.initial_equilibrium import find_initial_equilibrium, has_initial_equilibrium
from tilth.analysis.load_steps import load_steps
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator
from tilth.model import Model
from tilth.mpi import world
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
    simulation.distribute(processes_for(simulation))
    if has_initial_equilibrium(model):
        find_initial_equilibrium(simulation)
    for _, result in load_steps(simulation, Clock(model.schedule)):
        if after_step is not None:
            after_step(whole_simulation(simulation), whole_result(result), result.time)
    return whole_simulation(simulation)


LEAST_CELLS = 4
"""Cells with soil for each process with which an analysis is shared by the processes."""


def processes_for(simulation: Simulation) -> Communicator:
    """Returns the processes that share an analysis; each computes all of one with very few cells.

    What `march` tells and returns are the points and nodes of all processes.
    """
    cells = len(simulation.locate(0.0).occupied)
    return world() if cells >= LEAST_CELLS * world().size else SERIAL


def march_stages(
    model: Model,
    after_step: Callable[[StagedAnalysis, StepResult], None] | None = None,
    at_start: Callable[[StagedAnalysis], None] | None = None,
    at_end: Callable[[StagedAnalysis], None] | None = None,
    drive: Callable[[StagedAnalysis], None] | None = None,
) -> StagedAnalysis:
    """Finds the equilibrium of the starting state, then takes all load steps of all stages.

    Returns the analysis at its end.

    Args:
        after_step: is told the analysis and the result after each converged step.
        at_start, at_end: are told the analysis at the start and the end of each stage. Its stage is
            `analysis.simulation.setup.model.stage`.
        drive: may take steps itself at the start of each stage; of several processes each gives it
            the analysis with its own part of the points, and all take these steps together.

    Raises:
        AnalysisFailed: no equilibrium at the start, or with the least step.
    """

    def whole() -> StagedAnalysis:
        if analysis.simulation.state.distribution.serial:
            return analysis
        view = copy(analysis)
        view.simulation = whole_simulation(analysis.simulation)
        return view

    def told(listener: Callable[[StagedAnalysis], None] | None) -> Callable[[], None]:
        return lambda: None if listener is None else listener(whole())

    def starts() -> None:
        if drive is not None:
            drive(analysis)
        told(at_start)()

    analysis = StagedAnalysis(model)
    analysis.check()
    analysis.distribute(processes_for(analysis.simulation))
    analysis.begin()
    starts()
    steps = analysis.steps(on_stage_start=starts, on_stage_end=told(at_end))
    for _, result in steps:
        if after_step is not None:
            after_step(whole(), whole_result(result))
    return whole()


def initial_position(points: MaterialPoints) -> Floats:
    """Returns where the points were at the start [length], shape (n, dim)."""
    return points.position - points.displacement
