# SPDX-License-Identifier: BSD-3-Clause
"""Forces that are released over a stage: what was out of balance at its start.

When soil or a boundary is removed, a material is exchanged or new soil is placed, the forces on
the soil are no longer in balance. The residual at the start of the stage acts as an external force
on the nodes, which decreases as the declared share is released: so the stage begins in equilibrium,
and nothing of this force is left at its end. The forces stay at their nodes in space.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers, require_table
from tilth.model.load_curve import LoadCurve
from tilth.mpm.grid import ActiveGrid, find_keys
from tilth.mpm.pattern import Elements
from tilth.terms.protocol import AssembledTerm, Role, Term


class ReleasedForces:
    """The forces out of balance at the start of a stage, which persist until they are released.

    Args:
        dim: number of directions.
        share: share that has been released, over the time of the stage.

    Attributes:
        key: of the nodes, ascending, shape (m,).
        force: external force before anything is released [force], shape (m, dim).
    """

    def __init__(self, dim: int, share: LoadCurve) -> None:
        self._share = share
        self.key: Integers = np.zeros(0, dtype=np.int64)
        self.force: Floats = np.zeros((0, dim))

    def set(self, active: ActiveGrid, force: Floats) -> None:
        """Sets the forces at the start of the stage, shape (nodes, dim)."""
        loaded = np.flatnonzero(force.any(axis=1))
        self.key, self.force = active.key[loaded].copy(), force[loaded]

    def remaining(self, time: float) -> float:
        """Returns the share of the forces that still acts at a time of the stage [-]."""
        return 1.0 - self._share.factor(time)

    def on(self, active: ActiveGrid) -> Floats:
        """Returns the whole forces on the nodes of a grid [force], shape (nodes, dim)."""
        force = np.zeros((active.nodes, active.grid.dim))
        if len(self.key):
            number = find_keys(self.key, active.key)
            force[number >= 0] = self.force[number[number >= 0]]
        return force

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"key": self.key, "force": self.force}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table(state, increasing="key")
        self.key, self.force = state["key"], state["force"]


class Release(Term, AssembledTerm):
    """The forces not yet released in a step, independent of the displacement.

    Args:
        released: of the stage.
        active: the grid of the step.
        before, after: times at the start and end of the step.
    """

    role = Role.LOAD

    def __init__(
        self, released: ReleasedForces, active: ActiveGrid, before: float, after: float
    ) -> None:
        force = released.on(active)
        self._before = released.remaining(before) * force
        self._after = released.remaining(after) * force

    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
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
