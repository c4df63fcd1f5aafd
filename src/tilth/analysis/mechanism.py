# SPDX-License-Identifier: BSD-3-Clause
"""Connected soil that moves: whether it is a mechanism that the grid resolves.

Where soil has no cohesion a few points at its surface may move far, in cells that are partly
filled, without any meaning for the rest. A mechanism is at least `WIDTH` cells wide.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.comm import Communicator
from tilth.grid.background import Grid
from tilth.mpm.points import MaterialPoints

WIDTH = 3
"""Least width of a mechanism [cells]: a cell and its neighbours on both sides along each axis."""

LEAST_FILL = 0.5
"""Filled fraction from which on a cell counts: the ghost stabilisation does not hold it then."""

MOVING_SHARE = 0.5
"""Share of the soil in a cell that moves from which on the cell does."""


def moving_cells(
    points: MaterialPoints, moves: Flags, grid: Grid, axisymmetric: bool, comm: Communicator
) -> int:
    """Returns the number of cells of the largest mechanism, 0 if there is none.

    A cell and its neighbours along all axes move; such crosses that share a face form one
    mechanism. Along an axis on which all soil has fewer cells than `WIDTH` no neighbours are
    needed.

    Args:
        points: those that this process owns.
        moves: which of them move, shape (n,).
        grid: whose cells are counted.
        axisymmetric: whether volumes are those of rings.
        comm: the processes that share the soil.
    """
    cell, volume, moving = (
        np.concatenate(each)
        for each in zip(*comm.gathered(_cells(points, moves, grid)), strict=True)
    )
    size = grid.sizes(cell).prod(axis=1)
    if axisymmetric:
        size = size * 2.0 * np.pi * np.abs(grid.position(cell + 0.5)[:, 0])
    full = volume >= LEAST_FILL * size
    if full.any():
        cell, moving = cell[full], moving[full]
    extent = np.ptp(cell, axis=0) + 1
    cell = cell[moving]
    steps = np.eye(grid.dim, dtype=np.int64)
    needed = [sign * steps[k] for k in range(grid.dim) if extent[k] >= WIDTH for sign in (1, -1)]
    moved = _Cells(cell)
    inner = np.ones(len(cell), dtype=bool)
    for step in needed:
        inner &= moved.find(cell + step) >= 0
    crosses = [cell[inner], *(cell[inner] + step for step in needed)]
    return _largest(np.unique(np.concatenate(crosses), axis=0))


def _cells(points: MaterialPoints, moves: Flags, grid: Grid) -> tuple[Integers, Floats, Flags]:
    """Returns the cells with soil (m, dim), its volume in them and whether it moves, (m,) each."""
    place = np.floor(grid.in_cells(points.position)).astype(np.int64)
    cell, number = np.unique(place, axis=0, return_inverse=True)
    number = number.reshape(-1)
    volume = np.bincount(number, points.volume, len(cell)).astype(np.float64)
    moving = np.bincount(number, points.volume * moves, len(cell))
    return cell, volume, moving > MOVING_SHARE * volume


class _Cells:
    """Cells (n, dim), each once, that can be found by their lattice indices."""

    def __init__(self, cell: Integers) -> None:
        self._lower = cell.min(axis=0, initial=0) - 1
        extent = cell.max(axis=0, initial=0) - self._lower + 2
        self._stride = np.cumprod(np.concatenate([[1], extent[:-1]]))
        key = self._keys(cell)
        self._order = np.argsort(key)
        self._sorted = key[self._order]

    def _keys(self, cell: Integers) -> Integers:
        return np.asarray((cell - self._lower) @ self._stride)

    def find(self, cell: Integers) -> Integers:
        """Returns the numbers of cells (k, dim) at most one step outside, -1 for others, (k,)."""
        if len(self._sorted) == 0:
            return np.full(len(cell), -1)
        key = self._keys(cell)
        at = np.minimum(np.searchsorted(self._sorted, key), len(self._sorted) - 1)
        return np.where(self._sorted[at] == key, self._order[at], -1)


def _largest(cell: Integers) -> int:
    """Returns the most cells (n, dim), each given once, that are connected by faces."""
    from scipy.sparse import coo_matrix  # takes 0.2 s: only where soil moves
    from scipy.sparse.csgraph import connected_components

    if len(cell) == 0:
        return 0
    cells = _Cells(cell)
    pairs = []
    for step in np.eye(cell.shape[1], dtype=np.int64):
        other = cells.find(cell + step)
        some = np.flatnonzero(other >= 0)
        pairs.append(np.stack([some, other[some]]))
    i, j = np.concatenate(pairs, axis=1)
    graph = coo_matrix((np.ones(len(i)), (i, j)), shape=(len(cell), len(cell)))
    _, label = connected_components(graph, directed=False)
    return int(np.bincount(label).max())
