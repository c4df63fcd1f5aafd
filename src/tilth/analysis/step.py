# SPDX-License-Identifier: BSD-3-Clause
"""One load step: Newton's iteration for the equilibrium of the grid (docs/theory/mechanics.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries import Conditions
from tilth.comm import SERIAL, Communicator, norm
from tilth.errors import StepFailed
from tilth.mpm.grid import ActiveGrid
from tilth.solvers import LinearSolver, LinearSystem, SolveFailed
from tilth.terms.balance import Balance, Forces
from tilth.timers import Timers

ITERATIONS_BEFORE_ROUND_OFF = 3
"""Iterations that are always done before a small residual is put down to round-off.

Stiff constraints cancel in the residual; what round-off leaves of them cannot be iterated away.
"""

FORCING_TERM = 1e-4
"""Part of the residual that an iterative linear solver may leave at any time."""

LARGEST_FORCING_TERM = 1e-2
"""The same in an iteration after which Newton's tolerance is met in any case."""


@dataclass(frozen=True)
class Newton:
    """Settings of the iteration.

    Attributes:
        tolerance: largest residual relative to the forces [-].
        maximum_iterations: iterations after which the step counts as failed.
        line_search: whether steps that do not reduce the residual are shortened.
        round_off: residual [force] that round-off alone explains; it always counts as converged.
    """

    tolerance: float
    maximum_iterations: int
    line_search: bool
    round_off: float


@dataclass(frozen=True)
class Equilibrium:
    """A converged step.

    Attributes:
        displacement: of the nodes in the step [length], shape (nodes, dim).
        load: external force at the end of the step [force], shape (nodes, dim).
        reaction: force of the boundaries on the soil [force], shape (nodes, dim); zero elsewhere.
        initial_reaction: the same at the start of the step, on this step's grid.
        residuals: relative residual of the first guess and after each iteration.
    """

    displacement: Floats
    load: Floats
    reaction: Floats
    initial_reaction: Floats
    residuals: list[float]

    @property
    def iterations(self) -> int:
        """Number of linear solves."""
        return len(self.residuals) - 1


@dataclass(frozen=True)
class State:
    """A displacement that Newton's iteration has come to.

    Attributes:
        displacement: of the nodes in the step [length], shape (nodes, dim).
        forces: there.
        free: norm of the residual on the free degrees of freedom [force].
        relative: the same over the size of the forces [-].
    """

    displacement: Floats
    forces: Forces
    free: float
    relative: float


def solve_step(
    balance: Balance,
    conditions: Conditions,
    solver: LinearSolver,
    newton: Newton,
    timers: Timers,
    guess: Floats | None = None,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
    comm: Communicator = SERIAL,
) -> Equilibrium:
    """Finds the nodal displacement u of the step with f_ext - f_int(u) = 0 on the free nodes.

    Args:
        balance: all terms of the step.
        guess: nodal displacement to begin with (nodes, dim); none if not given.
        on_iteration: is told the iteration and its relative residual.

    Raises:
        StepFailed: no equilibrium within the iterations, an inverted point, a singular system.
    """
    active, held = balance.active, conditions.held
    own = slice(*active.owned)
    displacement = np.zeros((active.nodes, active.grid.dim))
    residuals: list[float] = []

    def evaluate(u: Floats) -> State:
        forces = balance.forces(u)
        free = norm(comm, np.where(held, 0.0, forces.residual)[own])
        reaction = norm(comm, np.where(held, forces.residual, 0.0)[own])
        # not all internal force: implicit boundaries balance the soil's in it
        size = max(norm(comm, forces.load[own]), norm(comm, forces.soil[own]), reaction)
        # at rest, an implicit boundary that begins to move is the only force
        return State(u, forces, free, free / size if size > 0.0 else float(free > 0.0))

    moving = bool(conditions.increment.any())
    initial_reaction = np.zeros_like(displacement)
    if moving or guess is None:  # what does not move does no work: its first reaction is not needed
        now = evaluate(displacement)
        forces = now.forces
        internal = forces.residual + forces.load
        initial_reaction = np.where(held, internal - balance.load_before, 0.0)
    if guess is not None:
        try:
            now = evaluate(np.where(held, conditions.increment, guess))
            moving = False
        except StepFailed:
            now = evaluate(displacement)
    system: LinearSystem | None = None
    while True:
        residuals.append(now.relative)
        on_iteration(len(residuals) - 1, now.relative)
        if not math.isfinite(now.relative):
            raise StepFailed("the residual is not a number", residuals=residuals)
        balanced = now.relative <= newton.tolerance or now.free <= newton.round_off
        if not balanced and len(residuals) > ITERATIONS_BEFORE_ROUND_OFF:
            balanced = now.free <= balance.round_off(now.displacement)
        if balanced and not moving:
            reaction = np.where(held, now.forces.residual, 0.0)
            load = now.forces.load
            return Equilibrium(now.displacement, load, reaction, initial_reaction, residuals)
        if len(residuals) > newton.maximum_iterations:
            reason = f"no equilibrium after {newton.maximum_iterations} Newton iterations"
            worst = _nearest_point(active, np.where(held, 0.0, now.forces.residual))
            raise StepFailed(reason, point=worst, residuals=residuals)
        if system is None:
            with timers.measure("assembly"):
                entries = len(active.column) * active.grid.dim**2
                system = LinearSystem(active, held, active.buffers.take("matrix", entries))
        balance.fill_stiffness(now.displacement, system.blocks)
        system.exact_nodes = balance.hard_nodes()
        change = np.zeros_like(displacement)
        right_side = -now.forces.residual
        if moving:
            change = np.where(held, conditions.increment, 0.0)
            right_side = right_side - system.times(change)
        with timers.measure("solve"):
            share = forcing_term(1.0 if moving else now.relative, newton.tolerance)
            try:
                change += solver.solve(system, right_side, share)
            except SolveFailed as error:
                raise StepFailed(str(error), residuals=residuals) from error
        search = newton.line_search and not moving
        shares = (1.0, 0.5, 0.25, 0.125) if search else (1.0,)
        now = _best(evaluate, now, change, shares, residuals)
        moving = False


def forcing_term(relative: float, tolerance: float) -> float:
    """Returns how much of the residual an iterative linear solver may leave.

    A tenth of what the iteration may end with; but what the linearisation misses is seldom less
    than `FORCING_TERM`, and the next iteration has to put that right in any case (inexact Newton
    methods: Eisenstat and Walker 1996).
    """
    return min(max(0.1 * tolerance / relative, FORCING_TERM), LARGEST_FORCING_TERM)


def _nearest_point(active: ActiveGrid, residual: Floats) -> int:
    """Returns the number of the point nearest to the node with the largest residual force."""
    points, node = active.points, int(np.linalg.norm(residual, axis=1).argmax())
    distance = np.linalg.norm(points.position - active.position[node], axis=1)
    return int(points.point_id[int(distance.argmin())])


def _best(
    evaluate: Callable[[Floats], State],
    now: State,
    change: Floats,
    shares: tuple[float, ...],
    residuals: list[float],
) -> State:
    """Takes the first share of `change` that lowers the residual, else the last one."""
    for share in shares:
        last = share == shares[-1]
        try:
            trial = evaluate(now.displacement + share * change)
        except StepFailed as failure:
            if last:
                raise StepFailed(
                    failure.reason, point=failure.point, residuals=residuals
                ) from failure
            continue
        if last or trial.free <= (1.0 - 1e-4 * share) * now.free:
            return trial
    raise AssertionError("a line search tries at least one step")
