# SPDX-License-Identifier: BSD-3-Clause
"""One implicit boundary in one step: where it touches soil, and the forces that it exerts there.

With N the shape functions of a cell, the boundary's internal force is the surface form

    f_a = integral of N_a [traction + P w],    w = sum_b N_b u_b - prescribed displacement,

with the penalty P = 4 / (3 delta) Pi Q Pi, the projector Pi on the constrained directions and the
acoustic tensor Q of the soil (docs/theory/implicit_boundaries.md). The paper's full form adds the
terms of `BandContact`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.boundaries.implicit import Implicit, Pose
from tilth.boundaries.protocol import Floats
from tilth.coupling import Coupling
from tilth.grid import ActiveGrid, find_keys, lattice_keys, shape_functions

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


@dataclass(frozen=True)
class Contact:
    """The quadrature points of a boundary that touch soil in one step, ordered by cell.

    Attributes:
        boundary: the boundary.
        chosen: numbers of its terms, shape (n,).
        at: the cells that they act on.
        pose: their place and direction.
        moduli: constrained modulus (capped) and shear modulus of the soil there [stress], (n, 2).
        axisymmetric: whether the hoop counts.
    """

    boundary: Implicit
    chosen: Integers
    at: Place
    pose: Pose
    moduli: Floats
    axisymmetric: bool

    @cached_property
    def penalty(self) -> Floats:
        """P, the stress per slip [stress/length], shape (n, dim, dim)."""
        normal, projector = self.pose.normal, self.pose.projector
        constrained, shear = self.moduli.T
        across = normal[:, :, None] * normal[:, None, :]
        acoustic = shear[:, None, None] * np.eye(normal.shape[1])
        acoustic = acoustic + (constrained - shear)[:, None, None] * across
        assert self.boundary.terms is not None
        square = self.boundary.terms.square[self.chosen]
        return np.asarray(square[:, None, None] * (projector @ acoustic @ projector))

    @cached_property
    def before(self) -> Floats:
        """What the points carry from the last step, turned into the middle of this one."""
        return turned(self.boundary.carried[self.chosen], self.pose, 0)

    def coupling(self) -> Coupling:
        """Returns the forces as elements of one cell each."""
        dim = self.pose.place.shape[1]
        weight = self.pose.weight
        constant = self.before[:, :dim] - np.einsum("nij,nj->ni", self.penalty, self.pose.increment)
        matrix, force = _core.surface_elements(
            self.at.start,
            self.at.value,
            np.ascontiguousarray(weight[:, None, None] * self.penalty),
            np.ascontiguousarray(weight[:, None] * constant),
        )
        return Coupling(node=self.at.node, matrix=np.asarray(matrix), force=np.asarray(force))

    def after(self, displacement: Floats) -> Floats:
        """Returns what the points carry at the end of a step with this nodal displacement."""
        slip = self.at.interpolate(displacement) - self.pose.increment
        return np.asarray(self.before + np.einsum("nij,nj->ni", self.penalty, slip))

    def nodal_force(self, carried: Floats, nodes: int) -> Floats:
        """Returns the boundary's internal force of what its points carry, shape (nodes, dim)."""
        dim = self.pose.place.shape[1]
        return self.at.scatter(self.pose.weight[:, None] * carried[:, :dim], nodes)

    def commit(self, carried: Floats) -> None:
        """Carries on to the next step; what touches no soil carries nothing."""
        kept = np.zeros_like(self.boundary.carried)
        kept[self.chosen] = turned(carried, self.pose, 1)
        self.boundary.carried = kept


def turned(carried: Floats, pose: Pose, part: int) -> Floats:
    """Returns carried vectors (and tensors behind them) turned by a half of the step's motion."""
    if pose.turn is None:
        return carried
    dim = pose.place.shape[1]
    turn = pose.turn[part]
    result = carried.copy()
    result[:, :dim] = np.einsum("nij,nj->ni", turn, carried[:, :dim])
    if carried.shape[1] > dim:
        whole = np.tile(np.eye(3), (len(carried), 1, 1))
        whole[:, :dim, :dim] = turn
        tensor = carried[:, dim:].reshape(-1, 3, 3)
        result[:, dim:] = (whole @ tensor @ np.swapaxes(whole, 1, 2)).reshape(-1, 9)
    return result
