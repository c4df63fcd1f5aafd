# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of triangles: normals, volume, quadrature, and long edges that are halved."""

import math

import numpy as np
import pytest

from tilth.curves import BadSurface
from tilth.surface.subdivide import subdivide
from tilth.surface.triangles import Triangles, triangle_rule

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
# Clockwise seen from outside: the soil is in the cube.
CUBE_FACES = np.array(
    [
        *([0, 3, 1], [0, 2, 3], [4, 7, 6], [4, 5, 7], [0, 5, 4], [0, 1, 5]),
        *([2, 7, 3], [2, 6, 7], [0, 6, 2], [0, 4, 6], [1, 7, 5], [1, 3, 7]),
    ]
)
STRETCH = np.array([[1.3, 0.2, 0.0], [0.0, 0.7, -0.4], [0.1, 0.0, 4.0]])


def cube() -> Triangles:
    return Triangles(CUBE, CUBE_FACES)


def skew() -> Triangles:
    """A parallelepiped far from the origin."""
    return Triangles(CUBE @ STRETCH.T + [100.0, -50.0, 3.0], CUBE_FACES)


def edges(triangles):
    corner = triangles.corner
    return np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)


def least_angle(triangles):
    side = np.sort(edges(triangles), axis=1)
    return np.arcsin(2.0 * triangles.area / (side[:, 1] * side[:, 2]))


def test_a_cube_has_its_normals_area_and_volume():
    surface = cube()
    assert surface.closed
    assert surface.volume == pytest.approx(1.0, rel=1e-15)
    np.testing.assert_allclose(surface.area, 0.5, rtol=1e-15)
    middle = surface.corner.mean(axis=1) - 0.5
    assert (np.einsum("ij,ij->i", surface.normal, middle) < 0.0).all()  # into the cube
    np.testing.assert_allclose(np.abs(surface.normal).sum(axis=1), 1.0)
    np.testing.assert_allclose(surface.area_vector, surface.area[:, None] * surface.normal)


def test_the_soil_may_be_outside():
    hole = Triangles(CUBE, CUBE_FACES[:, ::-1])
    assert hole.closed
    assert hole.volume == pytest.approx(-1.0, rel=1e-15)


def test_area_vectors_are_half_the_product_of_the_tangents_and_sum_to_zero():
    surface = skew()
    product = np.cross(surface.tangent[:, 0], surface.tangent[:, 1])
    np.testing.assert_allclose(surface.area_vector, 0.5 * product, rtol=1e-15)
    np.testing.assert_allclose(surface.area_vector.sum(axis=0), 0.0, atol=1e-13)
    assert surface.volume == pytest.approx(np.linalg.det(STRETCH), rel=1e-12)
    # the moment of a uniform pressure vanishes too
    moment = np.cross(surface.corner.mean(axis=1), surface.area_vector).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-10)


def test_vertex_normals_weigh_the_triangles_by_their_areas():
    # At vertex 0: two triangles of the plane z = 0, one of the plane x = 0 twice as large.
    vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 4], [9, 9, 9]]
    surface = Triangles(vertices, [[0, 1, 2], [0, 2, 3], [0, 3, 4]])
    assert not surface.closed
    normal = surface.vertex_normal
    np.testing.assert_allclose(normal[0], np.array([2.0, 0.0, 1.0]) / math.sqrt(5.0))
    np.testing.assert_allclose(normal[1], [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(normal[5], 0.0)
    inward = (0.5 - CUBE) * 2.0 / math.sqrt(3.0)
    alignment = np.einsum("ij,ij->i", cube().vertex_normal, inward)
    assert (alignment > 0.9).all()


def test_what_is_not_closed():
    assert not Triangles(CUBE, CUBE_FACES[1:]).closed
    turned = CUBE_FACES.copy()
    turned[3] = turned[3, ::-1]
    assert not Triangles(CUBE, turned).closed
    twice = Triangles(CUBE, np.concatenate([CUBE_FACES, CUBE_FACES]))
    assert not twice.closed
    with pytest.raises(BadSurface, match="closed surface"):
        _ = Triangles(CUBE, CUBE_FACES[1:]).volume


@pytest.mark.parametrize(("number", "degree"), [(3, 2), (6, 4)])
def test_rules_are_exact_up_to_their_degree_and_no_further(number, degree):
    rule = triangle_rule(number)
    assert rule.barycentric.shape == (number, 3)
    np.testing.assert_allclose(rule.barycentric.sum(axis=1), 1.0, rtol=1e-15)
    assert (rule.barycentric > 0.0).all()
    assert (rule.weight > 0.0).all()

    def error(a, b, c):
        # the integral of products of shares: a! b! c! / (a + b + c + 2)!
        factorial = math.factorial
        exact = factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 2)
        return abs(rule.weight @ np.prod(rule.barycentric ** [a, b, c], axis=1) - exact) / exact

    def powers(total):
        return [(a, b, total - a - b) for a in range(total + 1) for b in range(total + 1 - a)]

    for total in range(degree + 1):
        assert max(error(*p) for p in powers(total)) < 1e-13
    assert max(error(*p) for p in powers(degree + 1)) > 1e-3


def test_a_rule_integrates_over_triangles_in_space():
    surface, rule = skew(), triangle_rule(3)
    position = np.einsum("qc,mci->mqi", rule.barycentric, surface.corner)
    product = np.cross(surface.tangent[:, 0], surface.tangent[:, 1])
    # the divergence theorem for x and for x^2 / 2 in each direction, soil inside
    centre = np.array([100.0, -50.0, 3.0]) + STRETCH @ [0.5, 0.5, 0.5]
    for i in range(3):
        flux = -np.einsum("q,mq,m->", rule.weight, position[..., i], product[:, i])
        assert flux == pytest.approx(np.linalg.det(STRETCH), rel=1e-11)
        flux = -np.einsum("q,mq,m->", rule.weight, 0.5 * position[..., i] ** 2, product[:, i])
        assert flux == pytest.approx(np.linalg.det(STRETCH) * centre[i], rel=1e-11)


def test_there_are_two_rules():
    with pytest.raises(ValueError, match="3 and 6"):
        triangle_rule(4)


@pytest.mark.parametrize("longest", [3.0, 1.0, 0.3, 0.11])
@pytest.mark.parametrize("surface", [cube(), skew()], ids=["cube", "skew"])
def test_halved_edges_leave_the_body_what_it_is(surface, longest):
    result = subdivide(surface, longest)
    fine = result.triangles
    assert fine.closed
    assert edges(fine).max() <= longest
    assert fine.volume == pytest.approx(surface.volume, rel=1e-12)
    np.testing.assert_array_equal(fine.vertices[: len(surface.vertices)], surface.vertices)
    assert len(np.unique(fine.vertices, axis=0)) == len(fine.vertices)
    # each triangle lies in its old one
    np.testing.assert_allclose(fine.normal, surface.normal[result.origin], atol=1e-10)
    area = np.bincount(result.origin, fine.area, minlength=len(surface))
    np.testing.assert_allclose(area, surface.area, rtol=1e-11)
    assert least_angle(fine).min() >= 0.5 * least_angle(surface).min()


def test_new_vertices_are_half_way_between_their_parents():
    result = subdivide(skew(), 0.2)
    fine, old = result.triangles, len(CUBE)
    assert len(result.passes) > 3
    assert (result.parents < old + np.arange(len(result.parents))[:, None]).all()
    np.testing.assert_allclose(fine.vertices[result.parents].mean(axis=1), fine.vertices[old:])
    # a linear field is carried exactly, whatever its shape
    np.testing.assert_allclose(result.interpolated(skew().vertices), fine.vertices, rtol=1e-15)
    np.testing.assert_allclose(
        result.interpolated(skew().vertices @ [1.0, 2.0, 3.0]), fine.vertices @ [1.0, 2.0, 3.0]
    )


def test_one_long_edge_touches_its_neighbours_only():
    # A long triangle beside a row of short ones.
    vertices = [[0, 0, 0], [4, 0, 0], [2, 1, 0], [2, -0.9, 0], [5, 0.8, 0], [5.4, 0.2, 0]]
    strip = Triangles(vertices, [[0, 1, 2], [1, 0, 3], [1, 4, 2], [1, 5, 4]])
    result = subdivide(strip, 3.9)
    np.testing.assert_array_equal(result.parents, [[0, 1]])
    np.testing.assert_allclose(result.triangles.vertices[6], [2.0, 0.0, 0.0])
    assert sorted(result.origin.tolist()) == [0, 0, 1, 1, 2, 3]


def test_nothing_long_changes_nothing():
    result = subdivide(cube(), 1.5)
    np.testing.assert_array_equal(result.triangles.triangle, CUBE_FACES)
    assert len(result.parents) == 0
    np.testing.assert_array_equal(result.interpolated(CUBE), CUBE)
    with pytest.raises(ValueError, match="above zero"):
        subdivide(cube(), 0.0)


def test_parts_stay_with_their_triangles():
    number = np.repeat([0, 1, 2, 3, 4, 5], 2)
    names = ["x-", "x+", "y-", "y+", "z-", "z+"]
    fine = subdivide(Triangles(CUBE, CUBE_FACES, names, number), 0.2).triangles
    for i, axis in enumerate("xyz"):
        for side, place in (("-", 0.0), ("+", 1.0)):
            own = fine.in_part(axis + side)
            np.testing.assert_array_equal(fine.corner[own][..., i], place)
            assert fine.area[own].sum() == pytest.approx(1.0, rel=1e-13)
    with pytest.raises(BadSurface, match='no part "top"'):
        fine.in_part("top")


@pytest.mark.parametrize(
    ("vertices", "triangle", "problem", "wrong"),
    [
        (CUBE[:, :2], CUBE_FACES, r"vertices of shape \(8, 2\)", ()),
        (CUBE, [[0, 1]], r"triangles of shape \(1, 2\)", ()),
        (CUBE, np.empty((0, 3)), r"triangles of shape \(0, 3\)", ()),
        (CUBE, [[0, 1, 2], [0, 1, 8]], "triangles 1 have vertices that do not exist", (1,)),
        (CUBE, [[0, 1, -1]], "triangles 0 have vertices that do not exist", (0,)),
        (CUBE * np.nan, [[0, 1, 2]], "coordinates of triangles 0 are not numbers", (0,)),
        (CUBE, [[0, 1, 2], [0, 1, 1]], "triangles 1 have no height", (1,)),
        (1e6 + CUBE * 1e-10, [[0, 1, 2]], "triangles 0 have no height", (0,)),
    ],
)
def test_triangles_that_are_no_surface(vertices, triangle, problem, wrong):
    with pytest.raises(BadSurface, match=problem) as error:
        Triangles(vertices, triangle)
    assert error.value.numbers == wrong
    assert error.value.remedy in str(error.value)


def test_values_spread_from_known_vertices() -> None:
    """From the mean of the neighbours; from one vertex to all of the cube, layer by layer."""
    surface = cube()
    values = np.arange(8.0)[:, None] * [1.0, -2.0]
    known = np.ones(8, dtype=bool)
    np.testing.assert_array_equal(surface.spread(values, known), values)
    known[0] = False
    near = np.unique(surface.triangle[(surface.triangle == 0).any(axis=1)])[1:]
    found = surface.spread(values, known)
    np.testing.assert_allclose(found[0], values[near].mean(axis=0), rtol=1e-15)
    np.testing.assert_array_equal(found[1:], values[1:])
    only = np.arange(8) == 7
    np.testing.assert_allclose(surface.spread(values, only), np.tile(values[7], (8, 1)), rtol=1e-15)
    np.testing.assert_array_equal(surface.spread(values, ~np.ones(8, dtype=bool)), 0.0)


def test_a_part_must_exist():
    with pytest.raises(BadSurface, match="parts that do not exist"):
        Triangles(CUBE, CUBE_FACES, ["side"], np.ones(12))
