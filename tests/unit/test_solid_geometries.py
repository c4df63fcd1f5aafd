# SPDX-License-Identifier: BSD-3-Clause
"""Geometries that are pressed into soil: cones, plates, thin plates and several shapes as one."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from implicit_entries import BLADE, CONE, PLATE, WEDGE, boundary, entries

from tilth.arrays import Floats
from tilth.geometry.both_sides import BothSides
from tilth.geometry.box import Box
from tilth.geometry.cone import Cone
from tilth.geometry.footing import Footing
from tilth.geometry.make import make_geometry, make_shapes
from tilth.geometry.polyline import Polyline
from tilth.geometry.protocol import Geometry, QuadraturePoints
from tilth.geometry.quadrature import make_quadrature
from tilth.geometry.round import Circle
from tilth.geometry.several import outside_of_others
from tilth.grid.background import Grid
from tilth.model import Model

RADIUS, TIP, SHAFT = 0.4, 0.5, 0.7
SLANT = math.hypot(RADIUS, TIP)


def made(geometry: dict[str, Any], kind: str, **entry: Any) -> Geometry:
    """The geometry of a boundary as a case file declares it."""
    given = boundary(geometry, **entry)
    model = Model.from_dict(entries(given, kind=kind))
    return make_geometry(model.boundaries[0], model)


def points_of(geometry: Geometry, size: float, cell: float = 10.0) -> QuadraturePoints:
    """Quadrature points on a grid with large cells, so that only the facets' size counts."""
    dim = geometry.dim
    box = np.full(dim, -2.0), np.full(dim, 2.0)
    return make_quadrature(geometry, *box, Grid(np.full(dim, 0.037), np.full(dim, cell)), size)


@pytest.mark.parametrize("axis", [[0.0, 0.0, 1.0], [0.3, -0.5, 0.8]])
def test_areas_of_a_cone_and_its_shaft_converge_at_fourth_order(axis: list[float]) -> None:
    """pi R times the slant and 2 pi R times the length; a flat end is the polygon in its circle."""
    cone = Cone(np.array([0.1, -0.2, -0.6]), np.array(axis), RADIUS, TIP, SHAFT, inside=False)
    unit = np.array(axis) / np.linalg.norm(axis)
    errors = []
    for size in (0.05, 0.025):
        points = points_of(cone, size)
        along = points.normal @ unit
        tip, shaft, end = along < -0.1, np.abs(along) < 1e-9, along > 1.0 - 1e-9
        assert (tip | shaft | end).all()
        areas = np.array([points.weight[part].sum() for part in (tip, shaft, end)])
        errors.append(np.abs(areas[:2] / (math.pi * RADIUS * np.array([SLANT, 2 * SHAFT])) - 1.0))
        sectors = math.ceil(2.0 * math.pi * RADIUS / size)
        polygon = 0.5 * sectors * RADIUS**2 * math.sin(2.0 * math.pi / sectors)
        assert areas[2] == pytest.approx(polygon, rel=1e-12)
        np.testing.assert_allclose(cone.distance(points.position), 0.0, atol=1e-15)
    assert max(errors[1]) < 1e-6
    assert (np.log2(errors[0] / errors[1]) > 3.5).all()


def test_a_cone_is_pushed_up_by_the_water_that_it_displaces() -> None:
    """Archimedes: the resultant of the pressure -z on the closed surface is its volume, upwards."""
    cone = Cone(np.array([0.1, -0.2, -0.6]), np.array([0.3, -0.5, 0.8]), RADIUS, TIP, SHAFT, False)
    points = points_of(cone, 0.02)
    force = ((points.weight * points.position[:, 2])[:, None] * points.normal).sum(axis=0)
    volume = math.pi * RADIUS**2 * (TIP / 3.0 + SHAFT)
    np.testing.assert_allclose(force, [0.0, 0.0, volume], atol=1e-3 * volume)


@pytest.mark.parametrize(
    ("place", "distance"),
    [
        ([0.0, 0.4], 0.1),  # below the tip
        ([0.3 + 0.2, 1.2], 0.2),  # beside the shaft
        ([-0.3 - 0.2, 1.2], 0.2),
        ([0.0, 0.5 + 0.3 / math.tan(math.pi / 6) + 1.0 + 0.25], 0.25),  # above its end
        ([0.1, 1.2], -0.2),
        ([0.15 + 0.1 * math.cos(math.pi / 6), 0.5 + 0.15 * math.sqrt(3) - 0.05], 0.1),  # the cone
    ],
)
def test_distance_to_a_declared_cone(place: list[float], distance: float) -> None:
    """In the plane, in axisymmetry, and in 3D around the same axis."""
    for kind in ("plane_strain", "axisymmetric"):
        assert made(WEDGE, kind).distance(np.array([place]))[0] == pytest.approx(distance)
    upright = {**WEDGE, "tip": [0, 0, 0.5]}
    for angle in (0.0, 1.0, 4.0):
        x = [[place[0] * math.cos(angle), place[0] * math.sin(angle), place[1]]]
        assert made(upright, "3d").distance(np.array(x))[0] == pytest.approx(distance)
    inside = made({**upright, "soil": "inside"}, "3d")
    assert inside.distance(np.array([[place[0], 0.0, place[1]]]))[0] == pytest.approx(-distance)


def test_a_cone_of_180_degrees_is_a_flat_pile_in_any_direction() -> None:
    pile = made({**CONE, "angle": 180, "axis": [0, -2, 0], "tip": [0, 0, 0]}, "3d")
    x = np.array([[0.1, 0.05, 0.1], [0.1, -0.2, 0.0], [0.0, -0.45, 0.1], [0.0, -0.2, 0.5]])
    np.testing.assert_allclose(pile.distance(x), [0.05, -0.2, 0.05, 0.2])
    wedge = made({**WEDGE, "angle": 180, "axis": [1, 0], "tip": [0, 0]}, "plane_strain")
    x = np.array([[-0.1, 0.2], [0.5, 0.4], [0.5, 0.2], [1.2, -0.1]])
    np.testing.assert_allclose(wedge.distance(x), [0.1, 0.1, -0.1, 0.2])


def test_a_plate_with_a_thickness_is_a_turned_box() -> None:
    plate = made(PLATE, "plane_strain")
    normal, along = np.array([1.0, -2.0]) / math.sqrt(5.0), np.array([2.0, 1.0]) / math.sqrt(5.0)
    x = np.array([0.0, 2.0]) + np.array(
        [0.15 * normal, -0.25 * normal, 0.01 * normal, 0.35 * along, 0.28 * along + 0.09 * normal]
    )
    np.testing.assert_allclose(plate.distance(x), [0.1, 0.2, -0.04, 0.1, 0.05])
    assert points_of(plate, 0.1).weight.sum() == pytest.approx(2.0 * (0.5 + 0.1))
    blade = made(BLADE, "3d")
    assert points_of(blade, 0.1).weight.sum() == pytest.approx(2.0 * (0.1 + 0.05 + 0.02))
    assert blade.distance(np.array([[0.0, 0.0, 2.0]]))[0] == pytest.approx(-0.05)


@pytest.mark.parametrize(
    ("side", "area"),
    [
        (Footing([0.1, 0.2], [0.6, -0.8], [1.1]), 1.1),
        (Footing([0.1, 0.2, -0.1], [0.3, -0.5, 0.8], [1.1, 0.6], [1.0, 1.0, 0.0]), 0.66),
        (Polyline([[0, 0], [3, 4], [4, 4]], False, True), 6.0),
    ],
)
def test_a_thin_plate_has_two_sides(side: Geometry, area: float) -> None:
    thin = BothSides(side)
    points = points_of(thin, 0.1, cell=0.23)
    assert points.weight.sum() == pytest.approx(2.0 * area, rel=1e-13)
    np.testing.assert_allclose((points.weight[:, None] * points.normal).sum(axis=0), 0, atol=1e-14)
    x = np.random.default_rng(2).uniform(-1.0, 2.0, (300, thin.dim))
    np.testing.assert_array_equal(thin.distance(x), np.abs(side.distance(x)))
    foot = x - thin.distance(x)[:, None] * thin.gradient(x)
    np.testing.assert_allclose(thin.distance(foot), 0.0, atol=1e-14)
    for away in (1e-3, -1e-3):  # its normals point away from it on both sides
        first = side.facets(np.full(thin.dim, -2.0), np.full(thin.dim, 2.0), 0.1)
        beside = first.corner.mean(axis=1) + away * first.normal
        np.testing.assert_allclose(thin.gradient(beside), np.sign(away) * first.normal, atol=1e-9)


def test_facets_of_the_second_side_turn_the_other_way() -> None:
    thin = BothSides(Footing([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0]))
    facets = thin.facets(np.zeros(3), np.ones(3), 0.5)
    edges = facets.corner[:, 1:] - facets.corner[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    np.testing.assert_allclose(normal / np.linalg.norm(normal, axis=1)[:, None], facets.normal)
    assert len(np.unique(facets.group)) == len(facets.group)


def on_surface(shapes: list[Geometry], size: float = 0.02) -> tuple[Floats, Floats]:
    """Area and enclosed measure of several shapes as one body, by their quadrature points."""
    area, flux = 0.0, 0.0
    for number, shape in enumerate(shapes):
        points = points_of(shape, size)
        kept = points.of(outside_of_others(shapes, number, points.position, points.normal))
        area += kept.weight.sum()
        flux += (kept.weight[:, None] * kept.position * kept.normal).sum()
    return area, flux / shapes[0].dim


def square(lower: list[float], upper: list[float]) -> Box:
    return Box(np.array(lower), np.array(upper), np.eye(len(lower)), inside=False)


def test_what_lies_in_another_shape_is_no_surface() -> None:
    """Two circles whose centres are a radius apart: each keeps two thirds of its circumference."""
    circles = [Circle([x, 0.0], 1.0, inside=False) for x in (-0.5, 0.5)]
    area, measure = on_surface(circles)
    lens = 2.0 * math.pi / 3.0 - math.sqrt(3.0) / 2.0
    assert area == pytest.approx(8.0 * math.pi / 3.0, rel=0.01)
    assert measure == pytest.approx(2.0 * math.pi - lens, rel=0.01)


@pytest.mark.parametrize(
    ("first", "second", "area", "measure"),
    [
        (([-1, 0], [0, 1]), ([0, 0], [1, 1]), 6.0, 2.0),  # beside each other: a common face
        (([-1, 0], [0.5, 1]), ([-0.5, 0], [1, 1]), 6.0, 2.0),  # overlapping, flush at two faces
        (([-1, 0], [0, 1]), ([-1, 0], [0, 1]), 4.0, 1.0),  # the same twice
        (([-1, -1], [1, 0]), ([-0.3, 0], [0.3, 1]), 8.0, 2.6),  # a column on a footing
        (([-1, -1, 0], [1, 1, 1]), ([0, 0, 1], [0.5, 0.5, 1.5]), 17.0, 4.125),
    ],
)
def test_shapes_that_touch(first: Any, second: Any, area: float, measure: float) -> None:
    shapes: list[Geometry] = [square(*first), square(*second)]
    found = on_surface(shapes, 0.1)
    assert found == (pytest.approx(area, rel=1e-12), pytest.approx(measure, rel=1e-12))
    assert on_surface(shapes[::-1], 0.1) == pytest.approx(found)


def test_a_thin_skirt_hides_nothing() -> None:
    base = square([-1.0, 0.0], [1.0, 0.5])
    skirt = BothSides(Footing([-1.0, -0.5], [1.0, 0.0], [1.0]))
    assert on_surface([base, skirt], 0.1)[0] == pytest.approx(5.0 + 2.0, rel=1e-12)


def test_shapes_of_a_rigid_body_are_made_in_order() -> None:
    contact = {"normal": "unilateral", "tangential": "smooth"}
    skirt = {"type": "polyline", "vertices": [[0, 0], [0, 1]], "soil": "both"}
    body = {"name": "bucket", "geometries": [PLATE, skirt], "contact": contact, "centre": [0, 2]}
    held = {"displacement": {"x": 0, "y": -1}, "rotation": 0}
    model = Model.from_dict(entries(rigid_bodies=[{**body, **held}]))
    first, second = make_shapes(model.rigid_bodies[0], model)
    assert isinstance(first, Box)
    assert isinstance(second, BothSides)
    assert [key for key, _ in model.geometries()] == [
        "rigid_bodies[0].geometries[0]", "rigid_bodies[0].geometries[1]",
    ]  # fmt: skip
