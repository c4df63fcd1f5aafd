# SPDX-License-Identifier: BSD-3-Clause
"""State variables of the materials by name: in results, as tracked quantities, in wrong input."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from small_problems import affine, block_entries

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.analysis.snapshots import snapshot
from tilth.analysis.tracker import Tracker
from tilth.model.laws import Law
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints


def two_blocks(**changed: Any) -> dict[str, Any]:
    """A block of elastic soil and one of clay beside it, sheared far beyond yielding."""
    shear = np.array([[1.0, 0.4], [0.0, 1.0]])
    entries = block_entries("plane_strain", "gimp", "von_mises", boundaries=[affine(shear)])
    elastic = block_entries("plane_strain", "gimp")["materials"]["soil"]
    beside = {**entries["bodies"][0], "name": "rock", "material": "rock"}
    beside["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0]}
    entries["bodies"].append(beside)
    entries["materials"]["rock"] = elastic
    return {**entries, **changed}


def with_a_memory(points: MaterialPoints) -> MaterialPoints:
    """The same points; the law of the first body remembers a pressure."""
    soil, rock = points.ranges
    law = Law(soil.law.name, soil.law.parameters, {"greatest_pressure": "stress"}, True)
    state = np.zeros((len(points), 1))
    state[soil.start : soil.stop, 0] = 5.0 + np.arange(soil.stop - soil.start)
    return replace(points, ranges=[replace(soil, law=law), rock], state=state)


def test_each_law_fills_its_own_columns() -> None:
    points = with_a_memory(initial_points(Model.from_dict(two_blocks())))
    assert points.state_variables() == ["plastic_strain", "greatest_pressure"]
    found = points.state_variable("greatest_pressure")
    np.testing.assert_array_equal(found[:16], 5.0 + np.arange(16))
    assert np.isnan(found[16:]).all()


def test_results_hold_them_by_name_in_the_order_of_the_points() -> None:
    simulation = Simulation(Model.from_dict(two_blocks()))
    active = simulation.check()
    simulation.state.points = with_a_memory(simulation.state.points)
    order = simulation.state.points.point_id.argsort()
    fields = snapshot(simulation.setup, simulation.state, active, None, 0, 0.0).point_fields
    expected = simulation.state.points.state[order, 0]
    np.testing.assert_array_equal(fields["greatest_pressure"][:16], expected[:16])
    np.testing.assert_array_equal(fields["plastic_strain"], np.zeros(32))


def test_plastic_strain_can_be_tracked() -> None:
    asked = [
        {"name": "clay", "quantity": "state", "variable": "plastic_strain", "at": [1.0, 1.0]},
        {"name": "rock", "quantity": "state", "variable": "plastic_strain", "at": [3.0, 1.0]},
    ]
    model = Model.from_dict(two_blocks(track=asked))
    simulation = Simulation(model)
    tracker = Tracker(model, simulation.state.points)
    result = simulation.advance(0.0, 1.0)
    clay, rock = tracker.values(simulation.setup, simulation.state, result, 0.0)
    assert clay > 0.1
    assert rock == 0.0
    assert [unit for _, unit in tracker.columns] == ["", ""]


@pytest.mark.parametrize(
    ("entry", "parts"),
    [
        (
            {"variable": "plastic_strian"},
            ["track[0].variable", "did you mean `plastic_strain`", "plastic_strian"],
        ),
        ({}, ["track[0].variable", "missing", "`variable` and `at`"]),
        ({"variable": "plastic_strain", "component": "x"}, ["track[0].component", "no meaning"]),
    ],
)
def test_wrong_names_are_refused(entry: dict[str, Any], parts: list[str]) -> None:
    asked = {"name": "a", "quantity": "state", "at": [0.0, 0.0], **entry}
    with pytest.raises(BadInput) as error:
        Model.from_dict(two_blocks(track=[asked]))
    assert all(part in str(error.value) for part in parts), str(error.value)
