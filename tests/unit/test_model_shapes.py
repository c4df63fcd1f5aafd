# SPDX-License-Identifier: BSD-3-Clause
"""Axes and bounding boxes of the shapes, and shapes that are refused."""

import math

import numpy as np
import pytest

from tilth.errors import BadInput
from tilth.model import Box, Circle, Cylinder, Polygon, Sphere


def test_a_quarter_turn_is_exact() -> None:
    box = Box(lower=[1, 1], upper=[3, 2], angle=90)
    assert box.axes == ((0.0, 1.0), (-1.0, 0.0))
    assert box.bounds() == ((0.0, 1.0), (1.0, 3.0))


@pytest.mark.parametrize("axis", ["x", "y", "z"])
@pytest.mark.parametrize("angle", [0.0, 30.0, -130.0, 415.0])
def test_the_axes_of_a_rotated_box_are_those_of_rodrigues(axis: str, angle: float) -> None:
    direction = np.eye(3)["xyz".index(axis)]
    spin = np.cross(np.eye(3), direction)  # spin @ v = direction x v
    theta = math.radians(angle)
    rotation = np.eye(3) + math.sin(theta) * spin + (1 - math.cos(theta)) * spin @ spin
    box = Box(lower=[0, 0, 0], upper=[1, 2, 3], angle=angle, axis=axis)
    np.testing.assert_allclose(np.array(box.axes).T, rotation, rtol=0, atol=1e-15)
    corners = [rotation @ (i, 2 * j, 3 * k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    lower, upper = box.bounds()
    assert lower == pytest.approx(np.min(corners, axis=0), abs=1e-14)
    assert upper == pytest.approx(np.max(corners, axis=0), abs=1e-14)


def test_bounding_boxes() -> None:
    assert Circle(centre=[1, 2], radius=0.5).bounds() == ((0.5, 1.5), (1.5, 2.5))
    assert Sphere(centre=[0, 0, 1], radius=1).bounds() == ((-1, -1, 0), (1, 1, 2))
    cylinder = Cylinder(centre=[0, 0, 1], radius=1, axis="y", height=3)
    assert cylinder.bounds() == ((-1, 0, 0), (1, 3, 2))
    assert Polygon(vertices=[[0, 0], [2, 1], [1, 3]]).bounds() == ((0, 0), (2, 3))
    octant = Sphere(centre=[0, 0, 1], radius=2, inner_radius=1, sides=["x+", "z-"])
    assert octant.bounds() == ((0, -2, -1), (2, 2, 1))
    half = Cylinder(centre=[0, 0, 1], radius=1, axis="y", height=3, sides=["z+"])
    assert half.bounds() == ((-1, 0, 1), (1, 3, 2))


@pytest.mark.parametrize(
    ("entries", "problem"),
    [
        ({"inner_radius": 2.0}, r"inner_radius = 2\.0: is not below `radius` = 2"),
        ({"inner_radius": 0.0}, "greater than zero"),
        ({"sides": ["x+", "x-"]}, "names both sides of an axis"),
        ({"sides": ["x+", "x+"]}, "twice"),
        ({"sides": ["r+"]}, "sides"),
    ],
)
def test_shells_and_tubes_that_are_none(entries: dict[str, object], problem: str) -> None:
    with pytest.raises(BadInput, match=problem):
        Sphere(centre=[0, 0, 0], radius=2, **entries)
    with pytest.raises(BadInput, match=problem):
        Cylinder(centre=[0, 0, 0], radius=2, axis="z", height=1, **entries)


def test_a_cylinder_is_cut_along_its_axis_only() -> None:
    with pytest.raises(BadInput, match=r"z\+ is along the axis"):
        Cylinder(centre=[0, 0, 0], radius=2, axis="z", height=1, sides=["x+", "z+"])


@pytest.mark.parametrize("sense", [1, -1])
def test_area_of_a_polygon_in_either_sense(sense: int) -> None:
    ell = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]][::sense]
    assert Polygon(vertices=[[x + 1e3, y] for x, y in ell]).area == 4.0


@pytest.mark.parametrize(
    ("vertices", "problem"),
    [
        ([[0, 0], [1, 0]], "at least three"),
        ([[0, 0], [1, 0], [2, 0]], "no area"),
        ([[0, 0], [2, 2], [2, 0], [0, 1]], "intersect each other"),
        ([[0, 0], [1, 0], [1, 0], [1, 1]], "intersect each other"),
        ([[0, 0], [2, 0], [1, 0], [1, 1]], "intersect each other"),
        ([[0, 0], [1, 0], [1, 1], [0, 0]], "intersect each other"),
        ([[0, 0, 0], [1, 0, 0], [1, 1, 0]], "two coordinates"),
    ],
)
def test_polygons_that_enclose_no_body(vertices: list[list[float]], problem: str) -> None:
    with pytest.raises(BadInput, match=problem):
        Polygon(vertices=vertices)


def test_boxes_without_extent() -> None:
    with pytest.raises(BadInput, match=r"Box\.upper = \[1\.0, 0\.0\]"):
        Box(lower=[0, 0], upper=[1, 0])
    with pytest.raises(BadInput, match="2 components, but `upper` has 3"):
        Box(lower=[0, 0], upper=[1, 1, 1])
