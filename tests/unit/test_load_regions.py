# SPDX-License-Identifier: BSD-3-Clause
"""Loads on a part of a surface: regions in plan in 3D, rings in axisymmetry, the order of ends."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from balances import blocks_at
from small_problems import affine, block_entries

from tilth import BadInput, Model, check
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import Region
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.solvers.system import LinearSystem
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.terms.balance import Balance

PRESSURE = 3.0
ELL = [[0.3, 0.2], [1.7, 0.4], [1.6, 0.9], [0.8, 0.8], [0.7, 1.9], [0.2, 1.8]]
REGIONS: dict[str, dict[str, Any]] = {
    "rectangle": {"lower": [0.31, 0.22], "upper": [1.43, 1.71]},
    "circle": {"centre": [0.9, 1.1], "radius": 0.73},
    "polygon": {"vertices": ELL},
    "polygon, clockwise": {"vertices": ELL[::-1]},
    "whole": {"lower": [0.0, 0.0], "upper": [2.0, 2.0]},
}
BENT = np.array([[1.4, 0.3, 0.1], [-0.2, 0.9, 0.15], [0.1, -0.1, 1.1]])


def solid(load: dict[str, Any], **changed: Any) -> dict[str, Any]:
    entries = block_entries("3d", "linear", **changed)
    entries["bodies"][0]["surface"] = {"spacing": 0.4}
    entries["grid"]["origin"] = [0.13, 0.27, 0.0]
    entries["loads"] = [{"type": "surface", "body": "block", **load}]
    return entries


def on_first_step(simulation: Simulation) -> tuple[SurfaceLoads, ActiveGrid]:
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    model = simulation.setup.model
    loads = SurfaceLoads(
        declared_loads(model), model.analysis.kind, simulation.state.surfaces, active, 0.0, 1.0
    )
    return loads, active


def resultant(simulation: Simulation) -> tuple[Floats, Floats]:
    """Sum of the nodal forces and their moments x_i f_j about the origin."""
    loads, active = on_first_step(simulation)
    force = loads.force(np.zeros((active.nodes, active.grid.dim)))
    return force.sum(axis=0), np.einsum("ni,nj->ij", active.position, force)


def moments_of(region: Region) -> tuple[float, Floats]:
    """Area and centroid of a polygon (Green's theorem)."""
    x, y = np.array(region.corners()).T
    cross = x * np.roll(y, -1) - y * np.roll(x, -1)
    both = np.stack([(x + np.roll(x, -1)) @ cross, (y + np.roll(y, -1)) @ cross])
    return 0.5 * abs(cross.sum()), both / (3.0 * cross.sum())


@pytest.mark.parametrize("name", REGIONS)
def test_pressure_in_a_region_has_its_force_and_moment(name: str) -> None:
    region = Region(**REGIONS[name])
    area, centroid = moments_of(region)
    if region.radius is not None:
        assert area == pytest.approx(np.pi * region.radius**2, rel=1e-14)
        np.testing.assert_allclose(centroid, region.centre, rtol=1e-13)
    load = {"pressure": PRESSURE, "within": REGIONS[name]}
    force, moment = resultant(Simulation(Model.from_dict(solid(load))))
    np.testing.assert_allclose(force, [0.0, 0.0, -PRESSURE * area], atol=1e-12)
    place = np.array([*centroid, 2.0])
    np.testing.assert_allclose(moment, np.outer(place, force), atol=1e-12)


@pytest.mark.parametrize("name", REGIONS)
@pytest.mark.parametrize("follower", [True, False])
def test_it_moves_with_the_soil(name: str, follower: bool) -> None:
    """An affine motion, so long that triangles are divided: n da = cof(F) N dA."""
    load = {"pressure": PRESSURE, "within": REGIONS[name], "follower": follower}
    bent = BENT @ np.diag([2.0, 1.0, 1.0])
    entries = solid(load, boundaries=[affine(bent)], schedule={"steps": 4})
    simulation = Simulation(Model.from_dict(entries))
    triangles = len(simulation.state.surfaces["block"].shape().cells)
    for k in range(4):
        simulation.advance(k / 4, (k + 1) / 4)
    assert len(simulation.state.surfaces["block"].shape().cells) > 1.2 * triangles
    area, centroid = moments_of(Region(**REGIONS[name]))
    cofactor = np.linalg.det(bent) * np.linalg.inv(bent).T if follower else np.eye(3)
    force, moment = resultant(simulation)
    expected = -PRESSURE * area * cofactor[:, 2]
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-11)
    place = bent @ [*centroid, 2.0]
    np.testing.assert_allclose(moment, np.outer(place, force), atol=1e-10)


@pytest.mark.parametrize("more", [{}, {"traction": [1.0, -2.0, 0.5]},
                                  {"hydrostatic": {"level": 2.4, "unit_weight": 5.0}}])  # fmt: skip
def test_derivative_against_differences(more: dict[str, Any]) -> None:
    load = {"pressure": PRESSURE, "within": REGIONS["polygon"], **more}
    loads, active = on_first_step(Simulation(Model.from_dict(solid(load))))
    random = np.random.default_rng(4)
    u, direction = (random.normal(size=(active.nodes, 3)) for _ in range(2))
    u *= 0.03
    ahead, behind = (loads.force(u + sign * 1e-5 * direction) for sign in (1.0, -1.0))
    balance = Balance(active, [loads])
    system = LinearSystem(balance.active, np.zeros(u.shape, dtype=bool))
    system.blocks[:] = blocks_at(balance, u)
    expected = (behind - ahead) / 2e-5
    scale = np.abs(loads.force(u)).max()
    np.testing.assert_allclose(system.times(direction), expected, rtol=0, atol=1e-7 * scale)


def test_on_a_sphere_the_vertical_force_is_that_on_the_plan() -> None:
    load = {"pressure": PRESSURE, "within": {"centre": [0.1, -0.2], "radius": 0.6}}
    entries = solid(load)
    entries["bodies"][0]["shape"] = {"type": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1.3}
    force, _ = resultant(Simulation(Model.from_dict(entries)))
    assert force[2] == pytest.approx(-PRESSURE * np.pi * 0.6**2, rel=1e-12)


def test_only_what_lies_on_the_soil_is_loaded() -> None:
    """A circle round an edge of the block, as with a plane of symmetry: half of it."""
    load = {"pressure": PRESSURE, "within": {"centre": [0.0, 1.0], "radius": 0.5}}
    force, _ = resultant(Simulation(Model.from_dict(solid(load))))
    assert force[2] == pytest.approx(-0.5 * PRESSURE * np.pi * 0.5**2, rel=1e-12)


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ({"within": {}}, "says nothing of the region"),
        ({"within": {"lower": [0, 0]}}, "loads[0].within.upper: missing"),
        ({"within": {"radius": 1}}, "loads[0].within.centre: missing"),
        ({"within": {"centre": [1, 1], "radius": 1, "vertices": ELL}}, "is given with `centre`"),
        ({"within": {"centre": [1, 1], "radius": 0}}, "must be greater than zero"),
        ({"within": {"centre": [1, 1, 1], "radius": 1}}, "must have the two components"),
        ({"within": {"lower": [1, 1], "upper": [0, 2]}}, "x is not greater than that of `lower`"),
        ({"within": {"vertices": [[0, 0], [1, 1]]}}, "needs at least three"),
        ({"within": {"vertices": [[0, 0], [1, 1], [1, 0], [0, 2]]}}, "edges intersect"),
        ({"within": {"vertices": [[0, 0], [1, 1], [2, 2]]}}, "encloses no area"),
        ({"within": {"centre": [1, 1], "radius": 1e10}}, "loads[0].within.radius = 1"),
        ({"within": {"centre": [9, 9], "radius": 1}}, "no surface of the body 'block' lies"),
        ({"within": {"centre": [1, 1], "radius": 1}, "part": "x+"}, "no surface 'x+' of the body"),
        ({"within": {"centre": [1, 1], "radius": 1}, "start": [0, 0], "end": [1, 1]},
         "is given with `start`"),
    ],
)  # fmt: skip
def test_regions_that_are_none_are_refused(load: dict[str, Any], words: str) -> None:
    with pytest.raises(BadInput) as caught:
        Simulation(Model.from_dict(solid({"pressure": 1.0, **load})))
    assert words in str(caught.value)


def test_surfaces_above_each_other_are_refused_unless_one_is_named() -> None:
    load = {"pressure": PRESSURE, "within": {"centre": [0.0, 0.0], "radius": 0.3}}
    entries = solid(load)
    entries["bodies"][0]["shape"] = {
        "type": "sphere", "centre": [0.0, 0.0, 0.0], "radius": 1.6, "inner_radius": 0.8,
    }  # fmt: skip
    with pytest.raises(BadInput, match="lie above each other"):
        Simulation(Model.from_dict(entries))
    entries["loads"][0]["part"] = "outer"
    force, _ = resultant(Simulation(Model.from_dict(entries)))
    assert force[2] == pytest.approx(-PRESSURE * np.pi * 0.3**2, rel=1e-12)


def test_a_part_that_faces_downwards_is_loaded_from_below() -> None:
    load = {"pressure": PRESSURE, "within": REGIONS["rectangle"], "part": "z-"}
    force, _ = resultant(Simulation(Model.from_dict(solid(load))))
    np.testing.assert_allclose(force, [0.0, 0.0, PRESSURE * 1.12 * 1.49], rtol=0, atol=1e-12)


def test_region_is_for_3d() -> None:
    entries = block_entries("plane_strain", "linear")
    entries["bodies"][0]["surface"] = {}
    within = {"centre": [1, 1], "radius": 1}
    entries["loads"] = [{"type": "surface", "body": "block", "pressure": 1.0, "within": within}]
    with pytest.raises(BadInput, match="is for surfaces in 3D"):
        Model.from_dict(entries)


@pytest.mark.parametrize(("inner", "outer"), [(0.0, 0.77), (0.61, 1.37), (0.5, 2.0)])
def test_a_stretch_is_a_ring_in_axisymmetry(inner: float, outer: float) -> None:
    """The force on the full circle is the pressure times pi (b^2 - a^2)."""
    entries = block_entries("axisymmetric", "linear")
    entries["bodies"][0]["surface"] = {}
    entries["grid"]["origin"] = [0.0, 0.31]
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": PRESSURE, "start": [outer, 2.0],
         "end": [inner, 2.0]}
    ]  # fmt: skip
    force, _ = resultant(Simulation(Model.from_dict(entries)))
    assert force[1] == pytest.approx(-PRESSURE * np.pi * (outer**2 - inner**2), rel=1e-12)


@pytest.mark.parametrize("right", [True, False])
def test_exchanged_ends_are_named(right: bool) -> None:
    """From the left to the right end the stretch is the rest of the outline: 6.5 of 8."""
    ends = [[1.75, 2.0], [0.25, 2.0]]
    start, end = ends if right else ends[::-1]
    entries = block_entries("plane_strain", "linear")
    entries["boundaries"] = [
        {"type": "plane", "name": "base", "axis": "y", "at": 0.0, "condition": "fixed"}
    ]
    entries["bodies"][0]["surface"] = {}
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": 1.0, "start": start, "end": end}
    ]
    found = [text for text in check(Model.from_dict(entries)).warnings if "loads[0]" in text]
    if right:
        assert not found
    else:
        assert "acts on 81 % of the closed outline of 'block'" in found[0]
        assert "exchange `start` and `end`" in found[0]
