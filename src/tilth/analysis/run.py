# SPDX-License-Identifier: BSD-3-Clause
"""Runs and resumes an analysis with all its files."""

from __future__ import annotations

import json
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from tilth import _core
from tilth.analysis.asked_step import AskedStep, steps_before
from tilth.analysis.continued import go_on_with, require_continuable
from tilth.analysis.explain import Explanation
from tilth.analysis.from_stage import begin_from, stored_stage
from tilth.analysis.memory import memory_of, require_memory
from tilth.analysis.memory_failures import memory_failures
from tilth.analysis.recorder import Recorder
from tilth.analysis.setup_picture import checked_setup, write_report
from tilth.analysis.staged import StagedAnalysis, end_time
from tilth.analysis.stepping import Steps, exhausted, take_steps
from tilth.analysis.stored_run import StoredRun
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator, together
from tilth.environment import available_cores
from tilth.errors import AnalysisFailed, BadInput, TilthError
from tilth.input_files import absolute
from tilth.interrupt import StopSignals
from tilth.memory_errors import is_memory_error, memory_sentence
from tilth.model import Model
from tilth.model.fields import count_of
from tilth.model.overview import html_table
from tilth.mpi import world
from tilth.mpm.points import MaterialPoints
from tilth.output import prepare_output_folder, read_history
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.output.folder import (
    HISTORY,
    MODEL,
    SETUP,
    load_model,
    make_folder,
    require_folder,
)
from tilth.output.lock import FolderLock
from tilth.output.safety_files import undecided_factors
from tilth.report.setup_file import write_setup
from tilth.results.run_results import RunResults

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Result:
    """A finished analysis.

    Attributes:
        finished: whether the end of the schedule is reached.
        folder: where results.vtkhdf, history.csv, report.html and log.txt are.
        points: the material points at the end; of several processes those that this one owns.
        steps, iterations: load steps taken and Newton iterations in all, of this run.
        seconds, processor_seconds: wall-clock and processor time by part: basis, stress,
            assembly, solve, other [s]; those before a resume are included.
    """

    finished: bool
    folder: Path
    points: MaterialPoints
    steps: int
    iterations: int
    seconds: dict[str, float]
    processor_seconds: dict[str, float]

    def __repr__(self) -> str:
        return f"<Result: {self._end}, {self._size}, in {self.folder}>"

    def _repr_html_(self) -> str:
        seconds = f"{sum(self.seconds.values()):.3g} s"
        rows = {"run": self._end, "size": self._size, "time": seconds, "folder": str(self.folder)}
        return html_table(rows)

    @property
    def undecided(self) -> dict[str, str]:
        """What is certain of the stages' factors of safety that are undecided, by their names."""
        return undecided_factors(load_model(self.folder), self.folder)

    @property
    def _end(self) -> str:
        return "finished" if self.finished else "stopped before its end"

    @property
    def _size(self) -> str:
        return f"{len(self.points)} points, {self.steps} steps, {self.iterations} iterations"

    @property
    def history(self) -> dict[str, Floats]:
        """Columns of history.csv by heading (`name [unit]`), each of shape (rows,)."""
        return read_history(self.folder / HISTORY)

    @property
    def results(self) -> RunResults:
        """All outputs of the run, as `tilth.open` opens them."""
        return RunResults(self.folder)

    def plot(
        self,
        field: str,
        time: float | None = None,
        *,
        show: Literal["field", "points", "domains"] = "field",
        section: str | None = None,
        values: tuple[float, float] | None = None,
    ) -> Figure:
        """Returns the figure of a field over the deformed soil, see `RunResults.plot`."""
        return self.results.plot(field, time, show=show, section=section, values=values)


@StopSignals()
def run(
    model: Model,
    out: Path | str,
    *,
    threads: int | None = None,
    until: float | None = None,
    memory_limit: float | str | None = None,
    overwrite: bool = False,
    from_stage: tuple[Path | str, str] | None = None,
    continues: bool = False,
    quiet: bool = False,
    explain: int | str | None = None,
) -> Result:
    """Runs the analysis of a model and writes everything into the folder `out`.

    Args:
        threads: all cores if None; the results do not depend on it.
        until: time of the schedule at which to stop, in (0, end]; its end if None. The steps are
            those of the whole run: it stops at the end of the first one that reaches this time,
            writes that state and a checkpoint, and `resume` continues.
        memory_limit: memory that the run may need by its estimate [byte], or with a unit ("64GB");
            what is available if None.
        overwrite: whether an earlier run in `out` is replaced.
        from_stage: folder of another run and name of a stage from whose end this run goes on; the
            stages up to that one must be the same. None to begin at the start.
        continues: whether the run in `out`, finished or not, goes on from its checkpoint with this
            model, which may differ in what is still to come only: a later end of the schedule,
            rows of tables after the time that is reached, stages at the end, `output`.
        quiet: whether the progress bar is left out.
        explain: a step whose residual is explained term by term, whether it is found or fails: its
            number from 1 on, or "STAGE:STEP", counted from the start of a stage. The files
            explain_N.json, .csv and .png are written beside the results, which stay the same. Not
            with several processes.

    Raises:
        BadInput: the model cannot be computed, `until` is not a time of its schedule, `out` is not
            empty or in use by another run, the run needs too much memory, or the one in `out`
            cannot go on with this model. Nothing is changed then. Or the run, whose
            results are on disk then, ended or stopped at `until` without the step `explain`.
        AnalysisFailed: no equilibrium with the least step, not enough memory, or a file that cannot
            be written (a full disk); results so far are on disk. Or the report, after a complete
            analysis.
        KeyboardInterrupt: by Ctrl-C, and in the main thread also by SIGTERM and SIGHUP, unless the
            program has handlers of its own for them; `resume` continues.
    """
    return exhausted(
        run_steps(
            model,
            out,
            threads,
            until,
            memory_limit,
            overwrite,
            from_stage,
            continues,
            quiet,
            explain,
        )
    )


def run_steps(
    model: Model,
    out: Path | str,
    threads: int | None,
    until: float | None,
    memory_limit: float | str | None,
    overwrite: bool,
    from_stage: tuple[Path | str, str] | None,
    continues: bool,
    quiet: bool,
    explain: int | str | None = None,
) -> Steps[Result]:
    """As `run`, step by step."""
    if continues and (overwrite or from_stage is not None):
        what = "does not go with `overwrite` or `from_stage`: the run goes on in its folder"
        raise BadInput(what, "leave them out", key="continues")
    require_time(model, until)
    comm = world()
    asked = None if explain is None else AskedStep.of(explain, model, comm)
    estimate = memory_of(model)
    with together(comm):
        require_memory(estimate, memory_limit)
    with memory_failures(estimate, Path(out)), ExitStack() as stack:
        used = set_threads(threads, comm)
        with together(comm):
            analysis = StagedAnalysis(model, until)
            active, setup = checked_setup(analysis)
            simulation = analysis.simulation
            require_memory(memory_of(model, simulation.state.points, active), memory_limit)
            stored = None if from_stage is None else stored_stage(model, *from_stage)
            if asked is not None and stored is not None:
                asked.require_after(stored, model)
        initial = analysis.initial
        analysis.distribute(comm)
        warning = change = ""
        with together(comm):
            folder = require_folder(out) if continues else make_folder(out)
            if comm.rank == 0:
                warning = stack.enter_context(FolderLock(folder)).warning
            if continues:
                earlier = StoredRun.read(folder)
                change = require_continuable(earlier, model, until)
                if asked is not None:
                    asked.require_after(earlier, model)
                if comm.rank == 0:
                    go_on_with(earlier, model, setup)
            elif comm.rank == 0:
                if stored is not None and absolute(folder) == absolute(stored.folder):
                    what = "the run cannot be written into the folder from which it goes on"
                    raise BadInput(what, "choose another folder", key="out", value=str(out))
                prepare_output_folder(folder, overwrite)
                if stored is not None:
                    begin_from(stored, model, folder)
                else:
                    with writing(folder / MODEL):
                        text = json.dumps(model.to_dict(), indent=1)
                        write_durably(folder / MODEL, text.encode())
                write_setup(folder / SETUP, setup)
            del setup  # it may have copies of the points
        if stored is not None or continues:
            return (yield from _resumed(folder, until, used, warning, quiet, comm, change, explain))
        del simulation  # the first stage may have another one
        start = analysis.begin()
        if comm.size > 1:
            active = analysis.simulation.locate(0.0)
        recorder = Recorder.start(folder, analysis, active, used, start, initial)
        del initial
        explanation = None if asked is None else Explanation(asked)
        return (yield from _march(analysis, recorder, warning, quiet, explanation))


@StopSignals()
def resume(
    out: Path | str,
    *,
    threads: int | None = None,
    until: float | None = None,
    memory_limit: float | str | None = None,
    quiet: bool = False,
    explain: int | str | None = None,
) -> Result:
    """Continues from the last checkpoint in `out`; results agree to the last bit.

    Args:
        threads, until, memory_limit, quiet, explain: as in `run`; `until` and `explain` are later
            than the checkpoint.

    Raises:
        BadInput: there is nothing to resume in `out` or its files are damaged, another run uses
            it, `until` is not a time that is to come, or the run needs too much memory. Nothing is
            changed then. And as in `run`, without the step `explain`.
        AnalysisFailed, KeyboardInterrupt: as in `run`.
    """
    return exhausted(resume_steps(out, threads, until, memory_limit, quiet, explain))


def resume_steps(
    out: Path | str,
    threads: int | None,
    until: float | None,
    memory_limit: float | str | None,
    quiet: bool,
    explain: int | str | None = None,
) -> Steps[Result]:
    """As `resume`, step by step."""
    comm, warning = world(), ""
    with ExitStack() as stack:
        with together(comm):
            folder = require_folder(out)
            if comm.rank == 0:
                warning = stack.enter_context(FolderLock(folder)).warning
            estimate = memory_of(load_model(folder))
            require_memory(estimate, memory_limit)
        with memory_failures(estimate, folder):
            used = set_threads(threads, comm)
            return (yield from _resumed(folder, until, used, warning, quiet, comm, explain=explain))


def _resumed(
    folder: Path,
    until: float | None,
    threads: int,
    warning: str,
    quiet: bool,
    comm: Communicator,
    change: str = "",
    explain: int | str | None = None,
) -> Steps[Result]:
    """Continues from the last checkpoint in a folder.

    warning: of its lock. change: what is new in the model, for the log. explain: see `run`.
    """
    explanation = None
    with together(comm):
        stored = StoredRun.read(folder)
        if explain is not None:
            asked = AskedStep.of(explain, stored.model, comm)
            asked.require_after(stored, stored.model)
            explanation = Explanation(asked, steps_before(stored))
        require_time(stored.model, until)
        analysis = stored.analysis(until)
        if until is not None and analysis.stops:
            raise BadInput(
                f"the run is already complete up to time {analysis.time:.6g}",
                f"give a later time, at most {end_time(stored.model):.6g}, or leave it out",
                key="until",
                value=until,
            )
    analysis.distribute(comm)
    recorder = Recorder.resume(stored, analysis, threads)
    if change:
        with together(comm):
            recorder.log.goes_on(change)
    return (yield from _march(analysis, recorder, warning, quiet, explanation))


def require_time(model: Model, until: float | None) -> None:
    """Checks that a total time at which to stop is one of the analysis.

    Raises:
        BadInput: it is not.
    """
    end = end_time(model)
    if until is not None and not 0.0 < until <= end:
        raise BadInput(
            f"is not a time of the schedule, which goes from 0 to {end:.6g}",
            f"give a time above 0 and at most {end:.6g}",
            key="until",
            value=until,
        )


MOST_THREADS = 1024
"""As the core has it."""


def set_threads(threads: int | None, comm: Communicator = SERIAL) -> int:
    """Sets the number of threads of the kernels, all available cores if None; returns it.

    comm: processes that have the cores together; each has one thread if None.

    Raises:
        BadInput: the number is no whole number from 1 on, or there are more than `MOST_THREADS`.
    """
    used = count_of("threads", threads, 1 if comm.size > 1 else available_cores())
    if used > MOST_THREADS:
        remedy = f"give at most {MOST_THREADS}"
        raise BadInput("is more than the core takes", remedy, key="threads", value=used)
    _core.set_threads(used)
    return used


def _march(
    analysis: StagedAnalysis,
    recorder: Recorder,
    warning: str,
    quiet: bool,
    explanation: Explanation | None,
) -> Steps[Result]:
    """Takes all load steps and writes the report, also of an analysis that failed."""
    first = analysis.clock.step
    if warning:
        analysis.services.warnings.note("lock", warning)
    try:
        iterations = yield from take_steps(analysis, recorder, quiet, explanation)
    except AnalysisFailed:
        with suppress(AnalysisFailed):
            _report(recorder)
        raise
    _report(recorder)
    simulation = analysis.simulation
    if explanation is not None:
        clock, stage = analysis.clock, simulation.setup.model.stage.name
        explanation.require_reached(recorder.folder, clock.step, stage, clock.done, analysis.done)
    return Result(
        finished=analysis.done,
        folder=recorder.folder,
        points=simulation.state.owned_points,
        steps=analysis.clock.step - first,
        iterations=iterations,
        seconds=dict(simulation.services.timers.wall),
        processor_seconds=dict(simulation.services.timers.processor),
    )


def _report(recorder: Recorder) -> None:
    """Writes the report; the results are complete without it.

    Raises:
        AnalysisFailed: it cannot be drawn or written, whatever the reason.
    """
    comm = recorder.analysis.state.comm
    if not recorder.analysis.model.output.report:
        return
    with together(comm):
        try:
            if comm.rank == 0:
                with recorder.analysis.services.timers.measure("other"):
                    write_report(recorder.folder)
        except Exception as error:
            reason = error.message if isinstance(error, TilthError) else f"{error}"
            if is_memory_error(error):
                reason = memory_sentence(error)
            raise AnalysisFailed(
                f"the results are in {recorder.folder}, but not the report: {reason}",
                f"write it again with: tilth report {recorder.folder}",
            ) from error
