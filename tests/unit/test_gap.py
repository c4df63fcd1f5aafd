# SPDX-License-Identifier: BSD-3-Clause
"""Gap between a rigid surface and the outer boundary of the material points' domains."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import BASES, KINDS, dimension
from soils_with_surfaces import SoilAtRest, box

from tilth import _core
from tilth.boundaries.surfaces.gap import measure_gap
from tilth.grid.background import Grid
from tilth.mpm.domains import half_edges

WIDENING = 0.05  # of a domain across a line, see docs/theory/contact.md


def unit(vector):
    return np.asarray(vector) / np.linalg.norm(vector, axis=-1, keepdims=True)


def above(kind, y, count=200, low=0.6, high=3.4):
    """Places over a block from 0 to 4 at heights y, not at its edges."""
    dim = dimension(kind)
    x = np.random.default_rng(1).uniform(low, high, (count, dim))
    x[:, 1] = y
    return x


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
def test_a_flat_surface_is_met_where_it_is(kind, basis):
    dim = dimension(kind)
    soil = SoilAtRest(box([0.0] * dim, [4.0] * dim, basis), kind=kind)
    heights = 4.0 + np.linspace(-0.9, 1.9, 200)
    x, down = above(kind, heights), -np.eye(dim)[1]
    gap, point = soil.gap(x, down)
    np.testing.assert_allclose(gap, heights - 4.0, atol=1e-12)
    owner = soil.points.position[point]
    np.testing.assert_allclose(owner[:, 1], 3.75)
    assert np.abs(np.delete(owner - x, 1, axis=1)).max() <= 0.25 + 1e-12
    slanted = unit([0.3, -1.0, 0.2][:dim])
    gap, _ = soil.gap(x, slanted, reach=4.0, behind=1.5)
    straight = np.abs(x[:, 0] + gap * slanted[0] - 2.0) < 1.9  # others pass the edge
    assert straight.sum() > 100
    # a domain is widened by 5 % across a slanted line, which moves its face by less than that
    error = gap[straight] - (4.0 - heights[straight]) / slanted[1]
    assert np.abs(error).max() < WIDENING * 0.25


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_not_within_reach_is_infinite(kind):
    dim = dimension(kind)
    soil = SoilAtRest(box([0.0] * dim, [4.0] * dim), kind=kind)
    heights = np.array([6.1, 5.0, 3.1, 2.9, 0.1, -0.1, -2.0])
    gap, point = soil.gap(above(kind, heights, len(heights)), -np.eye(dim)[1], reach=2.0)
    np.testing.assert_allclose(gap, [np.inf, 1.0, -0.9, -np.inf, -np.inf, np.inf, np.inf])
    np.testing.assert_array_equal(point >= 0, np.isfinite(gap))
    behind = np.array([1.0, 1.0, 0.5, 1.5, 4.5, 1.0, 1.0])  # each point has its own
    gap, _ = soil.gap(above(kind, heights, len(heights)), -np.eye(dim)[1], 0.5, behind)
    np.testing.assert_allclose(gap, [np.inf, np.inf, -np.inf, -1.1, -3.9, np.inf, np.inf])


@pytest.mark.parametrize("basis", BASES)
def test_only_the_first_entry_counts(basis):
    soil = SoilAtRest(box([0, 3], [4, 4], basis), box([0, 0], [4, 2], basis))
    x = np.array([[1.3, 4.5], [1.3, 3.5], [1.3, 3.1], [1.3, 2.2], [1.3, 2.7]])
    gap, point = soil.gap(x, [0.0, -1.0], reach=3.0, behind=1.0)
    # from 3.1 the line begins above the upper body and enters it behind x
    np.testing.assert_allclose(gap, [0.5, -0.5, -0.9, 0.2, 0.7], atol=1e-12)
    np.testing.assert_array_equal(soil.points.body_id[point], [0, 0, 0, 1, 1])
    gap, _ = soil.gap(x, [0.0, -1.0], reach=3.0, behind=0.2)  # and here in it
    np.testing.assert_allclose(gap, [0.5, 1.5, 1.1, 0.2, 0.7], atol=1e-12)


def test_bodies_of_any_bases_are_measured_together():
    bodies = [box([i, 0], [i + 1, 2 + 0.1 * i], basis) for i, basis in enumerate(BASES)]
    soil = SoilAtRest(*bodies)
    at = np.arange(len(BASES))
    gap, point = soil.gap(np.stack([at + 0.4, np.full(len(at), 2.5)], axis=1), [0.0, -1.0])
    np.testing.assert_allclose(gap, 0.5 - 0.1 * at, atol=1e-12)
    np.testing.assert_array_equal(soil.points.body_id[point], at)


@pytest.mark.parametrize("thickness", [1e-3, 0.05, 0.4])
@pytest.mark.parametrize("kind", KINDS)
def test_soil_on_the_other_side_of_a_plate_does_not_count(kind, thickness):
    """Each side overlaps by a fifth of the plate's thickness; points are 0.5 apart."""
    dim, down = dimension(kind), -np.eye(dimension(kind))[1]
    soil = SoilAtRest(
        box([0.0] * dim, [4.0, 2.0, 4.0][:dim]), box([0.0, 2.0, 0.0][:dim], [4.0] * dim), kind=kind
    )
    upper = soil.points.body_id == 1
    soil.points.position[upper, 1] += 0.6 * thickness
    x = above(kind, 2.0 - 0.2 * thickness)
    for side, normal in (0, down), (1, -down):
        place = x + side * thickness * -down
        gap, point = soil.gap(place, normal, reach=0.5, behind=0.5 * thickness)
        np.testing.assert_allclose(gap, -0.2 * thickness, atol=1e-12)
        assert (soil.points.body_id[point] == side).all()


@pytest.mark.parametrize("kind", KINDS)
def test_no_line_slips_through_a_crack(kind):
    dim = dimension(kind)
    soil = SoilAtRest(box([0.0] * dim, [4.0] * dim), kind=kind)
    soil.points.half_length[:] *= 0.96
    for normal in (-np.eye(dim)[1], unit([0.2, -1.0, -0.1][:dim])):
        x = above(kind, 4.0, 2000, 1.2, 2.8)
        gap, _ = soil.gap(x, normal)
        surface = (x[:, 1] - 3.99) / -normal[1]  # the domains end 0.01 lower than before
        assert np.abs(gap - surface).max() < (1e-12 if normal[1] == -1.0 else 0.02)
    x[:, 1] = 2.0
    assert (soil.gap(x, -np.eye(dim)[1])[0] == -np.inf).all()


def widened_part(x, normal, centre, edge):
    """Begin and end of the part of a line in each domain: by clipping in the domain's own axes."""
    across = edge - np.einsum("pki,i->pk", edge, normal)[..., None] * normal
    edge = edge + WIDENING * across
    own = np.linalg.inv(edge)  # (x - c) @ own are the coordinates in half edges
    start = np.einsum("pi,pik->pk", x - centre, own)
    slope = np.einsum("i,pik->pk", normal, own)
    one, other = (-1.0 - start) / slope, (1.0 - start) / slope
    begin, end = np.minimum(one, other).max(axis=1), np.maximum(one, other).min(axis=1)
    return begin, end, np.abs(np.einsum("pki,i->pk", edge, normal)).sum(axis=1)


def expected_gap(x, normal, centre, edge, reach, behind):
    begin, end, half_width = widened_part(x, normal, centre, edge)
    met = np.flatnonzero(begin < end)
    closing = np.minimum(0.5 * behind, half_width)
    covered, last = -np.inf, None
    for p in met:
        if begin[p] <= -behind:
            covered = max(covered, end[p])
    while covered != last:
        last = covered
        for p in met:
            if begin[p] <= covered + closing[p]:
                covered = max(covered, end[p])
    entries = [p for p in met if -behind < begin[p] < reach and begin[p] > covered + closing[p]]
    if entries:
        return begin[entries].min()
    return -np.inf if covered > 0.0 else np.inf


@pytest.mark.parametrize("basis", ["gimp", "cpdi1"])
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("seed", range(4))
def test_it_is_that_of_a_search_through_all_domains(seed, kind, basis):
    """Sparse clouds of domains of all sizes, in the definition's own words."""
    rng, dim = np.random.default_rng(seed), dimension(kind)
    soil = SoilAtRest(box([0.0] * dim, [3.0] * dim, basis), kind=kind)
    points = soil.points
    points.position[:] += rng.uniform(-1.0, 1.0, points.position.shape) - 0.5
    if basis == "gimp":
        points.half_length[:] *= rng.choice([0.02, 0.3, 1.0, 1.9], points.half_length.shape)
        edge = np.einsum("pk,ki->pki", points.half_length, np.eye(dim))
    else:
        turn = np.eye(dim) + rng.uniform(-0.6, 0.6, (len(points), dim, dim))
        points.corner[:] = np.einsum("pij,pcj->pci", turn, points.corner)
        points.update_bounding_boxes()
        edge = half_edges(points)
    x = rng.uniform(-1.5, 3.5, (300, dim))
    normal, behind = unit(rng.normal(size=x.shape)), rng.choice([0.0, 0.3, 1.5], 300)
    gap, point = soil.gap(x, normal, 1.2, behind)
    expected = [
        expected_gap(*each, points.position, edge, 1.2, b)
        for *each, b in zip(x, normal, behind, strict=True)
    ]
    np.testing.assert_allclose(gap, expected, atol=1e-10)
    assert all((gap == value).sum() > 2 for value in (np.inf, -np.inf))
    found = point >= 0
    np.testing.assert_array_equal(found, np.isfinite(gap))
    for q in np.flatnonzero(found):
        begin, end, _ = widened_part(x[q], normal[q], points.position, edge)
        assert begin[point[q]] == pytest.approx(gap[q], abs=1e-10)
        assert begin[point[q]] < end[point[q]]


@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_quarter_turns_translation_and_another_grid_change_nothing(kind, basis):
    dim, rng = dimension(kind), np.random.default_rng(3)
    soil = SoilAtRest(box([0.0] * dim, [3.0] * dim, basis), kind=kind)
    points = soil.points
    points.position[:] += rng.uniform(-0.1, 0.1, points.position.shape)
    x, normal = rng.uniform(-1.0, 4.0, (400, dim)), unit(rng.normal(size=(400, dim)))
    gap, point = soil.gap(x, normal)
    assert np.isfinite(gap).sum() > 80
    other, _ = measure_gap(
        points, Grid(np.full(dim, 0.37), np.full(dim, 0.71)), {}, x, normal, 2.0, 1.0
    )
    np.testing.assert_allclose(other, gap, atol=1e-12)
    turn = np.eye(dim)
    turn[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    shift = np.array([5.3, -7.1, 0.4][:dim])
    points.position[:] = points.position @ turn.T + shift
    points.half_length[:] = points.half_length @ np.abs(turn.T)
    points.corner[:] = points.corner @ turn.T
    other, same = soil.gap(x @ turn.T + shift, normal @ turn.T)
    np.testing.assert_allclose(other, gap, atol=1e-12)
    np.testing.assert_array_equal(same, point)


@pytest.mark.usefixtures("every_loop_in_parallel")
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_any_number_of_threads_gives_the_same_bits(kind):
    dim, rng = dimension(kind), np.random.default_rng(3)
    soil = SoilAtRest(box([0.0] * dim, [3.0] * dim), kind=kind)
    soil.points.position[:] += rng.uniform(-0.1, 0.1, soil.points.position.shape)
    x, normal = rng.uniform(-1.0, 4.0, (2000, dim)), unit(rng.normal(size=(2000, dim)))
    found = []
    for threads in (1, 2, 5):
        _core.set_threads(threads)
        found.append(soil.gap(x, normal))
    for gap, point in found[1:]:
        assert gap.tobytes() == found[0][0].tobytes()
        np.testing.assert_array_equal(point, found[0][1])


@pytest.mark.parametrize("angle", [10.0, 30.0, 45.0])
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_turned_body_is_met_on_its_surface(kind, angle):
    """Exact with domains that turn with it; boxes are a row of teeth around the right mean."""
    dim, a = dimension(kind), np.radians(angle)
    along = np.array([np.cos(a), np.sin(a), 0.0][:dim])
    up = np.array([-np.sin(a), np.cos(a), 0.0][:dim])
    u = np.linspace(1.0, 5.0, 801)[:, None]
    x = u * along + 3.1 * up + 1.3 * np.eye(dim)[-1] * (dim == 3)
    for basis in BASES:
        soil = SoilAtRest(box([0.0] * dim, [6.0, 3.0, 3.0][:dim], basis, angle), kind=kind)
        error = (soil.gap(x, -up)[0] - 0.1) / 0.5  # in point spacings
        if basis in _core.corner_basis_names():
            np.testing.assert_allclose(error, 0.0, atol=1e-9)
        else:
            assert abs(error.mean()) < 0.05
            assert error.std() < 0.15
            if angle == 45.0:  # triangular teeth of height 1/2 / (1 + widening) in front of 1/2
                teeth = 0.5 - np.sqrt(0.5) + 0.25 / (1.0 + WIDENING)
                assert error.mean() == pytest.approx(teeth, abs=1e-3)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_distorted_domains_of_neighbours_have_one_surface(kind):
    """Corners that neighbours share are moved, those of the top in it."""
    dim = dimension(kind)
    soil = SoilAtRest(box([0.0] * dim, [4.0] * dim, "cpdi2"), kind=kind)
    points = soil.points
    corner = points.position[:, None] + points.corner
    moved = corner + 0.15 * np.sin(3.0 * np.roll(corner, 1, axis=2) + corner)
    moved[..., 1] = np.where(corner[..., 1] == 4.0, 4.0, np.minimum(moved[..., 1], 3.9))
    points.corner[:] = moved - points.position[:, None]
    points.update_bounding_boxes()
    x = above(kind, 4.2, 2000, 0.9, 3.1)
    gap, _ = soil.gap(x, -np.eye(dim)[1])
    np.testing.assert_allclose(gap, 0.2, atol=1e-12)
    x[:, 1] = 1.5
    gap, _ = soil.gap(x, unit([0.1, -1.0, 0.3][:dim]), reach=1.0)
    assert (gap == -np.inf).all()


@pytest.mark.parametrize("shift", [0.1, 0.3, 0.45])
def test_a_staircase_of_domains_is_met_where_its_volume_ends(shift):
    """A slope of 1 : 2: over whole periods the mean is that of the columns' tops, not the slope's.

    Lines along the normal measure the stair-case's mean height times cos of the slope.
    """
    vertices = [[0.0, -3.0], [12.0, -3.0], [12.0, 6.0 + shift], [0.0, shift]]
    soil = SoilAtRest({"shape": {"type": "polygon", "vertices": vertices}, "basis": "gimp"})
    position = soil.points.position
    columns = np.arange(4.25, 8.0, 0.5)
    top = np.array([position[np.isclose(position[:, 0], c), 1].max() + 0.25 for c in columns])
    cosine, sine = np.array([2.0, 1.0]) / np.sqrt(5.0)
    height = (top - (0.5 * columns + shift)).mean() * cosine
    x = np.linspace(4.0, 8.0, 2001)[1:]
    place = np.stack([x, 0.5 * x + shift], axis=1) + 0.2 * np.array([-sine, cosine])
    gap, _ = soil.gap(place, [sine, -cosine])
    assert gap.mean() == pytest.approx(0.2 - height, abs=0.03 * 0.5)


def test_there_may_be_nothing_to_measure():
    soil = SoilAtRest(box([0, 0], [1, 1]))
    gap, point = soil.gap(np.zeros((0, 2)), [0.0, 1.0])
    assert gap.shape == point.shape == (0,)


def test_wrong_input_is_refused():
    soil = SoilAtRest(box([0, 0], [1, 1]))
    x = np.zeros((3, 2))
    for arguments, words in (
        ((x, [0.0, np.nan]), "normal"),
        ((x, [0.0, 2.0]), "normal"),
        ((np.full((3, 2), np.inf), [0.0, 1.0]), "position"),
        ((x, [0.0, 1.0], np.inf), "reach"),
        ((x, [0.0, 1.0], 1.0, -0.1), "behind"),
        ((np.zeros((3, 3)), [0.0, 0.0, 1.0]), "position"),
    ):
        with pytest.raises(ValueError, match=words):
            soil.gap(*arguments)
