# SPDX-License-Identifier: BSD-3-Clause
"""Thickness of shapes along vertical lines, against the test of what is inside them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth.arrays import Floats
from tilth.bodies.inside import inside_mesh, inside_of
from tilth.bodies.mesh import read_mesh
from tilth.bodies.request import Request
from tilth.bodies.thickness import Crossings, crossings_of, mesh_crossings
from tilth.grid.background import Grid
from tilth.model import Box, Circle, Cylinder, Polygon, Sphere

L_SHAPE = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]]
NOTCHED = [[0.0, 0.0], [4.0, 0.5], [3.5, 3.0], [1.0, 2.6], [3.0, 2.0], [2.5, 1.0], [0.3, 1.5]]

SHAPES: list[Any] = [
    Box(lower=[0.3, -0.2], upper=[2.1, 1.4]),
    Box(lower=[0.3, -0.2], upper=[2.1, 1.4], angle=33.0),
    Box(lower=[0.3, -0.2], upper=[2.1, 1.4], angle=90.0),
    Polygon(vertices=L_SHAPE),
    Polygon(vertices=NOTCHED),
    Polygon(vertices=NOTCHED[::-1]),
    Circle(centre=[1.0, 0.4], radius=0.9),
    Box(lower=[0.3, -0.2, 0.1], upper=[2.1, 1.4, 0.7]),
    Box(lower=[0.3, -0.2, 0.1], upper=[2.1, 1.4, 0.7], angle=25.0, axis="x"),
    Box(lower=[0.3, -0.2, 0.1], upper=[2.1, 1.4, 0.7], angle=25.0, axis="z"),
    *(
        Cylinder(centre=[0.5, 0.3, 0.2], radius=1.2, axis=axis, height=1.5, **more)
        for axis, sides in (("x", ["y+", "z-"]), ("y", ["x-", "z+"]), ("z", ["x+", "y-"]))
        for more in ({}, {"inner_radius": 0.7}, {"inner_radius": 0.7, "sides": sides})
    ),
    *(
        Sphere(centre=[0.5, 0.3, 0.2], radius=1.2, **more)
        for more in (
            {}, {"inner_radius": 0.7}, {"sides": ["z+"]},
            {"inner_radius": 0.5, "sides": ["z-", "x+"]},
        )
    ),
]  # fmt: skip


def lines(dim: int, count: int = 80) -> Floats:
    """Horizontal places around the shapes."""
    return np.random.default_rng(3).uniform(-0.9, 3.2, (count, dim - 1))


def counted(inside: Any, place: Floats, low: float, high: float) -> Floats:
    """Thickness by counting the places inside on each line, to (high - low) / 10000."""
    height = low + (np.arange(10_000) + 0.5) * (high - low) / 10_000
    found = []
    for each in place:
        line = np.column_stack([np.tile(each, (len(height), 1)), height])
        found.append(inside(line).mean() * (high - low))
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("low", "high"), [(-2.0, 3.5), (0.05, 0.45)])
def test_thickness_is_what_is_inside(shape: Any, low: float, high: float) -> None:
    place = lines(3 if len(shape.bounds()[0]) == 3 else 2)
    found = crossings_of(shape, place).thickness(
        np.full(len(place), low), np.full(len(place), high)
    )
    expected = counted(inside_of(shape), place, low, high)
    assert expected.max() > 0.05
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3)


def test_a_line_without_the_shape_has_no_crossing() -> None:
    found = crossings_of(Polygon(vertices=L_SHAPE), np.array([[0.5], [5.0], [2.0]]))
    np.testing.assert_array_equal(found.hit(), [0, 2])
    thickness = found.thickness(np.full(3, -1.0), np.full(3, np.inf))
    np.testing.assert_allclose(thickness, [2.0, 0.0, 1.0], rtol=1e-14)


def test_a_line_through_a_corner_counts_once() -> None:
    """On a vertical side the outline is that of one of the two sides, never both or none."""
    found = crossings_of(Polygon(vertices=L_SHAPE), np.array([[1.0]]))
    assert found.thickness(np.array([-1.0]), np.array([3.0]))[0] in (1.0, 2.0)


TRIANGLES = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
6
1 0 0 0
2 2 0 0
3 4 0 0
4 0 1 0
5 2 2 0
6 4 1 0
$EndNodes
$Elements
3
1 3 2 1 1 1 2 5 4
2 2 2 1 1 2 3 6
3 2 2 1 1 2 6 5
$EndElements
"""

HEXAHEDRA = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
12
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0 0 1
6 1 0 2
7 1 1 2
8 0 1 1
9 2 0 0
10 2 1 0
11 2 0 3
12 2 1 3
$EndNodes
$Elements
2
1 5 2 1 1 1 2 3 4 5 6 7 8
2 5 2 1 1 2 9 10 3 6 11 12 7
$EndElements
"""


def in_mesh(text: str, folder: Path, dim: int, place: Floats) -> tuple[Crossings, Any]:
    file = folder / "body.msh"
    file.write_text(text)
    request = Request("body", False, Grid(np.zeros(dim), np.ones(dim)), spacing=np.ones(dim))
    blocks = read_mesh(file, dim, request)
    return mesh_crossings(blocks, place), inside_mesh(blocks)


def test_thickness_of_a_mesh_in_the_plane(tmp_path: Path) -> None:
    place = np.array([[0.0], [1.0], [2.0], [3.0], [0.37], [3.21], [5.0]])
    found, _ = in_mesh(TRIANGLES, tmp_path, 2, place)
    thickness = found.thickness(np.full(7, -1.0), np.full(7, np.inf))
    expected = np.interp(place[:, 0], [0.0, 2.0, 4.0], [1.0, 2.0, 1.0], right=0.0)
    np.testing.assert_allclose(thickness, expected, rtol=1e-14)


def test_thickness_of_a_mesh_in_space(tmp_path: Path) -> None:
    """Also on lines through the edges between the tetrahedra into which bricks are divided."""
    place = np.array([[0.5, 0.5], [0.25, 0.25], [1.0, 0.5], [1.3, 0.9], [1.5, 0.5], [3.0, 0.5]])
    found, _ = in_mesh(HEXAHEDRA, tmp_path, 3, place)
    thickness = found.thickness(np.full(6, -1.0), np.full(6, np.inf))
    expected = np.where(place[:, 0] <= 2.0, 1.0 + place[:, 0], 0.0)
    np.testing.assert_allclose(thickness, expected, rtol=0, atol=1e-8)
    low = found.thickness(np.full(6, 0.5), np.full(6, 1.2))
    np.testing.assert_allclose(low[:-1], 0.7, atol=1e-8)
