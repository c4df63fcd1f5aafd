# SPDX-License-Identifier: BSD-3-Clause
"""Material points of boxes, polygons and round bodies."""

import math

import numpy as np
import pytest

from tilth.bodies import BodyPoints, discretise
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Box, Circle, Cylinder, Polygon, Sphere

CELL = {2: [0.5, 0.25], 3: [0.5, 0.25, 0.4]}
ORIGIN = {2: [-1.0, 0.3], 3: [-1.0, 0.3, 0.1]}
L_SHAPE = [[0.0, 0.0], [2.1, 0.0], [2.1, 0.9], [0.8, 0.9], [0.8, 2.05], [0.0, 2.05]]


def points_of(shape, kind="plane_strain", origin=None, cell=None, **resolution) -> BodyPoints:
    dimension = 3 if kind == "3d" else 2
    body = Body(name="soil", material="clay", shape=shape, basis="gimp", **resolution)
    origin = np.array(ORIGIN[dimension] if origin is None else origin)
    return discretise(body, kind, Grid(origin, np.array(CELL[dimension] if cell is None else cell)))


def assert_sum(points: BodyPoints, volume: float) -> None:
    assert (points.volume > 0.0).all()
    assert math.fsum(points.volume) == pytest.approx(volume, rel=1e-13)
    assert len(points.position) == len(points.volume) == len(points.half_length)


def ring(area: float, radius: float) -> float:
    return 2.0 * math.pi * radius * area


def test_box_on_grid_lines_has_the_same_lattice_in_every_cell():
    box = Box(lower=[0.5, 0.05], upper=[1000.5, 1.3])
    points = points_of(box, points_per_cell=[2, 3])
    place = (points.position - ORIGIN[2]) / CELL[2]
    cell = np.floor(place)
    _, count = np.unique(cell, axis=0, return_counts=True)
    assert len(count) == 2000 * 5
    assert (count == 6).all()
    inner = place - cell
    assert np.abs(inner[:, 0] * 2 % 1 - 0.5).max() < 1e-12
    assert np.abs(inner[:, 1] * 3 % 1 - 0.5).max() < 1e-11
    assert_sum(points, 1000.0 * 1.25)
    np.testing.assert_allclose(points.half_length, [[0.125, 0.125 / 3.0]] * 60000, rtol=1e-14)


def test_box_points_run_along_x_then_y_then_z():
    points = points_of(
        Box(lower=[0, 0, 0], upper=[3, 2, 2]), kind="3d", cell=[1, 1, 1], points=[3, 2, 2]
    )
    expected = [[x, y, z] for z in (0.5, 1.5) for y in (0.5, 1.5) for x in (0.5, 1.5, 2.5)]
    np.testing.assert_allclose(points.position, expected, rtol=1e-15)


def test_box_off_the_grid_is_divided_exactly():
    lower, upper = np.array([0.07, 0.11]), np.array([1.9, 0.2])
    points = points_of(Box(lower=lower, upper=upper), points_per_cell=2)
    number = [7, 1]  # 1.83 / 0.25 to the nearest; 0.09 / 0.125 is at least one
    assert len(points.position) == math.prod(number)
    np.testing.assert_allclose(points.position.min(axis=0), lower + (upper - lower) / number / 2)
    np.testing.assert_allclose(points.position.max(axis=0), upper - (upper - lower) / number / 2)
    np.testing.assert_allclose(points.half_length[0], (upper - lower) / number / 2)
    assert_sum(points, float(np.prod(upper - lower)))


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0, -135.0])
@pytest.mark.parametrize(
    ("resolution", "number"),
    [
        ({"points": [6, 4]}, [6, 4]),
        ({"spacing": [0.3, 0.1]}, [7, 10]),
        ({"points_per_cell": 2}, [8, 8]),
    ],
)
def test_turned_box_is_the_straight_one_turned_about_its_corner(angle, resolution, number):
    straight = Box(lower=[3.0, 1.0], upper=[5.0, 2.0])
    turned = Box(lower=[3.0, 1.0], upper=[5.0, 2.0], angle=angle)
    own = [(np.arange(n) + 0.5) * side / n for n, side in zip(number, (2.0, 1.0), strict=True)]
    offset = np.array([[x, y] for y in own[1] for x in own[0]])
    sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    expected = np.column_stack(
        [
            3.0 + cosine * offset[:, 0] - sine * offset[:, 1],
            1.0 + sine * offset[:, 0] + cosine * offset[:, 1],
        ]
    )
    points = points_of(turned, **resolution)
    np.testing.assert_allclose(points.position, expected, atol=1e-14)
    np.testing.assert_allclose(points.half_length, points_of(straight, **resolution).half_length)
    assert_sum(points, 2.0)
    if angle:
        np.testing.assert_allclose(points.frame, [[cosine, -sine], [sine, cosine]], atol=1e-15)
    else:
        assert points.frame is None


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_turned_box_in_3d_follows_the_right_hand_rule(axis):
    box = Box(lower=[1.0, 2.0, 3.0], upper=[3.0, 3.0, 6.0], angle=90.0, axis=axis)
    points = points_of(box, kind="3d", cell=[3, 3, 3], points=[1, 1, 1])
    turn = {"x": [1.0, -1.5, 0.5], "y": [1.5, 0.5, -1.0], "z": [-0.5, 1.0, 1.5]}[axis]
    np.testing.assert_allclose(points.position, [np.array([1.0, 2.0, 3.0]) + turn])
    assert_sum(points, 6.0)


def test_box_volumes_in_axisymmetry_and_3d():
    box = Box(lower=[0.4, 0.0], upper=[1.7, 0.9])
    assert_sum(
        points_of(box, kind="axisymmetric", points_per_cell=3), math.pi * (1.7**2 - 0.4**2) * 0.9
    )
    turned = Box(lower=[2.0, 0.0], upper=[3.0, 0.5], angle=25.0)
    centre = 2.0 + 0.5 * math.cos(math.radians(25.0)) - 0.25 * math.sin(math.radians(25.0))
    assert_sum(points_of(turned, kind="axisymmetric", spacing=0.13), ring(0.5, centre))
    cuboid = Box(lower=[0.1, 0.2, 0.3], upper=[1.0, 1.0, 1.0])
    assert_sum(points_of(cuboid, kind="3d", points_per_cell=2), 0.9 * 0.8 * 0.7)


@pytest.mark.parametrize("resolution", [{"points_per_cell": 5}, {"spacing": [0.07, 0.05]}])
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_polygon_sums_to_its_volume_and_keeps_its_centroid(kind, resolution):
    area = 2.1 * 0.9 + 0.8 * 1.15
    centroid = np.array([2.1 * 0.9 * 1.05 + 0.8 * 1.15 * 0.4, 2.1 * 0.81 / 2 + 0.8 * 1.15 * 1.475])
    centroid /= area
    volume = ring(area, centroid[0]) if kind == "axisymmetric" else area
    points = points_of(Polygon(vertices=L_SHAPE), kind=kind, **resolution)
    backwards = points_of(Polygon(vertices=L_SHAPE[::-1]), kind=kind, **resolution)
    assert_sum(points, volume)
    np.testing.assert_array_equal(points.position, backwards.position)
    if kind == "plane_strain":
        mean = points.volume @ points.position / area
        assert np.abs(mean - centroid).max() < 0.05


def test_polygon_points_are_the_sub_cells_of_the_grid_inside_it():
    points = points_of(Polygon(vertices=L_SHAPE), points_per_cell=4)
    spacing = np.array(CELL[2]) / 4
    place = (points.position - ORIGIN[2]) / spacing - 0.5
    np.testing.assert_allclose(place, np.rint(place), atol=1e-9)
    x, y = points.position.T
    assert ((y < 0.9) | (x < 0.8)).all()
    assert ((x > 0) & (y > 0) & (x < 2.1) & (y < 2.05)).all()
    np.testing.assert_allclose(points.half_length, np.tile(spacing / 2, (len(place), 1)))
    # no sub-cell inside is left out, and none is used twice
    assert len(np.unique(np.rint(place), axis=0)) == len(place)
    area = 2.1 * 0.9 + 0.8 * 1.15
    assert abs(len(place) * spacing.prod() - area) < 0.15


def test_polygon_rectangle_on_the_grid_gives_the_points_of_the_box():
    corners = [[0.0, 0.3], [0.0, 1.05], [2.0, 1.05], [2.0, 0.3]]
    polygon = points_of(Polygon(vertices=corners), points_per_cell=2)
    box = points_of(Box(lower=[0.0, 0.3], upper=[2.0, 1.05]), points_per_cell=2)
    np.testing.assert_allclose(polygon.position, box.position, atol=1e-14)
    np.testing.assert_allclose(polygon.volume, box.volume, rtol=1e-13)


@pytest.mark.parametrize("shift", [0.0, 3.1e5])
def test_symmetric_polygon_keeps_symmetric_points_where_centres_lie_on_its_slopes(shift):
    embankment = [[shift + x, y] for x, y in [(-3.0, 0.0), (3.0, 0.0), (1.0, 2.0), (-1.0, 2.0)]]
    points = points_of(
        Polygon(vertices=embankment), origin=[shift, 0.0], cell=[0.5, 0.5], points_per_cell=2
    )
    place = np.rint((points.position - [shift, 0.0]) / 0.25 - 0.5).astype(int)
    present = {tuple(p) for p in place}
    assert {(-1 - i, j) for i, j in present} == present
    # row j: centres between the slopes at height (j + 1/2)/4, ends included
    assert all(sum(q == j for _, q in present) == 24 - 2 * j for j in range(8))


def test_circle_cylinder_and_sphere_sum_to_their_volumes():
    circle = points_of(Circle(centre=[0.3, 0.2], radius=0.77), points_per_cell=5)
    assert_sum(circle, math.pi * 0.77**2)
    assert (np.hypot(*(circle.position - [0.3, 0.2]).T) <= 0.77).all()
    np.testing.assert_allclose(
        circle.volume @ circle.position / circle.volume.sum(), [0.3, 0.2], atol=0.02
    )
    sphere = points_of(Sphere(centre=[0.1, 0.2, 0.3], radius=0.9), kind="3d", spacing=0.1)
    assert_sum(sphere, 4.0 / 3.0 * math.pi * 0.9**3)
    assert (np.linalg.norm(sphere.position - [0.1, 0.2, 0.3], axis=1) <= 0.9).all()
    assert len(sphere.position) * 0.1**3 == pytest.approx(4.0 / 3.0 * math.pi * 0.9**3, rel=0.02)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_cylinder_stands_on_its_lower_face(axis):
    along = "xyz".index(axis)
    cylinder = Cylinder(centre=[0.1, 0.2, 0.3], radius=0.8, axis=axis, height=1.3)
    points = points_of(cylinder, kind="3d", spacing=0.1)
    assert_sum(points, math.pi * 0.64 * 1.3)
    offset = points.position - [0.1, 0.2, 0.3]
    assert offset[:, along].min() >= 0.0
    assert offset[:, along].max() <= 1.3
    assert (np.linalg.norm(np.delete(offset, along, axis=1), axis=1) <= 0.8).all()


@pytest.mark.parametrize("sides", [None, ["y-"], ["x+", "z-"], ["x-", "y+", "z+"]])
def test_a_shell_is_hollow_and_has_its_sides_only(sides):
    whole = {"centre": [0.5, 0.3, -0.3], "radius": 0.9, "inner_radius": 0.4}  # on grid lines
    shell = points_of(Sphere(**whole, sides=sides), kind="3d", spacing=0.1)
    share = 0.5 ** len(sides or ())
    assert_sum(shell, share * 4.0 / 3.0 * math.pi * (0.9**3 - 0.4**3))
    offset = shell.position - [0.5, 0.3, -0.3]
    radius = np.linalg.norm(offset, axis=1)
    assert radius.min() >= 0.4
    assert radius.max() <= 0.9
    # the points of the whole shell on these sides, with the same volumes
    full = points_of(Sphere(**whole), kind="3d", spacing=0.1)
    on_side = np.ones(len(full.position), dtype=bool)
    for side in sides or ():
        i, sign = "xyz".index(side[0]), 1.0 if side[1] == "+" else -1.0
        on_side &= sign * (full.position[:, i] - whole["centre"][i]) > 0.0
    np.testing.assert_allclose(shell.position, full.position[on_side], atol=1e-14)
    np.testing.assert_allclose(shell.volume, full.volume[on_side], rtol=1e-12)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_quarter_of_a_tube(axis):
    along = "xyz".index(axis)
    first, second = "xyz"[(along + 1) % 3], "xyz"[(along + 2) % 3]
    shape = {"centre": [0.0, 0.3, 0.1], "radius": 0.8, "axis": axis, "height": 1.3}
    tube = Cylinder(**shape, inner_radius=0.5, sides=[f"{first}+", f"{second}-"])
    points = points_of(tube, kind="3d", spacing=0.1)
    assert_sum(points, math.pi * (0.64 - 0.25) * 1.3 / 4.0)
    offset = points.position - [0.0, 0.3, 0.1]
    radius = np.linalg.norm(np.delete(offset, along, axis=1), axis=1)
    assert radius.min() >= 0.5
    assert radius.max() <= 0.8
    assert offset[:, "xyz".index(first)].min() > 0.0
    assert offset[:, "xyz".index(second)].max() < 0.0
    whole = points_of(Cylinder(**shape, inner_radius=0.5), kind="3d", spacing=0.1)
    assert len(whole.position) == 4 * len(points.position)


def test_circle_in_axisymmetry_is_a_ring_or_a_ball():
    ring_points = points_of(
        Circle(centre=[2.0, 1.0], radius=0.8), kind="axisymmetric", points_per_cell=4
    )
    assert_sum(ring_points, ring(math.pi * 0.64, 2.0))
    ball = points_of(Circle(centre=[0.0, 1.0], radius=0.8), kind="axisymmetric", spacing=0.04)
    assert_sum(ball, 4.0 / 3.0 * math.pi * 0.8**3)
    assert (ball.position[:, 0] > 0.0).all()
    # mean radius of a ball, 3 pi a / 16, needs the weights 2 pi r to be right point by point
    assert ball.volume @ ball.position[:, 0] / ball.volume.sum() == pytest.approx(
        3.0 * math.pi * 0.8 / 16.0, rel=5e-3
    )


def test_domains_do_not_reach_across_the_axis_of_symmetry():
    points = points_of(
        Circle(centre=[0.0, 0.0], radius=1.0),
        kind="axisymmetric",
        origin=[0.02, 0.0],
        cell=[0.1, 0.1],
        points_per_cell=1,
    )
    assert (points.half_length[:, 0] <= points.position[:, 0]).all()
    assert (points.half_length[:, 1] == 0.05).all()


@pytest.mark.parametrize(
    ("shape", "kind", "resolution", "words"),
    [
        (Circle(centre=[0.1, 0.1], radius=0.001), "plane_strain", {"spacing": 1.0}, "no material"),
        (
            Polygon(vertices=[[0, 0], [1, 0], [0, 1e-3]]),
            "plane_strain",
            {"points_per_cell": 1},
            "no material",
        ),
        (Circle(centre=[0.5, 0], radius=0.8), "axisymmetric", {"spacing": 0.1}, "axis of symmetry"),
        (Box(lower=[-0.1, 0], upper=[1, 1]), "axisymmetric", {"spacing": 0.1}, "axis of symmetry"),
        (
            Box(lower=[0, 0], upper=[1, 1], angle=20.0),
            "axisymmetric",
            {"spacing": 0.1},
            "axis of symmetry",
        ),
        (
            Polygon(vertices=[[-0.1, 0], [1, 0], [0, 1]]),
            "axisymmetric",
            {"spacing": 0.1},
            "axis of symmetry",
        ),
        (Box(lower=[0, 0], upper=[1, 1]), "plane_strain", {"spacing": 1e-7}, "points, more than"),
        (Circle(centre=[0, 0], radius=1), "plane_strain", {"spacing": 1e-7}, "points, more than"),
        (Sphere(centre=[0, 0, 0], radius=1), "plane_strain", {"spacing": 0.1}, "2 dimensions"),
        (Circle(centre=[0, 0], radius=1), "3d", {"spacing": 0.1}, "3 dimensions"),
    ],
)
def test_bad_bodies_are_refused_by_name(shape, kind, resolution, words):
    with pytest.raises(BadInput, match=f'bodies "soil"[.].*{words}') as caught:
        points_of(shape, kind=kind, **resolution)
    assert caught.value.remedy


@pytest.mark.parametrize(
    ("shape", "kind", "resolution", "key"),
    [
        (Sphere(centre=[0, 0, 0], radius=1), "plane_strain", {"spacing": 0.1}, "shape.type"),
        (Box(lower=[-1, 0], upper=[1, 1]), "axisymmetric", {"spacing": 0.1}, "shape"),
        (Circle(centre=[0, 0], radius=1), "plane_strain", {"spacing": 1e-7}, "spacing"),
        (Box(lower=[0, 0], upper=[1e6, 1e6]), "plane_strain", {"points_per_cell": 9}, "points_per"),
        (Box(lower=[0, 0], upper=[9, 9]), "plane_strain", {"points": [1, 1]}, "points"),
    ],
)
def test_errors_name_the_entry_of_the_body(shape, kind, resolution, key):
    with pytest.raises(BadInput) as caught:
        points_of(shape, kind=kind, **resolution)
    assert caught.value.key.startswith(f'bodies "soil".{key}')


TRIANGLE = [[0, 0], [30, 0], [0, 30]]


@pytest.mark.parametrize(
    ("shape", "kind", "resolution", "words"),
    [
        (Box(lower=[0, 0], upper=[20, 3]), "plane_strain", {"spacing": 10}, "10 apart along x"),
        (Box(lower=[0, 0], upper=[20, 3]), "axisymmetric", {"points": [20, 1]}, "3 apart along y"),
        (Box(lower=[0, 0], upper=[1, 1.6]), "plane_strain", {"points": [1, 1]}, "1.6 apart"),
        (Box(lower=[0, 0, 0], upper=[2, 2, 9]), "3d", {"spacing": [1, 1, 3]}, "3 apart along z"),
        (
            Box(lower=[0, 0], upper=[20, 3], angle=30),
            "plane_strain",
            {"spacing": [2, 1]},
            "2 apart along its own x",
        ),
        (Polygon(vertices=TRIANGLE), "plane_strain", {"spacing": 2}, "2 apart"),
        (Circle(centre=[0, 0], radius=9), "axisymmetric", {"spacing": 2}, "2 apart"),
        (Sphere(centre=[0, 0, 0], radius=9), "3d", {"spacing": 2}, "2 apart"),
        (
            Cylinder(centre=[0, 0, 0], radius=9, axis="z", height=9),
            "3d",
            {"spacing": [1, 1, 2]},
            "2 apart along z",
        ),
    ],
)
def test_points_that_leave_cells_empty_are_refused(shape, kind, resolution, words):
    unit = [1.0] * (3 if kind == "3d" else 2)
    with pytest.raises(BadInput, match=rf"{words}.*cells without points") as caught:
        points_of(shape, kind=kind, origin=[0] * len(unit), cell=unit, **resolution)
    assert "points_per_cell = 1" in caught.value.remedy


@pytest.mark.parametrize("angle", [0.0, 20.0])
@pytest.mark.parametrize("side", [0.3, 1.0, 1.4999999, 1.5, 2.4, 2.5, 7.49])
def test_one_point_per_cell_is_enough_for_any_box(side, angle):
    box = Box(lower=[0.37, 0.2], upper=[0.37 + side, 0.2 + side], angle=angle)
    points = points_of(box, origin=[0, 0], cell=[1, 1], points_per_cell=1)
    assert_sum(points, side**2)


def test_turned_box_is_measured_by_the_smallest_side_of_a_cell():
    shape = Box(lower=[0, 0], upper=[4, 1], angle=90)
    with pytest.raises(BadInput, match=r"0\.5 apart along its own x in cells of 0\.25"):
        points_of(shape, spacing=[0.5, 0.25])
    straight = Box(lower=[0, 0], upper=[4, 1])
    assert len(points_of(straight, spacing=[0.5, 0.25]).position) == 32
