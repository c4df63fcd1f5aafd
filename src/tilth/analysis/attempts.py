# SPDX-License-Identifier: BSD-3-Clause
"""The attempts at a step: with the guess of the predictor, without it, with a line search.

Contact that opens and closes can have more than one equilibrium: a block stands, or leans on a
corner. Newton's iteration finds the nearest one to where it begins, and a guess may be nearer to
another one than to that in which the soil is. So a step that ends far beyond what the guess
explains is solved again from where the soil is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import zip_longest

import numpy as np

from tilth.analysis.predictor import Predictor
from tilth.analysis.residual import Newton
from tilth.analysis.run_warnings import JUMP, NO_JUMP, RunWarnings
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.terms.balance import Balance


def solve_in_attempts(
    attempts: Sequence[Newton],
    solve: Callable[[Newton, Floats | None], Equilibrium],
    step: PreparedStep,
    balance: Balance,
    guess: Floats | None,
    explained: float | None,
    predictor: Predictor | None,
    warnings: RunWarnings,
) -> Equilibrium:
    """Returns the equilibrium of the first attempt at a step that has one.

    Args:
        attempts: settings of the iteration, one after the other.
        solve: finds the equilibrium with these from a guess.
        step, balance: the step and all its terms.
        guess: nodal displacement for the first attempt [length], shape (nodes, dim), or None.
        explained: greatest motion that loads and boundaries explain, see `explained_motion`; None
            with a guess that is no prediction.
        predictor: made the guess, and rests after it has failed; None if it is not to rest.
        warnings: of the run.

    Raises:
        StepFailed: there is no equilibrium.
    """
    for newton, following in zip_longest(attempts, attempts[1:]):
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
            guess = explained = None
            balance.restart(following.changes)
    raise AssertionError("a step is tried at least once")


def explained_motion(step: PreparedStep, guess: Floats) -> float:
    """Returns the greatest motion in a step that its guess and its boundaries explain [length].

    guess: nodal displacement, shape (nodes, dim).
    """
    prescribed = float(np.abs(step.conditions.increment).max(initial=0.0))
    driven = max(prescribed, step.constraints.largest_increment())
    motion = step.active.comm.max(float(np.abs(guess).max(initial=0.0)))
    cell = float(step.active.grid.cell_size.min())
    return max(JUMP * max(motion, step.active.comm.max(driven)), NO_JUMP * cell)


def _motion(displacement: Floats, balance: Balance) -> float:
    return balance.comm.max(float(np.abs(displacement).max(initial=0.0)))


def _strays(found: Equilibrium, explained: float, balance: Balance) -> bool:
    return _motion(found.displacement, balance) > explained
