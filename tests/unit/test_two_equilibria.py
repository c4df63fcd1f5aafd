# SPDX-License-Identifier: BSD-3-Clause
"""A block on a rigid plane stands or leans: only its own weight grows, so it stands."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from implicit_blocks import by_number
from readings import some_of
from standing_blocks import CELL, DENSITY, GRAVITY, SLENDERNESS, WIDTH, standing_block

from tilth.analysis.attempts import explained_motion, solve, solve_in_attempts
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.curves.chain import Chain
from tilth.errors import StepFailed

HEIGHT = SLENDERNESS * WIDTH


def largest_motion(simulation: Simulation) -> float:
    return float(
        np.abs(by_number(simulation) - by_number(Simulation(simulation.setup.model))).max()
    )


@some_of(
    modulus=[1e7, 1e8],
    basis=["gimp", "cpdi2"],
    tangential=["friction", "bonded"],
    corner=[(0.07, 0.05), (0.01, 0.12), (0.2, 0.2)],
    turn=[0.0, 20.0],
)
def test_a_block_under_its_weight_stands(
    modulus: float, basis: str, tangential: str, corner: tuple[float, float], turn: float
) -> None:
    """Its top settles by rho g h^2 / (2 E) less what the plane holds, and by no more than twice."""
    settlement = 14 / 30 * DENSITY * GRAVITY * HEIGHT**2 / (2.0 * modulus)
    found = []
    simulation = march(
        standing_block(modulus, basis, tangential, corner, turn),
        lambda _, result, time: found.append(result.moment("plane", np.array(corner))[2]),
    )
    assert largest_motion(simulation) < 2.0 * settlement
    weights = np.arange(1, 15) / 30 * DENSITY * GRAVITY * HEIGHT * WIDTH
    np.testing.assert_allclose(found, weights * 0.5 * WIDTH, rtol=2e-2)


def converged(simulation: Simulation, motion: float) -> Any:
    """A converged first step of a simulation, all of whose nodes move by `motion`."""
    step = simulation.prepare(0.0, 1.0)
    soil = simulation.soil_on(step.active)
    balance = simulation.balance(step, soil)
    setup, state, services = simulation.setup, simulation.state, simulation.services
    equilibrium = solve(setup, state, services, step, soil, balance)
    moved = np.full_like(equilibrium.displacement, motion)
    return step, balance, replace(equilibrium, x=balance.at(moved))


@pytest.mark.parametrize("without_guess", [1e-3, 0.2, None])
def test_what_the_guess_does_not_explain_is_solved_without_it(without_guess: float | None) -> None:
    simulation = Simulation(standing_block())
    step, balance, near = converged(simulation, 1e-3)
    far = replace(near, x=balance.at(np.full_like(near.displacement, 0.2)))
    guess = np.full_like(near.displacement, 1e-3)

    def solve(newton: Any, guess: Floats | None) -> Any:
        if guess is not None:
            return far
        if without_guess is None:
            raise StepFailed("no equilibrium")
        return replace(near, x=balance.at(np.full_like(near.displacement, without_guess)))

    tries = [(simulation.setup.attempts[0], guess)]
    explained = explained_motion(step, guess)
    assert explained == pytest.approx(0.03)

    def found() -> Any:
        return solve_in_attempts(
            tries,
            solve,
            step,
            balance,
            explained,
            simulation.state.predictor,
            simulation.services.warnings,
        )

    if without_guess is None:
        with pytest.raises(StepFailed):
            found()
        return
    assert found().displacement.max() == without_guess
    assert simulation.state.predictor.rest > 0
    assert len(simulation.services.warnings.texts) == (without_guess > explained)


@pytest.mark.parametrize("condition", ["contact", "roller", "fixed"])
def test_soil_behind_a_surface_is_warned_of(condition: str) -> None:
    """From 0.02 of a cell on, by the tracked surface, though no point's centre is behind."""
    plane = {} if condition == "contact" else {"condition": condition}
    simulation = Simulation(standing_block(**plane))
    simulation.services.warnings.texts.clear()
    for depth in (0.01, 0.03):
        surface = simulation.state.surfaces["block"]
        chain = surface.chains[0]
        points = chain.current.points.copy()
        points[points[:, 1].argmin(), 1] = 0.05 - depth * CELL
        moved = Chain(points, chain.current.closed, chain.current.corner)
        surface.commit([replace(chain, current=moved)])
        simulation.services.warnings.depths(
            simulation.state.implicit,
            simulation.state.points,
            simulation.state.surfaces,
            1.0,
            simulation.state.grid,
        )
        texts = simulation.services.warnings.texts
        assert len(texts) == (depth > 0.02)
    assert "the surface of the body 'block' is up to 0.0075 (0.03 of a cell)" in texts[0]
    assert "behind the boundary 'plane'" in texts[0]
