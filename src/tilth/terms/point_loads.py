# SPDX-License-Identifier: BSD-3-Clause
"""Body forces and point forces on the material points as a term of the balance."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.loads import Loads
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Role, Term
from tilth.terms.space import Space


class PointLoads(Term, DisplacementTerm):
    """The loads on the points in a step, independent of the displacement.

    Args:
        loads: of the model.
        soil: the material points on the grid of the step.
        before, after: times at the start and end of the step.
    """

    role = Role.LOAD
    label = "loads on points"

    def __init__(self, loads: Loads, soil: Soil, before: float, after: float) -> None:
        none = np.zeros((soil.active.nodes, soil.active.grid.dim))
        self._before, self._after = (
            soil.scatter(loads.force(soil.points, time)) if loads else none
            for time in (before, after)
        )

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return self

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`."""
        return -self._after

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`: zero."""

    def load_before(self) -> Floats:
        """As `AssembledTerm.load_before`."""
        return self._before
