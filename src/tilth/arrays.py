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


def distinct_rows(table: npt.NDArray[Any]) -> Integers:
    """Returns the index of the first of all equal rows, for each row that occurs, (k,).

    Args:
        table: whole numbers of any type, shape (n, columns), n >= 1.

    The rows ascend as in `np.unique` over axis 0, which is many times slower: here a row is one
    number, as long as their range allows it.
    """
    least = table.min(axis=0)
    extent = table.max(axis=0) - least + 1
    if not float(np.prod(extent, dtype=float)) < 2.0**62:
        return np.asarray(np.unique(table, axis=0, return_index=True)[1])
    key = np.ravel_multi_index((table - least).astype(np.int64).T, extent.astype(np.int64))
    return np.asarray(np.unique(key, return_index=True)[1])


def make_read_only(*arrays: npt.NDArray[np.generic]) -> None:
    """Makes index arrays read-only: the core checks an object with such arrays only once."""
    for array in arrays:
        array.flags.writeable = False
