# SPDX-License-Identifier: BSD-3-Clause
"""Places on the active grid that are no material points: of boundaries and of surfaces."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid, find_keys, lattice_keys


@dataclass(frozen=True)
class Place:
    """Where n quadrature points act on the active grid: each on the corners of one cell.

    The cell is the one a point lies in, or, where no soil reaches that cell, the nearest one with
    soil; its shape functions are then extrapolated, so that they still sum to one and are exact
    for linear fields.

    Attributes:
        start: first point of each cell, shape (cells + 1,).
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        local: places from their cells' lowest corners, in cells, shape (n, dim).
        cell_size: [length], shape (dim,).
    """

    start: Integers
    node: npt.NDArray[np.int32]
    local: Floats
    cell_size: Floats

    @cached_property
    def value(self) -> Floats:
        """Shape functions N [-], shape (n, 2^dim)."""
        return np.asarray(_core.shape_values(self.local, self.cell_size))

    @cached_property
    def gradient(self) -> Floats:
        """Gradients of the shape functions [1/length], shape (n, 2^dim, dim)."""
        return np.asarray(_core.shape_functions(self.local, self.cell_size)[1])

    @property
    def cell(self) -> Integers:
        """The cell of each point, shape (n,)."""
        return np.repeat(np.arange(len(self.node)), np.diff(self.start))

    def interpolate(self, nodal: Floats) -> Floats:
        """Returns sum_a N_a nodal_a, shape (n, k)."""
        return np.asarray(_core.interpolate_places(self.start, self.node, self.value, nodal))

    def scatter(self, vector: Floats, nodes: int) -> Floats:
        """Returns sum_n N_na vector_n at all nodes, shape (nodes, k)."""
        nodal = np.zeros((nodes, vector.shape[1]))
        vector = np.ascontiguousarray(vector)
        _core.scatter_places(self.start, self.node, self.value, vector, nodal)
        return nodal


def locate_places(active: ActiveGrid, place: Floats) -> tuple[Integers, Place]:
    """Finds the cells that places act on; returns the order by cell, and what it orders.

    place: [length], shape (n, dim); none is more than a cell away from a material point.
    """
    grid = active.grid
    place = np.ascontiguousarray(place)
    found = _core.cells_of_places(place, grid.origin, grid.cell_size, active.cell_keys)
    order = np.argsort(found[0], kind="stable")
    key, local = np.asarray(found[0])[order], np.asarray(found[1])[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
    node = active.corners(np.asarray(_core.lattice(key[first])))
    return order, Place(np.append(first, len(key)), node, local, grid.cell_size)


def near_soil(active: ActiveGrid, place: Floats) -> npt.NDArray[np.bool_]:
    """Returns which places (n, dim) are in or beside a cell with soil, shape (n,)."""
    lattice = np.floor((place - active.grid.origin) / active.grid.cell_size).astype(np.int64)
    near = np.zeros(len(place), dtype=bool)
    for step in np.ndindex(*(3,) * place.shape[1]):
        near |= _has_soil(active, lattice + np.array(step) - 1)
    return near


def _has_soil(active: ActiveGrid, lattice: Integers) -> npt.NDArray[np.bool_]:
    return np.asarray(find_keys(active.cell_keys, lattice_keys(lattice)) >= 0)
