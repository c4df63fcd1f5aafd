# SPDX-License-Identifier: BSD-3-Clause
"""The loop over the load steps of an analysis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.dynamics import SAFETY
from tilth.analysis.gathering import whole_state
from tilth.analysis.likely_causes import likely_causes
from tilth.analysis.relaxation import Relaxation
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.errors import AnalysisFailed, BadInput, StepFailed
from tilth.model import Model
from tilth.output.folder import REPORT

CUTS_IN_A_ROW = 3
"""Cuts of one step after which likely causes are named."""


def load_steps(
    simulation: Simulation,
    clock: Clock,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
    on_cut: Callable[[float, StepFailed], None] = lambda time, failure: None,
) -> Iterator[tuple[float, StepResult]]:
    """Takes load steps until the clock is done or stops, and shortens those that fail.

    Args:
        simulation: is advanced.
        clock: where the analysis is in its schedule; is advanced.
        on_iteration: is called with the number of each Newton iteration and its relative residual.
        on_cut: is called with the time that a failed step should have reached, and its failure.

    Yields:
        The size of each converged step [time] and its result.

    Raises:
        AnalysisFailed: no equilibrium with the smallest step.
        BadInput: code of the user fails.
    """
    setup, state, services = simulation.setup, simulation.state, simulation.services
    model, cuts = setup.model, 0
    while not (clock.done or clock.stops):
        if clock.relaxing:
            yield from _relaxed(simulation, clock, on_iteration, on_cut)
            continue
        before, after = clock.time, clock.next_time()
        try:
            with services.observer.attempt(model, clock.step + 1, before, after):
                result = simulation.advance(
                    before, after, on_iteration, clock.is_least, clock.is_short
                )
        except StepFailed as failure:
            if not clock.cut(failure.share):
                if state.relaxation is not None:
                    yield from _relaxed(simulation, clock, on_iteration, on_cut)
                    cuts = 0
                    continue
                raise _failed(simulation, clock, after - before, failure) from failure
            cuts += failure.share is None  # else it is known how much of the step is possible
            if cuts == CUTS_IN_A_ROW:
                causes = likely_causes(setup, whole_state(state), services, clock, failure)
                if causes:
                    services.warnings.repeated_cuts(clock.step + 1, cuts, causes)
            on_cut(after, failure)
            continue
        except BadInput as error:  # code of the user that fails in this step
            when = f"in step {clock.step + 1} to time {after:.6g}{_of_stage(model)}"
            raise error.during(when) from error
        cuts = 0
        clock.accept(after, SAFETY * result.possible_size * (after - before))
        yield after - before, result


def _relaxed(
    simulation: Simulation,
    clock: Clock,
    on_iteration: Callable[[int, float], None],
    on_cut: Callable[[float, StepFailed], None],
) -> Iterator[tuple[float, StepResult]]:
    """Lets soil without equilibrium come to rest at the next regular time or time of output.

    Also goes on with soil that is on its way. Arguments and yielded steps as in `load_steps`, with
    the sizes of the steps of the equations of motion [time]; 0 of the last one, in equilibrium.

    Raises:
        AnalysisFailed: the soil does not come to rest, or a step fails.
        BadInput: code of the user fails.
    """
    setup, state, services = simulation.setup, simulation.state, simulation.services
    relaxation = state.relaxation
    assert relaxation is not None
    model, water = setup.model, setup.water
    before = after = clock.time
    if not clock.relaxing:
        after = clock.next_event
        relaxation.start(state.points, state.distribution, water, before)
        services.warnings.relaxation(relaxation.number, before, after)
    while relaxation.active:
        relaxation.settling = relaxation.may_be_at_rest
        size = 0.0 if relaxation.settling else relaxation.size
        try:
            if relaxation.steps >= relaxation.most_steps and not relaxation.settling:
                raise StepFailed(f"the soil is not at rest after {relaxation.steps} steps")
            with services.observer.attempt(model, clock.step + 1, before, after):
                result = simulation.advance(before, after, on_iteration)
        except StepFailed as failure:
            if relaxation.settling:
                relaxation.not_at_rest()
            elif not failure.residuals or not relaxation.cut(failure.share):
                relaxation.active = False
                raise _not_at_rest(model, relaxation, clock, failure) from failure
            else:
                on_cut(after, failure)
            continue
        except BadInput as error:
            when = f"while soil comes to rest at time {after:.6g}{_of_stage(model)}"
            raise error.during(when) from error
        told = relaxation.accept(state.points, state.distribution, water, result)
        clock.relax(after, told.at_rest)
        before = after
        yield size, replace(result, relaxing=told)


def _of_stage(model: Model) -> str:
    """Returns which stage it is, for messages; empty without stages."""
    stage = model.stage.name
    return f" of the stage {stage!r}" if stage else ""


def _not_at_rest(
    model: Model, relaxation: Relaxation, clock: Clock, failure: StepFailed
) -> AnalysisFailed:
    """Returns the error that ends an analysis whose soil does not come to rest."""
    share = relaxation.kinetic / relaxation.peak if relaxation.peak > 0.0 else 0.0
    return AnalysisFailed(
        f"relaxation {relaxation.number} at time {clock.time:.6g}{_of_stage(model)} failed: "
        f"{failure.reason} (kinetic energy {share:.2g} of its peak; forces of inertia and damping "
        f"{relaxation.force:.2g} of the load)",
        f"the results up to step {clock.step} are complete; see whether anything stops the soil "
        f"(`tilth report` writes {REPORT}), give more analysis.relaxation_steps, or compute the "
        "motion itself with analysis.inertia",
    )


def _failed(
    simulation: Simulation, clock: Clock, size: float, failure: StepFailed
) -> AnalysisFailed:
    """Returns the error that ends the analysis, with all an engineer needs to find the cause."""
    setup, state = simulation.setup, whole_state(simulation.state)
    where = ""
    if failure.point is not None:
        index = state.points.index_of(np.array([failure.point]))[0]
        at = ", ".join(f"{x:.4g}" for x in state.points.position[index])
        where = f"; worst point: number {failure.point} at ({at})"
    shown = [f"{r:.1e}" for r in failure.residuals] or ["none"]
    residuals = " ".join(shown if len(shown) <= 8 else [*shown[:3], "...", *shown[-4:]])
    of_stage = _of_stage(setup.model)
    # the causes are those of steps without equilibrium, not of those known to be too long
    causes = ""
    if not failure.share:
        causes = "; ".join(likely_causes(setup, state, simulation.services, clock, failure))
    likely = f"likely causes: {causes}; " if causes else ""
    offer = ""
    if state.dynamics is None:
        offer = 'go on through a collapse with analysis.beyond_limit = "relax", '
    return AnalysisFailed(
        f"step {clock.step + 1} to time {clock.time + size:.6g}{of_stage} failed: {failure.reason}"
        f" (step size {size:.2g}; relative residuals: {residuals}{where})",
        f"the results up to step {clock.step}, time {clock.time:.6g}{of_stage}, are complete; "
        f"{likely}"
        f"{failure.remedy or 'try smaller steps, a smaller schedule.minimum_step'}, "
        f"{offer}or see where the soil fails (`tilth report` writes {REPORT})",
    )
