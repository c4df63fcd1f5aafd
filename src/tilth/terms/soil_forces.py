# SPDX-License-Identifier: BSD-3-Clause
"""The internal force of the soil, as a term of the balance."""

from __future__ import annotations

from collections.abc import Sequence

from tilth.arrays import Flags, Floats
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, Role, Term


class SoilForces(Term):
    """The stresses of all material points."""

    def __init__(self, soil: Soil) -> None:
        self._soil = soil

    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`; the pattern has the nodes of the points' supports in any case."""
        return _SoilForces(self._soil, active)


class _SoilForces(AssembledTerm):
    role = Role.SOIL

    def __init__(self, soil: Soil, active: ActiveGrid) -> None:
        self._soil, self._active = soil, active

    def force(self, displacement: Floats) -> Floats:
        self._soil.update(self._active, displacement)
        return self._soil.internal_force(self._active)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        self._soil.add_stiffness(self._active, blocks)

    def yielding_nodes(self) -> Flags:
        return self._soil.yielding_nodes(self._active)
