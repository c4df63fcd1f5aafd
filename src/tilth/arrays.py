# SPDX-License-Identifier: BSD-3-Clause
"""Types of arrays, and checks of arrays that were read from a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Shorts = npt.NDArray[np.int32]
Flags = npt.NDArray[np.bool_]


def require_table(
    columns: Mapping[str, npt.NDArray[Any]], *, increasing: str | None = None, strictly: bool = True
) -> None:
    """Checks that arrays by name have as many rows each, and that one of them increases.

    Raises:
        ValueError: with the names of the arrays.
    """
    rows = {name: len(column) for name, column in columns.items()}
    if len(set(rows.values())) > 1:
        raise ValueError(f"different numbers of rows, {rows}")
    if increasing is not None:
        column = columns[increasing]
        rises = column[1:] > column[:-1] if strictly else column[1:] >= column[:-1]
        if not rises.all():
            raise ValueError(f"{increasing!r} does not increase")


def require_within(name: str, numbers: npt.NDArray[Any], count: int) -> None:
    """Checks that numbers of rows are at least 0 and less than `count`.

    Raises:
        ValueError: with the name of the array.
    """
    if ((numbers < 0) | (numbers >= count)).any():
        raise ValueError(f"{name!r} has numbers outside 0 to {count - 1}")


def make_read_only(*arrays: npt.NDArray[np.generic]) -> None:
    """Makes index arrays read-only: the core checks an object with such arrays only once."""
    for array in arrays:
        array.flags.writeable = False
