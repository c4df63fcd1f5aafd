# SPDX-License-Identifier: BSD-3-Clause
"""Pseudo-static earthquakes: forces on a block, and the stresses of an infinite slope."""

from __future__ import annotations

import numpy as np
from small_problems import block_entries

from tilth import Model
from tilth.analysis.simulation import Simulation

WEIGHT = 2.0 * 4.0 * 10.0
"""Of a block of 2 x 2 with the density 2 [force per length]."""


def test_the_base_carries_weight_and_earthquake() -> None:
    entries = block_entries(
        "plane_strain", "gimp",
        loads=[
            {"type": "body_force", "name": "weight", "acceleration": [0.0, -10.0]},
            {"type": "seismic", "name": "quake", "coefficient": [0.2, 0.1],
             "factor": [[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]},
        ],
        boundaries=[
            {"type": "plane", "name": "base", "axis": "y", "at": 0.0, "condition": "fixed"}
        ],
    )  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    quiet = simulation.advance(0.0, 0.5)
    np.testing.assert_allclose(quiet.resultant("base"), [0.0, 0.5 * WEIGHT], atol=1e-7)
    shaken = simulation.advance(0.5, 1.0)
    np.testing.assert_allclose(
        shaken.resultant("base"), [-0.2 * WEIGHT, WEIGHT - 0.1 * WEIGHT], rtol=1e-7
    )


def test_critical_coefficient_of_an_infinite_slope() -> None:
    """With kh = tan(phi - beta) the shear over the normal stress is tan(phi) at every depth.

    The stresses on planes along a slope of angle beta follow from equilibrium alone: gamma z
    (sin beta + kh cos beta) and gamma z (cos beta - kh sin beta). A layer 20 times as long as it is
    thick has them half way between its ends, in the middle of each cell. x is downhill along the
    slope, y normal to it.
    """
    beta, phi, thickness = np.radians(20.0), np.radians(35.0), 2.0
    coefficient = np.tan(phi - beta)
    outwards = coefficient * np.array([np.cos(beta), np.sin(beta)])
    down = np.array([np.sin(beta), -np.cos(beta)])
    entries = block_entries(
        "plane_strain", "gimp",
        loads=[
            {"type": "body_force", "acceleration": (1e-3 * down).tolist()},
            {"type": "seismic", "coefficient": outwards.tolist()},
        ],
        boundaries=[
            {"type": "plane", "name": "base", "axis": "y", "at": 0.0, "condition": "fixed"}
        ],
        grid={"cell_size": 0.25},
    )  # fmt: skip
    entries["bodies"][0]["shape"]["upper"] = [40.0, thickness]
    simulation = Simulation(Model.from_dict(entries))
    simulation.advance(0.0, 0.5)
    simulation.advance(0.5, 1.0)
    points = simulation.state.points
    middle = (np.abs(points.position[:, 0] - 20.0) < 2.0) & (points.position[:, 1] < 1.5)
    depth = thickness - (np.floor(points.position[middle, 1] / 0.25) + 0.5) * 0.25
    normal, shear = points.stress[middle, 1], points.stress[middle, 3]
    gamma = 2.0 * 1e-3
    along = gamma * depth * (np.sin(beta) + coefficient * np.cos(beta))
    across = -gamma * depth * (np.cos(beta) - coefficient * np.sin(beta))
    size = gamma * thickness
    np.testing.assert_allclose(normal, across, rtol=0, atol=1e-4 * size)
    np.testing.assert_allclose(shear, along, rtol=0, atol=1e-4 * size)
    np.testing.assert_allclose(shear / -normal, np.tan(phi), rtol=1e-3)
