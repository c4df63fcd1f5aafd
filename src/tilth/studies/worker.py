# SPDX-License-Identifier: BSD-3-Clause
"""A process that runs samples, one after the other: `python -m tilth.studies.worker FOLDER`.

It reads the folders of samples from its input, a line each, and answers each with a line when the
sample's `outcome.json` is complete. It ends with its input, that is with the study, however that
ends.
"""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from tilth.errors import EXIT_INTERRUPTED, BadInput, TilthError
from tilth.memory_errors import is_memory_error, memory_sentence
from tilth.model import SafetyOutcome, StrengthReduction, Study
from tilth.output.folder import (
    CHECKPOINT,
    REPORT,
    RESULTS,
    SETUP,
    STAGE_CHECKPOINT,
    safety_files,
)
from tilth.output.lock import FolderLock
from tilth.studies.folder import CASE, OUTPUT, RUN, read_record, write_outcome

LOCK_WAIT = 20.0
"""How long to wait for a process of an earlier study that has not ended yet [s]."""

BULKY = (CHECKPOINT, RESULTS, REPORT, SETUP, safety_files().mechanism, safety_files().picture)
"""Files of a run that are no tables."""


def run_sample(study: Study, folder: Path) -> None:
    """Runs the sample in a folder and writes its `outcome.json`, also if the run fails."""
    with _locked(folder):
        outcomes: list[float | None] = [None] * len(study.outcomes)
        reason = ""
        try:
            _analyse(study, folder)
            outcomes, reason = _taken(study, folder / RUN)
        except TilthError as error:
            reason = error.problem if isinstance(error, BadInput) else error.message
        except Exception as error:
            traceback.print_exc()
            reason = f"{type(error).__name__}: {error}"
            if is_memory_error(error):
                reason = memory_sentence(error)
        if study.keep == "tables":
            _remove_bulky(folder / RUN)
        write_outcome(folder, outcomes, " ".join(reason.split()))


def _analyse(study: Study, folder: Path) -> None:
    """Runs the analysis, and the search for the factor of safety if it is an outcome."""
    from tilth.analysis.run import run
    from tilth.analysis.safety_run import safety
    from tilth.case import load_case

    model = load_case(folder / CASE)
    if study.keep == "tables":
        output = model.output.model_copy(update={"report": False})
        model = model.model_copy(update={"output": output})
    options: dict[str, Any] = {"threads": 1, "overwrite": True, "quiet": True}
    for outcome in study.outcomes:
        if isinstance(outcome, SafetyOutcome):
            settings = StrengthReduction(
                tolerance=outcome.tolerance, start=outcome.start, davis=outcome.davis
            )
            safety(model, folder / RUN, settings=settings, **options)
            return
    run(model, folder / RUN, **options)


def _taken(study: Study, run: Path) -> tuple[list[float | None], str]:
    """Returns all outcomes, and why there is none of some."""
    from tilth.studies.outcomes import value_of

    outcomes: list[float | None] = []
    reasons = []
    for outcome in study.outcomes:
        try:
            outcomes.append(value_of(outcome, run))
        except BadInput as error:
            outcomes.append(None)
            reasons.append(f"{outcome.name}: {error.problem}")
    return outcomes, "; ".join(reasons)


def _remove_bulky(run: Path) -> None:
    if not run.is_dir():
        return
    stages = [file.name for file in run.iterdir() if STAGE_CHECKPOINT.fullmatch(file.name)]
    for name in (*BULKY, *stages):
        (run / name).unlink(missing_ok=True)


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Holds the lock of a sample's folder, after a process that is about to end if need be."""
    until = time.monotonic() + LOCK_WAIT
    with ExitStack() as stack:
        while True:
            try:
                stack.enter_context(FolderLock(folder))
                break
            except BadInput:
                if time.monotonic() > until:
                    raise
                time.sleep(0.1)
        yield


def _read_lines(lines: queue.Queue[str]) -> None:
    """Passes on the lines of the input; ends the process with it, in the middle of a run too."""
    for line in sys.stdin:
        lines.put(line.rstrip("\n"))
    os._exit(EXIT_INTERRUPTED)


def main() -> None:
    """Runs samples until the input ends."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    lines: queue.Queue[str] = queue.Queue()
    threading.Thread(target=_read_lines, args=(lines,), daemon=True).start()
    study, _ = read_record(Path(sys.argv[1]))
    while True:
        folder = Path(lines.get())
        with (folder / OUTPUT).open("w") as text:
            for number in (1, 2):  # what user's functions and libraries print
                os.dup2(text.fileno(), number)
        run_sample(study, folder)
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        if not (folder / OUTPUT).stat().st_size:
            (folder / OUTPUT).unlink()
        answers.write(f"{folder.name}\n")
        answers.flush()


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        os._exit(EXIT_INTERRUPTED)
