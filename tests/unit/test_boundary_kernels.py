# SPDX-License-Identifier: BSD-3-Clause
"""Kernels of implicit boundaries against NumPy: which soil is touched, and the elements' sums."""

import numpy as np
import pytest

from tilth import _core
from tilth.grid.background import Grid

CELL = np.array([0.5, 0.4, 0.7])
ORIGIN = np.array([0.1, -0.2, 0.05])


@pytest.fixture(autouse=True)
def _restore_threads():
    threads, points = _core.threads(), _core.parallel_from()
    _core.set_parallel_from(0)
    yield
    _core.set_threads(threads)
    _core.set_parallel_from(points)


def touching(
    place, position, half_length, normal=None, edge=None, around=1, part=None, lines=(), reach=None
):
    """Without normals the boxes themselves decide; `edge`: half edges in the rows.

    With the parts that places stand for, also the shares of them that are touched. `lines`: of a
    graded grid; `reach`: of the points, (points, dim), instead of `around`.
    """
    dim = place.shape[1]
    normal = np.zeros_like(place) if normal is None else normal
    grid = Grid(ORIGIN[:dim].copy(), CELL[:dim].copy(), lines=lines)
    nearest, share = map(
        np.asarray,
        _core.find_contact(
            np.array([0, len(place)]),
            place,
            normal,
            np.zeros((len(place), dim, dim)) if part is None else part,
            position,
            half_length,
            np.zeros((0, dim, dim)) if edge is None else edge,
            np.zeros((0, dim, dim)) if edge is None else inverse_of(edge),
            np.full(dim, around),
            np.zeros((0, dim)) if reach is None else reach,
            grid,
        ),
    )
    np.testing.assert_array_equal(share > 0.0, nearest >= 0)
    return nearest if part is None else (nearest, share)


def inverse_of(edge):
    """Inverse of the matrices with the edges in their columns."""
    return np.ascontiguousarray(np.linalg.inv(edge.transpose(0, 2, 1)))


def measure(place, position, half_length):
    """Squares of the distances in units of the points' boxes, shape (places, points)."""
    return (((place[:, None] - position) / half_length) ** 2).sum(axis=2)


def expected_touch(place, normal, offset, in_units, width):
    """The same as the kernel's, by looking at all pairs of places and points.

    in_units(offset): offsets from the domains' centres in their half edges, (places, points, dim);
    width: half of the domains' across the normals, (places, points).
    """
    dim = place.shape[1]
    squares = (in_units(offset) ** 2).sum(axis=2)
    height = np.einsum("qpi,qi->qp", offset, normal)
    foot = in_units(offset - height[..., None] * normal[:, None])
    if dim == 2:
        facing = (foot**2).sum(axis=2) <= 1.0 + 2e-9
    else:
        facing = (np.abs(foot) <= 1.0 + 1e-9).all(axis=2)
    by_ellipsoid = (squares <= dim * (1.0 + 1e-9)) & facing
    reached = by_ellipsoid.any(axis=1)
    cell = np.floor((place - ORIGIN[:dim]) / CELL[:dim])
    open_to_boxes = ~(cell[:, None] == cell[reached]).all(axis=2).any(axis=1)
    for q in np.flatnonzero(~reached):  # gaps between places that are reached
        way = (place[reached] - place[q]) / CELL[:dim]
        length = np.linalg.norm(way, axis=1)
        near = (length <= 1.0) & (length > 0.0)
        pull = np.linalg.norm((way[near] / length[near, None]).sum(axis=0))
        open_to_boxes[q] |= near.sum() > 1 and pull <= 0.5 * near.sum()
    beside = facing & (np.abs(height) <= 2.0 * width * (1.0 + 1e-9))
    touched = np.where((open_to_boxes & ~reached)[:, None], beside, by_ellipsoid)
    return np.where(touched.any(axis=1), np.where(touched, squares, np.inf).argmin(axis=1), -1)


def expected_of_boxes(place, position, half_length, normal):
    offset = place[:, None] - position
    return expected_touch(
        place,
        normal,
        offset,
        lambda offset: offset / half_length,
        np.abs(normal) @ half_length.T,
    )


def directions(seed, shape):
    normal = np.random.default_rng(seed).normal(size=shape)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def cloud(dim, seed, places=600, points=150):
    """Places and points on both sides of the grid's origin, boxes from thin to a whole cell."""
    rng = np.random.default_rng(seed)
    cell = CELL[:dim]
    reach = (3.0 if dim == 2 else 1.5) * cell
    position = ORIGIN[:dim] + rng.uniform(-reach, reach, (points, dim))
    place = ORIGIN[:dim] + rng.uniform(-1.5 * reach, 1.5 * reach, (places, dim))
    half_length = cell * rng.choice([1e-3, 0.1, 0.25, 0.5], (points, dim))
    return place, position, half_length


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("dim", [2, 3])
def test_the_nearest_point_that_is_touched_is_found(dim, seed):
    place, position, half_length = cloud(dim, seed)
    half_length = np.minimum(half_length, 0.3 * CELL[:dim])  # one cell around is searched
    normal = directions(seed, place.shape)
    expected = expected_of_boxes(place, position, half_length, normal)
    touched = expected >= 0
    assert 30 < touched.sum() < 500
    cells = [np.floor((x - ORIGIN[:dim]) / CELL[:dim]) for x in (place, position)]
    apart = np.abs(cells[0][touched] - cells[1][expected[touched]]).max(axis=1)
    assert (apart == 1).sum() > 10  # across a cell's face
    squares = measure(place, position, half_length)
    assert (squares[touched].min(axis=1) > dim).any(), "some only stand beside"
    found = touching(place, position, half_length, normal)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_gaps_between_places_that_are_reached_are_closed(dim):
    """A row of thin boxes: the ellipsoids reach every other place along it."""
    count = 11
    position = np.tile(ORIGIN[:dim] + 0.4 * CELL[:dim], (count, 1))
    position[:, 0] += 0.4 * CELL[0] * np.arange(count)
    place = np.repeat(position, 2, axis=0)
    place[1::2, 0] += 0.2 * CELL[0]
    half_length = np.tile(0.2 * CELL[:dim], (count, 1))
    place[:, 1] -= {2: 1.25, 3: 1.6}[dim] * half_length[0, 1]
    normal = np.tile(np.eye(dim)[1], (len(place), 1))
    found = touching(place, position, half_length, normal)
    alone = measure(place, position, half_length).min(axis=1) > dim
    assert alone[1::2].all()
    assert not alone[::2].any()
    assert (found[1:-1] >= 0).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_given_by_their_edges_touch_the_same(dim):
    place, position, half_length = cloud(dim, 7, places=3000)
    half_length = np.minimum(half_length, 0.3 * CELL[:dim])
    edge = half_length[:, :, None] * np.eye(dim)
    normal = np.random.default_rng(8).normal(size=place.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    expected = touching(place, position, half_length, normal)
    found = touching(place, position, half_length, normal, edge)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_slanted_domains_over_several_cells(dim):
    """By looking at all pairs: ellipsoids first, then feet along the normal."""
    rng = np.random.default_rng(9 + dim)
    place, position, half_length = cloud(dim, 7, places=3000, points=20)
    edge = rng.normal(size=(20, dim, dim)) * 0.5 * CELL[:dim]
    normal = rng.normal(size=place.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    around = np.ceil(2.0 * np.abs(edge).sum(axis=1) / CELL[:dim]).astype(int).max()
    assert around >= 3
    offset = place[:, None] - position
    expected = expected_touch(
        place,
        normal,
        offset,
        lambda offset: np.einsum("pki,qpi->qpk", inverse_of(edge), offset),
        np.abs(np.einsum("pki,qi->qpk", edge, normal)).sum(axis=2),
    )
    found = touching(place, position, half_length, normal, edge, around)
    np.testing.assert_array_equal(found, expected)
    # one cell around a place is not enough
    assert (touching(place, position, half_length, normal, edge) != expected).any()


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("slanted", [False, True])
def test_points_that_reach_a_layer_of_cells_of_any_size_are_found(dim, slanted):
    """On a graded grid, large points beside small cells: as if all cells were searched."""
    rng = np.random.default_rng(20 + dim)
    growth = np.cumsum(np.append(0.0, 1.4 ** np.arange(8)))
    lines = tuple(h * np.append(growth[:-1], growth[-1] + growth) for h in CELL[:dim])
    ends = np.array([line[-1] for line in lines])
    position, place = (ORIGIN[:dim] + ends * rng.random((n, dim)) for n in (200, 2000))
    grid = Grid(ORIGIN[:dim].copy(), CELL[:dim].copy(), lines=lines)
    half_length = grid.sizes_at(position) * rng.choice([0.1, 0.25, 0.4], (200, dim))
    normal, edge, half = directions(21, place.shape), None, half_length
    if slanted:
        edge = rng.normal(size=(200, dim, dim)) * half_length[:, None]
        half = np.abs(edge).sum(axis=1)
    # the foot in the domain, and at most twice its width away along any normal
    reach = 2.0 * half + np.linalg.norm(half, axis=1)[:, None]
    everywhere = touching(place, position, half_length, normal, edge, 40, None, lines)
    found = touching(place, position, half_length, normal, edge, 0, None, lines, reach)
    assert (everywhere >= 0).sum() > 100
    np.testing.assert_array_equal(found, everywhere)


@pytest.mark.parametrize("dim", [2, 3])
def test_all_neighbouring_cells_are_searched(dim):
    # One point in the middle of a cell, its box the whole cell: the ellipsoid reaches into each
    # neighbour across a face, and to each corner.
    middle = ORIGIN[:dim] + 0.5 * CELL[:dim]
    half = 0.5 * CELL[:dim]
    steps = np.array(list(np.ndindex(*(3,) * dim)), dtype=float) - 1.0
    steps = steps[np.abs(steps).any(axis=1)]
    to_ellipsoid = np.sqrt(dim) * steps / np.linalg.norm(steps, axis=1)[:, None]
    place = middle + (1.0 - 1e-6) * to_ellipsoid * half
    normal = (place - middle) / np.linalg.norm(place - middle, axis=1)[:, None]
    found = touching(place, middle[None], half[None], normal)
    np.testing.assert_array_equal(found, np.zeros(len(steps)))


@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_that_tile_a_body_reach_to_its_faces(dim):
    # Also with the round-off of places that were computed another way.
    cell, half = CELL[:dim], 0.25 * CELL[:dim]
    number = np.array(list(np.ndindex(*(6,) * dim)))
    lower = ORIGIN[:dim] - cell  # the body is 3 cells long
    position = lower + (2 * number + 1) * half
    on_edges = np.array(list(np.ndindex(*(7,) * dim))) / 6.0  # corners of all boxes
    outer = ((on_edges == 0.0) | (on_edges == 1.0)).any(axis=1)
    place = lower + 3.0 * cell * on_edges[outer]
    half_length = np.tile(half, (len(position), 1))
    on_face = np.abs(2.0 * on_edges[outer] - 1.0).argmax(axis=1)
    normal = np.eye(dim)[on_face]
    found = touching(place, position, half_length, normal)
    assert (found >= 0).all()
    at = measure(place, position, half_length)[np.arange(len(place)), found]
    np.testing.assert_allclose(at, dim, rtol=1e-12)
    away = np.where(on_edges[outer] == 0.0, -1.0, np.where(on_edges[outer] == 1.0, 1.0, 0.0))
    beyond = place + 1.0001 * half * away  # they may stand half a box's width from a boundary
    assert (touching(beyond, position, half_length, normal) == -1).all()


@pytest.mark.parametrize("angle", [0.0, 17.0, 30.0, 45.0, 80.0])
def test_a_turned_row_of_boxes_covers_its_own_length(angle):
    """A row of square boxes on a line, both turned against the grid: no place beyond its ends.

    It begins on a node, so that places beyond it lie in another cell.
    """
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    along, across = np.array([cosine, sine]), np.array([-sine, cosine])
    half, count = 0.2, 7
    start = ORIGIN[:2] + CELL[:2]
    middle = start + (2.0 * np.arange(count)[:, None] + 1.0) * half * along
    position = middle + half * across
    part = np.linspace(-0.3, 1.3, 1601)
    place = start + 2.0 * half * count * part[:, None] * along
    normal = np.tile(across, (len(place), 1))
    found = touching(place, position, np.full((count, 2), half), normal)
    inside = (part > -1e-9) & (part < 1.0 + 1e-9)
    np.testing.assert_array_equal(found >= 0, inside)


@pytest.mark.parametrize("angle", [0.0, 17.0, 45.0])
@pytest.mark.parametrize("turned", [False, True])
def test_the_share_of_a_segment_that_a_row_of_domains_covers(angle, turned):
    """Segments one after the other on a line, and a row of boxes that begins and ends anywhere."""
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    along, across = np.array([cosine, sine]), np.array([-sine, cosine])
    half, count = 0.05, 13
    start = ORIGIN[:2] + 0.3 * CELL[:2]
    position = start + (2.0 * np.arange(count)[:, None] + 1.0) * half * along + half * across
    edge = np.tile(half * np.stack([along, across]), (count, 1, 1))
    length, number = 0.07, 30
    low = -0.31 + length * np.arange(number)
    place = start + (low[:, None] + 0.4 * length) * along
    part = np.tile(np.stack([-0.4 * length * along, length * along]), (number, 1, 1))
    normal = np.tile(across, (number, 1))
    half_length = np.full((count, 2), half)
    found, share = touching(place, position, half_length, normal, edge if turned else None, 2, part)
    end = 2.0 * half * count
    exact = np.clip((np.minimum(low + length, end) - np.maximum(low, 0.0)) / length, 0.0, 1.0)
    kept = (exact > 0.1 + 1e-9) | (exact == 0.0)  # less is left out where the place is beyond
    np.testing.assert_allclose(share[kept], exact[kept], atol=1e-5)
    assert ((share > 0.0) & (share < 1.0)).sum() >= 1
    np.testing.assert_array_equal(found >= 0, share > 0.0)


def test_the_share_of_a_triangle_that_a_box_covers():
    """The parts of its three points, cut by the face of a box: their sum is the triangle's."""
    corners = ORIGIN + np.array([[0.0, 0.0, 0.0], [0.3, 0.05, 0.0], [0.1, 0.25, 0.0]])
    after, before = np.roll(corners, -1, axis=0), np.roll(corners, 1, axis=0)
    place = (4.0 * corners + after + before) / 6.0
    part = np.stack([corners - place, 0.5 * (after - corners), 0.5 * (before - corners)], axis=1)
    normal = np.tile([0.0, 0.0, 1.0], (3, 1))
    for cut in (0.02, 0.09, 0.17, 0.24):
        half = np.array([[cut + 1.0, 1.0, 0.1]])
        position = ORIGIN + np.array([[-1.0, 0.1, 0.1]])
        _, share = touching(
            place,
            position,
            half,
            normal,
            0.5 * np.diag([2.0, 2.0, 2.0])[None] * half[..., None],
            4,
            part,
        )
        covered = np.where(share > 0.0, share, 0.0).mean()
        inside = np.random.default_rng(1).dirichlet([1.0, 1.0, 1.0], 200_000) @ corners
        exact = (inside[:, 0] < ORIGIN[0] + cut).mean()
        assert covered == pytest.approx(exact, abs=0.03)


def test_no_points_and_no_places():
    some, none = np.zeros((3, 2)), np.zeros((0, 2))
    np.testing.assert_array_equal(touching(some, none, none), [-1, -1, -1])
    assert len(touching(none, some, np.ones((3, 2)))) == 0


def test_places_far_away_touch_nothing():
    # Further than the lattice can number.
    place = np.array([[1e7, 0.2], [0.2, -1e7], [-1e9, 1e9], [0.2, 0.2]])
    found = touching(place, np.array([[0.21, 0.19]]), np.full((1, 2), 0.1))
    np.testing.assert_array_equal(found, [-1, -1, -1, 0])


@pytest.mark.parametrize("dim", [2, 3])
def test_the_order_of_places_and_points_does_not_matter(dim):
    place, position, half_length = cloud(dim, seed=11)
    found = touching(place, position, half_length)
    rng = np.random.default_rng(12)
    places, points = rng.permutation(len(place)), rng.permutation(len(position))
    shuffled = touching(place[places], position[points], half_length[points])
    np.testing.assert_array_equal(np.where(shuffled < 0, -1, points[shuffled]), found[places])


@pytest.mark.parametrize("dim", [2, 3])
def test_touched_points_are_the_same_for_any_number_of_threads(dim):
    # Each point is there twice, so that ties are broken too.
    place, position, half_length = cloud(dim, seed=21)
    position = np.concatenate([position, position])
    half_length = np.concatenate([half_length, half_length])
    found = []
    for threads in (1, 2, 3, 2):
        _core.set_threads(threads)
        assert _core.threads() == threads
        found.append(touching(place, position, half_length))
    assert (found[0] >= 0).any()
    for other in found[1:]:
        np.testing.assert_array_equal(other, found[0])


def test_arrays_of_wrong_size_are_refused():
    place, position, half_length = cloud(2, seed=0)
    with pytest.raises(ValueError, match="half_length has"):
        touching(place, position, half_length[:-1].copy())
