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


def test_one_nearest_point_takes_the_whole_force() -> None:
    loads, points = loaded("plane_strain", [point_force([2.0, 2.0], [3.0, -4.0])])
    force = loads.force(points, 1.0)
    corner = (points.position == [1.75, 1.75]).all(axis=1)
    assert force[corner].tolist() == [[3.0, -4.0]]
    assert not force[~corner].any()


@pytest.mark.parametrize(
    ("kind", "at", "share"),
    [
        ("plane_strain", [1.0, 2.0], 2),
        ("plane_strain", [1.0, 1.0], 4),
        ("axisymmetric", [1.0, 2.0], 2),
        ("3d", [1.0, 1.0, 2.0], 4),
        ("3d", [1.0, 1.0, 1.0], 8),
    ],
)
def test_points_equally_near_share_the_force(kind: str, at: list[float], share: int) -> None:
    direction = [1.0, -2.0, 0.5][: len(at)]
    loads, points = loaded(kind, [point_force(at, direction)])
    force = loads.force(points, 1.0)
    touched = force.any(axis=1)
    assert touched.sum() == share
    np.testing.assert_allclose(force[touched], np.tile(direction, (share, 1)) / share, rtol=1e-15)
    moment = force[:, 1] @ points.position
    np.testing.assert_allclose(moment, direction[1] * np.array(at)[:], rtol=0, atol=0.6)


@pytest.mark.parametrize(("offset", "share"), [(1e-8, 2), (1e-5, 1)])
def test_ties_end_at_a_millionth_of_a_cell(offset: float, share: int) -> None:
    loads, points = loaded("plane_strain", [point_force([1.0 + offset, 2.0], [0.0, -1.0])])
    assert loads.force(points, 1.0).any(axis=1).sum() == share


def test_force_rides_on_its_points_when_these_are_reordered() -> None:
    """Points are sorted by cell every step: the force must find them again."""
    entries = block_entries(
        "plane_strain", "linear", loads=[point_force([2.0, 2.0], [0.0, -1.0])],
        boundaries=[affine(np.array([[0.3, -2.0], [0.0, 1.0]]))], schedule={"steps": 8},
    )  # fmt: skip
    entries["grid"]["cell_size"] = 0.4
    simulation = Simulation(Model.from_dict(entries))
    first = simulation.loads.force(simulation.points, 1.0)
    number = simulation.points.point_id[first.any(axis=1)]
    for k in range(8):
        simulation.advance(k / 8, (k + 1) / 8)
    assert not np.array_equal(simulation.points.point_id, np.sort(simulation.points.point_id))
    force = simulation.loads.force(simulation.points, 1.0)
    assert simulation.points.point_id[force.any(axis=1)].tolist() == number.tolist()


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
        "plane_strain", "gimp", loads=[point_force([2.0, 2.0], [3.0, -4.0])],
        boundaries=[affine(np.array([[1.1, 0.2], [0.0, 0.9]]))],
    )  # fmt: skip
    simulation = Simulation(Model.from_dict(entries))
    force: Floats = simulation.loads.force(simulation.points, 1.0)
    active = simulation.check()
    nodal = simulation.soil_on(active).scatter(force)
    simulation.advance(0.0, 1.0)
    displacement = active.position @ np.array([[0.1, 0.2], [0.0, -0.1]]).T
    loaded_point = simulation.points.index_of(np.array([15]))[0]
    expected = np.array([3.0, -4.0]) @ simulation.points.displacement[loaded_point]
    assert (nodal * displacement).sum() == pytest.approx(expected, rel=1e-13)
