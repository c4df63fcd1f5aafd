# SPDX-License-Identifier: BSD-3-Clause
"""``history.csv``: one row per load step with every tracked quantity."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.output.files import write_durably

FIRST_COLUMNS = ("step", "time", "iterations")


class HistoryWriter:
    """Writes the history row by row; ``append`` flushes each row to the file.

    ``columns`` are (name, unit) of the tracked quantities, the unit "" for pure numbers. Numbers
    are written with all digits, so that reading is bit-exact.
    """

    def __init__(self, path: Path | str, columns: Sequence[tuple[str, str]]) -> None:
        """Starts a new file, replacing any at ``path``."""
        self.path = Path(path)
        self._count = len(columns)
        write_durably(self.path, _row([*FIRST_COLUMNS, *_headings(columns)]).encode())
        self._file = self.path.open("a", encoding="utf-8", newline="")

    @classmethod
    def resume(
        cls, path: Path | str, last_step: int, columns: Sequence[tuple[str, str]]
    ) -> HistoryWriter:
        """Continues the file at ``path``, after removing all rows after ``last_step``.

        An incomplete last line (of a run that was killed) is removed as well. Raises ``BadInput``
        if the columns are not those of the file.
        """
        path = Path(path)
        lines = _complete_lines(path)
        if not lines or lines[0] != _row([*FIRST_COLUMNS, *_headings(columns)]):
            raise BadInput(f"{path}: the columns are not those of this case", "run the case again")
        kept = [lines[0]]
        kept += [line for line in lines[1:] if int(line.split(",", 1)[0]) <= last_step]
        write_durably(path, "".join(kept).encode())
        writer = cls.__new__(cls)
        writer.path = path
        writer._count = len(columns)
        writer._file = path.open("a", encoding="utf-8", newline="")
        return writer

    def append(self, step: int, time: float, iterations: int, values: Sequence[float]) -> None:
        """Writes the row of one step; ``values`` in the order of the columns."""
        if len(values) != self._count:
            raise ValueError(f"{len(values)} values for {self._count} columns")
        numbers = [repr(float(value)) for value in (time, *values)]
        self._file.write(_row([str(step), numbers[0], str(iterations), *numbers[1:]]))
        self._file.flush()

    def close(self) -> None:
        """Closes the file."""
        self._file.close()


def read_history(path: Path | str) -> dict[str, Floats]:
    """Returns all columns by heading (``name [unit]``), each of shape (rows,).

    Raises ``BadInput`` if the file is not the history of a run.
    """
    path = Path(path)
    lines = _complete_lines(path)
    if not lines:
        raise BadInput(f"{path} is empty: it is not the history of a tilth run")
    rows = list(csv.reader(lines))
    try:
        table = np.array(rows[1:], dtype=np.float64).reshape(len(rows) - 1, len(rows[0]))
    except ValueError as error:
        raise BadInput(f"{path}: not a table of numbers ({error})") from error
    return {heading: table[:, index].copy() for index, heading in enumerate(rows[0])}


def _headings(columns: Sequence[tuple[str, str]]) -> list[str]:
    return [f"{name} [{unit}]" if unit else name for name, unit in columns]


def _row(cells: Sequence[str]) -> str:
    """Returns one line of CSV with its line end."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _complete_lines(path: Path) -> list[str]:
    """Returns the lines of a file without an incomplete last one."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {error.strerror}") from error
    return [line for line in lines if line.endswith("\n")]
