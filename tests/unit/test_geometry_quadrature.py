# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature on boundaries: facets cut at the grid's lines, exact integrals, permanent points."""

import math

import numpy as np
import pytest
from geometries import AXIS, FLAT, GEOMETRIES, STAR, TURNED_2D, TURNED_3D

from tilth import _core
from tilth.geometry.box import Box
from tilth.geometry.footing import Footing
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.geometry.quadrature import make_quadrature
from tilth.geometry.round import Circle, Cylinder, Sphere
from tilth.grid.background import Grid


def quadrature(geometry, origin=0.013, cell_size=0.11, size=None, lower=-1.0, upper=1.0):
    dim = geometry.dim
    cell = np.full(dim, cell_size) * np.array([1.0, 0.8, 1.3])[:dim]
    bounds = np.full(dim, lower), np.full(dim, upper)
    return make_quadrature(geometry, *bounds, Grid(np.full(dim, origin), cell), size or cell_size)


def measure(edge):
    return math.dist(*edge)


AHEAD = np.roll(STAR, -1, axis=0)
PERIMETER = sum(map(measure, zip(STAR, AHEAD, strict=True)))
AREAS = {
    "polygon": PERIMETER,
    "rectangle": 2 * (1.1 + 0.7),
    "obstacle": 2 * (1.1 + 0.7),
    "cuboid": 2 * (1.1 * 0.7 + 1.1 * 0.5 + 0.7 * 0.5),
    "block": 2 * (1.1 * 0.7 + 1.1 * 0.5 + 0.7 * 0.5),
    "one segment": measure(STAR[:2]),
    "strip": 1.1,
    "pad": 1.1 * 0.6,
}
POLYGON_AREA = 0.5 * (STAR[:, 0] * AHEAD[:, 1] - STAR[:, 1] * AHEAD[:, 0]).sum()
VOLUMES = {  # of the closed body, positive where the soil is inside
    "polygon": POLYGON_AREA,
    "rectangle": 1.1 * 0.7,
    "obstacle": -1.1 * 0.7,
    "cuboid": 1.1 * 0.7 * 0.5,
    "block": -1.1 * 0.7 * 0.5,
    "circle": math.pi * 0.49,
    "hole": -math.pi * 0.49,
    "sphere": 4.0 / 3.0 * math.pi * 0.343,
    "cavity": -4.0 / 3.0 * math.pi * 0.343,
}


@pytest.mark.parametrize("name", AREAS)
def test_the_weights_of_flat_pieces_sum_to_their_area(name):
    points = quadrature(GEOMETRIES[name])
    assert points.weight.min() > 0.0
    np.testing.assert_allclose(points.weight.sum(), AREAS[name], rtol=1e-13)


@pytest.mark.parametrize("name", ["line", "plane"])
def test_each_facet_group_of_a_plane_has_its_area(name):
    points = quadrature(GEOMETRIES[name], size=0.2)
    _, group = np.unique(points.group, return_inverse=True)
    area = np.bincount(group.ravel(), weights=points.weight)
    np.testing.assert_allclose(area, 0.2 ** (GEOMETRIES[name].dim - 1), rtol=1e-12)


def chord_error(chords, derivative):
    """Relative error of three Gauss points on chords: L^6 f^(6) / 2016000, L in radii.

    Over t, the tangent of the angle, the arc is the integral of 1 / (1 + t^2), whose sixth
    derivative is at most 720; a component of its normal that of (1 + t^2)^(-3/2), at most 1575.
    """
    return derivative * (2.0 * math.tan(math.pi / chords)) ** 6 / 2016000.0


@pytest.mark.parametrize("name", VOLUMES)
def test_a_closed_surface_encloses_its_volume(name):
    geometry = GEOMETRIES[name]
    points = quadrature(
        geometry, cell_size=0.03 if geometry.dim == 3 and not geometry.flat else 0.1
    )
    # 3D: points exact to degree 2 give an error of fourth order.
    accuracy = 1e-6 if geometry.dim == 3 else 1.4 * math.pi * chord_error(44, 1575.0)
    accuracy = 1e-13 if geometry.flat else accuracy
    total = (points.weight[:, None] * points.normal).sum(axis=0)
    np.testing.assert_allclose(total, 0.0, atol=accuracy)
    flux = (points.weight * np.einsum("ni,ni->n", points.position, points.normal)).sum()
    np.testing.assert_allclose(flux, -geometry.dim * VOLUMES[name], rtol=accuracy)


@pytest.mark.parametrize(
    ("geometry", "area", "order"),
    [
        (Circle([0.1, -0.2], 0.7, inside=True), 1.4 * math.pi, 6.0),
        (Sphere([0.1, -0.2, 0.3], 0.7, inside=False), 4.0 * math.pi * 0.49, 4.0),
    ],
)
def test_the_area_of_a_round_surface_converges(geometry, area, order):
    # The grid's cells are large: only the facets' size counts.
    sizes = [0.1, 0.05] if geometry.dim == 2 else [0.06, 0.03]
    if geometry.dim == 2:  # the least number of chords
        error = abs(quadrature(geometry, cell_size=10.0, size=1.0).weight.sum() / area - 1.0)
        assert error < chord_error(32, 720.0)
    errors = [abs(quadrature(geometry, 0.0, 10.0, s).weight.sum() / area - 1.0) for s in sizes]
    assert errors[-1] < 1e-6
    assert math.log2(errors[0] / errors[1]) > order - 0.3


ROUND_AREAS = {
    "circle": 1.4 * math.pi,
    "hole": 1.4 * math.pi,
    "sphere": 4.0 * math.pi * 0.49,
    "cavity": 4.0 * math.pi * 0.49,
}


@pytest.mark.parametrize("name", [*AREAS, *ROUND_AREAS])
def test_the_area_does_not_depend_on_the_grid(name):
    geometry, rng = GEOMETRIES[name], np.random.default_rng(17)
    dim, size = geometry.dim, 0.05
    accuracy = 1e-6 if dim == 3 else chord_error(88, 720.0)
    balance = 1e-6 if dim == 3 else 1.4 * math.pi * chord_error(88, 1575.0)
    if geometry.flat:
        accuracy = balance = 1e-13
    for _ in range(4):
        cell = rng.uniform(0.05, 0.4, dim)
        origin = rng.uniform(-cell, cell)
        points = make_quadrature(geometry, np.zeros(dim), np.ones(dim), Grid(origin, cell), size)
        assert points.weight.min() > 0.0
        area = {**AREAS, **ROUND_AREAS}[name]
        np.testing.assert_allclose(points.weight.sum(), area, rtol=accuracy)
        if name in VOLUMES:  # closed
            total = (points.weight[:, None] * points.normal).sum(axis=0)
            np.testing.assert_allclose(total, 0.0, atol=balance)


@pytest.mark.parametrize("axis", [AXIS, [1.0, 0.0, 0.0]])
def test_the_facet_groups_round_a_cylinder_have_its_area(axis):
    size = 0.1
    points = quadrature(Cylinder([0.1, -0.2, 0.3], axis, 0.7, inside=True), size=size)
    axis = np.array(axis) / np.linalg.norm(axis)
    level = np.floor((points.position - [0.1, -0.2, 0.3]) @ axis / size).astype(int)
    area = np.bincount(level - level.min(), weights=points.weight)
    assert len(area) > 20
    np.testing.assert_allclose(area, 1.4 * math.pi * size, rtol=1e-6)


@pytest.mark.parametrize("name", ["circle", "cylinder", "borehole", "sphere", "cavity"])
def test_points_are_on_the_round_surface_with_its_normals(name):
    geometry = GEOMETRIES[name]
    points = quadrature(geometry)
    np.testing.assert_allclose(geometry.distance(points.position), 0.0, atol=1e-15)
    np.testing.assert_array_equal(points.normal, geometry.gradient(points.position))


OFFSETS = [0.0, 1e3, 5e5]  # in the coordinates of a map round-off is many times that of the shape
AWAY = ["polygon", "one segment", "rectangle", "obstacle", "cuboid", "strip", "pad"]


def away(name, offset):
    """Shapes that lie `offset` from the origin in each direction."""
    return {
        "polygon": lambda: Polyline(STAR + offset, closed=True, left=False),
        "one segment": lambda: Polyline(STAR[:2] + offset, closed=False, left=True),
        "rectangle": lambda: Box([offset] * 2, [offset + 1.0] * 2, TURNED_2D, inside=True),
        "obstacle": lambda: Box([offset] * 2, [offset + 1.0] * 2, TURNED_2D, inside=False),
        "cuboid": lambda: Box([offset] * 3, [offset + 1.0] * 3, TURNED_3D, inside=False),
        "strip": lambda: Footing([offset] * 2, [0.6, -0.83], [1.1]),
        "pad": lambda: Footing([offset] * 3, AXIS, [1.1, 0.6]),
    }[name]()


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("name", AWAY)
def test_the_gradient_on_flat_pieces_is_their_normal(name, offset):
    geometry = away(name, offset)
    points = quadrature(geometry)
    assert len(points.weight) > 20
    np.testing.assert_array_equal(geometry.gradient(points.position), points.normal)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize("name", AWAY)
def test_the_gradient_on_edges_and_vertices_is_the_normal_of_one_piece(name, offset):
    # Also where round-off puts the place a little beside.
    geometry = away(name, offset)
    dim = geometry.dim
    facets = geometry.facets(np.zeros(dim), np.ones(dim), 10.0)
    normals = np.unique(facets.normal, axis=0)
    x = np.concatenate([facets.corner, 0.5 * (facets.corner + np.roll(facets.corner, 1, axis=1))])
    x = np.repeat(x.reshape(-1, dim), 50, axis=0)
    x += np.random.default_rng(4).uniform(-1.0, 1.0, x.shape) * np.spacing(np.abs(x).max())
    gradient = geometry.gradient(x)
    error = np.abs(gradient[:, None] - normals).max(axis=2)
    np.testing.assert_allclose(error.min(axis=1), 0.0, atol=1e-15)
    if len(normals) > 1:
        assert len(np.unique(error.argmin(axis=1))) == len(normals)


def test_a_polynomial_of_degree_5_along_a_segment_is_exact():
    segment = Polyline([[-0.4, 0.3], [0.5, -0.6]], closed=False, left=True)
    points = quadrature(segment, cell_size=0.4)
    along = (points.position - segment.start[0]) @ [math.sqrt(0.5), -math.sqrt(0.5)]
    length = 0.9 * math.sqrt(2.0)
    for degree in range(6):
        integral = (points.weight * along**degree).sum()
        assert integral == pytest.approx(length ** (degree + 1) / (degree + 1), rel=1e-13)
    integral = (points.weight * along**6).sum()
    assert integral != pytest.approx(length**7 / 7.0, rel=1e-13)


def test_a_polynomial_of_degree_2_on_a_rectangle_is_exact():
    pad = Footing([0.1, 0.2, -0.1], AXIS, [1.0, 0.6], along=[1.0, 1.0, 0.0])
    first = np.array([1.0, 1.0, 0.0]) - (AXIS[0] + AXIS[1]) / (AXIS @ AXIS) * AXIS
    first /= np.linalg.norm(first)
    second = np.cross(AXIS, first) / np.linalg.norm(AXIS)
    points = quadrature(pad, cell_size=0.3)
    arm = points.position - [0.1, 0.2, -0.1]
    u, v = arm @ first, arm @ second
    expected = {(0, 0): 0.6, (1, 0): 0, (0, 1): 0, (1, 1): 0, (2, 0): 0.05, (0, 2): 0.018}
    for (i, j), value in expected.items():
        assert (points.weight * u**i * v**j).sum() == pytest.approx(value, rel=1e-13, abs=1e-15)


@pytest.mark.parametrize("name", FLAT)
def test_the_points_of_a_piece_are_in_one_cell(name):
    points = quadrature(GEOMETRIES[name])
    cell = 0.11 * np.array([1.0, 0.8, 1.3])[: GEOMETRIES[name].dim]
    number = np.floor((points.position - 0.013) / cell).reshape(-1, 3, len(cell))
    assert len(number) > 5
    inside = points.weight.reshape(-1, 3).sum(axis=1) > 1e-9  # the smallest are on a line
    np.testing.assert_array_equal(number[inside], number[inside][:, :1].repeat(3, axis=1))


@pytest.mark.parametrize("name", ["circle", "cylinder", "sphere"])
def test_the_points_of_a_round_piece_leave_their_cell_by_its_height_at_most(name):
    # Pieces of chords are in one cell; projection moves their points out by up to the height of
    # the arc over the chord.
    geometry = GEOMETRIES[name]
    dim = geometry.dim
    corner = geometry.facets(-np.ones(dim), np.ones(dim), 0.11).corner
    middles = [corner.mean(axis=1), *(0.5 * (corner + np.roll(corner, 1, axis=1))).swapaxes(0, 1)]
    height = 1.05 * max(np.abs(geometry.distance(middle)).max() for middle in middles)
    assert height < 0.01
    position = quadrature(geometry).position.reshape(-1, 3, dim) - 0.013
    cell = 0.11 * np.array([1.0, 0.8, 1.3])[:dim]
    low = np.floor((position.min(axis=1) + height) / cell)
    high = np.floor((position.max(axis=1) - height) / cell)
    assert (high <= low).all()
    assert len(np.unique(low, axis=0)) > 20


@pytest.mark.parametrize("offset", [0.0, 0.1, 1000.0, 12345.6])
def test_a_line_through_nodes_has_one_piece_in_each_cell(offset):
    # Along the diagonals of cells, one way and the other, and along grid lines: a closed line.
    h = 0.1
    vertex = np.array([[1, 1], [8, 1], [8, 4], [5, 7], [1, 3]]) * h
    line = Polyline(vertex + offset, closed=True, left=True)
    corner, cell = np.full(2, offset), np.full(2, h)
    points = make_quadrature(line, corner, corner + 1.0, Grid(corner, cell), 10.0)
    length = (7 + 3 + 2 + (3 + 4) * math.sqrt(2.0)) * h
    assert len(points.weight) == 3 * (7 + 3 + 3 + 4 + 2)
    np.testing.assert_allclose(points.weight.sum(), length, rtol=1e-13 + 1e-15 * offset / h)


@pytest.mark.parametrize("height", [0.2, 0.23])
@pytest.mark.parametrize("offset", [0.0, 0.1, 1000.0, 12345.6])
def test_a_footing_with_edges_on_grid_lines_has_two_triangles_in_each_cell(offset, height):
    h = 0.1
    centre = np.array([0.4, 0.35, height]) + offset
    pad = Footing(centre, [0.0, 0.0, -1.0], [0.6, 0.3], along=[1.0, 0.0, 0.0])
    corner, cell = np.full(3, offset), np.full(3, h)
    points = make_quadrature(pad, corner, corner + 1.0, Grid(corner, cell), h * (1.0 + 1e-6))
    assert len(points.weight) == 3 * 2 * 6 * 3
    number = np.floor((points.position - corner)[:, :2] / h)
    _, count = np.unique(number, axis=0, return_counts=True)
    np.testing.assert_array_equal(count, [6] * 18)
    np.testing.assert_allclose(points.weight, h * h / 6.0, rtol=1e-12 + 1e-15 * offset / h)


@pytest.mark.parametrize("offset", [0.0, 0.1, 1000.0, 12345.6])
@pytest.mark.parametrize("shift", [0.0, 1e-13, -1e-13])
@pytest.mark.parametrize("dim", [2, 3])
def test_facets_on_grid_lines_are_neither_lost_nor_doubled(dim, shift, offset):
    # 0.1 is not a binary fraction: the lines and the faces differ by round-off.
    h, cells = 0.1, 3
    lower = np.array([offset + 2 * h] * dim) + shift * h
    box = Box(lower, lower + cells * h, np.eye(dim), inside=True)
    points = make_quadrature(
        box, lower, lower + 1.0, Grid(np.full(dim, offset), np.full(dim, h)), h * (1.0 + 1e-6)
    )
    pieces = 2 * dim * cells ** (dim - 1) * (dim - 1)
    assert len(points.weight) == 3 * pieces
    # The round-off of the coordinates is that of the areas.
    accuracy = 1e-13 + 1e-15 * offset / h
    np.testing.assert_allclose(
        points.weight.sum(), 2 * dim * (cells * h) ** (dim - 1), rtol=accuracy
    )
    first = (points.weight[:, None] * points.position).sum(axis=0) / points.weight.sum()
    np.testing.assert_allclose(first - lower, 0.5 * cells * h, rtol=accuracy)


@pytest.mark.parametrize("normal", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
def test_a_plane_on_or_across_grid_planes_keeps_its_area(normal):
    plane = Plane([0.2, 0.2, 0.2], normal)
    cell = np.full(3, 0.1)
    points = make_quadrature(plane, np.zeros(3), np.full(3, 0.5), Grid(np.zeros(3), cell), 0.1)
    _, group = np.unique(points.group, return_inverse=True)
    area = np.bincount(group.ravel(), weights=points.weight)
    np.testing.assert_allclose(area, 0.01, rtol=1e-12)


@pytest.mark.parametrize("name", ["line", "plane", "cylinder", "borehole"])
def test_a_larger_region_keeps_the_points_of_a_facet_group(name):
    geometry = GEOMETRIES[name]
    small = quadrature(geometry, cell_size=0.3, lower=-0.31, upper=0.5)
    large = quadrature(geometry, cell_size=0.3, lower=-2.2, upper=1.4)
    assert np.isin(small.group, large.group).all()
    same = np.isin(large.group, small.group)
    assert 0 < same.sum() < len(same)
    by_small = np.argsort(small.group, kind="stable")
    by_large = np.argsort(large.group[same], kind="stable")
    for array in ("position", "weight", "normal", "group"):
        np.testing.assert_array_equal(
            getattr(small, array)[by_small], getattr(large, array)[same][by_large]
        )


@pytest.mark.parametrize("direction", [[1.0, 0.7], [1.0, -0.7], [-1.0, 0.7], [-1.0, -0.7]])
def test_points_follow_each_other_along_a_facet(direction):
    start = np.array([0.05, 0.03])
    segment = Polyline([start, start + direction], closed=False, left=True)
    for size in (10.0, 0.02):
        along = (quadrature(segment, size=size).position - start) @ direction
        assert (np.diff(along) > 0.0).all()


def test_pieces_are_not_longer_than_the_size():
    segment = Polyline([[0.0, 0.0], [0.9, 0.5]], closed=False, left=True)
    points = quadrature(segment, cell_size=0.5, size=0.07)
    assert points.weight.reshape(-1, 3).sum(axis=1).max() <= 0.07 * (1.0 + 1e-12)


@pytest.mark.parametrize("name", AREAS)
def test_long_facets_are_cut_into_the_same_cells(name):
    geometry = GEOMETRIES[name]
    dim = geometry.dim
    cell, size = 0.11 * np.array([1.0, 0.8, 1.3])[:dim], 0.07
    given = geometry, np.zeros(dim), np.ones(dim), Grid(np.full(dim, 0.013), cell), size
    points = make_quadrature(*given, facet_size=10.0)
    assert len(points.weight) < len(make_quadrature(*given).weight)
    np.testing.assert_allclose(points.weight.sum(), AREAS[name], rtol=1e-13)
    number = np.floor((points.position - 0.013) / cell).reshape(-1, 3, dim)
    weight = points.weight.reshape(-1, 3).sum(axis=1)
    inside = weight > 1e-9
    np.testing.assert_array_equal(number[inside], number[inside][:, :1].repeat(3, axis=1))
    if dim == 2:
        assert weight.max() <= size * (1.0 + 1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_cutting_keeps_each_facet_whole(dim):
    rng = np.random.default_rng(5)
    corner = rng.uniform(-1.0, 1.0, (200, dim, dim))
    corner[::4] = np.round(corner[::4], 1)  # corners on grid lines
    corner[::8, :, 0] = 0.2  # facets on grid lines
    origin, cell = np.full(dim, -0.1), np.array([0.1, 0.2, 0.25])[:dim]
    piece, facet = _core.cut_simplices(corner, Grid(origin, cell))
    assert (np.diff(facet) >= 0).all()

    def area(c):
        edge = c[:, 1:] - c[:, :1]
        if dim == 2:
            return np.linalg.norm(edge[:, 0], axis=1)
        return 0.5 * np.linalg.norm(np.cross(edge[:, 0], edge[:, 1]), axis=1)

    def moment(c):
        return (area(c)[:, None] * c.mean(axis=1)).T

    total = np.bincount(facet, weights=area(piece), minlength=200)
    np.testing.assert_allclose(total, area(corner), rtol=1e-12, atol=1e-14)
    for of_pieces, whole in zip(moment(piece), moment(corner), strict=True):
        total = np.bincount(facet, weights=of_pieces, minlength=200)
        np.testing.assert_allclose(total, whole, rtol=1e-12, atol=1e-14)
    place = (piece - origin) / cell
    number = np.floor(place.min(axis=1) + 1e-9)
    assert (place - number[:, None] > -1e-9).all()
    assert (place - number[:, None] < 1.0 + 1e-9).all()


def test_slivers_are_left_out():
    # A square on its tip, of which two tips cross grid lines by very little.
    tip = 0.2 * math.sqrt(2.0)
    pad = Footing([0.0, 0.0, 0.03], [0.0, 0.0, 1.0], [0.4, 0.4], along=[1.0, 1.0, 0.0])
    cell = np.array([tip * (1.0 - 1e-8), 2.0 * tip, 0.1])
    points = make_quadrature(pad, -cell, cell, Grid(np.zeros(3), cell), 1.0)
    assert np.abs(points.position[:, 0]).max() < cell[0]
    np.testing.assert_allclose(points.weight.sum(), 0.16, rtol=1e-13)


@pytest.mark.parametrize("parts", [1, 3, 7, 10])
def test_a_length_that_is_a_multiple_of_the_size_is_split_so(parts):
    # 3 * 0.1 / 0.1 is more than 3 in floating point.
    size = 0.1
    length = sum([size] * parts) * (1.0 + 1e-15)
    segment = Polyline([[0.0, 0.0], [length, 0.0]], closed=False, left=True)
    assert len(segment.facets(np.zeros(2), np.ones(2), size).corner) == parts
    pad = Footing(np.zeros(3), [0.0, 0.0, 1.0], [length, length])
    assert len(pad.facets(np.zeros(3), np.ones(3), size).corner) == 2 * parts**2
