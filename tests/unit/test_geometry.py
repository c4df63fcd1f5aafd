# SPDX-License-Identifier: BSD-3-Clause
"""Geometries of boundaries: signed distance, gradient, facets."""

import numpy as np
import pytest
from geometries import AXIS, DROP, GEOMETRIES, STAR, TURNED_2D, TURNED_3D
from scipy.spatial import cKDTree

from tilth.geometry.box import Box
from tilth.geometry.footing import Footing
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.geometry.round import Circle, Cylinder, Sphere


@pytest.fixture(params=GEOMETRIES)
def geometry(request):
    return GEOMETRIES[request.param]


def places(dim, n=400, reach=1.5):
    return reach * np.random.default_rng(7).uniform(-1.0, 1.0, (n, dim))


def singular_places(geometry):
    """Places where the gradient jumps: centres, axes, vertices, edges, and places on facets."""
    corner = geometry.facets(*(np.full(geometry.dim, v) for v in (-1.0, 1.0)), 0.25).corner
    on_it = np.concatenate([corner.reshape(-1, geometry.dim), corner.mean(axis=1)])
    if isinstance(geometry, Cylinder):
        return np.concatenate([on_it, geometry.centre + np.outer([-0.4, 0, 1.3], geometry.axis)])
    if isinstance(geometry, Circle | Sphere | Footing):
        return np.concatenate([on_it, geometry.centre[None]])
    if isinstance(geometry, Box):
        steps = np.linspace(0.0, 1.0, 5)
        share = np.stack(np.meshgrid(*[steps] * geometry.dim), axis=-1).reshape(-1, geometry.dim)
        return np.concatenate([on_it, geometry.lower + share * geometry.size @ geometry.axes])
    return on_it


def on_boundary(geometry, spacing):
    """Places on the boundary not further apart than `spacing` in any direction."""
    reach = np.full(geometry.dim, 3.0)
    facets = geometry.facets(-reach, reach, spacing)
    normal = np.repeat(facets.normal, geometry.dim, axis=0)
    return geometry.project(facets.corner.reshape(-1, geometry.dim), normal)[0]


def test_the_distance_is_that_to_the_nearest_place_on_the_facets(geometry):
    # If a place x has its nearest place p on a facet, edge or corner, a place q on the same has
    # |x - q|^2 = distance^2 + |p - q|^2; on a sphere |p - q|^2 is multiplied by |x| / radius.
    spacing = 1e-3 if geometry.dim == 2 else 0.04
    x = places(geometry.dim)
    nearest, _ = cKDTree(on_boundary(geometry, spacing)).query(x)
    excess = nearest**2 - geometry.distance(x) ** 2
    assert excess.min() > -1e-12
    assert excess.max() < (4.0 if not geometry.flat else 1.0) * spacing**2


@pytest.mark.parametrize("name", GEOMETRIES)
def test_the_distance_is_positive_in_the_soil(name):
    geometry = GEOMETRIES[name]
    x = places(geometry.dim)
    inside = {
        "line": lambda x: (x - [0.1, 0.2]) @ [3.0, 4.0] > 0.0,
        "plane": lambda x: (x - [0.1, 0.2, -0.1]) @ [1.0, -2.0, 2.0] > 0.0,
        "circle": lambda x: ((x - [0.1, -0.2]) ** 2).sum(axis=1) < 0.49,
        "hole": lambda x: ((x - [0.1, -0.2]) ** 2).sum(axis=1) > 0.49,
        "cylinder": lambda x: (
            (np.cross(x - [0.1, -0.2, 0.3], AXIS) ** 2).sum(axis=1) < 0.49 * AXIS @ AXIS
        ),
        "borehole": lambda x: ((x[:, :2] - [0.1, -0.2]) ** 2).sum(axis=1) > 0.49,
        "sphere": lambda x: ((x - [0.1, -0.2, 0.3]) ** 2).sum(axis=1) < 0.49,
        "cavity": lambda x: ((x - [0.1, -0.2, 0.3]) ** 2).sum(axis=1) > 0.49,
        "one segment": lambda x: (x - STAR[0]) @ [0.3, 0.65] > 0.0,
        "polygon": lambda x: in_polygon(x, STAR),
        "rectangle": lambda x: in_box(x, [-0.5, -0.4], [0.6, 0.3], TURNED_2D),
        "obstacle": lambda x: ~in_box(x, [-0.5, -0.4], [0.6, 0.3], TURNED_2D),
        "cuboid": lambda x: in_box(x, [-0.5, -0.4, -0.2], [0.6, 0.3, 0.3], TURNED_3D),
        "block": lambda x: ~in_box(x, [-0.5, -0.4, -0.2], [0.6, 0.3, 0.3], TURNED_3D),
        "strip": lambda x: (x - [0.1, 0.2]) @ [0.6, -0.8] > 0.0,
        "pad": lambda x: (x - [0.1, 0.2, -0.1]) @ AXIS > 0.0,
        "stake": lambda x: ~in_cone(x, [0.1, -0.2, -0.6], AXIS, 0.4, 0.5, 0.7),
        "pile": lambda x: ~in_cone(x, [0.1, -0.2, 0.6], [0.0, 0.0, -1.0], 0.4, 0.0, 0.9),
        "funnel": lambda x: in_cone(x, [0.1, -0.2, -0.6], AXIS, 0.4, 0.5, 0.7),
        "spline": lambda x: in_polygon(x, DROP.polyline(40)[:-1]),
    }
    if name == "open line":  # its ends apart, the sides are those of the polygon from which it is
        near = np.array([0.3, 0.4]) + places(2, reach=0.4)
        x, expected = near, in_polygon(near, STAR)
    elif name == "open spline":  # about a quarter of a circle
        x = x[(x[:, 0] > 0.0) & (x[:, 1] < 0.0)]
        expected = np.linalg.norm(x, axis=1) > 0.7
    else:
        expected = inside[name](x)
    assert 0 < expected.sum() < len(x)
    np.testing.assert_array_equal(geometry.distance(x) > 0.0, expected)


def in_polygon(x, vertices):
    """By the number of edges that a ray along the first axis crosses."""
    crossings = np.zeros(len(x), dtype=int)
    for a, b in zip(vertices, np.roll(vertices, -1, axis=0), strict=True):
        between = (a[1] > x[:, 1]) != (b[1] > x[:, 1])
        at = a[0] + (x[:, 1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        crossings += between & (x[:, 0] < at)
    return crossings % 2 == 1


def in_box(x, lower, upper, axes):
    own = (x - np.array(lower)) @ axes.T
    return ((own > 0.0) & (own < np.array(upper) - lower)).all(axis=1)


def in_cone(x, tip, axis, radius, tip_length, length):
    along = (x - np.array(tip)) @ axis / np.linalg.norm(axis)
    across = np.linalg.norm(np.cross(x - np.array(tip), axis), axis=1) / np.linalg.norm(axis)
    below = along < tip_length
    widest = np.where(below, radius * along / (tip_length or 1.0), radius)
    return (along > 0.0) & (along < tip_length + length) & (across < widest)


@pytest.mark.parametrize("left", [True, False])
def test_the_side_of_an_open_line_is_told_at_its_vertices(left):
    # A sharp corner: straight ahead of its tip only the two segments together tell the side.
    line = Polyline([[0.0, 0.1], [1.0, 0.0], [0.0, -0.1]], closed=False, left=left)
    x = np.array([[1.2, 0.0], [1.2, 0.05], [1.2, -0.05], [0.5, 0.0], [0.2, 0.3], [0.2, -0.3]])
    on_left = np.array([True, True, True, False, True, True])
    np.testing.assert_array_equal(line.distance(x) > 0.0, on_left == left)
    np.testing.assert_allclose(abs(line.distance(x))[:3], np.hypot([0.2] * 3, [0, 0.05, 0.05]))
    beyond = np.array([[-0.2, 0.15], [-0.2, 0.05], [-0.2, -0.15], [-0.2, -0.05]])
    on_left = np.array([True, False, True, False])  # of the first or last segment alone
    np.testing.assert_array_equal(line.distance(beyond) > 0.0, on_left == left)


def test_the_gradient_points_from_the_nearest_place(geometry):
    # Holds for each of the valid directions where there are several.
    x = np.concatenate([places(geometry.dim), singular_places(geometry)])
    gradient = geometry.gradient(x)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1.0, rtol=1e-14)
    foot = x - geometry.distance(x)[:, None] * gradient
    np.testing.assert_allclose(geometry.distance(foot), 0.0, atol=1e-14)


def test_the_gradient_is_the_derivative_of_the_distance(geometry):
    x, step = places(geometry.dim), 1e-6
    difference = np.stack(
        [
            (geometry.distance(x + step * e) - geometry.distance(x - step * e)) / (2.0 * step)
            for e in np.eye(geometry.dim)
        ],
        axis=1,
    )
    error = np.linalg.norm(difference - geometry.gradient(x), axis=1)
    assert error.max() < 1e-7


def test_singular_places_have_unit_gradients_and_leave_the_places_alone(geometry):
    x = singular_places(geometry)
    before = x.copy()
    assert np.isfinite(geometry.distance(x)).all()
    assert np.isfinite(geometry.gradient(x)).all()
    np.testing.assert_array_equal(x, before)


def test_the_facets_are_small_and_their_normals_point_into_the_soil(geometry):
    size = 0.1
    facets = geometry.facets(-np.ones(geometry.dim), np.ones(geometry.dim), size)
    edge = np.roll(facets.corner, -1, axis=1) - facets.corner
    assert np.linalg.norm(edge, axis=2).max() < (1 + 1e-12 if geometry.dim == 2 else 1.6) * size
    np.testing.assert_allclose(np.linalg.norm(facets.normal, axis=1), 1.0, rtol=1e-14)
    np.testing.assert_allclose(np.einsum("nci,ni->nc", edge, facets.normal), 0.0, atol=1e-14)
    middle = facets.corner.mean(axis=1)
    assert (geometry.distance(middle + 0.01 * facets.normal) > 0.0).all()
    assert (geometry.distance(middle - 0.01 * facets.normal) < 0.0).all()
    assert facets.group.dtype == np.int64


@pytest.mark.parametrize(
    "geometry",
    [
        *(GEOMETRIES[name] for name in ("line", "plane", "cylinder", "borehole")),
        Plane([0.1, 0.2], [0.0, 1.0]),  # the box's corners reach no further than the box
        Plane([0.1, 0.2, -0.1], [0.0, -1.0, 0.0]),
    ],
)
def test_a_boundary_without_end_covers_the_box(geometry):
    lower, upper = np.full(geometry.dim, -1.4), np.full(geometry.dim, 0.9)
    x = np.random.default_rng(3).uniform(lower, upper, (20000, geometry.dim))
    x -= geometry.distance(x)[:, None] * geometry.gradient(x)
    x = x[((x >= lower) & (x <= upper)).all(axis=1)][:100]
    assert len(x) == 100
    facets = geometry.facets(lower, upper, 0.2)
    origin, edges = facets.corner[:, 0], facets.corner[:, 1:] - facets.corner[:, :1]
    if not geometry.flat:  # onto the chords, along the radius
        height = np.einsum("ni,ni->n", origin - geometry.centre, facets.normal)
        radial = geometry.radial(x)
        share = height / (radial @ facets.normal.T)  # (places, facets), 1 on the surface
        x = (x - radial)[:, None] + np.where(share > 0.0, share, np.nan)[..., None] * radial[
            :, None
        ]
    else:
        x = np.repeat(x[:, None], len(origin), axis=1)
    coordinate = np.einsum("ndi,pni->pnd", np.linalg.pinv(edges.swapaxes(1, 2)), x - origin)
    least = np.minimum(coordinate.min(axis=2), 1.0 - coordinate.sum(axis=2))
    assert (np.nanmax(least, axis=1) > -1e-9).all()


@pytest.mark.parametrize("name", ["line", "plane", "cylinder"])
def test_a_patch_has_one_number_whatever_the_region(name):
    geometry = GEOMETRIES[name]
    large = geometry.facets(np.full(geometry.dim, -3.0), np.full(geometry.dim, 4.0), 0.3)
    _, count = np.unique(large.group, return_counts=True)
    assert set(count) == {geometry.dim - 1}  # one segment, or the two halves of a patch
    rng = np.random.default_rng(1)
    for _ in range(5):
        lower = rng.uniform(-2.0, 0.5, geometry.dim)
        small = geometry.facets(lower, lower + rng.uniform(0.1, 2.0, geometry.dim), 0.3)
        same = np.isin(large.group, small.group)
        order = np.argsort(small.group, kind="stable")
        of_large = np.argsort(large.group[same], kind="stable")
        np.testing.assert_array_equal(large.corner[same][of_large], small.corner[order])


@pytest.mark.parametrize("name", ["circle", "sphere", "polygon", "cuboid", "strip", "pad"])
def test_a_boundary_with_ends_does_not_depend_on_the_region(name):
    geometry = GEOMETRIES[name]
    near = geometry.facets(np.zeros(geometry.dim), np.ones(geometry.dim), 0.2)
    far = geometry.facets(np.full(geometry.dim, 8.0), np.full(geometry.dim, 9.0), 0.2)
    np.testing.assert_array_equal(near.corner, far.corner)
    assert len(np.unique(near.group)) == len(near.group)


@pytest.mark.parametrize("name", ["rectangle", "block"])
def test_only_the_named_faces_of_a_box_act(name):
    box = GEOMETRIES[name]
    upper = box.lower + box.size
    for k, letter in enumerate("xyz"[: box.dim]):
        for mark, expected in (("-", 0.0), ("+", box.size[k])):
            part = Box(box.lower, upper, box.axes, box.sign > 0.0, [letter + mark])
            corner = part.facets(box.lower, upper, 0.2).corner
            own = (corner - box.lower) @ box.axes.T
            np.testing.assert_allclose(own[..., k], expected, atol=1e-15)
            reach = own.reshape(-1, box.dim)
            for j in set(range(box.dim)) - {k}:
                np.testing.assert_allclose([reach[:, j].min(), reach[:, j].max()], [0, box.size[j]],
                                           atol=1e-15)  # fmt: skip
            x = places(box.dim)
            np.testing.assert_array_equal(part.distance(x), box.distance(x))


def test_the_widths_of_a_footing_go_along_the_given_direction():
    pad = Footing([0.0, 0.0, 1.0], [0.0, 0.0, -3.0], [2.0, 0.5], along=[0.0, 1.0, 1.0])
    corner = pad.facets(np.zeros(3), np.zeros(3), 0.1).corner.reshape(-1, 3)
    np.testing.assert_allclose(corner.min(axis=0), [-0.25, -1.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(corner.max(axis=0), [0.25, 1.0, 1.0], atol=1e-15)


@pytest.mark.parametrize("name", ["circle", "cylinder", "sphere"])
def test_the_radial_vector_leads_from_the_centre_or_axis(name):
    geometry = GEOMETRIES[name]
    x = places(geometry.dim)
    radial = geometry.radial(x)
    np.testing.assert_allclose(geometry.distance(x), 0.7 - np.linalg.norm(radial, axis=1))
    np.testing.assert_allclose(geometry.radial(x - radial), 0.0, atol=1e-15)
    np.testing.assert_allclose(geometry.radial(x + 0.5 * radial), 1.5 * radial, atol=1e-14)


@pytest.mark.parametrize("name", ["circle", "cylinder", "sphere"])
def test_few_facets_still_go_round(name):
    geometry = GEOMETRIES[name]
    facets = geometry.facets(-np.ones(geometry.dim), np.ones(geometry.dim), 100.0)
    directions = np.unique(facets.normal.round(9), axis=0)
    assert len(directions) >= 16


@pytest.mark.parametrize("name", GEOMETRIES)
def test_the_ratio_of_areas_is_that_of_the_projection(name):
    # By central differences of the projected places along the facet.
    geometry, step = GEOMETRIES[name], 3e-6
    reach = np.ones(geometry.dim)
    facets = geometry.facets(-reach, reach, 0.3)
    share = np.random.default_rng(2).dirichlet(np.ones(geometry.dim), len(facets.corner))
    x = np.einsum("nc,nci->ni", share, facets.corner)
    first = facets.corner[:, 1] - facets.corner[:, 0]
    first /= np.linalg.norm(first, axis=1)[:, None]
    directions = [first] if geometry.dim == 2 else [first, np.cross(first, facets.normal)]
    rates = []
    for along in directions:
        ahead, behind = (geometry.project(x + s * along, facets.normal)[0] for s in (step, -step))
        rates.append((ahead - behind) / (2.0 * step))
    area = np.linalg.norm(rates[0] if geometry.dim == 2 else np.cross(*rates), axis=1)
    _, ratio = geometry.project(x, facets.normal)
    assert ratio.shape == (len(x),)
    assert geometry.flat == (np.abs(ratio - 1.0).max() < 1e-3)
    np.testing.assert_allclose(ratio, area, rtol=1e-8)


def test_the_sides_of_many_polygons_are_told_also_near_their_vertices():
    rng = np.random.default_rng(9)
    acute = 0
    for corners in rng.integers(3, 12, 40):
        angle = 2.0 * np.pi * (np.arange(corners) + rng.uniform(0.0, 0.7, corners)) / corners
        radius = rng.choice([0.05, 0.3, 1.0], corners) * rng.uniform(0.5, 1.0, corners)
        vertex = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        distances = 10.0 ** rng.uniform(-6.0, -1.0, (20 * corners, 1))
        near = np.repeat(vertex, 20, axis=0) + distances * rng.normal(size=(20 * corners, 2))
        x = np.concatenate([places(2, n=100), near])
        left = bool(rng.integers(2))
        distance = Polyline(vertex, closed=True, left=left).distance(x)
        np.testing.assert_array_equal(distance > 0.0, in_polygon(x, vertex) == left)
        edge = np.roll(vertex, -1, axis=0) - vertex
        acute += ((edge * np.roll(edge, 1, axis=0)).sum(axis=1) < 0.0).sum()
    assert acute > 40
