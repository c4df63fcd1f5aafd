# SPDX-License-Identifier: BSD-3-Clause
"""Ghost stabilisation: ties the nodes of hardly filled cells to the material beside them.

A cell at the edge of a body that holds a sliver of material gives its outer nodes a stiffness
that vanishes with the sliver. A penalty on the jump of the normal derivative of the step's
displacement across the cell's faces (Burman 2010; Sticko et al. 2020; for the material point
method Coombs 2022) gives them stiffness instead:

    f = gamma E h integral over the face of [d u / d n] [d v / d n],

with E the volume-weighted Young's modulus of the two cells and h the cell's size along the
face's normal. In units of force: E h (1/length)^2 length^(dim-1) length = E length^(dim-1). It
vanishes for every displacement that is linear across the two cells, so that it has no net force,
resists no rigid motion, and leaves a homogeneous strain alone. It is weighted by how empty the
cell is and vanishes from half a cell on.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.coupling import Coupling
from tilth.grid import ActiveGrid, find_keys, lattice_keys
from tilth.soil import Soil

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

FULL = 0.5
"""Share of a cell from which on it is not stabilised."""


def filled_cells(soil: Soil, active: ActiveGrid) -> tuple[Integers, Floats, Floats]:
    """Returns the populated cells: keys, filled share [-], mean Young's modulus [stress].

    The key is that of the cell's lowest node; the share is that of the cell's volume, in
    axisymmetry of the ring it sweeps.
    """
    grid = active.grid
    key = active.cell_keys
    filled = np.zeros((len(key), 2))
    volume = soil.points.volume
    for body, stencil in zip(soil.points.bodies, active.stencils, strict=True):
        s = slice(body.start, body.stop)
        _core.fill_cells(
            stencil, soil.points.position[s], soil.points.half_length[s], volume[s],
            body.young_modulus, grid.origin, grid.cell_size, key, filled,
        )  # fmt: skip
    size = np.full(len(key), float(np.prod(grid.cell_size)))
    if soil.kind == "axisymmetric":
        size *= 2.0 * np.pi * _centre_radius(active, key)
    return key, filled[:, 0] / size, filled[:, 1] / np.maximum(filled[:, 0], 1e-300)


def _centre_radius(active: ActiveGrid, key: Integers) -> Floats:
    """Distance of the cells' centres from the axis; domains may reach a little across it."""
    column = np.asarray(_core.lattice(key))[:, 0]
    return np.asarray(np.abs(active.grid.origin[0] + (column + 0.5) * active.grid.cell_size[0]))


FIRM = 3.0
"""Dimensionless stiffness in cells behind an implicit boundary."""


def ghost_stabilisation(
    soil: Soil,
    active: ActiveGrid,
    held: npt.NDArray[np.bool_],
    gamma: float,
    behind: tuple[Integers, Floats] | None = None,
) -> list[Coupling]:
    """Returns the penalty on all faces of hardly filled cells at the edges of bodies.

    `gamma` is its dimensionless factor; 0 gives no penalty.
    Components that are `held` (nodes, dim) on the far nodes of the emptier cell are left out:
    they need no support, and would tie the soil to the boundary.
    """
    if gamma == 0.0 and (behind is None or len(behind[0]) == 0):
        return []
    grid, dim = active.grid, active.grid.dim
    key, fill, modulus = filled_cells(soil, active)
    place = np.asarray(_core.lattice(key))
    neighbour = {
        (axis, side): find_keys(key, lattice_keys(place + side * np.eye(3, dtype=np.int64)[axis]))
        for axis in range(dim)
        for side in (-1, 1)
    }
    at_edge = np.any([number < 0 for number in neighbour.values()], axis=0)
    emptiness = np.where(at_edge, gamma * np.clip(1.0 - fill / FULL, 0.0, 1.0), 0.0)
    weights = np.tile(emptiness[:, None], dim)
    if behind is not None:
        number = find_keys(key, behind[0])
        known = number >= 0
        hidden = np.zeros_like(weights)
        np.maximum.at(hidden, number[known], behind[1][known])
        # there the boundary's own penalty takes over: across it, not between equal slivers
        weights *= 1.0 - np.minimum(hidden.sum(axis=1), 1.0)[:, None]
        weights += FIRM * hidden
    couplings = []
    for axis in range(dim):
        cell = np.flatnonzero(neighbour[axis, 1] >= 0)
        other = neighbour[axis, 1][cell]
        weight = np.maximum(weights[cell, axis], weights[other, axis])
        cell, other, weight = (array[weight > 0.0] for array in (cell, other, weight))
        if len(cell) == 0:
            continue
        volume = np.maximum(fill[cell] + fill[other], 1e-300)
        weight = weight * (fill[cell] * modulus[cell] + fill[other] * modulus[other]) / volume
        if soil.kind == "axisymmetric":
            radius = 0.5 * (_centre_radius(active, key[cell]) + _centre_radius(active, key[other]))
            weight = weight * 2.0 * np.pi * radius
        offset, matrix = _face(tuple(grid.cell_size), axis)
        node = active.find((place[cell][:, None] + offset).reshape(-1, 3)).reshape(len(cell), -1)
        far = offset[:, axis] == np.where(fill[cell] < fill[other], 0, 2)[:, None]
        free = ~(held[node] & far[..., None]).any(axis=1)
        scalar = weight[:, None, None] * matrix
        couplings.append(
            Coupling(
                node=node.astype(np.int32),
                matrix=scalar[..., None, None] * (free[:, None] * np.eye(dim))[:, None, None],
                force=np.zeros((*node.shape, dim)),
            )
        )
    return couplings


FADE = 0.1
"""Motion, in cells, over which a face forgets by a factor e what its nodes did before."""


class Ghost:
    """Ghost stabilisation that remembers, so that a body at rest does not creep on it.

    The penalty on one step's displacement is a dashpot: what a stabilised node carries it would
    have to be given anew in each step. So each face keeps the displacement of its nodes (relative
    to one of them) as long as the soil does not move on:
    moved <- (moved + u) exp(-max |u| / h).

    Attributes:
        gamma: the dimensionless factor, see `ghost_stabilisation`.
        face: sorted names of the faces: key of the lower cell and axis, shape (faces,).
        moved: what their nodes have moved [length], shape (faces, nodes of a face, dim).
    """

    def __init__(self, gamma: float, dim: int) -> None:
        self.gamma = gamma
        self.face: Integers = np.zeros(0, dtype=np.int64)
        self.moved: Floats = np.zeros((0, 3 * 2 ** (dim - 1), dim))
        self._current: list[tuple[Integers, npt.NDArray[np.int32], Floats]] = []

    def couplings(
        self,
        soil: Soil,
        active: ActiveGrid,
        held: npt.NDArray[np.bool_],
        behind: tuple[Integers, Floats] | None = None,
    ) -> list[Coupling]:
        """Returns the penalty of `ghost_stabilisation` on what the faces remember and the step."""
        found = []
        self._current = []
        for coupling in ghost_stabilisation(soil, active, held, self.gamma, behind):
            place = active.lattice[coupling.node]
            axis = int((place[0].max(axis=0) - place[0].min(axis=0)).argmax())
            face = 4 * lattice_keys(place[:, 0]) + axis
            moved = np.zeros((*coupling.node.shape, active.grid.dim))
            number = find_keys(self.face, face)
            moved[number >= 0] = self.moved[number[number >= 0]]
            self._current.append((face, coupling.node, moved))
            force = np.einsum("eabij,ebj->eai", coupling.matrix, moved)
            found.append(Coupling(coupling.node, coupling.matrix, force))
        return found

    def commit(self, active: ActiveGrid, displacement: Floats) -> None:
        """Remembers a converged step's nodal displacement, shape (nodes, dim)."""
        faces, moves = [self.face[:0]], [self.moved[:0]]
        for face, node, moved in self._current:
            step = displacement[node]
            size = np.abs(step / active.grid.cell_size).max(axis=(1, 2))
            total = np.exp(-size / FADE)[:, None, None] * (moved + step)
            faces.append(face)
            moves.append(total - total[:, :1])  # a common motion has no force
        face, total = np.concatenate(faces), np.concatenate(moves)
        order = np.argsort(face)
        self.face, self.moved = face[order], total[order]


@cache
def _face(cell_size: tuple[float, ...], axis: int) -> tuple[Integers, Floats]:
    """Nodes of two cells that share a face, from the lower one's place, and the unit penalty.

    The derivative along the normal jumps by (u_0 - 2 u_1 + u_2) / h at each corner of the face
    and is linear (bilinear in 3D) between the corners.
    """
    dim = len(cell_size)
    offset = np.array([[0, 0, 0]])
    matrix: Floats = np.ones((1, 1))
    for k in reversed(range(dim)):
        h = cell_size[k]
        if k == axis:
            jump = np.array([1.0, -2.0, 1.0])
            along = np.outer(jump, jump) / h
        else:
            along = np.array([[2.0, 1.0], [1.0, 2.0]]) * h / 6.0
        unit = np.eye(3, dtype=np.int64)[k]
        offset = np.concatenate([offset + i * unit for i in range(len(along))])
        matrix = np.asarray(np.kron(along, matrix), dtype=np.float64)
    return offset, matrix
