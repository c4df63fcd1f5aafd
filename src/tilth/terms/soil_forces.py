# SPDX-License-Identifier: BSD-3-Clause
"""The internal force of the soil, as a term of the balance."""

from __future__ import annotations

from collections.abc import Sequence

from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import MovedDomains
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, Changes, DisplacementTerm, Role, Term
from tilth.terms.space import Space


class SoilForces(Term):
    """The internal force of the stresses of all material points."""

    def __init__(self, soil: Soil) -> None:
        self._soil = soil

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`; the pattern always contains the couplings of the points' nodes."""
        return _SoilForces(self._soil, space.active)


class _SoilForces(DisplacementTerm):
    role = Role.SOIL
    label = "soil"

    def __init__(self, soil: Soil, active: ActiveGrid) -> None:
        self._soil, self._pattern = soil, active

    def force(self, displacement: Floats) -> Floats:
        self._soil.update(displacement)
        return self._soil.internal_force()

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        self._soil.add_stiffness(self._pattern, blocks)

    def restart(self, changes: Changes) -> None:
        self._soil.restart()

    def refine(self, x: Unknowns) -> float:
        return self._soil.refine()

    def check(self, x: Unknowns) -> MovedDomains:
        return self._soil.moved_domains(x.u)

    def commit(self, x: Unknowns, checked: MovedDomains) -> None:
        self._soil.advance(x.u, checked)

    def yielding_nodes(self) -> Flags:
        return self._soil.yielding_nodes()
