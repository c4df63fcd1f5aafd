# SPDX-License-Identifier: BSD-3-Clause
"""Places on the active grid that are no material points: of boundaries and of surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.grid import ActiveGrid, find_keys, lattice_keys, shape_functions

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Place:
    """Where n quadrature points act on the active grid: each on the corners of one cell.

    The cell is the one a point lies in, or, where no soil reaches that cell, the nearest one with
    soil; its shape functions are then extrapolated, so that they still sum to one and are exact
    for linear fields.

    Attributes:
        start: first point of each cell, shape (cells + 1,).
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        value: shape functions N [-], shape (n, 2^dim).
        gradient: [1/length], shape (n, 2^dim, dim).
    """

    start: Integers
    node: npt.NDArray[np.int32]
    value: Floats
    gradient: Floats

    @property
    def cell(self) -> Integers:
        """The cell of each point, shape (n,)."""
        return np.repeat(np.arange(len(self.node)), np.diff(self.start))

    def interpolate(self, nodal: Floats) -> Floats:
        """Returns sum_a N_a nodal_a, shape (n, k)."""
        return np.asarray(np.einsum("na,nak->nk", self.value, nodal[self.node[self.cell]]))

    def scatter(self, vector: Floats, nodes: int) -> Floats:
        """Returns sum_n N_na vector_n at all nodes, shape (nodes, k)."""
        of_cell = np.einsum("na,nk->nak", self.value, vector)
        of_cell = np.add.reduceat(of_cell, self.start[:-1], axis=0)
        node = self.node.ravel()
        columns = [
            np.bincount(node, of_cell[:, :, k].ravel(), nodes) for k in range(vector.shape[1])
        ]
        return np.stack(columns, axis=1)


def locate_places(active: ActiveGrid, place: Floats) -> tuple[Integers, Place]:
    """Finds the cells that places act on; returns the order by cell, and what it orders.

    place: [length], shape (n, dim); none is more than a cell away from a material point.
    """
    grid, dim = active.grid, active.grid.dim
    scaled = (place - grid.origin) / grid.cell_size
    lattice = np.floor(scaled).astype(np.int64)
    empty = np.flatnonzero(~_has_soil(active, lattice))
    if len(empty):
        lattice[empty] = _nearest_cell_with_soil(active, scaled[empty])
    key = lattice_keys(lattice)
    order = np.argsort(key, kind="stable")
    lattice, key = lattice[order], key[order]
    first = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]])[: len(key)])
    cells = np.pad(lattice[first], ((0, 0), (0, 3 - dim)))
    node = active.corners(cells)
    value, gradient = shape_functions(scaled[order] - lattice, grid.cell_size)
    return order, Place(np.append(first, len(key)), node, value, gradient)


def near_soil(active: ActiveGrid, place: Floats) -> npt.NDArray[np.bool_]:
    """Returns which places (n, dim) are in or beside a cell with soil, shape (n,)."""
    lattice = np.floor((place - active.grid.origin) / active.grid.cell_size).astype(np.int64)
    near = np.zeros(len(place), dtype=bool)
    for step in np.ndindex(*(3,) * place.shape[1]):
        near |= _has_soil(active, lattice + np.array(step) - 1)
    return near


def _has_soil(active: ActiveGrid, lattice: Integers) -> npt.NDArray[np.bool_]:
    return np.asarray(find_keys(active.cell_keys, lattice_keys(lattice)) >= 0)


def _nearest_cell_with_soil(active: ActiveGrid, scaled: Floats) -> Integers:
    """Returns the cell, one of those around each place, that is nearest; places in cells.

    Of cells that are as near, such as two that share the face a place lies on, the one whose
    centre is nearer.
    """
    own = np.floor(scaled).astype(np.int64)
    best, least = own.copy(), np.full(len(own), np.inf)
    for step in np.ndindex(*(3,) * own.shape[1]):
        cell = own + np.array(step) - 1
        off = np.abs(scaled - (cell + 0.5))
        distance = np.linalg.norm(np.maximum(off - 0.5, 0.0), axis=1)
        distance = distance + 1e-6 * np.linalg.norm(off, axis=1)
        nearer = _has_soil(active, cell) & (distance < least)
        best[nearer], least[nearer] = cell[nearer], distance[nearer]
    return best
