# SPDX-License-Identifier: BSD-3-Clause
"""The predictor where soil is in contact: a guess that fails is not tried step after step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from contact_terms import DRIVEN, pressed

import tilth.analysis.attempts
from tilth.analysis.predictor import REST, Predictor
from tilth.analysis.simulation import Simulation
from tilth.errors import StepFailed

STEPS = 40


def advance(simulation: Simulation, step: int) -> None:
    simulation.advance(step / STEPS, (step + 1) / STEPS)


@pytest.fixture
def guesses(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether each attempt has a guess; those that have one fail."""
    asked: list[bool] = []
    solve = tilth.analysis.attempts.solve_step

    def solve_without(*arguments: Any) -> Any:
        asked.append(arguments[3] is not None)
        if asked[-1]:
            raise StepFailed("the guess leads astray")
        return solve(*arguments)

    monkeypatch.setattr(tilth.analysis.attempts, "solve_step", solve_without)
    return asked


@pytest.mark.slow
def test_the_predictor_rests_after_a_guess_that_failed(guesses: list[bool]) -> None:
    simulation = pressed("plane_strain", "friction", DRIVEN, steps=STEPS)
    for step in range(2 * REST + 2):
        advance(simulation, step)
    # no guess in the first step; the second one fails with it and is repeated without it
    assert guesses == [False, *2 * [True, False, *(REST - 1) * [False]], True, False]


@pytest.mark.slow
def test_without_contact_each_step_has_a_guess(guesses: list[bool]) -> None:
    simulation = pressed("plane_strain", "friction", DRIVEN, steps=STEPS)
    simulation.state.contact_surfaces = []
    for step in range(3):
        advance(simulation, step)
    assert guesses == [
        False,
        *2 * [True, True, False],
    ]  # a line search from the guess, then without


def test_the_rest_is_part_of_the_state() -> None:
    predictor, other = Predictor(2), Predictor(2)
    predictor.misled()
    other.restore(predictor.state())
    assert other.rest == REST
    with pytest.raises(ValueError, match="negative"):
        other.restore(predictor.state() | {"rest": np.array(-1)})
