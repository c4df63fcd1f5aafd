# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points of boundaries and surfaces in the cells of the active grid."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.grid.keys import find_keys, lattice_keys, overlay_shift, places_of_keys
from tilth.mpm.active_grid import ActiveGrid


@dataclass(frozen=True)
class PointsInCells:
    """The cells of n quadrature points, with shape functions on the corners of each cell.

    The cell of a point is the one that contains it, or the nearest one with soil if that cell has
    none. In the latter case the shape functions are extrapolated: they still sum to one and
    reproduce linear fields.

    Attributes:
        start: first point of each cell, shape (cells + 1,).
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        local: points' coordinates from their cells' lowest corners, in cells, shape (n, dim).
        size: of the cells [length], shape (cells, dim).
    """

    start: Integers
    node: npt.NDArray[np.int32]
    local: Floats
    size: Floats

    @cached_property
    def value(self) -> Floats:
        """Shape functions N [-], shape (n, 2^dim)."""
        return np.asarray(_core.shape_values(self.local))

    @cached_property
    def gradient(self) -> Floats:
        """Gradients of the shape functions [1/length], shape (n, 2^dim, dim)."""
        return np.asarray(_core.shape_functions(self.local, self.size[self.cell])[1])

    def of(self, kept: npt.NDArray[np.bool_]) -> PointsInCells:
        """Returns the points `kept`, shape (n,), in those of the cells that have any."""
        count = np.bincount(self.cell[kept], minlength=len(self.node))
        used = count > 0
        start = np.concatenate([[0], np.cumsum(count[used])])
        return PointsInCells(start, self.node[used], self.local[kept], self.size[used])

    @property
    def cell(self) -> Integers:
        """Number of the cell of each point, shape (n,)."""
        return np.repeat(np.arange(len(self.node)), np.diff(self.start))

    def interpolate(self, nodal: Floats) -> Floats:
        """Returns sum_a N_a nodal_a at the points, shape (n, k), of nodal values (nodes, k)."""
        return np.asarray(_core.interpolate_in_cells(self.start, self.node, self.value, nodal))

    def scatter(self, vector: Floats, nodes: int) -> Floats:
        """Returns sum_n N_na vector_n at all nodes, shape (nodes, k), of vectors (n, k)."""
        nodal = np.zeros((nodes, vector.shape[1]))
        vector = np.ascontiguousarray(vector)
        _core.scatter_in_cells(self.start, self.node, self.value, vector, nodal)
        return nodal


def locate_in_cells(
    active: ActiveGrid, position: Floats, overlay: Integers | int = 0
) -> tuple[Integers, PointsInCells]:
    """Returns the order of points by cell, shape (n,), and the points in this order.

    The cells of one overlay follow those of another. Arguments as `find_cells`.
    """
    key, local = find_cells(active, position, overlay)
    order = np.argsort(key, kind="stable")
    return order, points_in_cells(active, key[order], local[order])


def find_cells(
    active: ActiveGrid, position: Floats, overlay: Integers | int = 0
) -> tuple[Integers, Floats]:
    """Returns the key of each point's cell, (n,), and its coordinates in the cell, (n, dim).

    position: [length], shape (n, dim); at most one cell away from a material point of the overlay.
    overlay: of the soil, one number or shape (n,).
    """
    position = np.ascontiguousarray(position)
    if active.overlays > 1:
        return _in_cells_of_overlays(active, position, overlay)
    key, local = _core.locate_in_cells(position, active.grid, active.cell_keys)
    return np.asarray(key), np.asarray(local)


def points_in_cells(active: ActiveGrid, key: Integers, local: Floats) -> PointsInCells:
    """Returns points ordered by the keys of their cells (n,), at coordinates in these (n, dim)."""
    grid = active.grid
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
    node = active.corners(np.asarray(_core.lattice(key[first])))
    size = grid.sizes(places_of_keys(key[first], active.overlays)[0][:, : grid.dim])
    return PointsInCells(np.append(first, len(key)), node, local, size)


def _in_cells_of_overlays(
    active: ActiveGrid, position: Floats, overlay: Integers | int
) -> tuple[Integers, Floats]:
    """Returns the key of each point's cell, (n,), and its coordinates in the cell, (n, dim)."""
    overlay = np.broadcast_to(overlay, len(position))
    key, local = np.empty(len(position), dtype=np.int64), np.empty_like(position)
    for number in np.unique(overlay):
        own = np.flatnonzero(overlay == number)
        cell_keys = active.of_overlay(number).cell_keys
        found = _core.locate_in_cells(position[own], active.grid, cell_keys)
        key[own], local[own] = np.asarray(found[0]) + overlay_shift(number), found[1]
    return key, local


def near_process(active: ActiveGrid, position: Floats, layers: int = 0) -> Flags:
    """Returns which places lie in cells of this process or so many layers around them, shape (n,).

    All of them in a serial run; without layers each place belongs to one process.
    position: [length], shape (n, dim).
    """
    if active.shared is None:
        return np.ones(len(position), dtype=bool)
    lattice = np.floor(active.grid.in_cells(position)).astype(np.int64)
    return active.shared.boxes.near(active.comm.rank, lattice, layers)


def near_soil(
    active: ActiveGrid, position: Floats, overlay: Integers | int = 0
) -> npt.NDArray[np.bool_]:
    """Returns which positions (n, dim) lie in a cell with soil or in its neighbours, shape (n,).

    overlay: of the soil, one number or shape (n,).
    """
    lattice = np.floor(active.grid.in_cells(position)).astype(np.int64)
    near = np.zeros(len(position), dtype=bool)
    for step in np.ndindex(*(3,) * position.shape[1]):
        keys = lattice_keys(lattice + np.array(step) - 1, overlay)
        near |= find_keys(active.cell_keys, keys) >= 0
    return near
