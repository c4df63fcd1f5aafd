# SPDX-License-Identifier: BSD-3-Clause
"""Damping proportional to the elastic stiffness of the soil (docs/theory/inertia.md).

Soil resists its rate of strain by the stress of elastic soil,

    tau = (factor / h) D : ln V,

with V the stretch of the step of size h and D the elastic moduli at the start of the step. V does
not feel a rotation, and the stress acts in the configuration at the end of the step. The rate of
strain is the mean of the step, so that the work in every step is positive.

It is computed as that of a second soil without strain, at the same points and with the same means
against locking.
"""

from __future__ import annotations

from collections.abc import Sequence

from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.outcome import Outcome, Work
from tilth.terms.protocol import DisplacementTerm, Role, Term
from tilth.terms.space import Space


class StiffnessDamping(Term):
    """The viscous forces of all material points in one step.

    Args:
        soil: on the grid of the step.
        factor: of the elastic stiffness [time].
        size: of the step [time].
    """

    def __init__(self, soil: Soil, factor: float, size: float) -> None:
        self._viscous = soil.without_strain(factor / size)

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledStiffnessDamping:
        """As `Term.assembled`; the pattern always contains the couplings of the points' nodes."""
        return AssembledStiffnessDamping(self._viscous, space.active)


class AssembledStiffnessDamping(DisplacementTerm):
    """`StiffnessDamping` in the matrix's pattern."""

    role = Role.INERTIA
    label = "stiffness damping"

    def __init__(self, viscous: Soil, active: ActiveGrid) -> None:
        self._viscous, self._pattern = viscous, active

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`."""
        self._viscous.update(displacement)
        return self._viscous.internal_force()

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`."""
        self._viscous.add_stiffness(self._pattern, blocks)

    def outcome(self, x: Unknowns) -> Outcome:
        """As `AssembledTerm.outcome`: what the damping takes."""
        return Outcome(work=Work(damping=self.damping_work(x.u)))

    def damping_work(self, displacement: Floats) -> float:
        """Returns the work of the forces in the step [force length]."""
        return self._pattern.work(self.force(displacement), displacement)
