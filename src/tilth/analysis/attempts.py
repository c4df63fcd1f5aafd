# SPDX-License-Identifier: BSD-3-Clause
"""The attempts at a step: with the predictor's guess, without, with a line search, by creep.

Contact that opens and closes can have more than one equilibrium: a block stands, or leans on a
corner. Newton's iteration finds the nearest one to where it begins, and a guess may be nearer to
another one than to that in which the soil is. So a step that ends far beyond what the guess
explains is solved again from where the soil is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import zip_longest

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.analysis.creep import crept_to_rest
from tilth.analysis.observer import Search
from tilth.analysis.predictor import Predictor
from tilth.analysis.residual import Equations, Guess, Newton, most_patient
from tilth.analysis.run_warnings import JUMP, NO_JUMP, RunWarnings
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step import Equilibrium, solve_step
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.drag import Drag
from tilth.terms.protocol import Changes

Attempt = tuple[Newton, Floats | None]
"""Settings of the iteration, and the nodal displacement (nodes, dim) it begins with, None for 0."""


def solve(
    setup: Setup,
    state: State,
    services: Services,
    step: PreparedStep,
    soil: Soil,
    balance: Balance,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
    drag: Drag | None = None,
) -> Equilibrium:
    """Finds the equilibrium of a step, in several attempts if Newton's iteration needs them.

    Args:
        setup, state, services: of the analysis whose step it is.
        step, soil, balance: the step, with all its terms.
        on_iteration: is called with each iteration and its relative residual.
        drag: one of the terms, against which soil creeps after the other attempts have failed, soil
            with friction before contact is tried with care; None if it does not.

    Raises:
        StepFailed: there is no equilibrium.
    """
    attempts, predictor, warnings = setup.attempts, state.predictor, services.warnings
    guess: Floats | None = None
    explained: float | None = None
    dynamics = state.dynamics
    if dynamics is not None and (state.relaxes or step.after > step.before):
        guess = dynamics.guess(balance)
    elif setup.model.analysis.predictor and not state.is_forced:
        held = step.constraints.coupled_nodes()  # a free motion has no guess
        guess = predictor.guess(soil, step.before, step.after, held)
        if guess is not None:
            guess = step.active.updated(guess)
            explained = explained_motion(step, guess)

    def solved(newton: Newton, guess: Guess | None, search: Search = Search.STEP) -> Equilibrium:
        with services.observer.solving(newton, guess, search):
            return solve_step(balance, services, newton, guess, on_iteration)

    def from_displacement(newton: Newton, guess: Floats | None) -> Equilibrium:
        return solved(newton, None if guess is None else Guess({DISPLACEMENT: guess}))

    yields = drag is not None and setup.has_friction
    resting = predictor if state.contact_surfaces and not yields else None
    tries, later = attempts_from(guess, attempts, yields, again=resting is None)
    try:
        return solve_in_attempts(
            tries, from_displacement, step, balance, explained, resting, warnings
        )
    except StepFailed as failure:
        if drag is None:
            raise
        balance.restart(Changes.USUAL)
        newton = attempts[0]
        if step.driven > 0.0:
            newton = most_patient(newton)
        begun = 0.0 if guess is None or not yields else guess
        conditions = step.conditions
        start = np.where(conditions.constrained, conditions.increment, begun)

        def crept(newton: Newton, guess: Guess) -> Equilibrium:
            search = Search.CREEPING if np.isfinite(drag.size) else Search.REST
            return solved(newton, guess, search)

        found = crept_to_rest(
            step,
            soil,
            state.owned_points,
            warnings,
            crept,
            drag,
            newton,
            Guess({DISPLACEMENT: start}),
            Equations(balance),
            failure.reason,
        )  # fmt: skip
        if found is not None:
            return found
        if not later:
            raise
    balance.restart(later[0][0].changes)
    return solve_in_attempts(later, from_displacement, step, balance, None, None, warnings)


def attempts_from(
    guess: Floats | None, attempts: Sequence[Newton], yields: bool, again: bool
) -> tuple[list[Attempt], list[Attempt]]:
    """Returns the attempts at a step, and those that follow after soil has crept without success.

    Args:
        guess: nodal displacement for the first attempt [length], shape (nodes, dim), or None.
        attempts: settings of the iteration, one after the other.
        yields: whether soil with friction may creep. It is more often its flow that Newton's method
            does not solve than contact, so that it creeps before contact is tried with care.
        again: whether the line search begins with the guess, too.
    """
    plain, *others = attempts
    usual = [each for each in others if each.changes is Changes.USUAL]
    careful: list[Attempt] = [(each, None) for each in others if each not in usual]
    searches: list[Attempt] = [(each, None) for each in usual]
    if guess is not None and again:
        from_guess: list[Attempt] = [(each, guess) for each in usual]
        searches = from_guess if yields else [*from_guess, *searches]
    first: list[Attempt] = [(plain, guess), *searches]
    return (first, careful) if yields else ([*first, *careful], [])


def solve_in_attempts(
    tries: Sequence[Attempt],
    solve: Callable[[Newton, Floats | None], Equilibrium],
    step: PreparedStep,
    balance: Balance,
    explained: float | None,
    predictor: Predictor | None,
    warnings: RunWarnings,
) -> Equilibrium:
    """Returns the equilibrium of the first attempt at a step that has one.

    Args:
        tries: the attempts, one after the other.
        solve: makes one.
        step, balance: the step and all its terms.
        explained: greatest motion that loads and boundaries explain, see `explained_motion`; None
            with a guess that is no prediction.
        predictor: made the guess, and rests after it has failed; None if it is not to rest.
        warnings: of the run.

    Raises:
        StepFailed: there is no equilibrium.
    """
    for (newton, guess), following in zip_longest(tries, tries[1:]):
        try:
            found = solve(newton, guess)
            if explained is not None and _strays(found, explained, balance):
                if predictor is not None:
                    predictor.misled()
                balance.restart(newton.changes)
                found = solve(newton, None)
                if _strays(found, explained, balance):
                    warnings.strayed(_motion(found.displacement, balance), explained)
            return found
        except StepFailed as failure:
            if following is None:
                raise
            if guess is not None and predictor is not None:
                predictor.misled()
            if step.after > step.before:  # else a search for the starting state
                warnings.line_search(failure.reason, step.after)
            explained = None
            balance.restart(following[0].changes)
    raise AssertionError("a step is tried at least once")


def explained_motion(step: PreparedStep, guess: Floats) -> float:
    """Returns the greatest motion in a step that its guess and its boundaries explain [length].

    guess: nodal displacement, shape (nodes, dim).
    """
    motion = step.active.comm.max(float(np.abs(guess).max(initial=0.0)))
    cell = float(step.active.grid.cell_size.min())
    return max(JUMP * max(motion, step.driven), NO_JUMP * cell)


def _motion(displacement: Floats, balance: Balance) -> float:
    return balance.comm.max(float(np.abs(displacement).max(initial=0.0)))


def _strays(found: Equilibrium, explained: float, balance: Balance) -> bool:
    return _motion(found.displacement, balance) > explained
