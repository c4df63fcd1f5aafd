# SPDX-License-Identifier: BSD-3-Clause
"""The equations of a load step: the size of their residuals, and what counts as balanced."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.field import DISPLACEMENT, MOMENTUM, Field
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.comm import norm, together
from tilth.model import Analysis
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.balance import Balance, Residual
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
        round_off: residual that round-off alone explains, by equation, in its unit; it always
            counts as converged.
        refinement: of the terms at its solutions, see `AssembledTerm.refine`.
        changes: how terms change what they fix, as which points are active in contact.
    """

    tolerance: float
    maximum_iterations: int
    line_search: bool
    round_off: Mapping[str, float]
    refinement: Refinement = Refinement.NONE
    changes: Changes = Changes.USUAL
    takes_best: bool = False


@dataclass(frozen=True)
class Size:
    """How large the residual of one equation is, in its unit.

    Attributes:
        free: norm of the residual over the scale of its fields, on the free degrees of freedom,
            and of the global unknowns' equations over their scale.
        of_forces: the largest norm of its sums of terms and of what holds the rest.
    """

    free: float
    of_forces: float

    @property
    def relative(self) -> float:
        """The residual over the forces [-]; NaN if either is not a finite number."""
        if not math.isfinite(self.free + self.of_forces):
            return math.nan
        # without stress the only force is that of an implicit boundary that begins to move
        return self.free / self.of_forces if self.of_forces > 0.0 else float(self.free > 0.0)


@dataclass(frozen=True, eq=False)
class Iterate:
    """Unknowns that Newton's iteration has come to.

    Attributes:
        x: the unknowns.
        residual: there.
        sizes: of the residual, by equation.
        merit: what a correction should lower: the residual [force]; with several equations the
            root of the sum of their squares, each over the forces at the first iterate [-].
    """

    x: Unknowns
    residual: Residual
    sizes: Mapping[str, Size]
    merit: float

    @property
    def relative(self) -> float:
        """The largest of the equations' residuals over their forces [-]."""
        return float(np.max([each.relative for each in self.sizes.values()]))  # NaN if one is


@dataclass(frozen=True, eq=False)
class Guess:
    """Where an iteration begins.

    Attributes:
        of: values of fields at the end of the step, by their names; at its start where not given.
        of_globals: increments of the global unknowns, shape (m,), those of an equilibrium near by;
            None for those at the start of the step.
    """

    of: Mapping[str, Floats]
    of_globals: Floats | None = None

    @property
    def u(self) -> Floats:
        """Nodal displacement of the step [length], shape (nodes, dim)."""
        return self.of[DISPLACEMENT]


def newton_attempts(
    analysis: Analysis, round_off: Mapping[str, float], contact: bool
) -> list[Newton]:
    """Returns how a step is tried, one after the other: with a line search if it fails without.

    round_off: residual that counts as zero, by equation. contact: whether soil can separate from
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


class Equations:
    """The equations of all fields and global unknowns as functions of these.

    Attributes:
        balance: all terms of the step, with its fields.
        matrix: the derivative where it was last computed, which tells the round-off of fields
            besides the displacement; None before.
    """

    def __init__(self, balance: Balance) -> None:
        self.balance = balance
        self.matrix: BlockMatrix | None = None
        self._fields: dict[str, list[Field]] = {}
        for each in balance.fields.values():
            self._fields.setdefault(each.equation, []).append(each)
        self._first: dict[str, float] = {}  # of the forces, by equation

    def at(self, x: Unknowns) -> Iterate:
        """Returns the state at these unknowns.

        Raises:
            StepFailed: a term is not defined there.
        """
        with together(self.balance.comm):
            residual = self.balance.evaluate(x)
        sizes = {name: self._size(name, residual) for name in self._fields}
        if len(sizes) == 1:
            return Iterate(x, residual, sizes, sizes[MOMENTUM].free)
        for name, size in sizes.items():
            self._first.setdefault(name, size.of_forces)
            if self._first[name] == 0.0:
                self._first[name] = size.of_forces
        merits = [
            size.free / (self._first[name] or 1.0)
            for name, size in sizes.items()
            if size.free > self._round_off(name, x)
        ]
        return Iterate(x, residual, sizes, math.hypot(*merits))

    def _round_off(self, equation: str, x: Unknowns) -> float:
        """Returns the norm of the residual that round-off may cause, in the equation's unit."""
        fields, matrix, total = self._fields[equation], self.matrix, 0.0
        if matrix is not None and len(matrix.fields) > 1:
            for each in fields:
                size = each.over_scale(matrix.magnitude(x, each.name))[each.owned]
                total = math.hypot(total, norm(self.balance.comm, size))
        terms = self.balance.round_off(x, fields)
        return math.hypot(terms, float(np.finfo(np.float64).eps) * total)

    def _size(self, equation: str, residual: Residual) -> Size:
        balance, fields = self.balance, self._fields[equation]

        def norm_of(values: Mapping[str, Floats], which: bool | None = None) -> float:
            """Returns the norm of constrained (True), free (False) or all components."""
            norms = []
            for each in fields:
                if each.name in values:
                    own = each.over_scale(values[each.name])
                    if which is not None:
                        own = np.where(each.constrained == which, own, 0.0)
                    norms.append(norm(balance.comm, own[each.owned]))
            return norms[0] if len(norms) == 1 else math.hypot(*norms)

        free = norm_of(residual.of, False)
        if equation == MOMENTUM and len(residual.globals):  # each process has them all
            free = math.hypot(free, *(residual.globals / balance.global_scale))
        # not all internal force: implicit boundaries balance the soil's in it
        sums = [norm_of(each) for each in residual.sums.values()]
        return Size(free, float(np.max([*sums, norm_of(residual.of, True)])))

    def balanced(self, state: Iterate, newton: Newton, iterations: int) -> bool:
        """Returns whether the residuals are small enough, after so many iterations."""
        late = iterations >= ITERATIONS_BEFORE_ROUND_OFF
        return all(
            size.relative <= newton.tolerance
            or size.free <= newton.round_off.get(equation, 0.0)
            or (late and size.free <= self._round_off(equation, state.x))
            for equation, size in state.sizes.items()
        )

    def failure(self, state: Iterate, newton: Newton) -> str:
        """Returns why an iteration ended without a solution: how far the worst equation is off."""
        reason = f"no equilibrium after {newton.maximum_iterations} Newton iterations"
        if len(state.sizes) == 1:
            return reason
        worst = max(state.sizes, key=lambda name: state.sizes[name].relative)
        size, names = state.sizes[worst], [each.name for each in self._fields[worst]]
        return (
            f"{reason}: the equation {worst!r} of {', '.join(names)} is out of balance by "
            f"{size.free:.3g}, its largest sum of terms is {size.of_forces:.3g}"
        )

    def worst_point(self, state: Iterate) -> int:
        """Returns the number of the point nearest to the node with the largest residual force.

        Of the displacement's equation.
        """
        comm, active = self.balance.comm, self.balance.active
        constrained = self.balance.fields[DISPLACEMENT].constrained
        residual = np.where(constrained, 0.0, state.residual.u)[active.owned]
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
