# SPDX-License-Identifier: BSD-3-Clause
"""The residual of a load step: its size relative to the forces, and what counts as balanced."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.comm import norm, together
from tilth.model import Analysis
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.balance import Balance, Forces
from tilth.terms.protocol import Changes

ITERATIONS_BEFORE_ROUND_OFF = 3
"""Iterations that are always done before a small residual is put down to round-off.

Stiff constraints cancel in the residual; what round-off leaves of them cannot be iterated away.
"""


class Refinement(Enum):
    """Whether terms become more exact at solutions."""

    NONE = auto()
    """They do not."""
    SOME = auto()
    """They do, a few times: where the path, not its end, is looked for."""
    SETTLED = auto()
    """They do, until they do not change any more."""


@dataclass(frozen=True)
class Newton:
    """Settings of the iteration.

    Attributes:
        tolerance: largest residual relative to the forces [-].
        maximum_iterations: iterations after which the step counts as failed.
        line_search: whether steps that do not reduce the residual are shortened.
        takes_best: whether the line search tries shorter ones too, and takes the best of all if
            none reduces the residual.
        round_off: residual [force] that round-off alone explains; it always counts as converged.
        refinement: of the terms at its solutions, see `AssembledTerm.refine`.
        changes: how terms change what they fix, as which points are active in contact.
    """

    tolerance: float
    maximum_iterations: int
    line_search: bool
    round_off: float
    refinement: Refinement = Refinement.NONE
    changes: Changes = Changes.USUAL
    takes_best: bool = False


@dataclass(frozen=True)
class Iterate:
    """Unknowns that Newton's iteration has come to.

    Attributes:
        displacement: of the nodes in the step [length], shape (nodes, dim).
        unknowns: increments of the global unknowns in the step, shape (m,).
        forces: there.
        free: norm of the residual on the free degrees of freedom and of the global unknowns'
            equations over their scale [force].
        relative: the same over the size of the forces [-].
    """

    displacement: Floats
    unknowns: Floats
    forces: Forces
    free: float
    relative: float


def newton_attempts(analysis: Analysis, round_off: float, contact: bool) -> list[Newton]:
    """Returns how a step is tried, one after the other: with a line search if it fails without.

    round_off: residual that counts as zero [force]. contact: whether soil can separate from
        something; then the step is tried twice more, see `Changes` and `AssembledContact`.
    """
    plain = Newton(
        tolerance=analysis.tolerance,
        maximum_iterations=analysis.maximum_iterations,
        line_search=analysis.line_search or False,
        round_off=round_off,
    )
    patient = replace(plain, line_search=True, maximum_iterations=2 * plain.maximum_iterations)
    attempts = [plain, patient] if analysis.line_search is None else [plain]
    if contact:
        last = attempts[-1]
        attempts += [replace(last, changes=each) for each in (Changes.CAREFUL, Changes.SINGLE)]
    return attempts


def most_patient(newton: Newton) -> Newton:
    """Returns how pseudo-steps of soil that creeps are solved."""
    return replace(
        newton, line_search=True, takes_best=True, maximum_iterations=2 * newton.maximum_iterations
    )


class Residual:
    """The residual as a function of displacement and global unknowns.

    Args:
        balance: all terms of the step.
        constrained: prescribed degrees of freedom, shape (nodes, dim).
    """

    def __init__(self, balance: Balance, constrained: Flags) -> None:
        self._balance, self._constrained = balance, constrained

    def at(self, displacement: Floats, unknowns: Floats) -> Iterate:
        """Returns the state at a nodal displacement (nodes, dim) and global unknowns (m,).

        Raises:
            StepFailed: a term has no force there.
        """
        balance, comm, own = self._balance, self._balance.comm, self._balance.active.owned
        with together(comm):
            forces = balance.forces(displacement, unknowns)
        free = norm(comm, np.where(self._constrained, 0.0, forces.residual)[own])
        if len(unknowns):  # each process has them all
            free = math.hypot(free, *(forces.global_residual / balance.global_scale))
        reaction = norm(comm, np.where(self._constrained, forces.residual, 0.0)[own])
        # not all internal force: implicit boundaries balance the soil's in it
        sums = (forces.load, forces.soil, forces.inertia)
        size = max(*(norm(comm, force[own]) for force in sums), reaction)
        # without stress the only force is that of an implicit boundary that begins to move
        relative = free / size if size > 0.0 else float(free > 0.0)
        return Iterate(displacement, unknowns, forces, free, relative)

    def balanced(self, state: Iterate, newton: Newton, iterations: int) -> bool:
        """Returns whether the residual is small enough, after so many iterations."""
        if state.relative <= newton.tolerance or state.free <= newton.round_off:
            return True
        late = iterations >= ITERATIONS_BEFORE_ROUND_OFF
        return late and state.free <= self._balance.round_off(state.displacement)

    def worst_point(self, state: Iterate) -> int:
        """Returns the number of the point nearest to the node with the largest residual force."""
        comm, active = self._balance.comm, self._balance.active
        residual = np.where(self._constrained, 0.0, state.forces.residual)[active.owned]
        size = np.linalg.norm(residual, axis=1)
        node, own = int(size.argmax()), float(size.max())
        owned = np.arange(active.nodes)[active.owned]
        point = -1
        if own == comm.max(own):
            point = int(active.points.point_id[nearest_point(active, int(owned[node]))])
        return int(comm.max(float(point)))


def nearest_point(active: ActiveGrid, node: int) -> int:
    """Returns the index of the material point nearest to a node, of its overlay."""
    points = active.points
    distance = np.linalg.norm(points.position - active.position[node], axis=1)
    if active.overlays > 1:
        overlay = points.overlays_of(np.arange(len(points)))
        distance[overlay != active.overlay[node]] = np.inf
    return int(distance.argmin())
