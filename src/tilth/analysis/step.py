# SPDX-License-Identifier: BSD-3-Clause
"""One load step: Newton's iteration for the equilibrium of the grid (docs/theory/mechanics.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.residual import Equations, Guess, Iterate, Newton, Refinement
from tilth.analysis.services import Services
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.solvers import SolveFailed
from tilth.solvers.coupled import begin_system
from tilth.solvers.coupled_system import CoupledSystem, SystemSolver
from tilth.terms.balance import Balance
from tilth.terms.protocol import Changes, Role

FORCING_TERM = 1e-4
"""Part of the residual that an iterative linear solver may leave at any time."""

LARGEST_FORCING_TERM = 1e-2
"""The same in an iteration after which Newton's tolerance is met in any case."""

KEPT_MATRIX_RESIDUAL = 5.0
"""Largest residual, relative to Newton's tolerance, with which the last matrix is kept."""

KEPT_LEVELS_RATIO = 0.1
"""Largest ratio of two residuals in a row with which multigrid keeps its levels."""

REFINED_FROM = 1e-3
"""Relative residual from which on terms become more exact."""

REFINEMENTS, REFINED, MOST_REFINEMENTS = 8, 0.3, 25
"""How often they do: after so many times their change must be below this share of the first one,
or the path is good enough; and how often at most."""

LINE_SEARCH = (1.0, 0.5, 0.25, 0.125)
LONG_LINE_SEARCH = (*LINE_SEARCH, 1 / 16, 1 / 32, 1 / 64)
"""Shares of a correction that a line search tries, in this order; see `Newton.takes_best`."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A converged step.

    Attributes:
        x: all unknowns at its end.
        load: external force at the end of the step [force], shape (nodes, dim).
        reactions: of what is prescribed, by field: for the displacement the force of the
            boundaries on the soil [force], shape (nodes, dim); zero elsewhere.
        initial_reaction: that force at the start of the step, on this step's grid.
        residuals: relative residual of the first guess and after each iteration.
    """

    x: Unknowns
    load: Floats
    reactions: Mapping[str, Floats]
    initial_reaction: Floats
    residuals: list[float]

    @property
    def displacement(self) -> Floats:
        """Of the nodes in the step [length], shape (nodes, dim)."""
        return self.x.u

    @property
    def reaction(self) -> Floats:
        """Force of the boundaries on the soil [force], shape (nodes, dim); zero elsewhere."""
        return self.reactions[DISPLACEMENT]

    @property
    def iterations(self) -> int:
        """Number of linear solves."""
        return len(self.residuals) - 1


def solve_step(
    balance: Balance,
    services: Services,
    newton: Newton,
    guess: Guess | None = None,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
) -> Equilibrium:
    """Finds the unknowns of the step without a residual of what is free.

    Args:
        balance: all terms of the step, with its fields and what is prescribed of them.
        services: solve the linear systems, measure the time of it, and watch each iteration.
        newton: settings of the iteration.
        guess: where to begin; at the start of the step if not given.
        on_iteration: is called with the iteration and its relative residual.

    Raises:
        StepFailed: no equilibrium within the iterations, an inverted point, a singular system.
    """
    equations = Equations(balance)
    linearised = Linearisation(equations, services)
    residuals: list[float] = []
    begun, reuse = 0, Reuse.NOTHING
    refinements = _Refinements(newton.refinement)
    now, initial_reaction, moving = _first_state(equations, guess)
    while True:
        if newton.changes is Changes.CAREFUL and balance.adapt(now.x):
            now = equations.at(now.x)
        residuals.append(now.relative)
        on_iteration(len(residuals) - 1, now.relative)
        if not (moving or refinements.done) and now.relative <= REFINED_FROM:
            refinements.add(balance.refine(now.x), residuals)
            begun = len(residuals)
            now = equations.at(now.x)
            residuals[-1] = now.relative
        services.observer.iteration(len(residuals) - 1, now, moving)
        if not math.isfinite(now.relative):
            raise StepFailed("the residual is not a number", residuals=residuals)
        if equations.balanced(now, newton, len(residuals) - 1) and not moving:
            if _revised(balance, now, residuals):
                begun = len(residuals)
                now = equations.at(now.x)
                residuals.pop()
                refinements.again()
                continue
            reactions = reactions_at(balance, now)
            return Equilibrium(now.x, now.residual.load, reactions, initial_reaction, residuals)
        if len(residuals) - begun > newton.maximum_iterations:
            reason, point = equations.failure(now, newton), equations.worst_point(now)
            raise StepFailed(reason, point=point, residuals=residuals)
        tolerance = forcing_term(1.0 if moving else now.relative, newton.tolerance)
        shares: Sequence[float] = (1.0,)
        if newton.line_search and not moving:
            shares = LONG_LINE_SEARCH if newton.takes_best else LINE_SEARCH
        reuse = reused(residuals[begun:], reuse, newton)
        try:
            correction = linearised.correction(now, moving, tolerance, reuse)
            now = corrected(equations, now, correction, shares, newton.takes_best)
        except SolveFailed as error:
            raise StepFailed(str(error), residuals=residuals) from error
        except StepFailed as failure:
            failure.residuals = residuals
            raise
        moving = False


def reactions_at(balance: Balance, now: Iterate) -> dict[str, Floats]:
    """Returns the residuals of what is prescribed, 0 elsewhere, by field; see `Equilibrium`."""
    return {
        name: np.where(each.constrained, now.residual.of[name], 0.0)
        for name, each in balance.fields.items()
    }


def _revised(balance: Balance, now: Iterate, residuals: list[float]) -> bool:
    """Returns whether terms changed at a converged state, as by soil that came into contact."""
    try:
        return balance.revise(now.x)
    except StepFailed as failure:
        failure.residuals = residuals
        raise


class _Refinements:
    """How often terms were made more exact in a step, and whether they are exact enough."""

    def __init__(self, refinement: Refinement) -> None:
        self._settles = refinement is Refinement.SETTLED
        self.done = refinement is Refinement.NONE
        self._any = not self.done
        self._sizes: list[float] = []

    def again(self) -> None:
        """Lets terms become more exact once more, after others have changed."""
        self.done = not self._any

    def add(self, size: float, residuals: list[float]) -> None:
        """Takes note of how much terms changed; raises `StepFailed` if they do not settle."""
        self._sizes.append(size)
        tried = len(self._sizes)
        self.done = size <= 1.0
        if self.done or tried < REFINEMENTS:
            return
        if not self._settles:
            self.done = True
        elif tried > MOST_REFINEMENTS or size > REFINED * self._sizes[0]:
            reason = "the plastic volume changes of the points do not settle"
            raise StepFailed(reason, residuals=residuals)


def _first_state(equations: Equations, guess: Guess | None) -> tuple[Iterate, Floats, bool]:
    """Returns where the iteration begins, the reaction at the start of the step, (nodes, dim), and
    whether the prescribed degrees of freedom have yet to move.
    """
    balance = equations.balance
    fields, start = balance.fields, balance.first()
    moving = any(bool(each.increment.any()) for each in fields.values())
    moving = bool(balance.comm.max(float(moving)))
    initial_reaction = np.zeros_like(start.u)
    if moving or guess is None:  # what does not move does no work: its first reaction is not needed
        balance.begin(start)
        first = equations.at(start)
        internal = first.residual.u + first.residual.load - first.residual.sum_of(Role.INERTIA)
        external = balance.load_before - balance.inertia_before
        held = fields[DISPLACEMENT].constrained
        initial_reaction = np.where(held, internal - external, 0.0)
    if guess is None:
        return first, initial_reaction, moving
    imposed = {
        name: np.where(each.constrained, start.of[name] + each.increment, guess.of[name])
        if name in guess.of
        else start.of[name] + each.increment
        for name, each in fields.items()
    }
    begun = Unknowns(imposed, start.globals if guess.of_globals is None else guess.of_globals)
    if not moving:
        balance.begin(begun)
    if guess.of_globals is None:  # else it is an equilibrium near by
        balance.begin_at_guess()
    try:
        return equations.at(begun), initial_reaction, False
    except StepFailed:
        balance.begin(start)
        return equations.at(start), initial_reaction, moving


class Reuse(Enum):
    """What an iteration takes from the linear system of the last one; only multigrid keeps it."""

    NOTHING = 0
    LEVELS = 1
    MATRIX = 2


def reused(residuals: list[float], last: Reuse, newton: Newton) -> Reuse:
    """Returns what the next iteration takes over (docs/decisions/0037-square-footing-time.md).

    Where points begin or cease to yield the last matrix lowers the residual by a factor of about
    seven, however close it is to the solution. It is not kept twice in a row.

    residuals: relative residuals since the first guess. last: what the last iteration reused.
    """
    if len(residuals) < 2 or newton.line_search or newton.changes is Changes.CAREFUL:
        return Reuse.NOTHING
    before, now = residuals[-2:]
    close = now <= min(KEPT_MATRIX_RESIDUAL * newton.tolerance, KEPT_LEVELS_RATIO * before)
    if close and last is not Reuse.MATRIX:
        return Reuse.MATRIX
    return Reuse.LEVELS if now <= KEPT_LEVELS_RATIO * before else Reuse.NOTHING


class Linearisation:
    """The linear systems of a step.

    Args:
        equations: of the step, which get the matrix.
        services: solve them, and measure the time of assembly and solution.
    """

    def __init__(self, equations: Equations, services: Services) -> None:
        self._equations, self._balance = equations, equations.balance
        self._solver, self._timers = services.solver, services.timers
        self._begun: tuple[CoupledSystem, SystemSolver] | None = None

    def correction(
        self, now: Iterate, moving: bool, tolerance: float, reuse: Reuse = Reuse.NOTHING
    ) -> Unknowns:
        """Returns corrections of all unknowns.

        Args:
            now: where the residual is linearised.
            moving: whether prescribed degrees of freedom move by their increments; else they stay.
            tolerance: relative residual that an iterative solver may leave.
            reuse: what of the last linear system is used again.

        Raises:
            SolveFailed: the system is singular.
        """
        system, solver = self._system(now, reuse)
        of = {name: -values for name, values in now.residual.of.items()}
        right_side = Unknowns(of, -now.residual.globals)
        given = None
        if moving:
            moved = {
                name: np.where(each.constrained, each.increment, 0.0)
                for name, each in self._balance.fields.items()
            }
            given = Unknowns(moved, np.zeros_like(right_side.globals))
            right_side = right_side.plus(system.matrix.times(given), -1.0)
        with self._timers.measure("solve"):
            found = solver.solve(right_side, tolerance)
        return found if given is None else given.plus(found)

    def _system(self, now: Iterate, reuse: Reuse) -> tuple[CoupledSystem, SystemSolver]:
        balance = self._balance
        if self._begun is None:
            with self._timers.measure("assembly"):
                constrained = {name: each.constrained for name, each in balance.fields.items()}
                matrix = balance.space.matrix()
                system = CoupledSystem(balance.active, matrix, constrained)
            self._begun = system, begin_system(self._solver, system)
        system, solver = self._begun
        if reuse is Reuse.MATRIX and solver.by_multigrid:
            return system, solver
        solver.renew(similar=reuse is Reuse.LEVELS)
        balance.linearise(now.x, system.matrix)
        balance.linearised()
        self._equations.matrix = system.matrix
        system.displacement.exact_nodes = balance.exact_nodes()
        system.schur = balance.schur(now.x, system.matrix)
        return system, solver


def forcing_term(relative: float, tolerance: float) -> float:
    """Returns how much of the residual an iterative linear solver may leave.

    A tenth of what the iteration may end with; but what the linearisation misses is seldom less
    than `FORCING_TERM`, and the next iteration has to put that right in any case (inexact Newton
    methods: Eisenstat and Walker 1996).
    """
    return min(max(0.1 * tolerance / relative, FORCING_TERM), LARGEST_FORCING_TERM)


def corrected(
    equations: Equations,
    now: Iterate,
    correction: Unknowns,
    shares: Sequence[float],
    takes_best: bool = False,
) -> Iterate:
    """Takes the first share of `correction` that lowers the residual, else the last or best one."""

    def at(share: float) -> Iterate:
        return equations.at(now.x.plus(correction, share))

    possible: dict[float, float] = {}
    for share in shares:
        last = share == shares[-1]
        try:
            trial = at(share)
        except StepFailed:
            if last and not (takes_best and possible):
                raise
            continue
        if trial.merit <= (1.0 - 1e-4 * share) * now.merit or (last and not takes_best):
            return trial
        possible[share] = trial.merit
    return at(min(possible, key=lambda share: possible[share]))  # terms remember the last state
