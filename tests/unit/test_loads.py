# SPDX-License-Identifier: BSD-3-Clause
"""Loads: body forces on mass, tables, and point forces that ride on their points."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import KINDS, affine, block_entries, dimension

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.terms.loads import Loads, nearest_points


def loaded(kind: str, loads: list[dict[str, Any]], **changed: Any) -> tuple[Loads, MaterialPoints]:
    model = Model.from_dict(block_entries(kind, "linear", loads=loads, **changed))
    points = initial_points(model)
    return Loads(model, points), points


@pytest.mark.parametrize("kind", KINDS)
def test_weight_is_mass_times_acceleration(kind: str) -> None:
    acceleration = [3.0, -7.0, 2.0][: dimension(kind)]
    loads, points = loaded(kind, [{"type": "body_force", "acceleration": acceleration}])
    mass = {"plane_strain": 2 * 4.0, "axisymmetric": 2 * np.pi * 8.0, "3d": 2 * 8.0}[kind]
    total = loads.force(points, 0.5).sum(axis=0)
    np.testing.assert_allclose(total, 0.5 * mass * np.array(acceleration), rtol=1e-13)


def test_tables_are_linear_between_rows_and_constant_after() -> None:
    table = [[0.0, 0.0], [0.25, 1.0], [0.5, 1.0], [1.0, -1.0]]
    loads, _ = loaded(
        "plane_strain",
        [{"type": "body_force", "acceleration": [0.0, -8.0], "factor": table}],
        schedule={"steps": 1, "end": 2.0},
    )
    for time, factor in [(0, 0), (0.1, 0.4), (0.25, 1), (0.4, 1), (0.75, 0), (1.0, -1), (1.7, -1)]:
        assert loads.acceleration(time)[1] == pytest.approx(-8.0 * factor, abs=1e-15)


def test_loads_add_up() -> None:
    pull = {"type": "body_force", "acceleration": [1.0, 0.0]}
    weight = {"type": "body_force", "acceleration": [0.0, -8.0], "factor": [[0.0, 1.0], [1.0, 1.0]]}
    loads, _ = loaded("plane_strain", [pull, weight])
    assert loads.acceleration(0.5).tolist() == [0.5, -8.0]


def point_force(at: list[float], force: list[float], body: str = "block") -> dict[str, Any]:
    return {"type": "point_force", "body": body, "at": at, "force": force}


def test_a_point_at_the_place_takes_the_whole_force() -> None:
    loads, points = loaded("plane_strain", [point_force([1.75, 1.75], [3.0, -4.0])])
    force = loads.force(points, 1.0)
    there = (points.position == [1.75, 1.75]).all(axis=1)
    assert force[there].tolist() == [[3.0, -4.0]]
    assert not force[~there].any()


def test_force_rides_on_its_points_when_these_are_reordered() -> None:
    """Points are sorted by cell every step: the force must find them again."""
    entries = block_entries(
        "plane_strain", "linear", loads=[point_force([1.83, 1.97], [0.0, -1.0])],
        boundaries=[affine(np.array([[0.3, -2.0], [0.0, 1.0]]))], schedule={"steps": 8},
    )  # fmt: skip
    entries["grid"]["cell_size"] = 0.4
    simulation = Simulation(Model.from_dict(entries))
    first = simulation.setup.loads.force(simulation.state.points, 1.0)
    number = simulation.state.points.point_id[first.any(axis=1)]
    for k in range(8):
        simulation.advance(k / 8, (k + 1) / 8)
    assert not np.array_equal(
        simulation.state.points.point_id, np.sort(simulation.state.points.point_id)
    )
    force = simulation.setup.loads.force(simulation.state.points, 1.0)
    carrying = simulation.state.points.point_id[force.any(axis=1)]
    assert len(number) > 1
    assert sorted(carrying.tolist()) == sorted(number.tolist())
    of_points = force[simulation.state.points.index_of(number)]
    assert np.array_equal(of_points, first[first.any(axis=1)])


def test_seismic_load_is_a_part_of_all_body_forces() -> None:
    """Of their sum at the time, in its own direction: (3, -4) has the magnitude 5."""
    whole = [[0.0, 1.0], [1.0, 1.0]]
    pull = {"type": "body_force", "acceleration": [3.0, 0.0], "factor": whole}
    weight = {"type": "body_force", "acceleration": [0.0, -8.0]}
    quake = {"type": "seismic", "coefficient": [0.2, -0.1], "factor": [[0, 0], [0.25, 1], [0.5, 1]]}
    loads, points = loaded("plane_strain", [quake, pull, weight])
    assert loads.acceleration(0.0).tolist() == [3.0, 0.0]
    np.testing.assert_allclose(loads.acceleration(0.5), [3.0 + 1.0, -4.0 - 0.5], rtol=1e-15)
    total = loads.force(points, 0.5).sum(axis=0)
    np.testing.assert_allclose(total, 2 * 4.0 * np.array([4.0, -4.5]), rtol=1e-13)


def test_two_body_forces_tilt_gravity() -> None:
    """Tables of the cosine and the sine every degree: exact there, to 4e-5 of g between."""
    angle = np.radians(np.arange(31.0))
    time = np.linspace(0.0, 1.0, 31)
    parts = [[0.0, -10.0], [10.0, 0.0]]
    values = [np.cos(angle), np.sin(angle)]
    loads, _ = loaded(
        "plane_strain",
        [
            {
                "type": "body_force",
                "acceleration": a,
                "factor": np.stack([time, v], axis=1).tolist(),
            }
            for a, v in zip(parts, values, strict=True)
        ],
    )
    for degrees, tolerance in ((0.0, 1e-15), (7.0, 1e-14), (29.5, 4e-5)):
        turned = np.radians(degrees)
        expected = 10.0 * np.array([np.sin(turned), -np.cos(turned)])
        found = loads.acceleration(degrees / 30.0)
        np.testing.assert_allclose(found, expected, rtol=0, atol=10.0 * tolerance)


def two_bodies() -> MaterialPoints:
    entries = block_entries("plane_strain", "linear")
    other = dict(entries["bodies"][0], name="other")
    other["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0]}
    entries["bodies"].append(other)
    return initial_points(Model.from_dict(entries))


@pytest.mark.parametrize(("body", "x"), [("block", 1.75), ("other", 2.25)])
def test_nearest_point_of_a_body(body: str, x: float) -> None:
    points = two_bodies()
    ids = nearest_points(points, [2.0, 2.0], 1.0, body)
    assert points.position[points.index_of(ids)].tolist() == [[x, 1.75]]
    assert len(nearest_points(points, [2.0, 2.0], 1.0)) == 2


def test_work_of_a_dead_force_is_force_times_displacement() -> None:
    """The nodal force is spread by the same functions that move the point."""
    entries = block_entries(
        "plane_strain", "gimp", loads=[point_force([1.75, 1.75], [3.0, -4.0])],
        boundaries=[affine(np.array([[1.1, 0.2], [0.0, 0.9]]))],
    )  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    force: Floats = simulation.setup.loads.force(simulation.state.points, 1.0)
    active = simulation.check()
    nodal = simulation.soil_on(active).scatter(force)
    simulation.advance(0.0, 1.0)
    displacement = active.position @ np.array([[0.1, 0.2], [0.0, -0.1]]).T
    loaded_point = simulation.state.points.index_of(np.array([15]))[0]
    expected = np.array([3.0, -4.0]) @ simulation.state.points.displacement[loaded_point]
    assert (nodal * displacement).sum() == pytest.approx(expected, rel=1e-13)
