# SPDX-License-Identifier: BSD-3-Clause
"""Random bodies on oblique, curved and moving boundaries: every analysis comes to its end.

`curved_problems.py` says what is drawn.
"""

from __future__ import annotations

import numpy as np
import pytest
from curved_problems import YOUNG, Problem, problem_of

from tilth import AnalysisFailed, BadInput, Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.boundaries.implicit.passage import depth_behind

FEW, MANY, PART = 12, 200, 50


def taken(problem: Problem) -> str:
    """Takes all steps; why they stopped, or nothing where the analysis came to its end."""
    results: list[StepResult] = []
    try:
        simulation = march(Model.from_dict(problem.entries), lambda *step: results.append(step[1]))
    except (AnalysisFailed, BadInput) as error:
        return f"{problem.text}: {error} (after {len(results)} steps)"
    assert_sensible(problem, simulation, results)
    return ""


def assert_sensible(problem: Problem, simulation: Simulation, results: list[StepResult]) -> None:
    """The state is finite, no soil has passed a boundary, and the boundaries carry the loads."""
    points = simulation.state.points
    for name in ("position", "stress", "volume", "deformation_gradient"):
        assert np.isfinite(getattr(points, name)).all(), f"{name}: {problem.text}"
    assert points.volume.min() > 0.0, problem.text
    grid = simulation.state.grid
    for boundary in simulation.state.implicit:
        depth = depth_behind(boundary, points, 1.0, grid) / grid.cell_size.min()
        assert depth < 0.5, f"{depth:.2f} cells behind {boundary.name}: {problem.text}"
    load = simulation.setup.loads.force(points, 1.0).sum(axis=0)
    reaction = results[-1].reaction
    balanced = slice(1, None) if simulation.setup.kind == "axisymmetric" else slice(None)
    rest = np.abs(load + reaction.sum(axis=0))[balanced].max()
    face = points.volume.sum() ** (2.0 / 3.0 if simulation.setup.kind != "plane_strain" else 0.5)
    least = 1e-4 * YOUNG * face  # for a body may be carried only, without any force
    size = max(np.abs(reaction).max(), np.abs(load).max(), least)
    assert rest < 1e-5 * size, f"{rest:g} of {size:g}: {problem.text}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("first", "count"),
    [
        (0, FEW),
        *(pytest.param(k, PART, marks=pytest.mark.long) for k in range(0, MANY, PART)),
    ],
)
def test_every_problem_comes_to_its_end(first: int, count: int) -> None:
    stops = [stop for seed in range(first, first + count) if (stop := taken(problem_of(seed)))]
    assert not stops, f"{len(stops)} of {count} stop:\n" + "\n".join(stops)
