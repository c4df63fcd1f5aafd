# SPDX-License-Identifier: BSD-3-Clause
"""A spline cut at grid lines: every piece in one cell, integrals exact on any grid."""

import numpy as np
import pytest

from tilth.curves import Chain, LocalCubicSpline
from tilth.curves.quadrature import cut_at_grid, gauss_points
from tilth.grid.background import Grid

GRIDS = [
    ([0.0, 0.0], [0.5, 0.5]),  # through the points on the axes
    ([0.013, -0.2], [0.31, 0.17]),
    ([0.0, 0.0], [1.0, 1.0]),  # touches the ellipse at (0, 1) and (2, 0)
    ([1e4, -1e4], [0.25, 0.3]),
    ([0.3, 0.1], [7.0, 9.0]),
    ([0.011, 0.007], [0.02, 0.03]),  # many lines across a segment
]
CORNER = np.zeros(24, dtype=bool)
CORNER[[3, 4, 12]] = True


def ellipse(n=24, shift=0.0):
    angle = 2.0 * np.pi * (np.arange(n) + shift) / n
    return np.stack([2.0 * np.cos(angle), np.sin(angle)], axis=1)


def cut(spline, grid, number=4):
    pieces = cut_at_grid(spline, Grid(np.array(grid[0]), np.array(grid[1])))
    return pieces, gauss_points(spline, pieces, number)


def covered_once(spline, pieces):
    """Whether the pieces of each segment follow each other from 0 to 1."""
    first = np.append(True, np.diff(pieces.segment) != 0)
    last = np.append(first[1:], True)
    np.testing.assert_array_equal(pieces.segment[first], np.arange(len(spline)))
    np.testing.assert_array_equal(pieces.begin[first], 0.0)
    np.testing.assert_array_equal(pieces.end[last], 1.0)
    np.testing.assert_array_equal(pieces.end[~last], pieces.begin[~first])
    assert (pieces.end > pieces.begin).all()


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("corner", [None, CORNER])
def test_each_piece_lies_in_its_cell(grid, corner):
    spline = LocalCubicSpline(Chain(ellipse(), True, corner))
    pieces, points = cut(spline, grid)
    covered_once(spline, pieces)
    place = (points.position - grid[0]) / grid[1] - pieces.cell[points.piece]
    assert place.min() > -1e-9
    assert place.max() < 1.0 + 1e-9
    # inner cuts lie on a grid line
    inner = pieces.begin > 0.0
    at = (spline.position(pieces.segment[inner], pieces.begin[inner]) - grid[0]) / grid[1]
    assert np.abs(at - np.rint(at)).min(axis=1).max(initial=0.0) < 1e-9


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("number", [3, 4])
def test_pressure_on_a_closed_curve_has_no_resultant(grid, number):
    for corner in (None, CORNER):
        spline = LocalCubicSpline(Chain(ellipse(), True, corner))
        _, points = cut(spline, grid, number)
        force = points.area_vector
        np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-14)
        moment = points.position[:, 0] * force[:, 1] - points.position[:, 1] * force[:, 0]
        assert abs(moment.sum()) < 1e-13
        # by Gauss's theorem the first moments of the same vectors are the area
        first = (points.position * force).sum(axis=0)
        np.testing.assert_allclose(first, -spline.area, rtol=1e-13)


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("number", [2, 3, 4])
def test_pressure_on_an_open_curve_is_that_on_its_chord(grid, number):
    spline = LocalCubicSpline(Chain(ellipse()[:17], False, CORNER[:17]))
    pieces, points = cut(spline, grid, number)
    covered_once(spline, pieces)
    chord = spline.chain.points[-1] - spline.chain.points[0]
    np.testing.assert_allclose(points.area_vector.sum(axis=0), [-chord[1], chord[0]], atol=1e-14)
    np.testing.assert_allclose(
        (points.weight[:, None] * points.derivative).sum(axis=0), chord, atol=1e-14
    )
    for piece in (0, len(pieces.segment) // 2):  # and so of each piece
        ends = spline.position(
            pieces.segment[[piece] * 2], np.array([pieces.begin, pieces.end])[:, piece]
        )
        ahead = ends[1] - ends[0]
        found = points.area_vector[points.piece == piece].sum(axis=0)
        np.testing.assert_allclose(found, [-ahead[1], ahead[0]], atol=1e-15)


@pytest.mark.parametrize("grid", GRIDS)
def test_the_lengths_of_the_pieces_sum_to_that_of_the_curve(grid):
    spline = LocalCubicSpline(Chain(ellipse(), True))
    _, points = cut(spline, grid, 10)
    np.testing.assert_allclose(points.length.sum(), spline.length, rtol=1e-13)
    for segment in (0, 7):
        own = points.length[points.segment == segment].sum()
        np.testing.assert_allclose(own, spline.lengths[segment], rtol=1e-12)
    _, points = cut(spline, grid, 4)
    np.testing.assert_allclose(points.length.sum(), spline.length, rtol=1e-8)


def test_a_constant_pressure_on_bilinear_functions_is_exact_with_five_points():
    spline = LocalCubicSpline(Chain(ellipse(), True))
    origin, cell = np.array([0.1, 0.07]), np.array([0.5, 0.4])
    pieces = cut_at_grid(spline, Grid(origin, cell))

    def nodal(number):
        points = gauss_points(spline, pieces, number)
        local = (points.position - origin) / cell - pieces.cell[points.piece]
        force = np.zeros((40, 40, 2))
        for i in (0, 1):
            for j in (0, 1):
                value = np.abs(1 - i - local[:, 0]) * np.abs(1 - j - local[:, 1])
                at = pieces.cell[points.piece] + [i + 20, j + 20]
                np.add.at(force, (at[:, 0], at[:, 1]), value[:, None] * points.area_vector)
        return force

    best = nodal(12)
    assert np.abs(nodal(5) - best).max() < 1e-15
    assert 1e-15 < np.abs(nodal(4) - best).max() < 1e-8


def test_sides_on_grid_lines_belong_to_the_cells_of_the_soil():
    square = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]])
    corner = np.ones(4, dtype=bool)
    for points, inside in ((square, True), (square[::-1], False)):
        spline = LocalCubicSpline(Chain(points, True, corner))
        pieces, gauss = cut(spline, ([0.0, 0.0], [0.5, 0.5]))
        assert len(pieces.segment) == 12  # cut at the lines across only
        assert abs(gauss.length.sum() - 6.0) < 1e-14
        middle = (pieces.cell + 0.5) * 0.5
        within = ((middle > square[0]) & (middle < square[2])).all(axis=1)
        assert (within == inside).all()


def test_round_off_does_not_cut_a_straight_line_along_a_grid_line():
    way = np.linspace(0.0, 3.0, 11)
    chain = Chain(np.stack([way, 0.7 + 1e-15 * (-1.0) ** np.arange(11)], axis=1), False)
    pieces, _ = cut(LocalCubicSpline(chain), ([0.0, 0.0], [0.3, 0.1]))
    assert len(pieces.segment) == 10
    np.testing.assert_array_equal(pieces.cell, [[i, 7] for i in range(10)])


def test_a_line_that_is_touched_does_not_cut():
    # a symmetric arc, its highest place in the middle of a segment and exactly on a line
    chain = Chain([[-1.0, 0.0], [-0.4, 0.5], [0.4, 0.5], [1.0, 0.0]], False)
    spline = LocalCubicSpline(chain)
    top = spline.position(np.array([1]), np.array([0.5]))[0, 1]
    for shift, number in ((0.0, 3), (1e-14, 3), (-1e-14, 3), (1e-6, 3), (-1e-6, 5)):
        grid = ([-5.0, top + shift - 10.0], [10.0, 10.0])
        pieces, points = cut(spline, grid)
        assert len(pieces.segment) == number, shift
        covered_once(spline, pieces)
        np.testing.assert_allclose(points.area_vector.sum(axis=0), [0.0, 2.0], atol=1e-14)


def test_a_line_is_crossed_at_an_inflection_along_it():
    # y = x^3: value, slope and curvature are 0 where the curve passes the line
    control = np.array([[-1.0, -1.0], [-1.0 / 3.0, 1.0], [1.0 / 3.0, -1.0], [1.0, 1.0]])
    spline = LocalCubicSpline(Chain(control[[0, 3]], False))
    spline.control = control[None]
    for shift in (0.0, 1e-14, -1e-14):
        pieces = cut_at_grid(spline, Grid(np.array([-5.0, shift]), np.array([10.0, 10.0])))
        np.testing.assert_allclose(pieces.begin, [0.0, 0.5], atol=1e-4)
        np.testing.assert_array_equal(pieces.cell, [[0, -1], [0, 0]])


def test_a_line_is_crossed_once_by_a_curve_that_winds_about_it_within_round_off():
    # y = 1e-9 (t - 0.3) (t - 0.5) (t - 0.7) turns twice, both times within 1e-11 of the line
    x = np.arange(4.0)
    first = -0.105 + 0.71 / 3.0
    y = 1e-9 * np.array([-0.105, first, -first, 0.105])
    spline = LocalCubicSpline(Chain(np.stack([x, y], axis=1)[[0, 3]], False))
    spline.control = np.stack([x, y], axis=1)[None]
    pieces = cut_at_grid(spline, Grid(np.array([-1.0, 0.0]), np.array([10.0, 1.0])))
    np.testing.assert_array_equal(pieces.cell[:, 1], [-1, 0])
    covered_once(spline, pieces)


def test_a_curve_through_a_node_is_cut_once_there():
    chain = Chain([[0.0, 0.0], [1.0, 1.0]], False)
    pieces, _ = cut(LocalCubicSpline(chain), ([0.0, 0.0], [0.25, 0.25]))
    np.testing.assert_allclose(pieces.begin, [0.0, 0.25, 0.5, 0.75], atol=1e-15)
    np.testing.assert_array_equal(pieces.cell, [[i, i] for i in range(4)])
    pieces, _ = cut(LocalCubicSpline(chain), ([1e-15, 0.0], [0.25, 0.25]))
    assert len(pieces.segment) == 4


def test_a_segment_may_cross_a_line_three_times():
    control = np.array([[0.0, 0.1], [1.0, 4.0], [2.0, -3.2], [3.0, 0.9]])
    spline = LocalCubicSpline(Chain(control[[0, 3]], False))
    spline.control = control[None]
    pieces = cut_at_grid(spline, Grid(np.array([-9.0, -9.5]), np.array([20.0, 10.0])))
    np.testing.assert_array_equal(pieces.cell[:, 1], [0, 1, 0, 1])
    place = spline.position(pieces.segment[1:], pieces.begin[1:])
    np.testing.assert_allclose(place[:, 1], 0.5, atol=1e-14)


def test_curves_that_wind_through_a_fine_grid_are_cut_at_every_line():
    rng = np.random.default_rng(11)
    spline = LocalCubicSpline(Chain(rng.uniform(-1.0, 1.0, (60, 2)), True))
    grid = ([0.003, 0.001], [0.05, 0.07])
    pieces, points = cut(spline, grid)
    covered_once(spline, pieces)
    dense = np.linspace(0.01, 0.99, 40)
    share = pieces.begin[:, None] + (pieces.end - pieces.begin)[:, None] * dense
    segment = np.repeat(pieces.segment, 40)
    place = (spline.position(segment, share.ravel()) - grid[0]) / grid[1]
    off = place - np.repeat(pieces.cell, 40, axis=0)
    assert off.min() > -1e-9
    assert off.max() < 1.0 + 1e-9
    np.testing.assert_allclose(points.area_vector.sum(axis=0), 0.0, atol=1e-13)


# --- lines at unequal distances ------------------------------------------------------------------


def graded(origin, size, ratio):
    """A grid whose cells grow on both sides of one line of each axis."""
    lines = []
    for smallest in size:
        grows = smallest * ratio ** np.arange(12)
        lines.append(np.concatenate([[0.0], np.cumsum(np.concatenate([grows[::-1], grows]))]))
    start = np.array(origin) - [line[12] for line in lines]
    return Grid(start, np.array(size), lines=tuple(lines))


UNEQUAL = [
    graded([0.3, -0.2], [0.05, 0.03], 1.3),
    graded([2.0, 1.0], [0.02, 0.02], 1.5),  # touches the ellipse at (2, 0) and (0, 1)
    graded([0.0, 0.0], [0.4, 0.1], 1.01),
]


@pytest.mark.parametrize("grid", UNEQUAL)
def test_each_piece_lies_in_its_cell_of_a_graded_grid(grid):
    spline = LocalCubicSpline(Chain(ellipse(), True, CORNER))
    pieces = cut_at_grid(spline, grid)
    covered_once(spline, pieces)
    points = gauss_points(spline, pieces, 10)
    place = grid.in_cells(points.position) - pieces.cell[points.piece]
    assert place.min() > -1e-9
    assert place.max() < 1.0 + 1e-9
    inner = pieces.begin > 0.0
    at = grid.in_cells(spline.position(pieces.segment[inner], pieces.begin[inner]))
    assert np.abs(at - np.rint(at)).min(axis=1).max() < 1e-9
    assert inner.sum() > 20
    np.testing.assert_allclose(points.length.sum(), spline.length, rtol=1e-12)


@pytest.mark.parametrize("beyond", [False, True])
def test_equal_lines_cut_as_a_uniform_grid(beyond):
    """Also where the curve is beyond the first and the last line."""
    spline = LocalCubicSpline(Chain(ellipse(), True))
    origin, size = np.array([-3.0, -3.0]), np.array([0.25, 0.125])
    count = (14, 30) if beyond else (30, 60)
    lines = tuple(h * np.arange(n) for h, n in zip(size, count, strict=True))
    found = cut_at_grid(spline, Grid(origin, size, lines=lines))
    expected = cut_at_grid(spline, Grid(origin, size))
    np.testing.assert_array_equal(found.cell, expected.cell)
    np.testing.assert_array_equal(found.segment, expected.segment)
    np.testing.assert_allclose(found.begin, expected.begin, atol=1e-12)
    np.testing.assert_allclose(found.end, expected.end, atol=1e-12)


def test_a_segment_may_cross_an_unequal_line_three_times():
    control = np.array([[0.0, 0.1], [1.0, 4.0], [2.0, -3.2], [3.0, 0.9]])
    spline = LocalCubicSpline(Chain(control[[0, 3]], False))
    spline.control = control[None]
    lines = np.array([0.0, 20.0, 34.0]), np.array([0.0, 8.0, 14.0])
    pieces = cut_at_grid(spline, Grid(np.array([-9.0, -7.5]), np.array([14.0, 6.0]), lines=lines))
    np.testing.assert_array_equal(pieces.cell[:, 1], [0, 1, 0, 1])
    place = spline.position(pieces.segment[1:], pieces.begin[1:])
    np.testing.assert_allclose(place[:, 1], 0.5, atol=1e-14)
