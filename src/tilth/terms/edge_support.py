# SPDX-License-Identifier: BSD-3-Clause
"""Holds the weight of soil without cohesion in partly filled cells.

A node that only a sliver of soil reaches is in equilibrium by the stress of few points. Friction
alone bears the sliver's weight only in few directions, so that soil without cohesion has no
equilibrium at an edge whose points do not happen to lie well, however flat the edge is. The kinks
of the displacement across the faces of such cells are penalised, by a force that does not grow
beyond a share of the cell's own weight:

    t = M j / h / sqrt(1 + (j / j_0)^2),   M = W (1 - f) rho b h,   j_0 = a f h / W,

with the kink j, the jump of the normal derivative times the mean size h of the two cells, the
filled fraction f of the emptier one, its unit weight rho b. So t stays below a f (1 - f) rho b h,
a share of the cell's weight over its face: enough to hold a sliver, and little beside soil that
slides (docs/decisions/0043-sand-at-edges.md). The forces on the nodes of a face have no resultant
and no moment, and vanish with h.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats, Integers, require_table
from tilth.grid.keys import find_keys
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements, same_starts
from tilth.terms.ghost import DECAY_MOTION, Faces
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Role, Term
from tilth.terms.space import Coupled, Space
from tilth.terms.unheld_weight import STIFFNESS

SHARE = 0.3
"""Greatest traction on a face over f (1 - f) rho b h [-]."""


class EdgeSupport:
    """What the faces of cells at edges hold, with the motion of earlier steps.

    Attributes:
        face: sorted identifiers of the faces, see `Faces.identifiers`, shape (faces,).
        moved: displacement of their n nodes [length], shape (faces, n, dim), relative to one of
            them; it decays as in `Ghost`.
    """

    def __init__(self, dim: int) -> None:
        self.face: Integers = np.zeros(0, dtype=np.int64)
        self.moved: Floats = np.zeros((0, 3 * 2 ** (dim - 1), dim))

    def term(self, active: ActiveGrid, faces: Sequence[Faces], stiffening: float) -> SupportForces:
        """Returns the term of a step.

        stiffening: factor of the moduli of points on a frozen geometry [-].
        """
        parts = []
        for each in faces:
            face = each.identifiers(active)
            number = find_keys(self.face, face)
            moved = np.zeros((*each.node.shape, active.grid.dim))
            moved[number >= 0] = self.moved[number[number >= 0]]
            limit = SHARE * each.fill * each.size[:, each.axis] / STIFFNESS
            parts.append(_Part.of(each, active, face, moved / stiffening, limit, stiffening))
        return SupportForces(self, parts)

    def commit(self, parts: Sequence[_Part], displacement: Floats) -> None:
        """Stores a converged step's nodal displacement, shape (nodes, dim)."""
        identifiers, moves = [self.face[:0]], [self.moved[:0]]
        for part in parts:
            step = displacement[part.faces.node]
            size = np.abs(step / part.faces.size[:, None]).max(axis=(1, 2))
            total = np.exp(-size / DECAY_MOTION)[:, None, None] * (part.moved + step)
            identifiers.append(part.face)
            moves.append(part.faces.free * (total - total[:, :1]))
        face = np.concatenate(identifiers)
        order = np.argsort(face)
        self.face, self.moved = face[order], np.concatenate(moves)[order]

    def rows(self) -> tuple[Integers, list[str]]:
        """As `KeyedRows.rows`."""
        return self.face // 8, ["face", "moved"]

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"face": self.face, "moved": self.moved}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table(state, increasing="face")
        self.face, self.moved = state["face"], state["moved"]


@dataclass(frozen=True)
class _Part:
    """Faces with the same normal.

    Attributes:
        faces: the faces.
        face: their identifiers, shape (faces,).
        moved: displacement of earlier steps [length], shape (faces, n, dim).
        stiffness: factor of the unit stiffnesses [stress and as `Faces.weight`], shape (faces,).
        per_kink: (j / j_0)^2 over u . unit u [1/force-like], shape (faces,).
    """

    faces: Faces
    face: Integers
    moved: Floats
    stiffness: Floats
    per_kink: Floats

    @classmethod
    def of(
        cls, faces: Faces, active: ActiveGrid, face: Integers, moved: Floats, limit: Floats,
        stiffening: float,
    ) -> _Part:  # fmt: skip
        """Returns the part with a greatest elastic kink `limit` [length], shape (faces,)."""
        area = float(np.delete(active.grid.cell_size, faces.axis).prod())
        per_kink = faces.size[:, faces.axis] / area * (stiffening / limit) ** 2
        return cls(faces, face, moved, stiffening * faces.weight * faces.modulus, per_kink)

    @property
    def unit(self) -> Floats:
        """The unit stiffness of each face, shape (1 or faces, n, n)."""
        unit = self.faces.unit
        return unit if len(unit) == 1 else unit[self.faces.which]

    def products(self, displacement: Floats) -> tuple[Floats, Floats]:
        """Returns unit u of the total displacement, (faces, n, dim), and 1 + (j / j_0)^2."""
        free = self.faces.free
        total = free * (self.moved + displacement[self.faces.node])
        product = free * (self.unit @ total)
        return product, 1.0 + self.per_kink * (total * product).sum(axis=(1, 2))


class SupportForces(Term):
    """The support in one step."""

    def __init__(self, support: EdgeSupport, parts: Sequence[_Part]) -> None:
        self.support, self.parts = support, parts

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`."""
        return [
            Coupled(same_starts(each.faces.node), each.faces.node.ravel()) for each in self.parts
        ]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _AssembledSupport(self, list(zip(self.parts, elements, strict=True)))


class _AssembledSupport(DisplacementTerm):
    role = Role.STABILISATION
    label = "edge support"

    def __init__(self, term: SupportForces, parts: list[tuple[_Part, Elements]]) -> None:
        self._term, self._parts = term, parts

    def force(self, displacement: Floats) -> Floats:
        force = np.zeros_like(displacement)
        for part, elements in self._parts:
            product, square = part.products(displacement)
            factor = part.stiffness / np.sqrt(square)
            _core.add_element_forces(elements, factor[:, None, None] * product, force)
        return force

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        for part, elements in self._parts:
            product, square = part.products(displacement)
            factor = part.stiffness / np.sqrt(square)
            free = part.faces.free.astype(np.float64)
            unit = np.broadcast_to(part.unit, (len(factor), *part.unit.shape[1:]))
            elastic = np.einsum("f,fab,fai,fbi->fabi", factor, unit, free, free, optimize=True)
            matrix = np.einsum("fabi,ij->fabij", elastic, np.eye(free.shape[2]))
            softer = factor * part.per_kink / square
            matrix -= np.einsum("f,fai,fbj->fabij", softer, product, product)
            _core.add_dense_blocks(elements, np.ascontiguousarray(matrix), blocks)

    def commit(self, x: Unknowns, checked: None) -> None:
        self._term.support.commit(self._term.parts, x.u)
