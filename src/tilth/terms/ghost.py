# SPDX-License-Identifier: BSD-3-Clause
"""Ghost stabilisation: couples the nodes of partly filled cells to the adjacent material.

At the edge of a body, the stiffness of a cell's outer nodes vanishes with the volume of material in
the cell. A penalty on the jump of the normal derivative of the step's displacement across the
cell's faces (Burman 2010; Sticko et al. 2020; for the material point method Coombs 2022) gives
them stiffness instead:

    f = gamma E h integral over the face of [d u / d n] [d v / d n],

with E the modulus of the two cells and h their mean size along the face's normal. In units of
force: E h (1/length)^2 length^(dim-1) length = E length^(dim-1). It vanishes for every
displacement that is linear across the two cells. So it has no net force and resists neither rigid
motions nor homogeneous strains. It is weighted by the empty fraction of the cell and vanishes for
cells that are at least half full.

E is Young's modulus times the elastic share of the points' last strain increment: soil in plastic
flow has lost its own stiffness, and a penalty with the elastic stiffness would carry load in its
place. E is at least twice the equivalent stress, also in elastic soil, so that this stress moves a
node by a fraction of a cell only. It is the volume-weighted harmonic mean over the points in the
two cells, in which the softest dominate: one yielding cell suffices to let the other one move.

Exterior nodes, behind an implicit boundary and without soil, are coupled by a stiffer penalty to
the nodes in front of them on the same grid line, so that they extrapolate the soil's displacement
linearly; not to soil that lies behind them, on the other side of a thin wall.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum, auto
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers, Shorts, require_table
from tilth.grid.background import Grid, cell_corners
from tilth.grid.keys import find_keys, lattice_keys
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.filled_cells import cell_places, centre_radii, filled_cells
from tilth.terms.linear import EqualElements
from tilth.terms.unheld_weight import weight_at_edges

FILL_WITHOUT_PENALTY = 0.5
"""Filled fraction of a cell from which on it is not stabilised."""
EQUALLY_FILLED = 1e-9
"""Difference of the filled fractions of two cells below which neither is the emptier one."""
NEGLIGIBLE = 1e-9
"""Weight of a face over the greatest one up to which it is round-off, as of a boundary on a line of
the grid: the face has no force in this step, and remembers no displacement of it in the next."""
EXTERIOR_STIFFNESS = 2.0
"""Dimensionless penalty factor of exterior nodes a cell behind an implicit boundary."""


class Kind(Enum):
    """Which nodes a penalty on faces holds."""

    EDGE = auto()
    """Those of partly filled cells at edges, elastically."""
    EXTERIOR = auto()
    """Those behind an implicit boundary."""
    WEIGHT = auto()
    """Those of partly filled cells whose soil has no cohesion, against its weight."""


@dataclass(frozen=True)
class Faces:
    """Faces between cells, each with the penalty on the jump across it.

    All faces with the same normal between cells of the same two sizes along it share one matrix
    between nodes, the same for each component.

    Attributes:
        axis: direction of the normal.
        kind: which nodes they hold.
        node: the n nodes of the two cells, from the lower cell on, shape (faces, n).
        unit: stiffnesses for a modulus and a weight of 1 [force/length/stress], for a face of the
            size that it has on the grid's smallest cells, shape (units, n, n).
        which: which of them each face has, shape (faces,).
        size: mean size of the two cells [length], shape (faces, dim).
        weight: of each face [-]: its area relative to that on the smallest cells times the share of
            the penalty; in axisymmetry times 2 pi r [length], shape (faces,).
        free: components on which the penalty acts, shape (faces, n, dim).
        modulus: of the soil in the two cells [stress], shape (faces,).
        emptiness: as the weight, with the share in the greatest penalty, shape (faces,).
        fill: filled fraction of the emptier cell, of faces that hold weight [-], shape (faces,).
    """

    axis: int
    kind: Kind
    node: npt.NDArray[np.int32]
    unit: Floats
    which: Shorts
    size: Floats
    weight: Floats
    free: npt.NDArray[np.bool_]
    modulus: Floats
    emptiness: Floats
    fill: Floats

    def identifiers(self, active: ActiveGrid) -> Integers:
        """Returns numbers that name the faces from step to step, shape (faces,)."""
        return np.asarray(
            8 * active.key[self.node[:, 0]] + 4 * (self.kind is Kind.EXTERIOR) + self.axis
        )

    def of(self, kept: Flags) -> Faces:
        """Returns some of the faces, by flags (faces,)."""
        names = "node", "which", "size", "weight", "free", "modulus", "emptiness", "fill"
        return replace(self, **{name: getattr(self, name)[kept] for name in names})

    def coupling(self, moved: Floats | None = None) -> FaceCoupling:
        """Returns the penalty on the step's displacement and on that of earlier steps, `moved`.

        moved: modulus times displacement [stress length], shape (faces, n, dim); 0 if not given.
        """
        force = np.zeros(self.free.shape)
        if moved is not None:
            unit = self.unit if len(self.unit) == 1 else self.unit[self.which]
            force = self.weight[:, None, None] * self.free * (unit @ (self.free * moved))
        stiffness = self.weight * self.modulus
        return FaceCoupling(self.node, self.unit, self.which, stiffness, self.free, force)


@dataclass(frozen=True)
class FaceCoupling(EqualElements):
    """Elements with the force f_ai + stiffness sum_b unit_ab u_bi, in the free components i.

    Attributes:
        unit: stiffnesses for a factor of 1, shape (units, n, n).
        which: which of them each element has, shape (elements,).
        stiffness: factor of `unit`, shape (elements,); their product is in [force/length].
        free: components on which the stiffness acts, shape (elements, n, dim).
        force: at zero displacement [force], shape (elements, n, dim).
    """

    unit: Floats
    which: Shorts
    stiffness: Floats
    free: npt.NDArray[np.bool_]
    force: Floats

    def add_product(
        self, elements: Elements, vector: Floats, product: Floats, magnitude: bool = False
    ) -> None:
        """As `LinearElements.add_product`."""
        _core.add_scaled_products(
            elements, self.stiffness, self.unit, self.which, self.free, vector, magnitude, product
        )

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """As `LinearElements.add_stiffness`."""
        _core.add_scaled_blocks(elements, self.stiffness, self.unit, self.which, self.free, blocks)


def ghost_faces(
    soil: Soil,
    constrained: npt.NDArray[np.bool_],
    gamma: float,
    exterior: tuple[Integers, Floats] | None = None,
    unit_weight: Floats | None = None,
) -> list[Faces]:
    """Returns all faces of partly filled cells at the edges of bodies, by the axis of the normal.

    With the weight of soil without cohesion also those that hold it, see `EdgeSupport`.

    Where a node of the emptier cell that is not on the face has a constrained component, this
    component of the jump at its corner of the face is omitted: the node needs none, and the
    penalty would connect the soil to the boundary. The other corners are not affected. Of cells
    that are filled alike the nodes of both must have it.

    gamma: dimensionless factor of the penalty; no penalty for 0.
    constrained: prescribed components, shape (nodes, dim).
    exterior: keys and relative stiffness of exterior nodes, see
        `ImplicitConstraints.exterior_nodes`.
    unit_weight: of soil without cohesion, which has to be held at edges [stress/length], shape
        (n,), see `unheld_weight`; 0 if not given.
    """
    if gamma == 0.0 and (exterior is None or len(exterior[0]) == 0):
        return []
    active, dim = soil.active, soil.active.grid.dim
    key, fill, modulus = filled_cells(soil)
    lattice = np.asarray(_core.lattice(key))  # shifted by the cells' overlays, as their keys
    place = cell_places(active, key)
    along = np.eye(3, dtype=np.int64)[:dim]
    adjacent = lattice + np.stack([-along, along])[:, :, None]  # (sides, axes, cells, 3)
    neighbour = find_keys(key, lattice_keys(adjacent.reshape(-1, 3))).reshape(2, dim, len(key))
    at_edge = np.asarray((neighbour < 0).any(axis=(0, 1)))
    emptiness = np.where(at_edge, gamma * np.clip(1.0 - fill / FILL_WITHOUT_PENALTY, 0.0, 1.0), 0.0)
    weighted = np.zeros((2, len(key)))
    if gamma > 0.0 and unit_weight is not None and unit_weight.any():
        weighted = weight_at_edges(soil, fill, at_edge, unit_weight)
    depth = np.zeros((active.nodes, dim, 2))
    if exterior is not None:
        number = find_keys(active.key, exterior[0])
        depth[number[number >= 0]] = exterior[1][number >= 0]
    concerned = (emptiness > 0.0) | (weighted[0] > 0.0)
    concerned |= _cells_at(key, active.key[depth.any(axis=(1, 2))], dim)
    faces = []
    for axis in range(dim):
        cell = np.flatnonzero(neighbour[1, axis] >= 0)
        cell = cell[concerned[cell] | concerned[neighbour[1, axis, cell]]]
        other = neighbour[1, axis, cell]
        size = active.grid.sizes(place[cell]), active.grid.sizes(place[other])
        offset, line = _two_cells(dim, axis)
        unit, which = _units(active.grid, *size, axis)
        mean_size = 0.5 * (size[0] + size[1])
        area = np.delete(mean_size / active.grid.cell_size, axis, axis=1).prod(axis=1)
        node = active.find((lattice[cell][:, None] + offset).reshape(-1, 3))
        node = node.reshape(len(cell), len(offset))
        place_in = offset[:, :dim]
        # which nodes have cells above and below them along each axis, (n, dim, 2)
        facing = np.stack([place_in < place_in.max(axis=0), place_in > 0], axis=2)
        towards = depth[node] * facing  # (faces, n, dim, 2)
        end = offset[:, axis] != 1
        exterior_ends = end * towards[:, :, axis].sum(axis=2)  # (faces, nodes)
        at_boundary = towards.sum(axis=(2, 3)).max(axis=1, initial=0.0)
        # exterior nodes move with the soil on the same grid line
        stiff = EXTERIOR_STIFFNESS * exterior_ends.max(axis=1, initial=0.0)
        coupled = np.broadcast_to(((exterior_ends @ line) > 0.0)[..., None], (*node.shape, dim))
        # their penalty replaces that of partly filled cells near the boundary
        away = 1.0 - np.minimum(at_boundary, 1.0)
        weak = np.maximum(emptiness[cell], emptiness[other]) * away
        emptier = np.where(weighted[0, cell] >= weighted[0, other], cell, other)
        held_modulus = weighted[0, emptier] * mean_size[:, axis]
        fuller = (fill[cell] - fill[other])[:, None]
        far = tuple(  # nodes of the emptier cell; of one and of the other if there is none
            offset[:, axis] == np.where(fuller < difference, 0, 2)
            for difference in (-EQUALLY_FILLED, EQUALLY_FILLED)
        )
        softness = fill[cell] / modulus[cell] + fill[other] / modulus[other]
        mean_modulus = (fill[cell] + fill[other]) / np.maximum(softness, 1e-300)
        if soil.kind == "axisymmetric":
            radius = 0.5 * (centre_radii(active, key[cell]) + centre_radii(active, key[other]))
            area = area * (2.0 * np.pi * radius)
        at_end = (exterior_ends > 0.0,)
        kinds = (
            (Kind.EDGE, weak, mean_modulus, gamma, far, None),
            (Kind.EXTERIOR, stiff, mean_modulus, EXTERIOR_STIFFNESS, at_end, coupled),
            (Kind.WEIGHT, away * (held_modulus > 0.0), held_modulus, 1.0, far, None),
        )
        for kind, weight, modulus_of, greatest, far_nodes, only in kinds:
            some = np.flatnonzero(weight > NEGLIGIBLE * greatest)
            if len(some) == 0:
                continue
            held = constrained[node[some]]  # (faces, nodes, dim)
            free = np.ones(held.shape, dtype=bool)
            if held.any():
                omitted = [line @ (held & each[some][..., None]) for each in far_nodes]
                free = ~np.logical_and.reduce(omitted)
            if only is not None:
                free &= only[some]
            faces.append(
                Faces(
                    axis=axis,
                    kind=kind,
                    node=node[some].astype(np.int32),
                    unit=unit,
                    which=which[some],
                    size=mean_size[some],
                    weight=weight[some] * area[some],
                    free=free,
                    modulus=modulus_of[some],
                    emptiness=weight[some] / greatest * area[some],
                    fill=weighted[1, emptier[some]],
                )
            )
    return faces


def _cells_at(key: Integers, nodes: Integers, dim: int) -> Flags:
    """Returns which of the cells with sorted keys have one of the nodes with these keys."""
    found = np.zeros(len(key), dtype=bool)
    offset = lattice_keys(cell_corners(dim))
    for each in offset - offset[0]:
        number = find_keys(key, nodes - each)
        found[number[number >= 0]] = True
    return found


DECAY_MOTION = 0.1
"""Motion, in cells, over which the stored displacement of a face decays by a factor e."""


LEAST_MODULUS = 1e-300
"""A modulus that no soil falls below [stress]."""


class Ghost:
    """Ghost stabilisation with stored displacements, so that a loaded body does not creep.

    A penalty on the displacement of one step alone acts as a dashpot: a stabilised node under load
    would move in each step. So each face stores the displacement of its nodes (relative to one of
    them) times the modulus of the step. With u in cells it decays as the soil moves,
    moved <- (moved + E u) exp(-max |u| / `DECAY_MOTION`), and as it softens,
    moved <- moved E / E_before where E decreases.

    Attributes:
        gamma: dimensionless factor, see `ghost_faces`.
        face: sorted identifiers of the faces: key of the lower cell, kind and axis, shape (faces,).
        moved: modulus times displacement of their n nodes [stress length], shape (faces, n, dim).
        modulus: of the last step [stress], shape (faces,).
        of_weight: faces of the step for which `couplings` was called last that hold weight.
    """

    def __init__(self, gamma: float, dim: int) -> None:
        self.gamma = gamma
        self.face: Integers = np.zeros(0, dtype=np.int64)
        self.moved: Floats = np.zeros((0, 3 * 2 ** (dim - 1), dim))
        self.modulus: Floats = np.zeros(0)
        self.of_weight: list[Faces] = []
        self._current: list[tuple[Integers, Faces, Floats]] = []

    def couplings(
        self,
        soil: Soil,
        constrained: npt.NDArray[np.bool_],
        exterior: tuple[Integers, Floats] | None = None,
        unit_weight: Floats | None = None,
    ) -> list[FaceCoupling]:
        """Returns the penalty on the stored displacement and on that of the step.

        constrained, exterior, unit_weight: see `ghost_faces`.
        """
        found, active = [], soil.active
        self._current, self.of_weight = [], []
        for faces in ghost_faces(soil, constrained, self.gamma, exterior, unit_weight):
            if faces.kind is Kind.WEIGHT:
                self.of_weight.append(faces)
                continue
            face = faces.identifiers(active)
            moved = np.zeros((*faces.node.shape, active.grid.dim))
            number = find_keys(self.face, face)
            stored = np.flatnonzero(number >= 0)
            number = number[stored]
            softening = np.minimum(faces.modulus[stored], self.modulus[number])
            softening /= self.modulus[number]
            moved[stored] = softening[:, None, None] * self.moved[number]
            self._current.append((face, faces, moved))
            found.append(faces.coupling(moved))
        return found

    @property
    def faces(self) -> list[Faces]:
        """The faces of the step for which `couplings` was called last."""
        return [faces for _, faces, _ in self._current]

    def held_nodes(
        self, active: ActiveGrid, constrained: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Returns which nodes of faces have only held or constrained components, (nodes,).

        A face does not hold the components that it omits because of a constrained node
        (`ghost_faces`).
        """
        held = constrained.copy()
        on_face = np.zeros(active.nodes, dtype=bool)
        for _, faces, _ in self._current:
            face, component = np.nonzero(faces.free.reshape(-1, active.grid.dim))
            held[faces.node.ravel()[face], component] = True
            on_face[faces.node] = True
        return np.asarray(on_face & held.all(axis=1))

    def commit(self, active: ActiveGrid, displacement: Floats) -> None:
        """Stores a converged step's nodal displacement, shape (nodes, dim)."""
        identifiers, moves, moduli = [self.face[:0]], [self.moved[:0]], [self.modulus[:0]]
        for face, faces, moved in self._current:
            step = displacement[faces.node]
            size = np.abs(step / faces.size[:, None]).max(axis=(1, 2))
            total = np.exp(-size / DECAY_MOTION)[:, None, None]
            total = total * (moved + faces.modulus[:, None, None] * step)
            identifiers.append(face)
            kept = total - total[:, :1]  # a uniform motion causes no force
            if faces.kind is Kind.EDGE:  # what is not held now is not held later for it
                kept = faces.free * kept
            moves.append(kept)
            moduli.append(faces.modulus)
        face = np.concatenate(identifiers)
        order = np.argsort(face)
        self.face = face[order]
        self.moved = np.concatenate(moves)[order]
        self.modulus = np.concatenate(moduli)[order]

    def keep_forces(self) -> None:
        """Keeps the stored forces as they are in the next step, for its modulus is another one's.

        To be called when materials are exchanged, which is no softening.
        """
        self.modulus = np.full(len(self.modulus), LEAST_MODULUS)

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.face // 8, ["face", "moved", "modulus"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"face": self.face, "moved": self.moved, "modulus": self.modulus}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table(state, increasing="face")
        self.face, self.moved, self.modulus = state["face"], state["moved"], state["modulus"]


@cache
def _two_cells(dim: int, axis: int) -> tuple[Integers, npt.NDArray[np.bool_]]:
    """Returns the nodes of two adjacent cells and which of them are on one grid line.

    The nodes' lattice coordinates are relative to the lower cell's, x fastest, shape (n, 3).
    """
    offset = np.array([[0, 0, 0]])
    for k in reversed(range(dim)):
        unit = np.eye(3, dtype=np.int64)[k]
        offset = np.concatenate([offset + i * unit for i in range(3 if k == axis else 2)])
    across = offset - offset * np.eye(3, dtype=np.int64)[axis]
    return offset, (across[:, None] == across[None]).all(axis=2)


def _units(grid: Grid, below: Floats, above: Floats, axis: int) -> tuple[Floats, Shorts]:
    """Returns the unit penalties, see `Faces`, and which of them each face has.

    below, above: sizes of the two cells [length], shape (faces, dim).
    """
    two = np.stack([below[:, axis], above[:, axis]], axis=1)
    if axis in grid.graded:
        two, which = np.unique(two, axis=0, return_inverse=True)
    else:
        two, which = two[:1], np.zeros(len(two), dtype=np.int64)
    size = tuple(grid.cell_size.tolist())
    units = [_unit(size, axis, low, high) for low, high in two.tolist()]
    nodes = 3 * 2 ** (grid.dim - 1)
    return np.array(units).reshape(-1, nodes, nodes), which.reshape(-1).astype(np.int32)


@cache
def _unit(cell_size: tuple[float, ...], axis: int, below: float, above: float) -> Floats:
    """Returns the unit penalty of the nodes of two adjacent cells, of these sizes along the axis.

    The jump of the derivative along the normal is (u_2 - u_1) / above - (u_1 - u_0) / below at each
    corner of the face and linear (bilinear in 3D) between the corners.
    """
    matrix: Floats = np.ones((1, 1))
    for k in reversed(range(len(cell_size))):
        if k == axis:
            h = 0.5 * (below + above)
            jump = np.array([h / below, -(h / below + h / above), h / above])
            along = np.outer(jump, jump) / h
        else:
            along = np.array([[2.0, 1.0], [1.0, 2.0]]) * cell_size[k] / 6.0
        matrix = np.asarray(np.kron(along, matrix), dtype=np.float64)
    return matrix
