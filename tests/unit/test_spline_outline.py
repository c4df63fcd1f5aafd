# SPDX-License-Identifier: BSD-3-Clause
"""Chains of boundary points along the outlines of bodies."""

import numpy as np
import pytest

from tilth.curves import LocalCubicSpline
from tilth.errors import BadInput
from tilth.model import Body, Box, Circle, Mesh, Polygon, Sphere
from tilth.surface.outline import outline

TRAPEZIUM = [[0.0, 0.0], [3.0, 0.0], [2.0, 1.0], [1.0, 1.0], [0.0, 1.0]]


def chains(shape, kind="plane_strain", cell=(0.5, 0.5), **options):
    body = Body(name="dam", material="clay", shape=shape, basis="linear", points_per_cell=2)
    return outline(body, kind, cell, **options)


def area(chain):
    return LocalCubicSpline(chain).area


def lengths(chain):
    return np.linalg.norm(chain.chord, axis=1)


@pytest.mark.parametrize("angle", [0.0, 30.0, 200.0])
def test_a_box_has_its_corners_and_even_sides(angle):
    shape = Box(lower=(1.0, 2.0), upper=(2.1, 2.5), angle=angle)
    (chain,) = chains(shape)
    assert chain.closed
    assert len(chain) == 2 * (5 + 2)  # half a cell is 0.25
    assert chain.corner.sum() == 4
    np.testing.assert_allclose(chain.points[0], [1.0, 2.0])
    np.testing.assert_allclose(lengths(chain), [0.22] * 5 + [0.25] * 2 + [0.22] * 5 + [0.25] * 2)
    np.testing.assert_allclose(area(chain), 0.55, rtol=1e-14)  # anticlockwise
    low, high = shape.bounds()
    np.testing.assert_allclose(chain.points.min(axis=0), low, atol=1e-15)
    np.testing.assert_allclose(chain.points.max(axis=0), high, atol=1e-15)


@pytest.mark.parametrize("way", [1, -1])
def test_a_polygon_goes_anticlockwise_whatever_its_vertices(way):
    (chain,) = chains(Polygon(vertices=TRAPEZIUM[::way]), spacing=0.3)
    np.testing.assert_allclose(area(chain), 2.5, rtol=1e-14)
    assert lengths(chain).max() < 0.3 * (1.0 + 1e-12)
    corners = chain.points[chain.corner]
    # the vertex on a straight side is no corner, but it is a point
    assert sorted(corners.tolist()) == sorted(v for v in TRAPEZIUM if v != [1.0, 1.0])
    assert [1.0, 1.0] in chain.points.tolist()


def test_a_circle_has_no_corners():
    (chain,) = chains(Circle(centre=(3.0, 1.0), radius=1.0))
    assert chain.closed
    assert not chain.corner.any()
    assert len(chain) == 26  # 2 pi / 0.25
    np.testing.assert_allclose(np.linalg.norm(chain.points - [3.0, 1.0], axis=1), 1.0)
    assert 0.0 < np.pi - area(chain) < 1e-4
    (small,) = chains(Circle(centre=(3.0, 1.0), radius=0.01))
    assert len(small) == 16


def test_a_ball_on_the_axis_is_half_a_circle():
    shape = Circle(centre=(0.0, 1.0), radius=2.0)
    (chain,) = chains(shape, "axisymmetric")
    assert not chain.closed
    np.testing.assert_allclose(chain.points[[0, -1]], [[0.0, -1.0], [0.0, 3.0]], atol=1e-15)
    assert (chain.points[1:-1, 0] > 0.0).all()
    np.testing.assert_allclose(np.linalg.norm(chain.points - [0.0, 1.0], axis=1), 2.0)
    spline = LocalCubicSpline(chain)
    normal = spline.normal(np.array([0, len(spline) - 1]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(normal, [[0.0, 1.0], [0.0, -1.0]], atol=1e-4)  # into the ball
    (torus,) = chains(Circle(centre=(2.5, 1.0), radius=2.0), "axisymmetric")
    assert torus.closed
    (plane,) = chains(shape)
    assert plane.closed


def test_the_axis_is_no_surface():
    (chain,) = chains(Box(lower=(0.0, 0.0), upper=(1.0, 2.0)), "axisymmetric")
    assert not chain.closed
    np.testing.assert_allclose(chain.points[[0, -1]], [[0.0, 0.0], [0.0, 2.0]])
    np.testing.assert_allclose(lengths(chain).sum(), 4.0)
    np.testing.assert_array_equal(chain.points[chain.corner], [[1.0, 0.0], [1.0, 2.0]])
    (away,) = chains(Box(lower=(0.5, 0.0), upper=(1.0, 2.0)), "axisymmetric")
    assert away.closed
    # a body with a notch at the axis has two pieces of surface
    notched = [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [0.0, 3.0], [0.0, 2.0], [1.0, 1.5], [0.0, 1.0]]
    outer, notch = chains(Polygon(vertices=notched), "axisymmetric")
    ends = [[0.0, 2.0], [0.0, 1.0], [0.0, 0.0], [0.0, 3.0]]
    found = np.concatenate([outer.points[[0, -1]], notch.points[[0, -1]]])
    np.testing.assert_allclose(found, ends)
    # one that touches the axis in a point only stays closed
    (tip,) = chains(Polygon(vertices=[[0.0, 1.0], [1.0, 0.5], [1.0, 1.5]]), "axisymmetric")
    assert tip.closed


def ring_mesh(path, sectors, flip=False):
    """A ring of quadrilaterals between the radii 1 and 2, some cut into triangles."""
    meshio = pytest.importorskip("meshio")
    angle = 2.0 * np.pi * np.arange(sectors) / sectors
    way = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    i = np.arange(sectors)
    j = (i + 1) % sectors
    quads = np.stack([i, i + sectors, j + sectors, j], axis=1)
    if flip:
        quads = quads[:, ::-1]
    cut = quads[: sectors // 2]
    triangles = np.concatenate([cut[:, [0, 1, 2]], cut[:, [0, 2, 3]]])
    cells = [("triangle", triangles), ("quad", quads[sectors // 2 :])]
    points = np.concatenate([way, 2.0 * way])
    meshio.Mesh(points, cells).write(path, file_format="gmsh22", binary=False)
    return Mesh(file=str(path))


@pytest.mark.parametrize("flip", [False, True])
def test_a_mesh_has_its_outer_edge_and_its_holes(tmp_path, flip):
    outer, hole = chains(ring_mesh(tmp_path / "ring.msh", 48, flip), cell=(9.0, 9.0))
    assert outer.closed
    assert hole.closed
    assert (len(outer), len(hole)) == (48, 48)
    assert not outer.corner.any()
    np.testing.assert_allclose([area(outer), area(hole)], [4.0 * np.pi, -np.pi], rtol=2e-6)
    outer, _ = chains(ring_mesh(tmp_path / "ring.msh", 48, flip), spacing=0.2)
    assert len(outer) == 96


def test_sharp_nodes_of_a_mesh_are_corners(tmp_path):
    coarse = ring_mesh(tmp_path / "ring.msh", 12)
    outer, hole = chains(coarse, cell=(9.0, 9.0))
    assert outer.corner.all()  # they turn by 30 degrees
    polygon = 6.0 * 2.0**2 * np.sin(np.pi / 6.0)
    np.testing.assert_allclose(area(outer), polygon, rtol=1e-14)
    outer, hole = chains(coarse, cell=(9.0, 9.0), corner_angle=40.0)
    assert not outer.corner.any()
    assert not hole.corner.any()


def test_a_mesh_whose_outline_touches_itself_is_refused(tmp_path):
    meshio = pytest.importorskip("meshio")
    points = np.array([[0, 0], [1, 0], [1, 1], [0, 1], [2, 1], [2, 2], [1, 2]], dtype=float)
    points = np.column_stack([points, np.zeros(7)])
    cells = [("quad", np.array([[0, 1, 2, 3], [2, 4, 5, 6]]))]
    file = tmp_path / "two.msh"
    meshio.Mesh(points, cells).write(file, file_format="gmsh22", binary=False)
    with pytest.raises(BadInput, match=r'"dam".*touches itself at \(1, 1\)'):
        chains(Mesh(file=str(file)))


def test_a_body_in_space_has_no_outline():
    with pytest.raises(BadInput, match="a sphere has no outline in the plane"):
        chains(Sphere(centre=(0.0, 0.0, 0.0), radius=1.0))
    with pytest.raises(BadInput, match="a box has no outline in the plane"):
        chains(Box(lower=(0.0, 0.0, 0.0), upper=(1.0, 1.0, 1.0)), "3d", (0.5, 0.5, 0.5))
