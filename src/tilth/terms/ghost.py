# SPDX-License-Identifier: BSD-3-Clause
"""Ghost stabilisation: ties the nodes of hardly filled cells to the material beside them.

A cell at the edge of a body that holds a sliver of material gives its outer nodes a stiffness
that vanishes with the sliver. A penalty on the jump of the normal derivative of the step's
displacement across the cell's faces (Burman 2010; Sticko et al. 2020; for the material point
method Coombs 2022) gives them stiffness instead:

    f = gamma E h integral over the face of [d u / d n] [d v / d n],

with E the modulus of the two cells and h the cell's size along the face's normal. In units of
force: E h (1/length)^2 length^(dim-1) length = E length^(dim-1). It vanishes for every
displacement that is linear across the two cells, so that it has no net force, resists no rigid
motion, and leaves a homogeneous strain alone. It is weighted by how empty the cell is and vanishes
from half a cell on.

E is Young's modulus times the elastic share of the points' last strain increment: where soil
flows plastically its own stiffness is gone, and a penalty that kept it would bear load in its
place. It is never less than twice the equivalent stress, of elastic soil either, so that a node
that this stress pushes moves by a part of a cell only. Of the points in the two cells the soft ones
count (volume-weighted harmonic mean), since one yielding cell is enough to let the other one move.

Nodes behind an implicit boundary, where no soil is, are tied firmly to those in front of them on
the same grid lines, line by line: they continue the soil's field linearly.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid, find_keys, lattice_keys
from tilth.mpm.pattern import Elements, same_starts
from tilth.mpm.soil import Soil

FILL_WITHOUT_PENALTY = 0.5
"""Share of a cell from which on it is not stabilised."""
LEAST_SHARE = 1e-3
"""Share of Young's modulus that is left in plastic flow, so that slivers keep a stiffness."""
LEAST_MODULUS_OVER_STRESS = 2.0
"""Least modulus over the equivalent stress: a node that bears the soil's stress moves little."""


def filled_cells(soil: Soil) -> tuple[Integers, Floats, Floats]:
    """Returns the populated cells: keys, filled share [-], harmonic mean of modulus [stress].

    The key is that of the cell's lowest node; the share is that of the cell's volume, in
    axisymmetry of the ring it sweeps. The modulus is Young's where nothing yields.
    """
    active, grid = soil.active, soil.active.grid
    key = active.cell_keys
    filled = np.zeros((len(key), 2))
    volume = soil.points.volume
    young = soil.elastic_moduli.young
    for body, stencil in zip(soil.points.bodies, active.stencils, strict=True):
        s = slice(body.start, body.stop)
        share = np.maximum(soil.points.elastic_share[s], LEAST_SHARE)
        bearing = LEAST_MODULUS_OVER_STRESS * _equivalent_stress(soil.points.stress[s])
        modulus = np.maximum(young[s] * share, bearing)
        softness = 1.0 / modulus
        if body.has_corners:
            for column, weight in enumerate((volume[s], volume[s] * softness)):
                *_, moment = _core.share_corner_domains(
                    stencil, soil.points.position[s], soil.points.corner[s], weight, grid.origin,
                    grid.cell_size, key,
                )  # fmt: skip
                filled[:, column] += moment[:, 0]
            continue
        _core.fill_cells(
            stencil, soil.points.position[s], soil.points.half_length[s], volume[s], softness,
            grid.origin, grid.cell_size, key, filled,
        )  # fmt: skip
    size = np.full(len(key), float(np.prod(grid.cell_size)))
    if soil.kind == "axisymmetric":
        size *= 2.0 * np.pi * _centre_radius(active, key)
    modulus = np.maximum(filled[:, 0], 1e-300) / np.maximum(filled[:, 1], 1e-300)
    return key, filled[:, 0] / size, modulus


def _equivalent_stress(stress: Floats) -> Floats:
    """Returns von Mises' equivalent stress of Cauchy stresses (n, 6) [stress], shape (n,)."""
    normal = stress[:, :3] - stress[:, :3].mean(axis=1)[:, None]
    square = (normal**2).sum(axis=1) + 2.0 * (stress[:, 3:] ** 2).sum(axis=1)
    return np.asarray(np.sqrt(1.5 * square))


def _centre_radius(active: ActiveGrid, key: Integers) -> Floats:
    """Distance of the cells' centres from the axis, of cells that it cuts at least half a cell."""
    column, width = np.asarray(_core.lattice(key))[:, 0], active.grid.cell_size[0]
    centre = np.abs(active.grid.origin[0] + (column + 0.5) * width)
    return np.asarray(np.maximum(centre, 0.5 * width))


STIFFNESS_BEHIND = 2.0
"""Dimensionless stiffness of nodes a cell behind an implicit boundary."""


@dataclass(frozen=True)
class Faces:
    """Faces between cells, each with the penalty on the jump across it.

    All faces with the same normal share one matrix between nodes, the same for each component.

    Attributes:
        axis: of the normal.
        firm: whether they tie nodes behind boundaries, rather than those of hardly filled cells.
        node: of the two cells, from the lower one on, shape (faces, nodes of a face).
        unit: stiffness for a modulus and a weight of 1 [force/length/stress], shape (n, n).
        weight: of each face [-]; in axisymmetry times 2 pi r [length], shape (faces,).
        free: components that the penalty acts on, shape (faces, n, dim).
        modulus: of the soil in the two cells [stress], shape (faces,).
    """

    axis: int
    firm: bool
    node: npt.NDArray[np.int32]
    unit: Floats
    weight: Floats
    free: npt.NDArray[np.bool_]
    modulus: Floats

    def coupling(self, moved: Floats | None = None) -> FaceCoupling:
        """Returns the penalty on the step's displacement and on `moved`, of modulus times length.

        moved: shape (faces, n, dim); nothing if not given.
        """
        force = np.zeros(self.free.shape)
        if moved is not None:
            force = self.weight[:, None, None] * self.free * (self.unit @ (self.free * moved))
        return FaceCoupling(self.node, self.unit, self.weight * self.modulus, self.free, force)


@dataclass(frozen=True)
class FaceCoupling:
    """Elements with the force f_ai + stiffness sum_b unit_ab u_bi, in the free components i.

    Attributes:
        node: node numbers, shape (elements, n).
        unit: shape (n, n).
        stiffness: what `unit` is multiplied by, shape (elements,); their product in [force/length].
        free: components that the stiffness acts on, shape (elements, n, dim).
        force: at zero displacement [force], shape (elements, n, dim).
    """

    node: npt.NDArray[np.int32]
    unit: Floats
    stiffness: Floats
    free: npt.NDArray[np.bool_]
    force: Floats

    @property
    def node_start(self) -> Integers:
        """As `LinearElements.node_start`."""
        return same_starts(self.node)

    def add_product(
        self, elements: Elements, vector: Floats, product: Floats, magnitude: bool = False
    ) -> None:
        """As `LinearElements.add_product`."""
        _core.add_scaled_products(
            elements, self.stiffness, self.unit, self.free, vector, magnitude, product
        )

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """As `LinearElements.add_stiffness`."""
        _core.add_scaled_blocks(elements, self.stiffness, self.unit, self.free, blocks)


def ghost_faces(
    soil: Soil,
    constrained: npt.NDArray[np.bool_],
    gamma: float,
    behind: tuple[Integers, Floats] | None = None,
) -> list[Faces]:
    """Returns all faces of hardly filled cells at the edges of bodies, by the axis of the normal.

    `gamma` is the penalty's dimensionless factor; 0 gives none. Where a far node of the emptier
    cell has a `constrained` component (nodes, dim), this component of the jump at its corner of the
    face is left out: it needs no support, and would tie the soil to the boundary. The other corners
    keep theirs.
    """
    if gamma == 0.0 and (behind is None or len(behind[0]) == 0):
        return []
    active, dim = soil.active, soil.active.grid.dim
    key, fill, modulus = filled_cells(soil)
    place = np.asarray(_core.lattice(key))
    along = np.eye(3, dtype=np.int64)[:dim]
    beside = place + np.stack([-along, along])[:, :, None]  # (sides, axes, cells, 3)
    neighbour = find_keys(key, lattice_keys(beside.reshape(-1, 3))).reshape(2, dim, len(key))
    at_edge = (neighbour < 0).any(axis=(0, 1))
    emptiness = np.where(at_edge, gamma * np.clip(1.0 - fill / FILL_WITHOUT_PENALTY, 0.0, 1.0), 0.0)
    depth = np.zeros((active.nodes, dim))
    if behind is not None:
        number = find_keys(active.key, behind[0])
        depth[number[number >= 0]] = behind[1][number >= 0]
    faces = []
    for axis in range(dim):
        cell = np.flatnonzero(neighbour[1, axis] >= 0)
        other = neighbour[1, axis, cell]
        offset, unit, line = _face(tuple(active.grid.cell_size.tolist()), axis)
        node = active.find((place[cell][:, None] + offset).reshape(-1, 3))
        node = node.reshape(len(cell), len(offset))
        end = offset[:, axis] != 1
        behind_ends = depth[node, axis] * end  # (faces, nodes)
        at_boundary = depth[node].sum(axis=2).max(axis=1, initial=0.0)
        # behind a boundary nodes move with the soil in front, line by line
        firm = STIFFNESS_BEHIND * behind_ends.max(axis=1, initial=0.0)
        hidden = np.broadcast_to(((behind_ends @ line) > 0.0)[..., None], (*node.shape, dim))
        # there its own penalty takes over: across it, not between equal slivers
        weak = np.maximum(emptiness[cell], emptiness[other]) * (1.0 - np.minimum(at_boundary, 1.0))
        far = offset[:, axis] == np.where(fill[cell] < fill[other], 0, 2)[:, None]
        softness = fill[cell] / modulus[cell] + fill[other] / modulus[other]
        stiff = (fill[cell] + fill[other]) / np.maximum(softness, 1e-300)
        circumference = np.ones(len(cell))
        if soil.kind == "axisymmetric":
            radius = 0.5 * (_centre_radius(active, key[cell]) + _centre_radius(active, key[other]))
            circumference = 2.0 * np.pi * radius
        for weight, ends, tied in ((weak, far, None), (firm, end & (behind_ends > 0.0), hidden)):
            some = np.flatnonzero(weight > 0.0)
            if len(some) == 0:
                continue
            left_out = constrained[node[some]] & ends[some][..., None]  # (faces, nodes, dim)
            free = ~(line @ left_out) if left_out.any() else np.ones(left_out.shape, dtype=bool)
            if tied is not None:
                free &= tied[some]
            faces.append(
                Faces(
                    axis=axis,
                    firm=tied is not None,
                    node=node[some].astype(np.int32),
                    unit=unit,
                    weight=weight[some] * circumference[some],
                    free=free,
                    modulus=stiff[some],
                )
            )
    return faces


MEMORY_LENGTH = 0.1
"""Motion, in cells, over which a face forgets by a factor e what its nodes did before."""


class Ghost:
    """Ghost stabilisation that remembers, so that a body at rest does not creep on it.

    The penalty on one step's displacement is a dashpot: what a stabilised node carries it would
    have to be given anew in each step. So each face keeps the displacement of its nodes (relative
    to one of them), times the modulus of the step, as long as the soil does not move on or soften:
    moved <- (moved + E u) exp(-max |u| / h), and moved <- moved E / E_before where E falls.

    Attributes:
        gamma: the dimensionless factor, see `ghost_faces`.
        face: sorted names of the faces: key of the lower cell, kind and axis, shape (faces,).
        moved: modulus times motion of their nodes [stress length], shape (faces, nodes of a
            face, dim).
        modulus: of the step in which they moved [stress], shape (faces,).
    """

    def __init__(self, gamma: float, dim: int) -> None:
        self.gamma = gamma
        self.face: Integers = np.zeros(0, dtype=np.int64)
        self.moved: Floats = np.zeros((0, 3 * 2 ** (dim - 1), dim))
        self.modulus: Floats = np.zeros(0)
        self._current: list[tuple[Integers, Faces, Floats]] = []

    def couplings(
        self,
        soil: Soil,
        constrained: npt.NDArray[np.bool_],
        behind: tuple[Integers, Floats] | None = None,
    ) -> list[FaceCoupling]:
        """Returns the penalty of `ghost_faces` on what the faces remember and on the step."""
        found, active = [], soil.active
        self._current = []
        for faces in ghost_faces(soil, constrained, self.gamma, behind):
            place = active.lattice[faces.node[:, 0]]
            face = 8 * lattice_keys(place) + 4 * faces.firm + faces.axis
            moved = np.zeros((*faces.node.shape, active.grid.dim))
            number = find_keys(self.face, face)
            known = np.flatnonzero(number >= 0)
            number = number[known]
            softened = np.minimum(faces.modulus[known] / self.modulus[number], 1.0)
            moved[known] = softened[:, None, None] * self.moved[number]
            self._current.append((face, faces, moved))
            found.append(faces.coupling(moved))
        return found

    def holds(
        self, active: ActiveGrid, constrained: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Returns the nodes whose components are all constrained or tied by the faces, (nodes,).

        Faces leave components out behind which a node is constrained (`ghost_faces`).
        """
        tied = constrained.copy()
        reached = np.zeros(active.nodes, dtype=bool)
        for _, faces, _ in self._current:
            face, component = np.nonzero(faces.free.reshape(-1, active.grid.dim))
            tied[faces.node.ravel()[face], component] = True
            reached[faces.node] = True
        return np.asarray(reached & tied.all(axis=1))

    def commit(self, active: ActiveGrid, displacement: Floats) -> None:
        """Remembers a converged step's nodal displacement, shape (nodes, dim)."""
        names, moves, moduli = [self.face[:0]], [self.moved[:0]], [self.modulus[:0]]
        for face, faces, moved in self._current:
            step = displacement[faces.node]
            size = np.abs(step / active.grid.cell_size).max(axis=(1, 2))
            total = np.exp(-size / MEMORY_LENGTH)[:, None, None]
            total = total * (moved + faces.modulus[:, None, None] * step)
            names.append(face)
            moves.append(total - total[:, :1])  # a common motion has no force
            moduli.append(faces.modulus)
        face = np.concatenate(names)
        order = np.argsort(face)
        self.face = face[order]
        self.moved = np.concatenate(moves)[order]
        self.modulus = np.concatenate(moduli)[order]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        return {"face": self.face, "moved": self.moved, "modulus": self.modulus}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        self.face, self.moved, self.modulus = state["face"], state["moved"], state["modulus"]


@cache
def _face(
    cell_size: tuple[float, ...], axis: int
) -> tuple[Integers, Floats, npt.NDArray[np.bool_]]:
    """Two cells that share a face: nodes, unit penalty, pairs of nodes on one line across it.

    The nodes are seen from the lower cell's place.

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
    across = offset - offset * np.eye(3, dtype=np.int64)[axis]
    return offset, matrix, (across[:, None] == across[None]).all(axis=2)
