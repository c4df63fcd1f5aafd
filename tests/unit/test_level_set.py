# SPDX-License-Identifier: BSD-3-Clause
"""The boundary where a user's function is zero: length, area, normals, patches."""

import numpy as np
import pytest
from scipy.special import ellipe

from tilth.geometry.level_set import LevelSet

CENTRE = np.array([0.1, 0.03, -0.07])
RADIUS = 1.3


def ball(x):
    """Signed distance, the soil inside a circle or sphere."""
    return RADIUS - np.linalg.norm(x - CENTRE[: x.shape[1]], axis=1)


def paraboloid(x):
    """The same boundary by a function that is no distance."""
    return 5.0 * (RADIUS**2 - np.sum((x - CENTRE[: x.shape[1]]) ** 2, axis=1))


def ellipse(x):
    return 1.0 - (x[:, 0] / 1.5) ** 2 - (x[:, 1] / 0.8) ** 2


def torus(x):
    """Signed distance, the soil outside."""
    x = x - CENTRE  # so that no node lies on it, where facets without an area are dropped
    return np.hypot(np.hypot(x[:, 0], x[:, 1]) - 1.2, x[:, 2]) - 0.5


def floor(x):
    return x[:, -1].copy()


def facets_of(function, dim, size, box=2.0):
    level_set = LevelSet(function, dim, 0.4)
    return level_set, level_set.facets(np.full(dim, -box), np.full(dim, box), size)


def area_vectors(corner):
    if corner.shape[2] == 2:
        edge = corner[:, 1] - corner[:, 0]
        return np.stack([-edge[:, 1], edge[:, 0]], axis=1)
    return 0.5 * np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])


def gauss(facets):
    """Places, weights and facets of two points a segment or three a triangle."""
    if facets.corner.shape[2] == 2:
        near = 0.5 - 0.5 / 3.0**0.5
        weights = np.array([[1 - near, near], [near, 1 - near]])
    else:
        weights = np.full((3, 3), 1.0 / 6.0) + 0.5 * np.eye(3)
    places = np.einsum("gc,fci->fgi", weights, facets.corner).reshape(-1, facets.corner.shape[2])
    area = np.linalg.norm(area_vectors(facets.corner), axis=1)
    facet = np.repeat(np.arange(len(area)), len(weights))
    return places, area[facet] / len(weights), facet


PROBLEMS = {
    "circle": (ball, 2, 2 * np.pi * RADIUS, (0.4, 0.1)),
    "circle, no distance": (paraboloid, 2, 2 * np.pi * RADIUS, (0.4, 0.1)),
    "ellipse": (ellipse, 2, 6.0 * ellipe(1 - (0.8 / 1.5) ** 2), (0.4, 0.05)),
    "sphere": (ball, 3, 4 * np.pi * RADIUS**2, (0.5, 0.125)),
    "sphere, no distance": (paraboloid, 3, 4 * np.pi * RADIUS**2, (0.5, 0.125)),
    "torus": (torus, 3, 4 * np.pi**2 * 1.2 * 0.5, (0.4, 0.1)),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_length_and_area_converge(name):
    """Flat facets with order 2; with the projection's ratio the order of the Gauss rule, 4 or 3."""
    function, dim, exact, sizes = PROBLEMS[name]
    flat, curved = [], []
    for size in sizes:
        level_set, facets = facets_of(function, dim, size)
        x, weight, facet = gauss(facets)
        place, ratio = level_set.project(x, facets.normal[facet])
        np.testing.assert_allclose(level_set.distance(place), 0.0, atol=1e-12)
        flat.append(abs(weight.sum() / exact - 1.0))
        curved.append(abs((weight * ratio).sum() / exact - 1.0))
    halvings = np.log2(sizes[0] / sizes[1])
    assert np.log2(flat[0] / flat[1]) / halvings > 1.7
    assert np.log2(curved[0] / curved[1]) / halvings > 3.0
    assert curved[1] < 1e-2 * flat[1]


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_surface_is_closed_and_its_normals_point_into_the_soil(name):
    function, dim, exact, sizes = PROBLEMS[name]
    level_set, facets = facets_of(function, dim, sizes[1])
    vectors = area_vectors(facets.corner)
    area = np.linalg.norm(vectors, axis=1)
    np.testing.assert_allclose(vectors.sum(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(vectors / area[:, None], facets.normal, atol=1e-14)
    middle = facets.corner.mean(axis=1)
    along = np.sum(facets.normal * level_set.gradient(middle), axis=1)
    assert along.min() > 0.3  # slivers, on which the surface is tilted
    assert (area * (1.0 - along)).sum() < 2e-2 * exact
    np.testing.assert_allclose(
        level_set.distance(facets.corner.reshape(-1, dim)), 0.0, atol=1e-12 * 0.4
    )
    edge = np.linalg.norm(facets.corner - np.roll(facets.corner, 1, axis=1), axis=2)
    assert edge.max() <= dim**0.5 * sizes[1] * (1.0 + 1e-12)
    # Each end belongs to two segments, each edge to two triangles.
    corner = np.round(facets.corner, 9) + 0.0
    ends = corner if dim == 2 else np.stack([corner, np.roll(corner, 1, axis=1)], axis=2)
    ends = ends.reshape(-1, dim) if dim == 2 else ends.reshape(-1, 2, dim)
    if dim == 3:
        ends = np.array([sorted(map(tuple, pair)) for pair in ends]).reshape(-1, 2 * dim)
    _, number = np.unique(ends, axis=0, return_counts=True)
    assert set(number) == {2}


@pytest.mark.parametrize("dim", [2, 3])
def test_the_ratio_is_that_of_the_projection_onto_a_sphere(dim):
    """Along the radius: |n . m| (R / r)^(dim - 1), with the place's distance r from the centre."""
    level_set = LevelSet(ball, dim, 0.4)
    random = np.random.default_rng(1)
    direction, normal = random.normal(size=(2, 200, dim))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    normal = 0.3 * normal / np.linalg.norm(normal, axis=1)[:, None] - direction
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    r = RADIUS + random.uniform(-0.2, 0.2, 200)
    centre = CENTRE[:dim]
    place, ratio = level_set.project(centre + r[:, None] * direction, normal)
    np.testing.assert_allclose(place, centre + RADIUS * direction, atol=1e-8)
    expected = np.abs(np.sum(normal * direction, axis=1)) * (RADIUS / r) ** (dim - 1)
    np.testing.assert_allclose(ratio, expected, rtol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("function", [ball, paraboloid])
def test_a_larger_region_has_the_same_facets_in_each_patch(dim, function):
    level_set = LevelSet(function, dim, 0.4)
    small = level_set.facets(np.full(dim, -0.9), np.full(dim, 0.2), 0.3)
    large = level_set.facets(np.full(dim, -3.1), np.full(dim, 2.0), 0.3)
    assert 0 < len(small.group) < len(large.group)
    shared = np.isin(large.group, small.group)
    np.testing.assert_array_equal(large.group[shared], small.group)
    np.testing.assert_array_equal(large.corner[shared], small.corner)
    np.testing.assert_array_equal(large.normal[shared], small.normal)
    # A patch is one cell of the lattice, on both sides of the origin.
    cell = np.floor(large.corner.mean(axis=1) / 0.3).astype(int)
    assert cell.min() < 0 < cell.max()
    _, by_cell = np.unique(cell, axis=0, return_inverse=True)
    _, by_patch = np.unique(large.group, return_inverse=True)
    pairs = np.unique(np.stack([by_cell.ravel(), by_patch.ravel()]), axis=1)
    assert pairs.shape[1] == by_cell.max() + 1 == by_patch.max() + 1


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("height", [0.0, 0.5, 0.3])
def test_zeros_at_the_nodes_make_neither_holes_nor_double_facets(dim, sign, height):
    level_set = LevelSet(lambda x: sign * (x[:, -1] - height), dim, 0.5)
    facets = level_set.facets(np.full(dim, -1.0), np.full(dim, 1.0), 0.25)
    inside = (np.abs(facets.corner.mean(axis=1)) < 1.0).all(axis=1)
    area = np.linalg.norm(area_vectors(facets.corner), axis=1)
    assert area[inside].sum() == pytest.approx(2.0 ** (dim - 1), rel=1e-12)
    np.testing.assert_allclose(facets.normal, sign * np.eye(dim)[[-1] * len(area)], atol=1e-12)
    np.testing.assert_allclose(facets.corner[..., -1], height, atol=1e-14)


def test_zeros_at_single_nodes():
    """The diamond |x| + |y| = 1, with nodes on its corners and all along its sides."""
    for sign in (1.0, -1.0):
        _, facets = facets_of(lambda x, s=sign: s * (np.abs(x).sum(axis=1) - 1.0), 2, 0.25)
        length = np.linalg.norm(area_vectors(facets.corner), axis=1)
        assert length.sum() == pytest.approx(4.0 * 2.0**0.5, rel=1e-12)


def test_distance_is_the_function_or_its_first_order_estimate():
    x = np.random.default_rng(2).uniform(-2.0, 2.0, (500, 2))
    np.testing.assert_array_equal(LevelSet(ball, 2, 0.4).distance(x), ball(x))
    near = x[np.abs(ball(x)) < 0.1]
    estimate = LevelSet(paraboloid, 2, 0.4).distance(near)
    np.testing.assert_allclose(estimate, ball(near), atol=0.1**2 / (2 * (RADIUS - 0.1)))
    assert np.abs(estimate - ball(near)).max() > 1e-4
    # A distance with a kink stays what it is there too.
    wall = LevelSet(lambda x: 1.0 - np.abs(x[:, 0]), 2, 0.4)
    np.testing.assert_array_equal(wall.distance(np.zeros((3, 2))), 1.0)


def test_gradient_is_a_unit_vector_everywhere():
    x = np.random.default_rng(3).uniform(-2.0, 2.0, (500, 3))
    outward = (x - CENTRE) / np.linalg.norm(x - CENTRE, axis=1)[:, None]
    np.testing.assert_allclose(LevelSet(ball, 3, 0.4).gradient(x), -outward, atol=1e-8)
    np.testing.assert_allclose(LevelSet(paraboloid, 3, 0.4).gradient(x), -outward, atol=1e-8)
    for function in (lambda x: np.hypot(x[:, 0], x[:, 1]), lambda x: 0.0 * x[:, 0] + 1.0):
        direction = LevelSet(function, 2, 0.4).gradient(np.array([[0.0, 0.0], [1e-9, 0.0]]))
        np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-14)


def test_far_from_the_origin():
    """Coordinates of a map: nodes at the 20,000,000th line, steps above the round-off."""
    shift = np.array([5e6, -4e5])
    level_set = LevelSet(lambda x: RADIUS - np.linalg.norm(x - shift, axis=1), 2, 0.25)
    facets = level_set.facets(shift - 2.0, shift + 2.0, 0.25)
    x, weight, facet = gauss(facets)
    place, ratio = level_set.project(x, facets.normal[facet])
    assert (weight * ratio).sum() == pytest.approx(2 * np.pi * RADIUS, rel=1e-4)
    np.testing.assert_allclose(np.linalg.norm(place - shift, axis=1), RADIUS, atol=1e-8)
    np.testing.assert_allclose(level_set.gradient(place), (shift - place) / RADIUS, atol=1e-5)
    slope = LevelSet(lambda x: 0.6 * x[:, 0] + 0.8 * x[:, 1] - 0.6 * 5e6 + 0.8 * 4e5, 2, 0.25)
    np.testing.assert_allclose(slope.gradient(place), len(place) * [[0.6, 0.8]], atol=1e-5)


def test_no_boundary_in_the_region_gives_no_facets():
    for dim in (2, 3):
        _, facets = facets_of(lambda x: floor(x) + 100.0, dim, 0.5)
        assert facets.corner.shape == (0, dim, dim)
        assert facets.normal.shape == (0, dim)
        assert facets.group.shape == (0,)


def test_a_place_whose_projection_fails_stays():
    level_set = LevelSet(lambda x: 1.0 + x[:, 0] ** 2, 2, 0.4)  # nowhere zero
    x = np.array([[0.1, 0.2]])
    place, ratio = level_set.project(x, np.array([[1.0, 0.0]]))
    np.testing.assert_array_equal(place, x)
    np.testing.assert_array_equal(ratio, 1.0)
