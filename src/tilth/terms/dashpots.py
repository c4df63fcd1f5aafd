# SPDX-License-Identifier: BSD-3-Clause
"""Viscous tractions on a boundary, proportional to the velocity of the soil there.

With the impedances Z = rho c_s I + (rho c_p - rho c_s) n n^T of the ground beyond and its outcrop's
velocity v_o the traction on the soil is -Z (v - v_o): plane waves that meet the boundary at a right
angle leave through it (Lysmer and Kuhlemeyer 1969), and the wave of which v_o is the motion at a
free surface comes in.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from tilth import _core
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements, same_starts
from tilth.mpm.quadrature import PointsInCells
from tilth.terms.inertia import AssembledInertia, Inertia
from tilth.terms.linear import Coupling
from tilth.terms.outcome import Outcome, Work
from tilth.terms.protocol import DisplacementTerm, Role, Term
from tilth.terms.released import Release
from tilth.terms.space import Coupled, Space


class Dashpots(Term):
    """The dashpots of one boundary in one step.

    Args:
        name: of the boundary.
        at: its quadrature points in the cells of the grid, n of them.
        impedance: times the area of each [force time/length], shape (n, dim, dim).
        outcrop: velocity of the outcrop of the ground beyond before and after the step
            [length/time], shape (2, dim).
        inertia: of the soil; stands before this term in the balance.
        held: the forces that the boundary keeps, a term of their own.
    """

    def __init__(
        self,
        name: str,
        at: PointsInCells,
        impedance: Floats,
        outcrop: Floats,
        inertia: Inertia,
        held: Release,
    ) -> None:
        self.name, self._outcrop, self._inertia, self._held = name, outcrop, inertia, held
        by_point = np.einsum("na,nb,nij->nabij", at.value, at.value, impedance)
        matrix = np.ascontiguousarray(np.add.reduceat(by_point, at.start[:-1], axis=0))
        self._coupling = Coupling(at.node, matrix, np.zeros(matrix.shape[:2] + matrix.shape[-1:]))

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`: the nodes of each cell."""
        return [Coupled(same_starts(self._coupling.node), self._coupling.node.ravel())]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledDashpots:
        """As `Term.assembled`."""
        (own,) = elements
        inertia = self._inertia.in_matrix
        assert inertia is not None
        return AssembledDashpots(
            self.name, self._coupling, space.active, own, self._outcrop, inertia, self._held
        )


class AssembledDashpots(DisplacementTerm):
    """`Dashpots` in the matrix's pattern: a force that is linear in the displacement."""

    role = Role.INERTIA

    def __init__(
        self,
        name: str,
        coupling: Coupling,
        active: ActiveGrid,
        elements: Elements,
        outcrop: Floats,
        inertia: AssembledInertia,
        held: Release,
    ) -> None:
        self.name, self._coupling, self._elements, self._held = name, coupling, elements, held
        self._pattern = active
        self.label = f"absorbing boundary {name!r}"
        self._outcrop, self._inertia, self._from_rest = outcrop, inertia, inertia.from_rest

    def _product(self, velocity: Floats) -> Floats:
        product = np.zeros_like(velocity)
        self._coupling.add_product(self._elements, np.ascontiguousarray(velocity), product)
        return product

    @cached_property
    def _force_before(self) -> Floats:
        motion = self._inertia.motion_at_start() if self._from_rest else self._inertia.before
        return self._product(motion.velocity - self._outcrop[0])

    def inertia_before(self) -> Floats:
        """As `AssembledTerm.inertia_before`."""
        return self._force_before

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`."""
        if self._from_rest:  # the search for the accelerations, with the velocity that there is
            return self._force_before.copy()
        return self._product(self._inertia.after(displacement).velocity - self._outcrop[1])

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`."""
        if not self._from_rest:
            by_displacement, _ = self._inertia.derivatives()
            matrix = by_displacement * self._coupling.matrix
            _core.add_dense_blocks(self._elements, matrix, blocks)

    def outcome(self, x: Unknowns) -> Outcome:
        """As `AssembledTerm.outcome`: its force on the soil, and what leaves through it."""
        work = Work(radiated=self.radiated_work(x.u))
        return Outcome({self.name: self.on_soil(x.u)}, work)

    def radiated_work(self, displacement: Floats) -> float:
        """Returns the energy that leaves in the step less what comes in [force length]."""
        force = 0.5 * (self._force_before + self.force(displacement))
        return self._pattern.work(force, displacement)

    def on_soil(self, displacement: Floats) -> Floats:
        """Returns the boundary's force on the soil at the end of the step [force], (nodes, dim).

        That of the dashpots and what it keeps.
        """
        return -self.force(displacement) - self._held.force(displacement)
