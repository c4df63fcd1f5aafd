# SPDX-License-Identifier: BSD-3-Clause
"""The loop over all load steps of a run, which is left between two steps and gone on with."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeVar

from tilth.analysis.explain import Explanation
from tilth.analysis.explain_files import told
from tilth.analysis.recorder import Recorder
from tilth.analysis.safety import strength_reduction
from tilth.analysis.safety_record import record
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.errors import AnalysisFailed, BadInput, StepFailed
from tilth.interrupt import DeferredStop

GO_ON, STOP, LEAVE = 0, 1, 2
"""What a caller asks for between two steps; LEAVE: no step is given any more."""

T = TypeVar("T")


@dataclass
class TakenStep:
    """A converged and recorded step, given to the caller before the next one is taken.

    Attributes:
        analysis: in the state after it; the caller may `change` its model.
        recorder: of the run.
        size: of the step [time].
        result: of the step.
        signals: takes the requests to stop; the caller may pause it while code of the user runs.
        asked: what the caller asks for.
    """

    analysis: StagedAnalysis
    recorder: Recorder
    size: float
    result: StepResult
    signals: DeferredStop
    asked: int = GO_ON


Steps = Generator[TakenStep, None, T]
"""Gives each step, and at the end a `T`; it must be exhausted, not closed."""


def exhausted(steps: Steps[T]) -> T:
    """Takes all steps; returns what they end with."""
    try:
        while True:
            next(steps)
    except StopIteration as end:
        result: T = end.value
        return result
    finally:
        steps.close()  # where a second Ctrl-C came just here


def take_steps(
    analysis: StagedAnalysis,
    recorder: Recorder,
    quiet: bool,
    explanation: Explanation | None = None,
) -> Steps[int]:
    """Takes and records the load steps; gives each and at the end the number of iterations.

    Where one process asks to stop, all do.

    explanation: of a step, which is written as soon as this step is accepted or the run ends.
    """
    iterations, comm, going = 0, analysis.state.comm, True
    if explanation is not None:
        analysis.services.observer = explanation
    with DeferredStop() as stop:
        with (
            recorder.recording(analysis.clock, quiet) as progress,
            told(explanation, recorder.folder, progress.message) as tell,
        ):

            def on_iteration(iteration: int, residual: float) -> None:
                stop.check_all(comm.max)
                progress.iteration(analysis.clock.step + 1, iteration, residual)

            def on_cut(time: float, failure: StepFailed) -> None:
                recorder.cut(analysis.clock, time, failure)

            def on_stage_end() -> None:
                recorder.stage_end()
                reduce_strength(analysis, recorder, lambda *_: stop.check_all(comm.max))

            while going:
                for size, result in analysis.steps(
                    on_iteration, on_cut, on_stage_end, recorder.stage_start
                ):
                    iterations += result.equilibrium.iterations
                    clock, simulation = analysis.clock, analysis.simulation
                    recorder.step(clock, size, result)
                    tell()
                    progress.step_done(clock.step, analysis.time, result.equilibrium.iterations)
                    taken = TakenStep(analysis, recorder, size, result, stop)
                    yield taken
                    asked = int(comm.max(float(taken.asked)))
                    if asked != GO_ON and not clock.done:
                        analysis.stop()
                        recorder.stop()
                    if asked == LEAVE and not clock.done:
                        going = False
                        break
                    if analysis.simulation is not simulation:
                        break  # the steps go on with the changed one
                else:
                    going = False
        stop.check_all(comm.max)  # a signal in the last iteration
    return iterations


def reduce_strength(
    analysis: StagedAnalysis, recorder: Recorder, on_iteration: Callable[[int, float], None]
) -> None:
    """Makes the strength reductions at the end of the present stage.

    Raises:
        AnalysisFailed: a factor of safety is not found.
    """
    clock, setup, state, services = (
        analysis.clock,
        analysis.setup,
        analysis.state,
        analysis.services,
    )
    for index, stage in setup.model.stage.reductions:
        try:
            result = strength_reduction(
                analysis.simulation, clock.time, stage, on_iteration=on_iteration
            )
        except AnalysisFailed as failure:
            raise AnalysisFailed(f"stage {stage.name!r}: {failure.message}", failure.remedy) from (
                failure
            )
        except BadInput as error:
            raise error.during(f"in the stage {stage.name!r}") from error
        record(recorder.folder, setup, state, services, clock.step, clock.time, result, index)
        if not result.is_decided:
            what = f"stage {stage.name!r}: {result.text}"
            services.warnings.note(f"safety {index}", what)
        recorder.factor_of_safety(stage.name, result.text)
