# SPDX-License-Identifier: BSD-3-Clause
"""Kernels of implicit boundaries against NumPy: which soil is touched, and the elements' sums."""

import itertools

import numpy as np
import pytest

from tilth import _core

CELL = np.array([0.5, 0.4, 0.7])
ORIGIN = np.array([0.1, -0.2, 0.05])


@pytest.fixture(autouse=True)
def _restore_threads():
    threads, points = _core.threads(), _core.parallel_from()
    _core.set_parallel_from(0)
    yield
    _core.set_threads(threads)
    _core.set_parallel_from(points)


def touching(place, position, half_length, normal=None):
    """Without normals the ellipsoids alone decide. Half lengths, or half edges (n, dim, dim)."""
    dim = place.shape[1]
    normal = np.zeros_like(place) if normal is None else normal
    grid = ORIGIN[:dim].copy(), CELL[:dim].copy()
    edges = half_length[:, :, None] * np.eye(dim) if half_length.ndim == 2 else half_length
    return np.asarray(
        _core.touching_points(np.array([0, len(place)]), place, normal, position, edges, *grid)
    )


def measure(place, position, half_length):
    """Squares of the distances in units of the points' boxes, shape (places, points)."""
    return (((place[:, None] - position) / half_length) ** 2).sum(axis=2)


def nearest_touched(place, position, half_length):
    """The same as the kernel's, by looking at all pairs."""
    squares = measure(place, position, half_length)
    nearest = squares.argmin(axis=1)
    least = squares[np.arange(len(place)), nearest]
    return np.where(least <= place.shape[1] * (1.0 + 1e-9), nearest, -1)


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
    given = cloud(dim, seed)
    expected = nearest_touched(*given)
    assert 100 < (expected >= 0).sum() < 500
    cells = [np.floor((x - ORIGIN[:dim]) / CELL[:dim]) for x in given[:2]]
    touched = expected >= 0
    apart = np.abs(cells[0][touched] - cells[1][expected[touched]]).max(axis=1)
    assert (apart == 1).sum() > 20  # across a cell's face
    np.testing.assert_array_equal(touching(*given), expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_boxes_up_to_half_a_width_away_along_the_normal_are_touched(dim):
    place, position, half_length = cloud(dim, 7, places=3000)
    half_length = np.minimum(half_length, 0.3 * CELL[:dim])  # one cell around is searched
    normal = np.random.default_rng(8).normal(size=place.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    offset = place[:, None] - position
    height = np.einsum("qpi,qi->qp", offset, normal)
    along = offset - height[..., None] * normal[:, None]
    beside = (np.abs(along) <= half_length).all(axis=2)
    beside &= np.abs(height) <= 2.0 * np.abs(normal) @ half_length.T
    squares = measure(place, position, half_length)
    by_ellipsoid = (squares <= dim).any(axis=1)
    cell = np.floor((place - ORIGIN[:dim]) / CELL[:dim])
    reached = (cell[:, None] == cell[by_ellipsoid]).all(axis=2).any(axis=1)  # in such cells no more
    touched = np.where(reached[:, None], squares <= dim, beside)
    expected = np.where(touched.any(axis=1), np.where(touched, squares, np.inf).argmin(axis=1), -1)
    assert (expected != nearest_touched(place, position, half_length)).sum() > 10
    found = touching(place, position, half_length, normal)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("normals", [False, True])
@pytest.mark.parametrize("dim", [2, 3])
def test_domains_with_corners_reach_as_far_as_their_own_shape(dim, normals):
    # One sheared and turned shape for all domains: in its coordinates they are boxes again.
    place, position, _ = cloud(dim, 5, places=2000)
    edge = 0.15 * np.array([[1.0, 0.4, 0.2], [-0.5, 0.9, 0.3], [0.1, -0.2, 1.1]])[:dim, :dim]
    normal = np.zeros_like(place)
    if normals:
        normal[:] = np.array([0.6, 0.8, 0.0])[:dim]
    offset = place[:, None] - position
    squares = ((offset @ np.linalg.inv(edge)) ** 2).sum(axis=2)
    height = offset @ normal[0]
    along = (offset - height[..., None] * normal[0]) @ np.linalg.inv(edge)
    beside = (np.abs(along) <= 1.0).all(axis=2) & normals
    beside &= np.abs(height) <= 2.0 * np.abs(edge @ normal[0]).sum()
    by_ellipsoid = (squares <= dim).any(axis=1)
    cell = np.floor((place - ORIGIN[:dim]) / CELL[:dim])
    reached = (cell[:, None] == cell[by_ellipsoid]).all(axis=2).any(axis=1)
    touched = np.where(reached[:, None], squares <= dim, beside)
    expected = np.where(touched.any(axis=1), np.where(touched, squares, np.inf).argmin(axis=1), -1)
    assert (expected >= 0).sum() > 50
    found = touching(place, position, np.tile(edge, (len(position), 1, 1)), normal)
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_all_neighbouring_cells_are_searched(dim):
    # One point in the middle of a cell, its box the whole cell: the ellipsoid reaches into each
    # neighbour across a face, and to each corner, but not beyond.
    middle = ORIGIN[:dim] + 0.5 * CELL[:dim]
    half = 0.5 * CELL[:dim]
    steps = np.array(list(np.ndindex(*(3,) * dim)), dtype=float) - 1.0
    steps = steps[np.abs(steps).any(axis=1)]
    to_ellipsoid = np.sqrt(dim) * steps / np.linalg.norm(steps, axis=1)[:, None]
    for share, expected in ((1.0 - 1e-6, 0), (1.0 + 1e-6, -1)):
        place = middle + share * to_ellipsoid * half
        found = touching(place, middle[None], half[None])
        np.testing.assert_array_equal(found, np.full(len(steps), expected))


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
    found = touching(place, position, half_length)
    assert (found >= 0).all()
    at = measure(place, position, half_length)[np.arange(len(place)), found]
    np.testing.assert_allclose(at, dim, rtol=1e-12)
    away = np.where(on_edges[outer] == 0.0, -1.0, np.where(on_edges[outer] == 1.0, 1.0, 0.0))
    assert (touching(place + 1e-6 * away, position, half_length) == -1).all()


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


def elements(dim, seed=31, count=40):
    """Random input of `surface_elements`; some elements have no quadrature point."""
    rng = np.random.default_rng(seed)
    start = np.concatenate([[0], np.cumsum(rng.integers(0, 6, count))])
    assert (np.diff(start) == 0).any()
    n, points = 2**dim, int(start[-1])
    shape = rng.uniform(-0.5, 1.0, (points, n))  # extrapolated ones are negative
    penalty = rng.normal(size=(points, dim, dim))  # no symmetry is assumed
    return start, shape, penalty, rng.normal(size=(points, dim))


@pytest.mark.parametrize("dim", [2, 3])
def test_the_elements_are_the_sums_over_their_points(dim):
    start, shape, penalty, constant = elements(dim)
    matrix, force = _core.surface_elements(start, shape, penalty, constant)
    n = shape.shape[1]
    assert np.asarray(matrix).shape == (40, n, n, dim, dim)
    assert np.asarray(force).shape == (40, n, dim)
    for e, (low, high) in enumerate(itertools.pairwise(start)):
        value, own = shape[low:high], penalty[low:high]
        expected = np.einsum("qa,qb,qij->abij", value, value, own)
        np.testing.assert_allclose(matrix[e], expected, rtol=1e-13, atol=1e-14)
        np.testing.assert_allclose(force[e], value.T @ constant[low:high], rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_matrix_is_the_derivative_of_the_force(dim):
    # f_a = integral of N_a [constant + P sum_b N_b u_b]: linear, so one difference is exact.
    start, shape, penalty, constant = elements(dim)
    matrix, force = (np.asarray(part) for part in
                     _core.surface_elements(start, shape, penalty, constant))  # fmt: skip
    element = np.repeat(np.arange(len(start) - 1), np.diff(start))
    u = np.random.default_rng(41).normal(size=force.shape)
    slip = np.einsum("qb,qbi->qi", shape, u[element])
    moved = constant + np.einsum("qij,qj->qi", penalty, slip)
    _, after = _core.surface_elements(start, shape, penalty, moved)
    change = np.einsum("eabij,ebj->eai", matrix, u)
    np.testing.assert_allclose(np.asarray(after) - force, change, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("dim", [2, 3])
def test_elements_are_the_same_for_any_number_of_threads(dim):
    given, results = elements(dim, count=3000), []
    for threads in (1, 2, 3, 2):
        _core.set_threads(threads)
        results.append([np.asarray(part) for part in _core.surface_elements(*given)])
    assert np.abs(results[0][0]).max() > 0.0
    for other in results[1:]:
        for a, b in zip(other, results[0], strict=True):
            np.testing.assert_array_equal(a, b)


def test_arrays_of_wrong_size_are_refused():
    start, shape, penalty, constant = elements(2)
    with pytest.raises(ValueError, match="penalty has"):
        _core.surface_elements(start, shape, penalty[:-1].copy(), constant)
    place, position, half_length = cloud(2, seed=0)
    with pytest.raises(ValueError, match="half_edge has"):
        touching(place, position, half_length[:-1].copy())
