# SPDX-License-Identifier: BSD-3-Clause
"""Stress at the start: level ground at rest, laws that need a stress, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import (
    BASES,
    KINDS,
    block_entries,
    dimension,
    initial_stress,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import BadInput, Model
from tilth.analysis.simulation import Simulation
from tilth.mpm.initial_points import initial_points

SURCHARGE = 30.0


def level_ground(kind: str, basis: str, law: str = "mohr_coulomb", **entry: Any) -> dict[str, Any]:
    """A block between smooth walls under its own weight, with the stress at rest."""
    entries = block_entries(
        kind, basis, law, boundaries=rollers(kind), loads=[weight(kind, 5.0)],
    )  # fmt: skip
    entries["loads"][0]["factor"] = [[0.0, 1.0], [1.0, 1.0]]
    at_rest = {"type": "k0", "body": "block", "K0": 0.5, "ground": 2.0, **entry}
    entries["initial"] = {"stress": [at_rest]}
    return entries


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("law", ["mohr_coulomb", "undrained_mohr_coulomb"])
def test_level_ground_at_rest_stays_at_rest(kind: str, basis: str, law: str) -> None:
    """The weight of the points is in equilibrium with their stress: nothing moves."""
    simulation = Simulation(Model.from_dict(level_ground(kind, basis, law)))
    before, number = simulation.state.points.stress.copy(), simulation.state.points.point_id.copy()
    up = dimension(kind) - 1
    depth = 2.0 - simulation.state.points.position[:, up]
    np.testing.assert_allclose(before[:, up], -10.0 * depth, rtol=1e-14)
    np.testing.assert_allclose(before[:, 0], -5.0 * depth, rtol=1e-14)
    result = simulation.advance(0.0, 1.0)
    assert np.abs(simulation.state.points.displacement).max() < 1e-12
    after = simulation.state.points.stress[simulation.state.points.index_of(number)]
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-9)
    base = result.resultant(f"low {'xyz'[up]}")[up]
    area = np.pi * 4.0 if kind == "axisymmetric" else 2.0 ** (dimension(kind) - 1)
    assert base == pytest.approx(5.0 * 2.0 * 2.0 * area, rel=1e-10)


def test_cam_clay_under_a_surcharge() -> None:
    """Stiffness and preconsolidation follow the depth; the surcharge is carried by a boundary."""
    entries = level_ground("plane_strain", "gimp", "modified_cam_clay", surcharge=SURCHARGE)
    clay = {"overconsolidation_ratio": 1.5, "preconsolidation_pressure": None}
    entries["materials"]["soil"] = material_entries("modified_cam_clay", **clay)
    entries["boundaries"].append(plane("top", "y", 2.0))
    simulation = Simulation(Model.from_dict(entries))
    points = simulation.state.points
    vertical = SURCHARGE + 10.0 * (2.0 - points.position[:, 1])
    p, q = 2.0 / 3.0 * vertical, 0.5 * vertical
    expected = 1.5 * (p + q**2 / (1.2**2 * p))
    found = points.state_variable("preconsolidation_pressure")
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    bulk = p / (0.05 / 0.95)
    np.testing.assert_allclose(points.elastic_moduli().bulk, bulk, rtol=1e-10)
    result = simulation.advance(0.0, 1.0)
    assert np.abs(points.displacement).max() < 1e-12
    assert result.resultant("top")[1] == pytest.approx(-2.0 * SURCHARGE, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_given_stress_is_that_of_the_points(kind: str) -> None:
    entries = block_entries(kind, "linear", "modified_cam_clay")
    points = initial_points(Model.from_dict(entries))
    assert (points.stress[:, :3] == -100.0).all()
    assert not points.stress[:, 3:].any()
    assert (points.elastic_deformation[:, :3] != 0.0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_a_table_gives_the_stress_along_the_last_axis(kind: str) -> None:
    """The vertical stress grows with depth, and both horizontal ones are K0 times it."""
    entries, up = block_entries(kind, "linear"), dimension(kind) - 1
    pressure = {"depth": [[0.0, 10.0], [2.0, 50.0]], "surface": 2.0}
    table = {"type": "table", "body": "block", "vertical_pressure": pressure, "K0": 0.5}
    entries["initial"] = {"stress": [table], "equilibrium": False}
    points = initial_points(Model.from_dict(entries))
    expected = np.zeros((len(points), 6))
    expected[:, up] = -10.0 - 20.0 * (2.0 - points.position[:, up])
    expected[:, [axis for axis in range(3) if axis != up]] = 0.5 * expected[:, [up]]
    np.testing.assert_allclose(points.stress, expected, rtol=1e-12)


def test_no_stress_is_refused_where_a_law_needs_one() -> None:
    entries = block_entries("plane_strain", "linear", "modified_cam_clay")
    del entries["initial"]
    with pytest.raises(BadInput, match=r"(?s)bodies\[0\].material.*cannot be without stress"):
        Model.from_dict(entries)


def given(stress: list[float], body: str = "block") -> dict[str, Any]:
    entry = {"type": "given", "body": body, "stress": stress}
    return {
        **block_entries("plane_strain", "linear", "mohr_coulomb"),
        "initial": {"stress": [entry]},
    }


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        (given([1.0, 2.0, 3.0]), r"initial.stress\[0\].stress.*has 3 components, expected 4"),
        (given([0.0] * 4, "rock"), r"initial.stress\[0\].body.*there is no body"),
        (given([-500.0, -10.0, -10.0, 0.0]), "lies outside the yield surface"),
        (given([100.0, 100.0, 100.0, 0.0]), "lies outside the yield surface"),
        (level_ground("3d", "linear", ground=1.7), "lies above the ground"),
        (level_ground("3d", "linear", K0=0.0), r"K0.*must be greater than zero"),
        (level_ground("3d", "linear", K0=9.0, surcharge=100.0), "lies outside the yield surface"),
        (level_ground("3d", "linear", surcharge=-1.0), r"surcharge.*must not be negative"),
        ({**level_ground("3d", "linear"), "loads": []}, "no body force acts at time 0"),
    ],
)  # fmt: skip
def test_wrong_stress_is_refused(entries: dict[str, Any], message: str) -> None:
    with pytest.raises(BadInput, match=f"(?s){message}"):
        Simulation(Model.from_dict(entries))


def test_wrong_weight_is_refused() -> None:
    entries = level_ground("plane_strain", "linear")
    entries["loads"][0]["acceleration"] = [1.0, -5.0]
    with pytest.raises(BadInput, match="does not act downwards only"):
        Simulation(Model.from_dict(entries))
    entries["loads"][0] = weight("plane_strain", 5.0)  # it grows from zero
    with pytest.raises(BadInput, match="no body force acts at time 0"):
        Simulation(Model.from_dict(entries))


def test_one_stress_for_each_body() -> None:
    entries = level_ground("plane_strain", "linear")
    entries["initial"]["stress"] *= 2
    with pytest.raises(BadInput, match=r"has its stress from initial.stress\[0\] already"):
        Model.from_dict(entries)


def test_cam_clay_cannot_start_in_tension() -> None:
    entries = block_entries("plane_strain", "linear", "modified_cam_clay")
    entries["initial"] = initial_stress("plane_strain", "modified_cam_clay")["initial"]
    entries["initial"]["stress"][0]["stress"] = [10.0] * 3 + [0.0]
    with pytest.raises(BadInput, match="is not possible with this law"):
        Simulation(Model.from_dict(entries))
