# SPDX-License-Identifier: BSD-3-Clause
"""Scalar fields on irregular sets of cells: Poisson's equation by multilinear finite elements."""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.grid.background import Grid
from tilth.model.laws import laws
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.solvers import LinearSystem

RADIUS = 1.0
LAW = laws()["hencky_elastic"]


def cell_size(dim: int, over_radius: int) -> Floats:
    """Sides of the cells [length]: no two of them equal."""
    return np.array([1.0, 0.8, 1.2])[:dim] * RADIUS / over_radius


def ball(dim: int, over_radius: int, halvings: int = 0) -> ActiveGrid:
    """The cells whose centres are in a disc or a ball; each is cut in half so many times.

    The centre of the ball is not on the lattice, which has negative places, too.
    """
    size = cell_size(dim, over_radius)
    number = int(2 * over_radius)
    one = np.arange(-number, number)
    place = np.stack(np.meshgrid(*[one] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    offset = np.array([0.13, -0.07, 0.11])[:dim]
    inside = np.linalg.norm((place + 0.5) * size - offset, axis=1) < RADIUS
    place = place[inside]
    for _ in range(halvings):
        halves = np.stack(np.meshgrid(*[[0, 1]] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        place, size = (2 * place[:, None] + halves).reshape(-1, dim), 0.5 * size
    return active_cells(place, size)


def active_cells(place: Integers, size: Floats) -> ActiveGrid:
    """The active grid of cells at lattice places (cells, dim), with a point in each."""
    count, dim = place.shape
    body = PointRange("body", 0, count, "linear", None, LAW, np.array([1.0, 0.0]), 1.0)
    points = MaterialPoints.undeformed(
        [body], (place + 0.5) * size, np.full(count, size.prod()), np.tile(0.5 * size, (count, 1)),
    )  # fmt: skip
    return locate(points, Grid(np.zeros(dim), size), Buffers())


def cell_matrices(size: Floats) -> tuple[Floats, Floats]:
    """Stiffness of -div grad and mass matrix of a cell, its corners x fastest."""
    stiffness = [np.array([[1.0, -1.0], [-1.0, 1.0]]) / h for h in size]
    mass = [h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]]) for h in size]

    def product(factors: list[Floats]) -> Floats:
        return reduce(np.kron, factors[::-1])

    directions = range(len(size))
    whole = sum(
        product([stiffness[k] if k == d else mass[k] for k in directions]) for d in directions
    )
    return np.asarray(whole), product(mass)


def corners_of(active: ActiveGrid) -> Integers:
    return active.corners(np.asarray(_core.lattice(active.cell_keys))).astype(np.int64)


def edge_nodes(active: ActiveGrid) -> Flags:
    """Which nodes have not all their cells, shape (nodes,)."""
    count = np.bincount(corners_of(active).ravel(), minlength=active.nodes)
    return count < 2**active.grid.dim


def poisson(active: ActiveGrid, coupling: Floats, constrained: Flags) -> LinearSystem:
    """The system of sum_j coupling_ij (-div grad u_j) = f_i, coupling (components, components)."""
    system = LinearSystem(active, np.repeat(constrained[:, None], len(coupling), axis=1))
    corner = corners_of(active)
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    entry = np.searchsorted(
        rows * active.nodes + active.column, corner[:, :, None] * active.nodes + corner[:, None]
    )
    stiffness, _ = cell_matrices(active.grid.cell_size)
    scalar = np.zeros(len(active.column))
    np.add.at(scalar, entry, stiffness)
    system.blocks[:] = scalar[:, None, None] * coupling
    return system


def load(active: ActiveGrid, source: Floats) -> Floats:
    """Nodal right side of a source that is interpolated between the nodes, (nodes, components)."""
    corner = corners_of(active)
    _, mass = cell_matrices(active.grid.cell_size)
    right = np.zeros_like(source)
    np.add.at(right, corner, np.einsum("ab,cbi->cai", mass, source[corner]))
    return right


def error(active: ActiveGrid, nodal: Floats, exact: Callable[[Floats], Floats]) -> float:
    """L2 norm of a nodal field (nodes,) less an exact one, by 3 Gauss points a direction."""
    dim, size = active.grid.dim, active.grid.cell_size
    gauss, weights = np.polynomial.legendre.leggauss(3)
    corner = corners_of(active)
    total = 0.0
    for index in np.ndindex(*[3] * dim):
        at = 0.5 * (1.0 + gauss[list(index)])
        weight = np.prod(0.5 * weights[list(index)] * size)
        shape = reduce(np.kron, [np.array([1.0 - s, s]) for s in at[::-1]])
        place = active.position[corner[:, 0]] + at * size
        total += weight * float(((nodal[corner] @ shape - exact(place)) ** 2).sum())
    return float(np.sqrt(total))
