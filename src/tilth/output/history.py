# SPDX-License-Identifier: BSD-3-Clause
"""``history.csv``, ``boundaries.csv`` and ``energies.csv``: every quantity, one row per step."""

from __future__ import annotations

import csv
import io
import os
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.output.disk import writing
from tilth.output.files import RESTORE, write_durably

FIRST_COLUMNS = ("step", "time", "iterations")

OF_STAGES = ("stage", "stage_time")
"""Columns that follow in an analysis with stages: name of the stage, and the time within it."""


class Mark(NamedTuple):
    """Up to where a checkpoint counts on the history: number of bytes and their check sum."""

    size: int
    checksum: int


class HistoryWriter:
    """Writes the history row by row; ``append`` flushes each row to the file.

    ``columns`` are (name, unit) of the tracked quantities, the unit "" for pure numbers. Numbers
    are written with all digits, so that reading is bit-exact. All methods raise ``AnalysisFailed``
    if the file cannot be written.
    """

    def __init__(
        self,
        path: Path | str,
        columns: Sequence[tuple[str, str]],
        content: bytes = b"",
        stages: bool = False,
    ) -> None:
        """Starts a new file, replacing any at ``path``, or goes on after ``content``.

        ``stages`` tells whether the columns ``OF_STAGES`` are written.

        ``content`` is what :func:`checked_history` returned; what the file has after it is deleted.
        """
        self.path = Path(path)
        self._count, self._stages = len(columns), stages
        content = content or heading_row(columns, stages).encode()
        self._mark = Mark(len(content), zlib.crc32(content))
        with writing(self.path):
            write_durably(self.path, content)
            self._file = self.path.open("ab")

    def append(
        self,
        step: int,
        time: float,
        iterations: int,
        values: Sequence[float],
        stage: tuple[str, float] = ("", 0.0),
    ) -> None:
        """Writes the row of one step; ``values`` in the order of the columns.

        ``time`` is the total time, ``stage`` the name of the stage and the time within it.
        """
        if len(values) != self._count:
            raise ValueError(f"{len(values)} values for {self._count} columns")
        of_stage = [stage[0], repr(float(stage[1]))] if self._stages else []
        numbers = [repr(float(value)) for value in (time, *values)]
        row = _row([str(step), numbers[0], str(iterations), *of_stage, *numbers[1:]]).encode()
        with writing(self.path):
            self._file.write(row)
            self._file.flush()
        self._mark = Mark(self._mark.size + len(row), zlib.crc32(row, self._mark.checksum))

    @property
    def mark(self) -> Mark:
        """What a checkpoint keeps of the rows so far."""
        return self._mark

    def sync(self) -> None:
        """Waits until all rows are on the disk; also while another thread appends to them."""
        with writing(self.path):
            os.fsync(self._file.fileno())

    def close(self) -> None:
        """Closes the file."""
        with writing(self.path):
            self._file.close()


def checked_history(
    path: Path | str,
    columns: Sequence[tuple[str, str]],
    last_step: int,
    mark: Mark,
    stages: bool = False,
) -> bytes:
    """Returns the rows of the steps 0 to ``last_step`` with the headings, as they are in the file.

    Later rows, and an incomplete last one (of a run that was killed), are left out. ``mark`` is
    that of the checkpoint. Raises ``BadInput`` if the columns are not ``columns``, or a row is
    missing or not as it was written.
    """
    path = Path(path)
    try:
        require_file(path)
        content = path.read_bytes()
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}", RESTORE) from error
    heading = heading_row(columns, stages).encode()
    if not content.startswith(heading):
        raise BadInput(f"{path}: the columns are not those of this case", RESTORE)
    rows = content[len(heading) :].splitlines(keepends=True)[: last_step + 1]
    kept = heading + b"".join(rows)
    if Mark(len(kept), zlib.crc32(kept)) == mark and len(rows) == last_step + 1:
        return kept
    for step in range(last_step + 1):
        if step >= len(rows) or not _is_row(rows[step], step, len(columns), stages):
            state = "missing" if step >= len(rows) else "damaged"
            problem = (
                f"{path}: the row of step {step} is {state}, but the checkpoint is of step "
                f"{last_step}"
            )
            raise BadInput(problem, RESTORE)
    raise BadInput(f"{path} was changed after the run wrote it", RESTORE)


def mark_of(content: bytes, last_step: int) -> Mark:
    """Returns the mark of the headings and the rows of the steps 0 to ``last_step``."""
    kept = b"".join(content.splitlines(keepends=True)[: last_step + 2])
    return Mark(len(kept), zlib.crc32(kept))


def with_columns(content: bytes, columns: Sequence[tuple[str, str]]) -> bytes:
    """Returns a history with stages with other columns; NaN in those that it does not have."""
    rows = list(csv.reader(io.StringIO(content.decode())))
    first = len(FIRST_COLUMNS) + len(OF_STAGES)
    place = {heading: index for index, heading in enumerate(rows[0])}
    wanted = [place.get(heading) for heading in headings(columns)]
    lines = [heading_row(columns, stages=True)]
    for row in rows[1:]:
        lines.append(_row([*row[:first], *("nan" if i is None else row[i] for i in wanted)]))
    return "".join(lines).encode()


def read_history(path: Path | str) -> dict[str, Floats]:
    """Returns all columns by heading (``name [unit]``), each of shape (rows,).

    An incomplete last row (of a run that was killed) is left out. Raises ``BadInput`` if the file
    is not the history of a run: other first columns, rows that are no numbers, steps that are not
    0, 1, 2, ...
    """
    path = Path(path)
    try:
        require_file(path)
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        rows = list(csv.reader(line for line in lines if line.endswith("\n")))
        if not rows:
            raise BadInput(f"{path} is empty: it is not the history of a tilth run", RESTORE)
        headings = [h for h in rows[0] if h != OF_STAGES[0]]
        numbers = [
            [cell for heading, cell in zip(rows[0], row, strict=True) if heading != OF_STAGES[0]]
            for row in rows[1:]
        ]
        table = np.array(numbers, dtype=np.float64).reshape(len(rows) - 1, len(headings))
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}", RESTORE) from error
    except (ValueError, csv.Error) as error:
        raise BadInput(f"{path}: not a table of numbers ({error})", RESTORE) from error
    if tuple(rows[0][: len(FIRST_COLUMNS)]) != FIRST_COLUMNS:
        problem = f"{path}: the first columns are not {', '.join(FIRST_COLUMNS)}"
        raise BadInput(problem, RESTORE)
    wrong = np.flatnonzero(table[:, 0] != np.arange(len(table)))
    if len(wrong) or not np.isfinite(table[:, : len(FIRST_COLUMNS)]).all():
        step = int(wrong[0]) if len(wrong) else "a later one"
        raise BadInput(f"{path}: the row of step {step} is missing or damaged", RESTORE)
    return {heading: table[:, index].copy() for index, heading in enumerate(headings)}


def read_stages(path: Path | str) -> list[tuple[str, float, float]]:
    """Returns the stages of a history: name, total time of the first and the last row of each.

    An empty list for a history without stages, or a file that cannot be read.
    """
    try:
        require_file(path)
        with Path(path).open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row.get(OF_STAGES[0])]
        found: list[tuple[str, float, float]] = []
        for row in rows:
            name, time = row[OF_STAGES[0]], float(row["time"])
            if found and found[-1][0] == name:
                found[-1] = (name, found[-1][1], time)
            else:
                found.append((name, found[-1][2] if found else time, time))
    except (OSError, ValueError, TypeError, csv.Error):
        return []
    return found


def heading_row(columns: Sequence[tuple[str, str]], stages: bool = False) -> str:
    """Returns the first line of a history; arguments as in :class:`HistoryWriter`."""
    return _row([*FIRST_COLUMNS, *(OF_STAGES if stages else ()), *headings(columns)])


def headings(columns: Sequence[tuple[str, str]]) -> list[str]:
    """Returns the headings of columns (name, unit)."""
    return [f"{name} [{unit}]" if unit else name for name, unit in columns]


def _row(cells: Sequence[str]) -> str:
    """Returns one line of CSV with its line end."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _is_row(line: bytes, step: int, columns: int, stages: bool) -> bool:
    """Returns whether a line is complete, of this step, and of numbers."""
    cells = line.split(b",")
    if stages:
        del cells[len(FIRST_COLUMNS) : len(FIRST_COLUMNS) + 1]
        columns += 1
    try:
        numbers = [float(cell) for cell in cells[1:]]
        return (
            line.endswith(b"\n")
            and cells[0] == str(step).encode()
            and len(numbers) == len(FIRST_COLUMNS) - 1 + columns
        )
    except ValueError:
        return False
