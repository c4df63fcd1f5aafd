# SPDX-License-Identifier: BSD-3-Clause
"""A cone pushed from its hole through clay on a coarse grid that follows it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.limit_loads import cone_factor

SMOOTH_FOOTING = 5.69
"""N of a smooth circular footing on the surface of clay (Cox, Eason and Hopkins 1961)."""

DEPTH, CELL, STRENGTH, POISSON = 0.3, 0.25, 10e3, 0.49


def penetrate(rigidity: float) -> tuple[Simulation, list[float]]:
    """Returns the end of a short push in clay of a rigidity index, and N in each step.

    In each step the forces of cone and base are equal.
    """
    changes = {
        "analysis.tolerance": 1e-9,
        "grid.cell_size": CELL,
        "materials.clay.young_modulus": 2.0 * (1.0 + POISSON) * rigidity * STRENGTH,
        "bodies.0.shape.vertices": [
            [0.0, 3.0], [4.0, 3.0], [4.0, 8.0], [0.5, 8.0], [0.5, 7.0], [0.0, 6.133975]
        ],
        "boundaries.0.at": 4.0,
        "boundaries.1.geometry.point": [0.0, 3.0],
        "boundaries.2.displacement": {"y": -DEPTH},
        "schedule.steps": 12,
    }  # fmt: skip
    factors: list[float] = []
    area = math.pi * 0.25

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        cone, base = result.resultant("cone")[1], result.resultant("base")[1]
        assert abs(cone + base) < 1e-6 * abs(cone)
        factors.append(-cone / (area * STRENGTH))

    model = varied(example("cone_penetration", "contact.toml"), changes)
    return march(model, after_step), factors


@pytest.mark.slow
def test_a_cone_bears_more_than_a_footing_and_balances_its_base() -> None:
    """No clay is in the cone, none is lost, and stiffer clay bears more."""
    end, factors = penetrate(100.0)
    assert SMOOTH_FOOTING < factors[-1] < 1.12 * cone_factor(100.0)
    (cone,) = end.state.contact_surfaces
    assert cone.distance(end.state.points.position, 1.0).min() > -0.1 * CELL
    lost = 1.0 - end.state.points.volume.sum() / end.state.points.initial_volume.sum()
    bulk = 2.0 * (1.0 + POISSON) * 100.0 * STRENGTH / (3.0 * (1.0 - 2.0 * POISSON))
    assert np.abs(lost) < factors[-1] * STRENGTH / bulk
    _, stiffer = penetrate(300.0)
    assert factors[-1] < stiffer[-1] < 1.12 * cone_factor(300.0)
