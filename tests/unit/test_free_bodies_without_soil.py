# SPDX-License-Identifier: BSD-3-Clause
"""A loaded free body comes down on the soil below it, or is refused."""

from __future__ import annotations

import pytest
from small_problems import block_entries, rollers

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.errors import StepFailed


def simulation(height: float, force: float) -> Simulation:
    """Returns a block of height 2 below a ball of which only the height is free."""
    ball = {
        "name": "ball", "centre": [1.0, height + 0.5], "displacement": {"x": 0.0}, "rotation": 0.0,
        "geometry": {"type": "circle", "centre": [1.0, height + 0.5], "radius": 0.5,
                     "soil": "outside"},
        "contact": {"normal": "unilateral", "tangential": "smooth"}, "force": {"y": force},
    }  # fmt: skip
    entries = block_entries("plane_strain", "gimp", rigid_bodies=[ball])
    return Simulation(Model.from_dict({**entries, "boundaries": rollers("plane_strain")}))


def test_a_loaded_body_far_above_the_soil_is_refused() -> None:
    with pytest.raises(BadInput, match="no soil is within 1 cell of the rigid body 'ball'"):
        simulation(3.5, -1.0).check()


def test_a_loaded_body_that_has_left_the_soil_fails_the_step() -> None:
    with pytest.raises(StepFailed, match="no soil is near the rigid body 'ball'"):
        simulation(3.5, -1.0).advance(0.0, 1.0)


def test_a_loaded_body_near_the_soil_comes_down_on_it() -> None:
    near = simulation(2.5, -1e-3)
    near.check()
    near.advance(0.0, 0.1)
    # its lowest quadrature point is a little higher than its lowest point
    assert near.state.rigid_bodies["ball"].displacement[1] == pytest.approx(-0.5, abs=0.01)


def test_a_body_of_few_cells_is_warned_of() -> None:
    """Contact was compared with other results for radii of 4 cells and more."""
    near = simulation(2.5, -1e-3)
    near.check()
    assert any(
        "radius of the rigid body 'ball' is only 0.5 cells" in text
        for text in near.services.warnings.texts
    )
