# SPDX-License-Identifier: BSD-3-Clause
"""A sphere pushed into clay by its radius has no soil inside it at any step."""

from __future__ import annotations

import numpy as np
import pytest
from readings import long

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth_verification.cases import example, varied

RADIUS, CELL, TOP = 0.2, 0.05, 1.05
"""Of the sphere and of the cells; height of the clay [m]."""


@pytest.mark.slow
@pytest.mark.parametrize("face", ["rough", long("smooth")])
def test_a_sphere_leaves_no_soil_inside_it(face: str) -> None:
    """Neither the surface of the clay, which is followed, nor the centre of a material point."""
    changes = {
        "grid.cell_size": CELL,
        "materials.clay.young_modulus": 5e6,
        "rigid_bodies.0.geometry.radius": RADIUS,
        "rigid_bodies.0.geometry.centre": [0.0, TOP + RADIUS],
        "rigid_bodies.0.centre": [0.0, TOP + RADIUS],
        "rigid_bodies.0.displacement.y": -RADIUS,
        "rigid_bodies.0.contact.tangential": face,
        "schedule.steps": 60,
    }
    overlaps: list[tuple[float, float]] = []

    def after_step(simulation: Simulation, _: StepResult, time: float) -> None:
        centre = np.array([0.0, TOP + RADIUS * (1.0 - time)])
        (surface,) = simulation.state.surfaces.values()
        places = (surface.chains[0].current.points, simulation.state.points.position)
        reach = [RADIUS - np.linalg.norm(each - centre, axis=1).min() for each in places]
        overlaps.append((float(reach[0]), float(reach[1])))

    march(varied(example("hertz", "sphere_on_clay.toml"), changes), after_step)
    surface, points = np.max(overlaps, axis=0) / CELL
    assert surface < 0.1
    assert points < 0.05
