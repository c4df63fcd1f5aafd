# SPDX-License-Identifier: BSD-3-Clause
"""One load step: Newton's iteration for the equilibrium of the grid (docs/theory/mechanics.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from tilth.analysis.residual import Iterate, Newton, Refinement, Residual
from tilth.analysis.services import Services
from tilth.arrays import Flags, Floats
from tilth.boundaries import Conditions
from tilth.errors import StepFailed
from tilth.solvers import LinearSystem, SolveFailed, StepSolver
from tilth.solvers.petsc import PetscStepSolver
from tilth.terms.balance import Balance
from tilth.terms.protocol import Changes

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


@dataclass(frozen=True)
class Equilibrium:
    """A converged step.

    Attributes:
        displacement: of the nodes in the step [length], shape (nodes, dim).
        load: external force at the end of the step [force], shape (nodes, dim).
        reaction: force of the boundaries on the soil [force], shape (nodes, dim); zero elsewhere.
        initial_reaction: the same at the start of the step, on this step's grid.
        residuals: relative residual of the first guess and after each iteration.
        global_unknowns: increments in the step of the unknowns that belong to no node, those of one
            term after the other, shape (m,).
    """

    displacement: Floats
    load: Floats
    reaction: Floats
    initial_reaction: Floats
    residuals: list[float]
    global_unknowns: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def iterations(self) -> int:
        """Number of linear solves."""
        return len(self.residuals) - 1


def solve_step(
    balance: Balance,
    conditions: Conditions,
    services: Services,
    newton: Newton,
    guess: Floats | None = None,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
    unknowns: Floats | None = None,
) -> Equilibrium:
    """Finds displacement u and global unknowns g of the step without a residual on what is free.

    Args:
        balance: all terms of the step.
        conditions: prescribed degrees of freedom.
        services: solve the linear systems, measure the time of it, and watch each iteration.
        newton: settings of the iteration.
        guess: nodal displacement to begin with (nodes, dim); none if not given.
        on_iteration: is called with the iteration and its relative residual.
        unknowns: global unknowns to begin with, (m,), those of the guess; those at the start of
            the step if not given.

    Raises:
        StepFailed: no equilibrium within the iterations, an inverted point, a singular system.
    """
    constrained = conditions.constrained
    residual = Residual(balance, constrained)
    linearised = Linearisation(balance, constrained, services)
    residuals: list[float] = []
    begun, reuse = 0, Reuse.NOTHING
    refinements = _Refinements(newton.refinement)
    now, initial_reaction, moving = _first_state(residual, balance, conditions, guess, unknowns)
    while True:
        if newton.changes is Changes.CAREFUL and balance.adapt(now.displacement):
            now = residual.at(now.displacement, now.unknowns)
        residuals.append(now.relative)
        on_iteration(len(residuals) - 1, now.relative)
        if not (moving or refinements.done) and now.relative <= REFINED_FROM:
            refinements.add(balance.refine(now.displacement), residuals)
            begun = len(residuals)
            now = residual.at(now.displacement, now.unknowns)
            residuals[-1] = now.relative
        services.observer.iteration(len(residuals) - 1, now, moving)
        if not math.isfinite(now.relative):
            raise StepFailed("the residual is not a number", residuals=residuals)
        if residual.balanced(now, newton, len(residuals) - 1) and not moving:
            if _revised(balance, now, residuals):
                begun = len(residuals)
                now = residual.at(now.displacement, now.unknowns)
                residuals.pop()
                refinements.again()
                continue
            reaction = np.where(constrained, now.forces.residual, 0.0)
            return Equilibrium(
                now.displacement, now.forces.load, reaction, initial_reaction, residuals,
                now.unknowns,
            )  # fmt: skip
        if len(residuals) - begun > newton.maximum_iterations:
            reason = f"no equilibrium after {newton.maximum_iterations} Newton iterations"
            raise StepFailed(reason, point=residual.worst_point(now), residuals=residuals)
        tolerance = forcing_term(1.0 if moving else now.relative, newton.tolerance)
        prescribed = conditions.increment if moving else None
        shares: Sequence[float] = (1.0,)
        if newton.line_search and not moving:
            shares = LONG_LINE_SEARCH if newton.takes_best else LINE_SEARCH
        reuse = reused(residuals[begun:], reuse, newton)
        try:
            correction = linearised.correction(now, prescribed, tolerance, reuse)
            now = corrected(residual, now, correction, shares, newton.takes_best)
        except SolveFailed as error:
            raise StepFailed(str(error), residuals=residuals) from error
        except StepFailed as failure:
            failure.residuals = residuals
            raise
        moving = False


def _revised(balance: Balance, now: Iterate, residuals: list[float]) -> bool:
    """Returns whether terms changed at a converged state, as by soil that came into contact."""
    try:
        return balance.revise(now.displacement)
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


def _first_state(
    residual: Residual,
    balance: Balance,
    conditions: Conditions,
    guess: Floats | None,
    unknowns: Floats | None,
) -> tuple[Iterate, Floats, bool]:
    """Returns where the iteration begins, the reaction at the start of the step, (nodes, dim), and
    whether the prescribed degrees of freedom have yet to move.
    """
    constrained = conditions.constrained
    zero, first_unknowns = np.zeros_like(conditions.increment), balance.first_unknowns()
    moving = bool(balance.comm.max(float(conditions.increment.any())))
    initial_reaction = np.zeros_like(zero)
    if moving or guess is None:  # what does not move does no work: its first reaction is not needed
        balance.begin(zero, first_unknowns)
        first = residual.at(zero, first_unknowns)
        internal = first.forces.residual + first.forces.load - first.forces.inertia
        external = balance.load_before - balance.inertia_before
        initial_reaction = np.where(constrained, internal - external, 0.0)
    if guess is None:
        return first, initial_reaction, moving
    start = np.where(constrained, conditions.increment, guess)
    begun = first_unknowns if unknowns is None else unknowns
    if not moving:
        balance.begin(start, begun)
    if unknowns is None:  # else it is an equilibrium near by
        balance.begin_at_guess()
    try:
        return residual.at(start, begun), initial_reaction, False
    except StepFailed:
        balance.begin(zero, first_unknowns)
        return residual.at(zero, first_unknowns), initial_reaction, moving


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
        balance: all terms of the step.
        constrained: prescribed degrees of freedom, shape (nodes, dim).
        services: solve them, and measure the time of assembly and solution.
    """

    def __init__(self, balance: Balance, constrained: Flags, services: Services) -> None:
        self._balance, self._constrained = balance, constrained
        self._solver, self._timers = services.solver, services.timers
        self._begun: tuple[LinearSystem, StepSolver | PetscStepSolver] | None = None

    def correction(
        self,
        now: Iterate,
        prescribed: Floats | None,
        tolerance: float,
        reuse: Reuse = Reuse.NOTHING,
    ) -> tuple[Floats, Floats]:
        """Returns corrections of displacement (nodes, dim) and global unknowns (m,).

        Args:
            now: where the residual is linearised.
            prescribed: correction of the constrained degrees of freedom, (nodes, dim); None for 0.
            tolerance: relative residual that an iterative solver may leave.
            reuse: what of the last linear system is used again.

        Raises:
            SolveFailed: the system is singular.
        """
        system, solver = self._system(now, reuse)
        right_side, of_unknowns = -now.forces.residual, -now.forces.global_residual
        moved = np.zeros_like(right_side)
        if prescribed is not None:
            moved = np.where(self._constrained, prescribed, 0.0)
            right_side = right_side - system.times(moved)
            if system.border is not None:
                of_unknowns = of_unknowns - system.inner_products(system.border.rows, moved)
        with self._timers.measure("solve"):
            free, unknowns = solver.solve_bordered(right_side, of_unknowns, tolerance)
        return moved + free, unknowns

    def _system(
        self, now: Iterate, reuse: Reuse
    ) -> tuple[LinearSystem, StepSolver | PetscStepSolver]:
        balance, active = self._balance, self._balance.active
        if self._begun is None:
            with self._timers.measure("assembly"):
                entries = len(active.column) * self._constrained.shape[1] ** 2
                memory = active.buffers.take("matrix", entries)
                system = LinearSystem(active, self._constrained, memory)
            self._begun = system, self._solver.begin(system)
        system, solver = self._begun
        if reuse is Reuse.MATRIX and solver.by_multigrid:
            return system, solver
        solver.renew(similar=reuse is Reuse.LEVELS)
        balance.fill_stiffness(now.displacement, system.blocks)
        system.border = balance.border(now.displacement, now.unknowns)
        balance.linearised()
        system.exact_nodes = balance.exact_nodes()
        return system, solver


def forcing_term(relative: float, tolerance: float) -> float:
    """Returns how much of the residual an iterative linear solver may leave.

    A tenth of what the iteration may end with; but what the linearisation misses is seldom less
    than `FORCING_TERM`, and the next iteration has to put that right in any case (inexact Newton
    methods: Eisenstat and Walker 1996).
    """
    return min(max(0.1 * tolerance / relative, FORCING_TERM), LARGEST_FORCING_TERM)


def corrected(
    residual: Residual,
    now: Iterate,
    correction: tuple[Floats, Floats],
    shares: Sequence[float],
    takes_best: bool = False,
) -> Iterate:
    """Takes the first share of `correction` that lowers the residual, else the last or best one."""
    nodal, unknowns = correction

    def at(share: float) -> Iterate:
        return residual.at(now.displacement + share * nodal, now.unknowns + share * unknowns)

    possible: dict[float, float] = {}
    for share in shares:
        last = share == shares[-1]
        try:
            trial = at(share)
        except StepFailed:
            if last and not (takes_best and possible):
                raise
            continue
        if trial.free <= (1.0 - 1e-4 * share) * now.free or (last and not takes_best):
            return trial
        possible[share] = trial.free
    return at(min(possible, key=lambda share: possible[share]))  # terms remember the last state
