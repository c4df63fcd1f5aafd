# SPDX-License-Identifier: BSD-3-Clause
"""Runs a study: all its samples, its table, its statistics and its report."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tilth.analysis.check import check
from tilth.case import case_entries, load_study
from tilth.environment import available_cores
from tilth.errors import BadInput
from tilth.input_files import absolute
from tilth.interrupt import StopSignals
from tilth.model import Model, Study
from tilth.model.fields import count_of
from tilth.output.folder import make_folder
from tilth.output.lock import FolderLock
from tilth.report.fields import with_unit
from tilth.studies.folder import (
    OUTPUT,
    PAGE,
    PICTURE,
    STATISTICS,
    TABLE,
    Taken,
    prepare,
    read_outcome,
    write_case,
    write_outcome,
    write_table,
)
from tilth.studies.outcomes import require_outcomes, unit_of
from tilth.studies.pool import run_all
from tilth.studies.progress import StudyProgress
from tilth.studies.result import StudyResult
from tilth.studies.samples import Sample, make_samples
from tilth.studies.statistics import statistics, write_statistics

BETWEEN_TABLES = 10.0
"""Time between two writings of the table while samples are run, at least [s]."""


@StopSignals()
def study(
    declared: Study | Path | str,
    out: Path | str,
    *,
    model: Model | None = None,
    processes: int | None = None,
    overwrite: bool = False,
    quiet: bool = False,
) -> StudyResult:
    """Runs all samples of a study and writes everything into the folder `out`.

    Samples that are complete in `out` are not run again: a study that was interrupted, or killed,
    goes on where it stopped, and its table is identical to that of an uninterrupted one, to the
    byte, for any number of processes. A study with further samples adds these.

    Args:
        declared: the study, or its file.
        model: the case, if the study does not name one.
        processes: in which samples run at the same time, each with one thread; as many as there
            are cores if None.
        overwrite: whether another study in `out` is replaced.
        quiet: whether the progress bar is left out.

    Raises:
        BadInput: an entry is wrong or a sample no valid model, before anything is run; `out` has
            something else or is in use.
        AnalysisFailed: a file cannot be written. Samples that fail do not raise: they are in
            `StudyResult.reasons` and in the table.
        KeyboardInterrupt: as in `run`; all processes have ended then.
    """
    used = count_of("processes", processes, available_cores())
    asked = declared if isinstance(declared, Study) else load_study(declared)
    entries = _case_of(asked, model)
    samples = make_samples(asked, entries)
    base = Model.from_dict(samples[0].entries)
    require_outcomes(asked, base)
    check(base)
    folder = absolute(make_folder(out))
    with FolderLock(folder):
        prepare(folder, asked, entries, samples, overwrite)
        running = _Running(folder, asked, base, samples)
        running.run(used, quiet)
        return running.result()


def _case_of(asked: Study, model: Model | None) -> dict[str, Any]:
    """Returns the entries of the case of a study."""
    if (model is None) == (asked.case is None):
        what = "missing" if model is None else "is given, and a model too"
        raise BadInput(what, "name a case file, or give a model", key="case")
    return case_entries(str(asked.case)) if model is None else model.to_dict()


class _Running:
    """A study in its folder, with what has come out so far."""

    def __init__(self, folder: Path, asked: Study, base: Model, samples: Sequence[Sample]) -> None:
        self.folder, self.asked, self.samples = folder, asked, samples
        self.units = [unit_of(outcome, base) for outcome in asked.outcomes]
        names = zip(asked.outcomes, self.units, strict=True)
        self.headings = [v.column for v in asked.vary]
        self.headings += [with_unit(o.name, unit) for o, unit in names]
        self.taken: dict[int, Taken] = {}
        self._written = time.monotonic()
        for sample in samples:
            found = read_outcome(folder, sample, asked)
            if found is not None and not found.ended:
                self.taken[sample.number] = found

    def run(self, processes: int, quiet: bool) -> None:
        """Runs the samples that are not complete; the table is written however it ends."""
        by_folder = {sample.folder: sample for sample in self.samples}
        waiting = [sample for sample in self.samples if sample.number not in self.taken]
        if not waiting:
            self._write_table()
            return
        failed = sum(each.status == "failed" for each in self.taken.values())
        with StudyProgress(len(self.samples), len(self.taken), failed, quiet=quiet) as progress:

            def on_done(own: Path) -> None:
                sample = by_folder[own.name]
                found = read_outcome(self.folder, sample, self.asked)
                assert found is not None
                self.taken[sample.number] = found
                progress.sample(sample.number, found.reason)
                if time.monotonic() - self._written > BETWEEN_TABLES:
                    self._write_table()

            def on_lost(own: Path, how: str) -> None:
                reason = f"its process was ended {how}{_last_said(own)}"
                write_outcome(own, [None] * len(self.asked.outcomes), reason, ended=True)
                on_done(own)

            def folders() -> Iterator[Path]:
                for sample in waiting:
                    yield write_case(self.folder, self.asked, sample)

            try:
                run_all(self.folder, folders(), min(processes, len(waiting)), on_done, on_lost)
            finally:
                self._write_table()

    def _write_table(self) -> None:
        write_table(self.folder / TABLE, self.headings, self.samples, self.taken)
        self._written = time.monotonic()

    def result(self) -> StudyResult:
        """Returns all that has come out, and writes statistics and report."""
        first = len(self.asked.vary)
        numbers = [sample.number for sample in self.samples]
        rows = [self.taken[number].outcomes for number in numbers]
        table = np.array(rows, dtype=np.float64).reshape(len(rows), len(self.asked.outcomes))
        found = [
            statistics(outcome.name, unit, numbers, table[:, i], outcome.worst)
            for i, (outcome, unit) in enumerate(zip(self.asked.outcomes, self.units, strict=True))
        ]
        write_statistics(self.folder / STATISTICS, found)
        result = StudyResult(
            folder=self.folder,
            numbers=numbers,
            values={
                heading: [sample.values[i] for sample in self.samples]
                for i, heading in enumerate(self.headings[:first])
            },
            outcomes={h: table[:, i] for i, h in enumerate(self.headings[first:])},
            reasons={n: self.taken[n].reason for n in numbers if self.taken[n].reason},
            statistics=found,
        )
        from tilth.studies.page import write_page

        write_page(self.folder / PAGE, self.folder / PICTURE, self.asked, result)
        return result


def _last_said(folder: Path) -> str:
    """Returns what the process of a sample has said last, after ": ", or nothing."""
    try:
        lines = (folder / OUTPUT).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return ""
    said = [line for line in lines if line.strip() and not line.startswith(" ")]
    return f": {said[-1]}" if said else ""
