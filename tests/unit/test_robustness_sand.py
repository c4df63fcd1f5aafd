# SPDX-License-Identifier: BSD-3-Clause
"""Random problems of sand with hardly any cohesion below their limit load: they run to the end."""

from __future__ import annotations

import pytest
from readings import long
from sand_problems import STEPS, sand_problem

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.verification.march import march

FEW, MANY = 18, 200
"""Problems in every run of the tests, and in the long ones."""
KNOWN = {
    3: "cpdi1 in space without F-bar under a rough footing: an inverted point at 0.9 of its way",
    190: "a wall that goes away by 0.1 of its height, standard MPM: no equilibrium at 0.6 of its way",
}
"""Those that stop, and where."""
DIES, STILL = 0.5, 1e-3
"""Motion in the last step in which nothing changes over that in the first one, or over the whole
motion: as in the metamorphic tests (docs/decisions/0042-metamorphic-tests.md)."""


def ends(model: Model) -> list[float]:
    """Runs a model; returns the largest motion of a point in each step [length]."""
    motions: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        motions.append(float(abs(simulation.points.last_displacement).max()))

    march(model, after_step)
    return motions


@pytest.mark.parametrize(
    "seed",
    [each if each < FEW and each not in KNOWN else long(each) for each in range(MANY)],
)
def test_it_runs_to_its_end_and_stands(seed: int) -> None:
    if seed in KNOWN:
        pytest.xfail(KNOWN[seed])
    problem = sand_problem(seed)
    motions = ends(problem.model)
    if not problem.model.rigid_bodies and len(motions) == 2 * STEPS:
        whole = sum(motions[:STEPS])
        assert motions[-1] <= max(DIES * motions[STEPS], STILL * whole), problem.text
