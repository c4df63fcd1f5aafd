# SPDX-License-Identifier: BSD-3-Clause
"""Gap between a rigid surface and tracked surfaces of the soil, and soil inside a rigid body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_problems import KINDS, dimension
from soils_with_surfaces import SoilAtRest, ball, box

from tilth.boundaries.contact.overlap import soil_inside
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.curves.chain import Chain
from tilth.geometry.round import Circle, Sphere
from tilth.surface.tracked import TrackedSurface
from tilth.surface.tracked_triangles import TrackedSolidSurface, TrackedTriangles
from tilth.surface.triangles import Triangles

TRACKED = {"surface": {}, "spacing": 0.5}


def unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector, axis=-1, keepdims=True)


def rays(dim, count=300):
    return unit(np.random.default_rng(1).normal(size=(count, dim)))


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0])
@pytest.mark.parametrize("kind", KINDS)
def test_plane_surfaces_are_met_to_round_off(kind, angle):
    dim, a = dimension(kind), np.radians(angle)
    shift = np.array([5.0, 0.3, 0.1][:dim])
    soil = SoilAtRest(box(shift, shift + [3.1, 2.3, 2.7][:dim], angle=angle, **TRACKED), kind=kind)
    turn = np.eye(dim)
    turn[:2, :2] = [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]
    rng = np.random.default_rng(2)
    own = rng.uniform(0.5, 2.0, (300, dim))
    own[:, 1] = 2.3 + rng.uniform(-0.9, 1.5, 300)
    slanted = np.array([0.1, -1.0, -0.05][:dim]) / np.linalg.norm([0.1, 1.0, 0.05][:dim])
    for normal in (-np.eye(dim)[1], slanted):
        gap, point = soil.gap(shift + own @ turn, normal @ turn, behind=1.2)
        np.testing.assert_allclose(gap, (own[:, 1] - 2.3) / -normal[1], atol=1e-12)
        owner = (soil.points.position[point] - shift) @ turn.T
        np.testing.assert_allclose(owner[:, 1], 2.3 - 0.23, atol=1e-9)  # the uppermost of 5 rows
    # deep inside, beside, and leaving the soil through the opposite face
    own = np.full((4, dim), 1.1)
    own[:, 1] = [0.9, 4.9, -0.1, -1.5]
    gap, point = soil.gap(shift + own @ turn, -turn[1])
    np.testing.assert_array_equal(gap, [-np.inf, np.inf, np.inf, np.inf])
    np.testing.assert_array_equal(point, -1)


@pytest.mark.parametrize("hole", [False, True])
def test_a_circle_is_met_to_the_order_of_the_spline(hole):
    """A disc from outside; a hole, whose chain is reversed, from inside."""
    angle = np.linspace(0.0, 2.0 * np.pi, 397)[1:]
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    soil = SoilAtRest(ball([3.0, 4.0], 2.0, **TRACKED))
    surface = soil.surfaces["body 0"]
    errors = []
    for number in (24, 48, 96):
        at = 2.0 * np.pi * np.arange(number) / number
        vertices = [3.0, 4.0] + 2.0 * np.stack([np.cos(at), np.sin(at)], axis=1)
        assert isinstance(surface, TrackedSurface)
        chain = Chain(vertices[:: -1 if hole else 1], closed=True)
        surface.chains = [replace(surface.chains[0], current=chain)]
        radius, normal = (1.7, outward) if hole else (2.3, -outward)
        gap, _ = soil.gap([3.0, 4.0] + radius * outward, normal)
        errors.append(np.abs(gap - 0.3).max())
        overlap, _ = soil.gap([3.0, 4.0] + (4.0 - radius) * outward, normal)
        assert np.abs(overlap + 0.3).max() == pytest.approx(errors[-1], rel=1e-6)
    assert errors == pytest.approx([2.44e-5, 1.53e-6, 9.54e-8], rel=0.01)  # as documented
    assert min(np.log2(np.array(errors[:-1]) / errors[1:])) > 3.5


def test_a_sphere_is_met_to_the_second_order():
    errors = []
    for spacing in (0.4, 0.2):
        soil = SoilAtRest(
            ball([3.0, 3.0, 3.0], 2.0, spacing=0.5, surface={"spacing": spacing}), kind="3d"
        )
        outward = rays(3)
        gap, _ = soil.gap(3.0 + 2.2 * outward, -outward)
        errors.append(np.abs(gap - 0.2).max())
        assert gap.min() > 0.2 - 1e-12  # the triangles lie inside of the sphere
    assert errors[0] < (1.5 * 0.4) ** 2 / 3.0 / (2.0 * 2.0)  # height of a cap, longest edge 1.5
    assert 1.7 < np.log2(errors[0] / errors[1]) < 2.3


@pytest.mark.parametrize("kind", KINDS)
def test_inside_and_outside_are_told_apart_everywhere(kind):
    """Lines that meet no surface: from deep in a ball, or far from it; its curve may be open."""
    dim = dimension(kind)
    centre = np.array([0.0, 3.0] if kind == "axisymmetric" else [3.0] * dim)
    soil = SoilAtRest(ball(centre, 2.0, **TRACKED), kind=kind)
    x = centre + np.random.default_rng(2).uniform(-4.0, 4.0, (600, dim))
    if kind == "axisymmetric":
        x[:, 0] = np.abs(x[:, 0])
        assert not soil.surfaces["body 0"].chains[0].current.closed
    radius = np.linalg.norm(x - centre, axis=1)
    x = x[np.abs(radius - 2.0) > 0.3]
    inside = np.linalg.norm(x - centre, axis=1) < 2.0
    gap, point = soil.gap(x, rays(dim, len(x)), reach=0.2, behind=0.1)
    np.testing.assert_array_equal(gap, np.where(inside, -np.inf, np.inf))
    assert inside.sum() > 20
    assert (point == -1).all()


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_body_without_a_tracked_surface_keeps_its_domains(kind):
    dim, up = dimension(kind), np.eye(dimension(kind))[1]
    lower = box([0.0] * dim, [4.0, 1.9, 4.0][:dim], spacing=0.475)
    upper = box([0.0, 2.5, 0.0][:dim], [4.0, 3.4, 4.0][:dim], **TRACKED)
    soil = SoilAtRest(lower, upper, kind=kind)
    x = np.full((4, dim), 1.3)
    x[:, 1] = [4.0, 3.1, 2.3, 1.7]
    gap, point = soil.gap(x, -up, reach=3.0, behind=0.4)
    np.testing.assert_allclose(gap, [0.6, -0.3, 0.4, -0.2], atol=1e-12)
    np.testing.assert_array_equal(soil.points.body_id[point], [1, 1, 0, 0])


def test_an_open_curve_rules_where_lines_meet_it():
    vertices = [[0.0, 2.0], [1.0, 2.1], [2.0, 2.1], [4.0, 2.0]]
    body = box([0, 0], [4, 2], basis="gimp", points_per_cell=2)
    body["surface"] = {"vertices": vertices[::-1], "closed": False, "corner_angle": 1}
    soil = SoilAtRest(body)
    x = np.array([[1.5, 2.5], [1.5, 1.8], [4.3, 1.1], [-0.3, 1.1], [1.5, 0.9], [1.5, 3.9]])
    normal = np.array([[0, -1], [0, -1], [-1, 0], [1, 0], [0, -1], [0, -1]])
    gap, _ = soil.gap(x, normal, reach=1.0, behind=1.0)
    np.testing.assert_allclose(gap, [0.4, -0.3, 0.3, 0.3, -np.inf, np.inf], atol=1e-12)


def test_a_curve_through_material_points_is_not_the_soils_surface():
    body = box([0, 0], [4, 2], points_per_cell=2, surface={"points": "outer_layer"})
    gap, _ = SoilAtRest(body).gap([[1.3, 2.5]], [0.0, -1.0])
    np.testing.assert_allclose(gap, 0.5, atol=1e-12)


def test_a_curve_that_has_rolled_over_itself_leaves_it_to_the_domains():
    """A loop of the curve stands above the block, and crosses its top."""
    soil = SoilAtRest(box([0, 0], [4, 2], basis="cpdi1", **TRACKED))
    surface = soil.surfaces["body 0"]
    assert isinstance(surface, TrackedSurface)
    loop = [[0, 0], [4, 0], [4, 2], [2.2, 2], [1.5, 2.6], [1.5, 1.6], [2.4, 2.5], [1, 2], [0, 2]]
    chain = Chain(np.array(loop, dtype=float), True, np.ones(len(loop), dtype=bool))
    surface.chains = [replace(surface.chains[0], current=chain)]
    x = np.stack([np.linspace(0.1, 3.9, 50), np.full(50, 2.9)], axis=1)
    gap, point = soil.gap(x, [0.0, -1.0])
    by_domains = measure_gap(soil.points, soil.grid, {}, x, np.tile([0.0, -1.0], (50, 1)), 2.0, 1.0)
    np.testing.assert_allclose(gap, 0.9, atol=1e-12)
    np.testing.assert_array_equal(point, by_domains[1])


def test_triangles_that_have_folded_over_leave_their_lines_to_the_domains():
    """Of three layers the uppermost is upside down: lines leave the soil, then enter it twice."""
    soil = SoilAtRest(
        box([0.0] * 3, [4.0, 2.0, 4.0], spacing=0.5, surface={"spacing": 0.25}), kind="3d"
    )
    surface = soil.surfaces["body 0"]
    assert isinstance(surface, TrackedSolidSurface)
    old = surface.triangles.current
    top = (np.abs(old.vertices[:, 1] - 2.0) < 1e-9) & (np.abs(old.vertices[:, 0] - 2.0) < 1.9)
    vertices = old.vertices.copy()
    vertices[top, 0] += 2.0 * np.sin(0.5 * np.pi * old.vertices[top, 0])
    vertices[top, 1] += 0.1 * np.cos(0.25 * np.pi * (old.vertices[top, 0] - 2.0))
    surface.triangles = TrackedTriangles(Triangles(vertices, old.triangle), old.vertices)
    x = np.full((400, 3), 1.7)
    x[:, 0], x[:, 1] = np.linspace(0.05, 3.95, 400), 2.8
    gap, point = soil.gap(x, [0.0, -1.0, 0.0])
    assert np.isfinite(gap).all()
    assert (point >= 0).all()
    folded = np.abs(gap - 0.8) < 1e-12
    assert 50 < folded.sum() < 390
    assert np.abs(gap - 0.8).max() < 0.11


def test_no_line_slips_through_between_triangles():
    """Lines through vertices and edges, to round-off."""
    soil = SoilAtRest(box([0.0] * 3, [2.0] * 3, **TRACKED), kind="3d")
    surface = soil.surfaces["body 0"]
    assert isinstance(surface, TrackedSolidSurface)
    corner = surface.triangles.current.corner
    top = corner[(np.abs(corner[:, :, 1] - 2.0) < 1e-9).all(axis=1)]
    places = np.concatenate(
        [top.reshape(-1, 3), 0.5 * (top + np.roll(top, 1, axis=1)).reshape(-1, 3)]
    )
    places = places[(np.abs(places[:, [0, 2]] - 1.0) < 0.99).all(axis=1)]
    gap, _ = soil.gap(places + 0.4 * np.eye(3)[1], [0.0, -1.0, 0.0])
    np.testing.assert_allclose(gap, 0.4, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", ["gimp", "cpdi1"])
def test_soil_inside_a_rigid_body_is_found(kind, basis):
    """A ball half sunk into a block: as many points as lie in it; its depth is its radius."""
    dim = dimension(kind)
    centre = np.array([0.0, 2.0] if kind == "axisymmetric" else [2.0] * dim)
    soil = SoilAtRest(box([0.0] * dim, [4.0, 2.0, 4.0][:dim], basis), kind=kind)
    shape = (Circle if dim == 2 else Sphere)(centre, 1.1, inside=False)
    inside, depth = soil_inside(shape.distance, soil.points, 1e-9)
    distance = np.linalg.norm(soil.points.position - centre, axis=1)
    np.testing.assert_array_equal(inside, np.flatnonzero(distance < 1.1))
    assert depth == pytest.approx(1.1, abs=1e-9)  # the centre is a corner of domains
    few, _ = soil_inside(shape.distance, soil.points, 0.6)
    np.testing.assert_array_equal(few, np.flatnonzero(distance < 0.5))


def test_soil_that_only_touches_a_rigid_body_is_not_inside():
    soil = SoilAtRest(box([0, 0], [4, 2]))
    for height, expected in ((3.0, 0.0), (2.95, 0.05), (3.2, 0.0)):
        shape = Circle(np.array([1.5, height]), 1.0, inside=False)
        inside, depth = soil_inside(shape.distance, soil.points, 1e-9)
        assert len(inside) == 0
        assert depth == pytest.approx(expected, abs=1e-9)
