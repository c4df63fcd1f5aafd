# SPDX-License-Identifier: BSD-3-Clause
"""Forces that are released over a stage: what was out of balance at its start.

When soil or a boundary is removed, a material is exchanged or new soil is placed, the forces on
the soil are no longer in balance. The residual at the start of the stage acts as an external force,
which decreases as the declared share is released: so the stage begins in equilibrium, and nothing
of this force is left at its end.

At the start of the stage each force acts at its node. Then its place moves with the soil, and the
corners of the cell in which it lies share it: it would otherwise be lost, or load an almost empty
cell, where soil leaves the cells around the node.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats, Integers, require_table
from tilth.comm import from_owners
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.quadrature import locate_in_cells, near_process, near_soil
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Role, Term
from tilth.terms.space import Space

LAYERS = 2
"""Layers of cells around a process' own from where forces act on its nodes, see `SurfaceLoads`."""


class ReleasedForces:
    """The forces out of balance at the start of a stage, which persist until they are released.

    Every process has them all.

    Args:
        dim: number of directions.
        share: share that has been released, over the time of the stage.

    Attributes:
        position: places of the forces, which move with the soil [length], shape (m, dim).
        overlay: of each force, shape (m,).
        force: external force before anything is released [force], shape (m, dim).
    """

    def __init__(self, dim: int, share: LoadCurve) -> None:
        self._share = share
        self.position: Floats = np.zeros((0, dim))
        self.overlay: Integers = np.zeros(0, dtype=np.int64)
        self.force: Floats = np.zeros((0, dim))

    def set(self, active: ActiveGrid, force: Floats) -> None:
        """Sets the forces at the start of the stage, shape (nodes, dim); all processes call it."""
        own = np.arange(active.nodes)[active.owned]
        loaded = own[force[own].any(axis=1)]
        columns = active.key[loaded], active.position[loaded], force[loaded], active.overlay[loaded]
        gathered = zip(*active.comm.gathered(columns), strict=True)
        key, *found = (np.concatenate(parts) for parts in gathered)
        order = np.argsort(key)
        self.position, self.force, self.overlay = (each[order] for each in found)

    def remaining(self, time: float) -> float:
        """Returns the share of the forces that still acts at a time of the stage [-]."""
        return 1.0 - self._share.factor(time)

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays for a checkpoint."""
        return {"position": self.position, "overlay": self.overlay, "force": self.force}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint; raises `ValueError` if it is no such state."""
        require_table(state)
        self.position, self.force = state["position"], state["force"]
        self.overlay = state["overlay"]


class Release(Term, DisplacementTerm):
    """The forces not yet released in a step, independent of the displacement.

    As far as they act on the nodes of this process. A force more than a cell away from any soil is
    left out.

    Args:
        released: of the stage.
        active: the grid of the step.
        before, after: times at the start and end of the step.
    """

    role = Role.LOAD
    label = "released forces"

    def __init__(
        self, released: ReleasedForces, active: ActiveGrid, before: float, after: float
    ) -> None:
        place, overlay = released.position, released.overlay
        here = near_process(active, place, LAYERS)
        near = np.flatnonzero(here)[near_soil(active, place[here], overlay[here])]
        order, self._at = locate_in_cells(active, place[near], overlay[near])
        self._released, self._number, self._active = released, near[order], active
        force = self._at.scatter(released.force[self._number], active.nodes)
        self._before = released.remaining(before) * force
        self._after = released.remaining(after) * force

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

    def commit(self, x: Unknowns, checked: None) -> None:
        """As `AssembledTerm.commit`: the forces move with the soil; all processes know them all."""
        position = self._released.position.copy()
        mine = near_process(self._active, position)
        position[self._number] += self._at.interpolate(x.u)
        self._released.position = from_owners(self._active.comm, mine, position[mine])
