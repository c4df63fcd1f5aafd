# SPDX-License-Identifier: BSD-3-Clause
"""Which process owns which cells of the grid: boxes of cells with about equally many points.

The boxes come from recursive bisection (Berger and Bokhari 1987): the cells are cut in two across
their longest side, so that both parts have points in proportion to their processes, and so on. A
cut lies on a grid line, so that each part is a box; the outer boxes have no end, so that every cell
of the grid has an owner. A node belongs to the owner of the cell whose lowest node it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Integers
from tilth.comm import Communicator

FAR = 1 << 40
"""Lattice index beyond all of a grid: the outer boxes end there."""


@dataclass(frozen=True)
class Cut:
    """A cut between two parts, each of which is a process or cut again.

    Attributes:
        axis: direction of the normal.
        line: lattice index of the cut's grid line.
        below, above: the parts.
    """

    axis: int
    line: int
    below: Cut | int
    above: Cut | int


class Boxes:
    """A box of cells for each process.

    Args:
        cut: that of the whole grid; 0 for one process.
        dim: number of directions.

    Attributes:
        lower, upper: first lattice index of each box and one past its last, shape (size, dim).
    """

    def __init__(self, cut: Cut | int, dim: int) -> None:
        self._cut = cut
        self.lower, self.upper = np.zeros((2, _size(cut), dim), dtype=np.int64)
        self._fill(cut, np.full(dim, -FAR), np.full(dim, FAR))

    def _fill(self, cut: Cut | int, lower: Integers, upper: Integers) -> None:
        if isinstance(cut, int):
            self.lower[cut], self.upper[cut] = lower, upper
            return
        middle = np.where(np.arange(len(lower)) == cut.axis, cut.line, upper)
        self._fill(cut.below, lower, middle)
        self._fill(cut.above, np.where(middle == upper, lower, middle), upper)

    def owner(self, cell: Integers) -> Integers:
        """Returns the process that owns each cell, by lattice indices (n, dim or 3), (n,)."""
        owner = np.zeros(len(cell), dtype=np.int64)

        def mark(cut: Cut | int, index: Integers) -> None:
            if isinstance(cut, int):
                owner[index] = cut
                return
            below = cell[index, cut.axis] < cut.line
            mark(cut.below, index[below])
            mark(cut.above, index[~below])

        mark(self._cut, np.arange(len(cell)))
        return owner

    def near(self, rank: int, cell: Integers, layers: int) -> Flags:
        """Returns which cells (n, dim or 3) are in a process' box or so many layers around it."""
        return _within(cell, self.lower[rank] - layers, self.upper[rank] + layers)


def _size(cut: Cut | int) -> int:
    return 1 if isinstance(cut, int) else _size(cut.below) + _size(cut.above)


def _within(cell: Integers, lower: Integers, upper: Integers) -> Flags:
    inside = np.ones(len(cell), dtype=bool)
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if low > -FAR // 2:
            inside &= cell[:, k] >= low
        if high < FAR // 2:
            inside &= cell[:, k] < high
    return inside


def bisected(comm: Communicator, parts: int, cell: Integers) -> Boxes:
    """Returns boxes for so many processes.

    Args:
        comm: the processes that know the points, each its own.
        parts: number of boxes.
        cell: lattice indices of the cells of this process' points, shape (n, dim).
    """
    return Boxes(_bisected(comm, 0, parts, cell), cell.shape[1])


def _bisected(comm: Communicator, first: int, parts: int, cell: Integers) -> Cut | int:
    """Cuts points for so many processes, of which `first` is the first one."""
    if parts == 1:
        return first
    ends = np.stack([cell.min(axis=0, initial=FAR), -cell.max(axis=0, initial=-FAR)])
    low, high = np.min(comm.gathered(ends), axis=0)
    axis = int((-high - low).argmax())
    layers = int(-high[axis] - low[axis]) + 1
    if layers < 2:
        raise TooManyProcesses
    count = np.bincount(cell[:, axis] - low[axis], minlength=layers)
    points = np.sum(comm.gathered(count), axis=0)
    half = parts // 2
    below = np.cumsum(points)[:-1]  # below each line between two layers
    line = int(low[axis]) + 1 + int(np.abs(below * parts - points.sum() * half).argmin())
    under = cell[:, axis] < line
    return Cut(
        axis,
        line,
        _bisected(comm, first, half, cell[under]),
        _bisected(comm, first + half, parts - half, cell[~under]),
    )


class TooManyProcesses(Exception):
    """There are more processes than cells with points."""
