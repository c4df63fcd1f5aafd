# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety of a model or of a run, with all its files."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from tilth.analysis.run import run, set_threads
from tilth.analysis.safety import SafetyResult, strength_reduction
from tilth.analysis.safety_record import record
from tilth.analysis.safety_search import Trial
from tilth.analysis.setup_picture import write_report
from tilth.analysis.staged import end_time
from tilth.analysis.stored_run import StoredRun
from tilth.comm import together
from tilth.errors import BadInput
from tilth.interrupt import DeferredStop, StopSignals
from tilth.model import Model, StrengthReduction
from tilth.mpi import world
from tilth.mpm.frozen_points import require_reducible
from tilth.output.folder import CHECKPOINT, require_folder
from tilth.output.lock import FolderLock


@StopSignals()
def safety(
    model: Model | Path | str,
    out: Path | str | None = None,
    *,
    settings: StrengthReduction | None = None,
    threads: int | None = None,
    overwrite: bool = False,
    quiet: bool = False,
    on_trial: Callable[[Trial], None] = lambda trial: None,
) -> SafetyResult:
    """Finds the factor of safety at the end of an analysis, and writes its files.

    Where the result is not `is_decided`, only its bracket is certain.

    Besides the files of the run the folder gets `safety.csv`, `safety.json`, `safety.vtkhdf` and
    `safety.png`; the report shows them.

    Args:
        model: is run first, as by `run`; or the folder of an earlier run, whose last checkpoint is
            the state.
        out: folder of a model's run.
        settings: of the search.
        threads, overwrite, quiet: as in `run`.
        on_trial: is called with each factor that was tried.

    Raises:
        BadInput: as `run` and `strength_reduction`; `out` without a model or the reverse.
        AnalysisFailed: as `run` and `strength_reduction`.
        KeyboardInterrupt: as in `run`; the run's files are complete once it is finished.
    """
    if isinstance(model, Model):
        if out is None:
            raise BadInput("missing", "give the folder of the results", key="out")
        require_reducible(model.of_stages[-1], settings.davis if settings else None)
        until = None if model.output.checkpoint_every else end_time(model)  # has a checkpoint
        run(model, out, threads=threads, until=until, overwrite=overwrite, quiet=quiet)
        folder = Path(out)
    else:
        if out is not None:
            raise BadInput("has no meaning for the folder of a run", "leave it out", key="out")
        folder = require_folder(model)
    return _of_run(folder, settings or StrengthReduction(), threads, on_trial)


def _of_run(
    folder: Path,
    settings: StrengthReduction,
    threads: int | None,
    on_trial: Callable[[Trial], None],
) -> SafetyResult:
    """Finds the factor of safety of the last checkpoint of a run."""
    comm = world()
    with ExitStack() as stack:
        with together(comm):
            if comm.rank == 0:
                stack.enter_context(FolderLock(folder))
            if not (folder / CHECKPOINT).exists():
                raise BadInput(
                    f"{folder} has no checkpoint",
                    "run the case with `checkpoint_every` of at least 1 in [output]",
                )
            stored = StoredRun.read(folder)
            analysis = stored.analysis(None)
        set_threads(threads, comm)
        analysis.distribute(comm)
        clock, setup, state = analysis.clock, analysis.setup, analysis.state
        with DeferredStop() as stop:
            result = strength_reduction(
                analysis.simulation,
                clock.time,
                settings,
                on_trial,
                lambda *_: stop.check_all(comm.max),
            )
            stop.check_all(comm.max)
        record(folder, setup, state, analysis.services, clock.step, clock.time, result)
        with together(comm):
            if stored.model.output.report and comm.rank == 0:
                write_report(folder)
    return result
