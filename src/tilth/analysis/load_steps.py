# SPDX-License-Identifier: BSD-3-Clause
"""The loop over the load steps of an analysis."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.dynamics import SAFETY
from tilth.analysis.likely_causes import likely_causes
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.errors import AnalysisFailed, BadInput, StepFailed
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
    cuts = 0
    while not (clock.done or clock.stops):
        before, after = clock.time, clock.next_time()
        try:
            result = simulation.advance(before, after, on_iteration, clock.is_least)
        except StepFailed as failure:
            if not clock.cut(failure.share):
                raise _failed(simulation, clock, after - before, failure) from failure
            cuts += failure.share is None  # else it is known how much of the step is possible
            if cuts == CUTS_IN_A_ROW and (causes := likely_causes(simulation, clock, failure)):
                simulation.run_warnings.repeated_cuts(clock.step + 1, cuts, causes)
            on_cut(after, failure)
            continue
        except BadInput as error:  # code of the user that fails in this step
            when = f"in step {clock.step + 1} to time {after:.6g}{_of_stage(simulation)}"
            raise error.during(when) from error
        cuts = 0
        clock.accept(after, SAFETY * result.possible_size * (after - before))
        yield after - before, result


def _of_stage(simulation: Simulation) -> str:
    """Returns which stage the simulation is in, for messages; empty without stages."""
    stage = simulation.model.stage.name
    return f" of the stage {stage!r}" if stage else ""


def _failed(
    simulation: Simulation, clock: Clock, size: float, failure: StepFailed
) -> AnalysisFailed:
    """Returns the error that ends the analysis, with all an engineer needs to find the cause."""
    where = ""
    if failure.point is not None:
        index = simulation.points.index_of(np.array([failure.point]))[0]
        at = ", ".join(f"{x:.4g}" for x in simulation.points.position[index])
        where = f"; worst point: number {failure.point} at ({at})"
    shown = [f"{r:.1e}" for r in failure.residuals] or ["none"]
    residuals = " ".join(shown if len(shown) <= 8 else [*shown[:3], "...", *shown[-4:]])
    of_stage = _of_stage(simulation)
    causes = "; ".join(likely_causes(simulation, clock, failure))
    likely = f"likely causes: {causes}; " if causes else ""
    return AnalysisFailed(
        f"step {clock.step + 1} to time {clock.time + size:.6g}{of_stage} failed: {failure.reason}"
        f" (step size {size:.2g}; relative residuals: {residuals}{where})",
        f"the results up to step {clock.step}, time {clock.time:.6g}{of_stage}, are complete; "
        f"{likely}"
        f"{failure.remedy or 'try smaller steps, a smaller schedule.minimum_step'}, "
        f"or see where the soil fails (`tilth report` writes {REPORT})",
    )
