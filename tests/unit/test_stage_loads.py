# SPDX-License-Identifier: BSD-3-Clause
"""Loads of every type that begin and end with stages: what the base carries."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from staged_problems import box, roller

from tilth import BadInput, Model, run
from tilth.analysis.simulation import Simulation

WEIGHT = 4.0 * 2.0 * 2.0 * 10.0
"""Of 4 x 2 of soil with the density 2."""


def ground(**changed: Any) -> dict[str, Any]:
    """Gravity; a surcharge, a point force and an earthquake; these without the earthquake."""
    base = {**roller("y", 0.0, "base"), "condition": "fixed"}
    soil = {"model": "hencky_elastic", "young_modulus": 1e4, "poisson_ratio": 0.3, "density": 2.0}
    whole = [[0.0, 1.0], [1.0, 1.0]]
    entries: dict[str, Any] = {
        "format": 1,
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 0.5},
        "materials": {"soil": soil},
        "bodies": [box("ground", [0.0, 0.0], [4.0, 2.0], 2, surface={})],
        "boundaries": [base],
        "loads": [
            {"name": "gravity", "type": "body_force", "acceleration": [0.0, -10.0]},
            {"name": "raft", "type": "surface", "body": "ground", "start": [3.0, 2.0],
             "end": [1.0, 2.0], "traction": [0.0, -7.0]},
            {"name": "crane", "type": "point_force", "body": "ground", "at": [3.6, 2.0],
             "force": [2.0, -5.0]},
            {"name": "quake", "type": "seismic", "coefficient": [0.1, 0.05], "factor": whole},
        ],
        "stages": [
            {"name": "weight", "schedule": {"steps": 1}},
            {"name": "build", "schedule": {"steps": 1}, "activate": ["raft", "crane"]},
            {"name": "shake", "schedule": {"steps": 1}, "activate": ["quake"]},
            {"name": "leave", "schedule": {"steps": 1}, "deactivate": ["quake", "crane"],
             "factors": {"raft": [[0.0, 1.0], [1.0, 0.5]]}},
        ],
        "track": [
            {"name": f"base {axis}", "quantity": "reaction", "boundary": "base", "component": axis}
            for axis in "xy"
        ],
    }  # fmt: skip
    return {**entries, **changed}


@pytest.mark.slow
def test_the_base_carries_what_acts_in_each_stage(tmp_path: Path) -> None:
    history = run(Model.from_dict(ground()), tmp_path / "out", quiet=True).history
    steps = np.array(history["step"]) > 0
    found = np.column_stack([history[f"base {axis} [N/m]"] for axis in "xy"])[steps]
    expected = [
        [0.0, WEIGHT],
        [-2.0, WEIGHT + 14.0 + 5.0],
        [-2.0 - 0.1 * WEIGHT, 0.95 * WEIGHT + 19.0],
        [0.0, WEIGHT + 7.0],
    ]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * WEIGHT)


def test_a_seismic_load_needs_gravity_in_its_stage() -> None:
    entries = ground()
    entries["stages"][2]["deactivate"] = ["gravity"]
    entries["stages"][3]["deactivate"] = ["quake", "crane"]
    with pytest.raises(BadInput, match="a seismic load is a part of gravity"):
        Model.from_dict(entries)


def test_soil_that_is_left_carries_a_point_force() -> None:
    """The upper half is gone: a force at the new surface has its share of the soil below it."""
    entries = ground()
    del entries["stages"]
    entries["schedule"] = {"steps": 1}
    entries["loads"] = [{**entries["loads"][2], "at": [2.1, 1.0]}]
    model = Model.from_dict(entries)
    whole = Simulation(model).state.points
    left = whole.selected(whole.position[:, 1] < 1.0)
    simulation = Simulation(model, left, whole)
    (load,) = simulation.setup.loads.on_points
    place = load.share @ left.position[left.index_of(load.point_id)]
    np.testing.assert_allclose(place, [2.1, 1.0], rtol=1e-12)
    none = whole.selected(whole.position[:, 0] > 3.2)
    with pytest.raises(BadInput, match="no soil is within a cell"):
        Simulation(model, none, whole)


def test_a_restored_analysis_has_the_same_shares() -> None:
    entries = ground()
    del entries["stages"]
    entries["schedule"] = {"steps": 2}
    model = Model.from_dict(entries)
    simulation = Simulation(model)
    simulation.advance(0.0, 0.5)
    again = Simulation.restored(model, simulation.state.arrays())
    (one,), (other,) = simulation.setup.loads.on_points, again.setup.loads.on_points
    assert np.array_equal(one.point_id, other.point_id)
    assert np.array_equal(one.share, other.share)
