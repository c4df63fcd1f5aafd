# SPDX-License-Identifier: BSD-3-Clause
"""The rotation vector of a body that turned in several steps, also by more than half a turn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_problems import block_entries, rollers

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.boundaries.contact.rotation import rotation_by, vector_near


@pytest.mark.parametrize("degrees", [0.0, 30.0, 170.0, 200.0, 400.0, -250.0])
def test_vector_near_keeps_whole_turns(degrees: float) -> None:
    vector = np.radians(degrees) * np.array([0.36, 0.48, 0.8])
    np.testing.assert_allclose(vector_near(rotation_by(vector), 1.01 * vector), vector, atol=1e-12)


def test_rotations_one_after_the_other_are_in_the_result() -> None:
    ball = {
        "name": "ball", "centre": [1.0, 1.0, 4.0],
        "geometry": {"type": "sphere", "centre": [1.0, 1.0, 4.0], "radius": 0.5, "soil": "outside"},
        "contact": {"normal": "unilateral", "tangential": "smooth"},
        "displacement": {"x": 0.0, "y": 0.0, "z": 0.0},
        "rotation": {"x": [[0, 0], [0.5, 90], [1, 90]], "y": 0,
                     "z": [[0, 0], [0.5, 0], [1, 90]]},
    }  # fmt: skip
    entries = block_entries("3d", "gimp", boundaries=rollers("3d"), rigid_bodies=[ball])
    turned = Simulation(Model.from_dict(entries))
    for before in (0.0, 0.5):
        turned.advance(before, before + 0.5)
    expected = Rotation.from_euler("xz", [90.0, 90.0], degrees=True).as_rotvec()
    np.testing.assert_allclose(turned.state.rigid_bodies["ball"].rotation, expected, atol=1e-12)
