# SPDX-License-Identifier: BSD-3-Clause
"""The internal force of the soil, as a term of the balance."""

from __future__ import annotations

from collections.abc import Sequence

from tilth.arrays import Flags, Floats
from tilth.errors import StepFailed
from tilth.mpm.domains import MovedDomains
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, Changes, Role, Term

MOST_REVISIONS = 25
"""Revisions of plastic volume changes in a solution, at most."""

REVISIONS, PROGRESS = 8, 0.3
"""Revisions after which the changes must be below this share of the first one."""


class SoilForces(Term):
    """The internal force of the stresses of all material points."""

    def __init__(self, soil: Soil) -> None:
        self._soil = soil

    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`; the pattern always contains the couplings of the points' nodes."""
        return _SoilForces(self._soil, active)


class _SoilForces(AssembledTerm):
    role = Role.SOIL

    def __init__(self, soil: Soil, active: ActiveGrid) -> None:
        self._soil, self._pattern = soil, active
        self._domains: MovedDomains = {}
        self._sizes: list[float] = []

    def force(self, displacement: Floats) -> Floats:
        self._soil.update(displacement)
        return self._soil.internal_force()

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        self._soil.add_stiffness(self._pattern, blocks)

    def restart(self, changes: Changes) -> None:
        self._soil.restart()
        self._sizes.clear()

    def refine(self, displacement: Floats) -> bool:
        size = self._soil.refine()
        if size <= 1.0:
            return False
        self._sizes.append(size)
        tried = len(self._sizes)
        if tried > MOST_REVISIONS or (tried > REVISIONS and size > PROGRESS * self._sizes[0]):
            raise StepFailed("the plastic volume changes of the points do not settle")
        return True

    def require_acceptable(self, displacement: Floats) -> None:
        self._domains = self._soil.moved_domains(displacement)

    def commit(self, displacement: Floats) -> None:
        self._soil.advance(displacement, self._domains)

    def yielding_nodes(self) -> Flags:
        return self._soil.yielding_nodes()
