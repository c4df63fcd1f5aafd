# SPDX-License-Identifier: BSD-3-Clause
"""Holes in shapes of the plane: points, volume, outline, thickness, size, wrong ones."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries

from tilth.bodies.discretise import discretise, inside_body
from tilth.bodies.size import body_size
from tilth.bodies.thickness import crossings_of
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Box, Circle, Model, Polygon
from tilth.model.shapes import DeclaredShape
from tilth.surface.outline import outline

GRID = Grid(np.zeros(2), np.full(2, 0.5))
ROUND = {"type": "circle", "centre": [4.0, 3.0], "radius": 1.0}
TRIANGLE = {"type": "polygon", "vertices": [[7, 1], [7, 3], [9, 1]]}
TURNED = {"type": "box", "lower": [8.0, 4.0], "upper": [9.0, 4.5], "angle": 30.0}
HOLES = [ROUND, TRIANGLE, TURNED]
HOLES_AREA = math.pi + 2.0 + 0.5
SHAPES: list[tuple[DeclaredShape, float]] = [
    (Polygon(vertices=[[1, 0], [11, 0], [11, 6], [1, 6]], holes=HOLES), 60.0 - HOLES_AREA),  # type: ignore[arg-type]
    (Box(lower=[1, 0], upper=[11, 6], holes=HOLES), 60.0 - HOLES_AREA),  # type: ignore[arg-type]
    (Circle(centre=[6, 3], radius=5, holes=HOLES), 25.0 * math.pi - HOLES_AREA),  # type: ignore[arg-type]
]
SAME = {"ids": lambda case: type(case[0]).__name__}


def body(shape: Any, basis: str = "gimp") -> Body:
    return Body(name="soil", material="soil", shape=shape, basis=basis, points_per_cell=4)  # type: ignore[arg-type]


def in_a_hole(x: np.ndarray) -> np.ndarray:
    """Whether positions are in one of the three holes, by their definitions."""
    u, v = (x - [8.0, 4.0]) @ [math.cos(math.pi / 6), math.sin(math.pi / 6)], (x - [8.0, 4.0]) @ [
        -math.sin(math.pi / 6), math.cos(math.pi / 6)
    ]  # fmt: skip
    disc = np.hypot(x[:, 0] - 4.0, x[:, 1] - 3.0) < 1.0 - 1e-6
    triangle = (x[:, 0] > 7 + 1e-6) & (x[:, 1] > 1 + 1e-6) & (x.sum(axis=1) < 10 - 1e-6)
    return disc | triangle | ((u > 0) & (u < 1) & (v > 0) & (v < 0.5))


@pytest.mark.parametrize("case", SHAPES, **SAME)
@pytest.mark.parametrize("basis", ["gimp", "cpdi2"])
def test_points_fill_the_shape_without_its_holes(
    case: tuple[DeclaredShape, float], basis: str
) -> None:
    shape, area = case
    found = discretise(body(shape, basis), "plane_strain", GRID)
    assert math.fsum(found.volume) == pytest.approx(area, rel=1e-14)
    assert shape.measure() == pytest.approx(area, rel=1e-14)
    filled = discretise(
        body(shape.model_copy(update={"holes": ()}), basis), "plane_strain", GRID
    ).position
    np.testing.assert_array_equal(found.position, filled[~in_a_hole(filled)])
    assert found.volume == pytest.approx(0.125**2, rel=0.05)


def test_the_volume_in_axisymmetry_is_that_of_the_rings() -> None:
    """By Pappus: the area of each hole goes around at the radius of its centroid."""
    shape, _ = SHAPES[0]
    found = discretise(body(shape), "axisymmetric", GRID)
    centre = np.array([8.0, 4.0]) + 0.5 * np.array([math.cos(math.pi / 6), math.sin(math.pi / 6)])
    centre += 0.25 * np.array([-math.sin(math.pi / 6), math.cos(math.pi / 6)])
    moment = 60.0 * 6.0 - math.pi * 4.0 - 2.0 * (23.0 / 3.0) - 0.5 * centre[0]
    assert math.fsum(found.volume) == pytest.approx(2.0 * math.pi * moment, rel=1e-13)


def test_a_point_on_the_outline_of_a_hole_stays() -> None:
    """As on the outer outline, on all sides: the hole has the cells 2 to 4 without their edges."""
    hole = {"type": "polygon", "vertices": [[1.25, 1.25], [3.25, 1.25], [3.25, 3.25], [1.25, 3.25]]}
    shape = Box(lower=[0, 0], upper=[5, 5], holes=[hole])  # type: ignore[list-item]
    soil = body(shape).model_copy(update={"points_per_cell": 1})
    found = discretise(soil, "plane_strain", GRID).position  # centres 0.25, 0.75, ...
    inner = (np.abs(found - 2.25) < 1.0 + 1e-9).all(axis=1)
    assert inner.sum() == 5 * 5 - 3 * 3
    np.testing.assert_allclose(found[inner].mean(axis=0), 2.25)


@pytest.mark.parametrize("case", SHAPES, **SAME)
def test_what_is_inside_has_the_area_and_thickness_of_the_shape(
    case: tuple[DeclaredShape, float],
) -> None:
    shape, area = case
    side = np.linspace(0.0, 12.0, 601)[:-1] + 0.01
    x, y = np.meshgrid(side, side[:300], indexing="ij")
    place = np.column_stack([x.ravel(), y.ravel()])
    inside = inside_body(body(shape), "plane_strain", GRID)(place)
    assert not (inside & in_a_hole(place)).any()
    height = side[:, None]
    thickness = crossings_of(shape, height).thickness(np.full(600, -9.0), np.full(600, 99.0))
    if not isinstance(shape, Circle):  # which reaches above the sampled places
        assert inside.mean() * 72.0 == pytest.approx(area, abs=0.05)
        np.testing.assert_allclose(inside.reshape(600, 300).sum(axis=1) * 0.02, thickness, atol=0.1)
    assert thickness.sum() * 0.02 == pytest.approx(area, abs=0.02)


@pytest.mark.parametrize("case", SHAPES, **SAME)
def test_the_outline_has_a_clockwise_chain_around_each_hole(
    case: tuple[DeclaredShape, float],
) -> None:
    """The soil is on its left: areas of the chains, with their signs, sum to that of the shape."""
    shape, area = case
    chains = outline(body(shape), "plane_strain", [0.5, 0.5], spacing=0.02)
    areas = []
    for chain in chains:
        assert chain.closed
        (x, y), (u, v) = chain.points.T, np.roll(chain.points, -1, axis=0).T
        areas.append(0.5 * float((x * v - y * u).sum()))
    assert [math.copysign(1.0, each) for each in areas] == [1.0, -1.0, -1.0, -1.0]
    assert sum(areas) == pytest.approx(area, rel=1e-3)
    assert chains[2].corner.sum() == 3
    assert chains[3].corner.sum() == 4


def test_the_estimated_size_is_without_the_holes() -> None:
    shape, area = SHAPES[0]
    size = body_size(body(shape), "plane_strain", GRID)
    assert size.points == pytest.approx(area / 0.125**2)


WRONG: list[tuple[list[Any], str, str]] = [
    ([{**ROUND, "radius": 3.0}], "holes[0]", "is not wholly inside the shape, but reaches from "),
    ([{**ROUND, "centre": [1.5, 3.0]}], "holes[0]", "is not wholly inside the shape"),
    ([{**ROUND, "centre": [30.0, 3.0]}], "holes[0]", "is not wholly inside the shape"),
    ([{"type": "box", "lower": [0, -1], "upper": [12, 7]}], "holes[0]", "is not wholly inside"),
    ([ROUND, {**ROUND, "centre": [5.0, 3.0]}], "holes[1]", "touches or overlaps holes[0]"),
    ([ROUND, {**ROUND, "radius": 0.5}], "holes[1]", "touches or overlaps holes[0]"),
    ([TRIANGLE, {**ROUND, "centre": [7.3, 1.3], "radius": 0.1}], "holes[1]", "touches or overlaps"),
    ([TRIANGLE, {"type": "box", "lower": [7.5, 1.5], "upper": [10, 3]}], "holes[1]", "touches or"),
    ([TRIANGLE, {"type": "box", "lower": [6, 0.5], "upper": [10, 4]}], "holes[1]", "touches or"),
    ([{**ROUND, "holes": [{**ROUND, "radius": 0.5}]}], "holes[0].holes", "a hole has no holes"),
    ([{**ROUND, "centre": [4, 3, 0]}], "holes[0].centre", "must have two coordinates"),
    (
        [{"type": "sphere", "centre": [4, 3, 0], "radius": 1}],
        "holes[0].type",
        "a sphere is no hole in 2D",
    ),
    ([{"centre": [4, 3], "radius": 1}], "holes[0].type", "missing"),
]


@pytest.mark.parametrize(("holes", "key", "problem"), WRONG)
def test_a_wrong_hole_is_refused(holes: list[Any], key: str, problem: str) -> None:
    with pytest.raises(BadInput) as error:
        Polygon(vertices=[[1, 0], [11, 0], [11, 6], [1, 6]], holes=holes)
    assert f"Polygon.{key}" in str(error.value)
    assert problem in str(error.value)


def test_a_circle_is_no_hole_in_space() -> None:
    with pytest.raises(BadInput, match=r"holes\[0\].type: a circle is no hole in 3D"):
        Box(lower=[0, 0, 0], upper=[9, 9, 9], holes=[ROUND])  # type: ignore[list-item]


def test_a_hole_that_no_point_falls_in_is_refused() -> None:
    hole = {**ROUND, "radius": 0.01}
    shape = Box(lower=[0, 0], upper=[10, 10], holes=[hole])  # type: ignore[list-item]
    with pytest.raises(BadInput, match=r'bodies "soil".shape.holes\[0\]: no material point lies'):
        discretise(body(shape), "plane_strain", GRID)


def test_a_hole_beyond_the_axis_is_refused() -> None:
    """The half of a ball at r < 0 is not there, and so no hole can be in it."""
    entries = block_entries("axisymmetric", "gimp", "hencky_elastic")
    hole = {"type": "circle", "centre": [-0.5, 1.0], "radius": 0.2}
    ball = {"type": "circle", "centre": [0.0, 1.0], "radius": 1.0, "holes": [hole]}
    entries["bodies"][0]["shape"] = ball
    with pytest.raises(BadInput, match=r"bodies\[0\].shape.holes\[0\].*x = -0.7, beyond the axis"):
        Model.from_dict(entries)
