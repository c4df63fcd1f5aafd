# SPDX-License-Identifier: BSD-3-Clause
"""Random problems of sand with hardly any cohesion below their limit load: they run to the end."""

from __future__ import annotations

from pathlib import Path

import pytest
import tomllib
from readings import long
from sand_footings import small_footing
from sand_problems import STEPS, STILL_STEPS, sand_problem

from tilth import Model, steps
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.mpm.initial_points import initial_points
from tilth.templates import template
from tilth_verification.cases import varied

FEW, MANY = 18, 200
"""Problems in every run of the tests, and in the long ones."""
UNQUIET = {62, 84, 92, 104, 151, 193}
"""Those that move by up to 1.5 % when nothing changes, or by up to 8e-4 in the last step."""
LET_GO, STILL = 0.01, 1e-4
"""Motion in a step in which nothing changes, and in the last of ten, over the whole motion. Ghost
stabilisation holds up to 3 % of the work (docs/decisions/0042-metamorphic-tests.md), and lets go of
it where points begin to flow."""


def ends(model: Model) -> list[float]:
    """Runs a model; returns the largest motion of a point in each step [length]."""
    motions: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        motions.append(float(abs(simulation.state.points.last_displacement).max()))

    march(model, after_step)
    return motions


@pytest.mark.parametrize(
    "seed",
    [each if each < FEW else long(each) for each in range(MANY)],
)
def test_it_runs_to_its_end_and_stands(seed: int) -> None:
    if seed in UNQUIET:
        pytest.xfail("it moves on in steps in which nothing changes (decision 43)")
    problem = sand_problem(seed)
    motions = ends(problem.model)
    if not problem.model.rigid_bodies and len(motions) == STEPS + STILL_STEPS:
        whole = sum(motions[:STEPS])
        assert max(motions[STEPS:]) <= LET_GO * whole, problem.text
        assert motions[-1] <= STILL * whole, problem.text


@pytest.mark.parametrize("dilation_angle", [0.0, 5.0])
def test_fill_without_cohesion_is_placed_and_stands(tmp_path: Path, dilation_angle: float) -> None:
    """The two lifts of the template, of sand without stress at first; the base bears all weight."""
    entries = tomllib.loads(template("embankment"))
    entries["materials"]["fill"] |= {"cohesion": 0.0, "dilation_angle": dilation_angle}
    model = Model.from_dict(entries)
    weight = 9.81 * float(initial_points(model).mass.sum())
    for step in steps(model, tmp_path):
        base, finished = step.force("base"), step.finished
    assert finished
    assert base[1] == pytest.approx(weight, rel=1e-8)


@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi2"])
@pytest.mark.parametrize("steps", [10, 20])
def test_a_footing_goes_down_in_sand_by_equilibria(basis: str, steps: int) -> None:
    """Without cohesion and dilation, to 0.2 B; soil creeps in most steps, and none is cut."""
    changes = {"bodies.0.basis": basis, "bodies.0.domain_update": None}
    model = varied(small_footing(steps), changes)
    residuals: list[float] = []
    told: list[str] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        residuals.append(result.equilibrium.residuals[-1])
        told[:] = simulation.services.warnings.texts

    march(model, after_step)
    assert len(residuals) == steps
    assert max(residuals) <= model.analysis.tolerance
    assert any("let go against a drag" in text for text in told)
