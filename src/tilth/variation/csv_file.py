# SPDX-License-Identifier: BSD-3-Clause
"""Tables of numbers in CSV files, with a line of names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.model.fields import GREATEST

MOST_BYTES = 1_000_000_000
"""Size of a file [bytes], at most."""


def read_csv(
    file: str, key: str, example: str, row_for: str, accepted: Callable[[list[str]], bool]
) -> tuple[list[str], Floats]:
    """Reads a line with names, then rows of as many numbers; lines that begin with # are left out.

    Args:
        file: path of the .csv file.
        key: of the entry in the case file, for messages.
        example: of the line with the names, for messages.
        row_for: what there is one row for, for messages.
        accepted: whether the names are those of such a file.

    Returns:
        The names, and the numbers, shape (rows, names).

    Raises:
        BadInput: the file cannot be read, or is not such a table.
    """

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=key, value=file)

    path = Path(file)
    try:
        require_file(path)
        if path.stat().st_size > MOST_BYTES:
            raise refused("is larger than 1 GB", "use fewer rows")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        problem = f"cannot be read: {error.strerror or error}"
        raise refused(problem, "check the path and its permissions") from None
    except UnicodeDecodeError:
        raise refused("is not a text file in UTF-8", "save it as CSV in UTF-8") from None
    rows = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    names = [name.strip() for name in rows[0].split(",")] if rows else []
    if not names or not accepted(names):
        first = f"begins with {rows[0][:60]!r}" if rows else "is empty"
        raise refused(f"{first} instead of the names of its columns", f"such as {example}")
    if len(rows) == 1:
        raise refused(f"has no rows of {len(names)} numbers", f"give one row for {row_for}")
    try:
        table = np.loadtxt(rows[1:], delimiter=",", comments=None, ndmin=2, dtype=np.float64)
    except ValueError as error:
        reason = str(error).split(";")[0]
        raise refused(f"has a row that cannot be read: {reason}", f"such as {example}") from None
    if table.shape[1] != len(names):
        raise refused(f"has no rows of {len(names)} numbers", f"give one row for {row_for}")
    bad = np.flatnonzero(~(np.abs(table) <= GREATEST).all(axis=1))
    if len(bad):
        problem = f"row {bad[0] + 1} below the names has a number that is not finite, or too large"
        raise refused(problem, f"numbers are at most {GREATEST:g} in magnitude")
    return names, table
