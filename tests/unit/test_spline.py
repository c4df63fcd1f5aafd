# SPDX-License-Identifier: BSD-3-Clause
"""Local cubic spline through a chain: orders, corners, locality, the exported B-spline."""

import numpy as np
import pytest

from tilth.curves import BadSurface, Chain, LocalCubicSpline
from tilth.curves.chain import sharp_corners

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
NUMBERS = (32, 64, 128, 256)


def ellipse(n, a, b, uneven=0.0):
    """Points anticlockwise; neighbouring distances differ by up to (1 + uneven) / (1 - uneven)."""
    shift = uneven * np.random.default_rng(4).uniform(-0.5, 0.5, n)
    angle = 2.0 * np.pi * (np.arange(n) + shift) / n
    return np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1)


def arc(n, a, b):
    """Points of an open part of an ellipse."""
    angle = np.linspace(0.3, 2.9, n)
    return np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1)


def everywhere(spline, number=16):
    """Segments and parameters of places all along a spline."""
    t = (np.arange(number) + 0.5) / number
    return np.repeat(np.arange(len(spline)), number), np.tile(t, len(spline))


def errors(points, closed, a, b):
    """Greatest errors of position, normal and curvature; of the area and the length too."""
    spline = LocalCubicSpline(Chain(points, closed))
    at = everywhere(spline)
    x = spline.position(*at)
    angle = np.arctan2(x[:, 1] / b, x[:, 0] / a)
    for _ in range(8):  # the foot of x on the ellipse
        foot = np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1)
        along = np.stack([-a * np.sin(angle), b * np.cos(angle)], axis=1)
        value = ((foot - x) * along).sum(axis=1)
        angle -= value / ((along**2).sum(axis=1) - ((foot - x) * foot).sum(axis=1))
    speed = np.linalg.norm(along, axis=1)
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1) / speed[:, None]
    return {
        "position": np.linalg.norm(x - foot, axis=1).max(),
        "normal": np.linalg.norm(spline.normal(*at) - inward, axis=1).max(),
        "curvature": np.abs(spline.curvature(*at) - a * b / speed**3).max(),
        "area": abs(spline.area - np.pi * a * b) if closed else None,
    }


def rates(make, closed, a, b):
    found = [errors(make(n), closed, a, b) for n in NUMBERS]
    keys = [key for key in found[0] if found[0][key] is not None]
    # over the whole range, since uneven points differ from one number to the next
    steps = np.log2(NUMBERS[-1] / NUMBERS[0])
    return {key: np.log2(found[0][key] / found[-1][key]) / steps for key in keys}, found[-1]


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (2.0, 1.0)])
@pytest.mark.parametrize("uneven", [0.0, 0.6])
def test_circle_and_ellipse_converge(a, b, uneven):
    rate, error = rates(lambda n: ellipse(n, a, b, uneven), True, a, b)
    expected = {"position": 4.0, "normal": 3.0, "curvature": 2.0, "area": 4.0}
    for key, order in expected.items():
        # one set of uneven points may be a little worse than another
        assert rate[key] > order - (0.1 if uneven == 0.0 else 0.3), (key, rate)
    assert error["position"] < 2e-7
    assert error["area"] < 1e-7


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (2.0, 1.0)])
def test_the_ends_of_an_open_curve_converge_alike(a, b):
    rate, error = rates(lambda n: arc(n, a, b), False, a, b)
    assert rate["position"] > 3.9, rate
    assert rate["normal"] > 2.9, rate
    assert rate["curvature"] > 1.9, rate
    assert error["position"] < 1e-8


def test_the_arc_length_of_a_circle_converges_and_so_does_the_parameter_of_the_knots():
    error = []
    for n in NUMBERS:
        spline = LocalCubicSpline(Chain(ellipse(n, 1.0, 1.0), True))
        segment, t = everywhere(spline)
        knot = spline.knots[segment] + t * np.diff(spline.knots)[segment]
        uneven = np.abs(spline.arc_length(segment, t) - knot).max()
        error.append([abs(spline.length - 2.0 * np.pi), uneven])
    assert np.log2(np.array(error[:-1]) / error[1:]).min() > 3.9
    assert error[-1][0] < 1e-8


def test_arc_length_and_derivatives_belong_to_the_position():
    spline = LocalCubicSpline(Chain(ellipse(12, 2.0, 1.0, 0.6), True))
    segment, t = everywhere(spline)
    step = 1e-5

    def difference(of):
        return (of(segment, t + step) - of(segment, t - step)) / (2.0 * step)

    derivative = spline.derivative(segment, t)
    np.testing.assert_allclose(difference(spline.position), derivative, atol=1e-9)
    np.testing.assert_allclose(
        difference(spline.derivative), spline.second_derivative(segment, t), atol=1e-9
    )
    speed = np.linalg.norm(derivative, axis=1)
    np.testing.assert_allclose(difference(spline.arc_length), speed, atol=1e-9)
    across = (spline.normal(segment, t) * derivative).sum(axis=1)
    np.testing.assert_allclose(across, 0.0, atol=1e-14)


def test_the_soil_is_on_the_left():
    circle = ellipse(64, 1.0, 1.0)
    for points, sign in ((circle, 1.0), (circle[::-1], -1.0)):
        spline = LocalCubicSpline(Chain(points, True))
        at = everywhere(spline)
        inward = -spline.position(*at)
        np.testing.assert_allclose((inward * spline.normal(*at)).sum(axis=1), sign, atol=1e-5)
        np.testing.assert_allclose(spline.curvature(*at), sign, atol=1e-3)
        np.testing.assert_allclose(spline.area, sign * np.pi, atol=1e-5)


@pytest.mark.parametrize("parts", [1, 2, 3, 7])
def test_a_square_keeps_its_corners_and_sides_exactly(parts):
    share = np.arange(parts)[:, None] / parts
    points = np.concatenate(
        [p + share * (q - p) for p, q in zip(SQUARE, np.roll(SQUARE, -1, axis=0), strict=True)]
    )
    corner = sharp_corners(points, True, 40.0)
    np.testing.assert_array_equal(np.flatnonzero(corner), parts * np.arange(4))
    spline = LocalCubicSpline(Chain(points, True, corner))
    x = spline.position(*everywhere(spline))
    # the distance to the nearest of the four lines
    off = np.minimum(np.abs(x), np.abs(1.0 - x)).min(axis=1)
    assert off.max() < 1e-15
    assert abs(spline.area - 1.0) < 1e-15
    assert abs(spline.length - 4.0) < 1e-14
    segment, t = np.arange(len(spline)), np.zeros(len(spline))
    np.testing.assert_array_equal(spline.position(segment, t), points)
    np.testing.assert_allclose(np.abs(spline.normal(*everywhere(spline))).max(axis=1), 1.0)


def test_straight_runs_stay_straight_beside_a_curve():
    # a stadium: two straight runs and two half circles, no corner
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)
    right = np.stack([2.0 + np.cos(angle), np.sin(angle)], axis=1)
    line = np.stack([np.linspace(2.0, -2.0, 9)[1:-1], np.ones(7)], axis=1)
    half = np.concatenate([right, line])
    spline = LocalCubicSpline(Chain(np.concatenate([half, -half]), True))
    for segments in (np.arange(8, 16), np.arange(24, 32)):
        x = spline.position(*(v.ravel() for v in np.meshgrid(segments, np.linspace(0, 1, 9))))
        assert np.ptp(x[:, 1]) < 1e-14
    # far from the origin and in a slanting direction straightness is lost to round-off only
    way = np.array([0.6, 0.8])
    along = 1e6 + np.cumsum(np.random.default_rng(2).uniform(0.2, 1.0, 12))
    spline = LocalCubicSpline(Chain(along[:, None] * way, False))
    x = spline.position(*everywhere(spline))
    assert np.abs(x @ np.array([-0.8, 0.6])).max() < 1e-9


def test_runs_of_two_and_three_points_between_corners():
    # a lens of two circular arcs of three points each, then half of it with a chord
    angle = np.radians([-45.0, 0.0, 45.0])
    right = np.stack([np.cos(angle) - np.cos(angle[0]), np.sin(angle)], axis=1)
    lens = np.concatenate([right[:2], -right[:2]])
    spline = LocalCubicSpline(Chain(lens, True, np.array([True, False, True, False])))
    # its pieces are those of a circle through eight points
    circle = LocalCubicSpline(Chain(ellipse(8, 1.0, 1.0), True))
    np.testing.assert_allclose(spline.area, 2.0 * (0.25 * circle.area - 0.5), rtol=1e-14)
    tangent = spline.tangent(np.array([0, 1]), np.array([0.0, 1.0]))
    np.testing.assert_allclose(tangent, [np.sqrt([0.5, 0.5]), np.sqrt([0.5, 0.5]) * [-1, 1]])
    half = LocalCubicSpline(Chain(right, True, np.array([True, False, True])))
    np.testing.assert_allclose(half.area, 0.5 * spline.area, rtol=1e-14)
    np.testing.assert_allclose(half.curvature(np.full(3, 2), np.array([0, 0.4, 1])), 0, atol=1e-14)


def test_the_tangent_at_a_corner_is_that_of_the_one_side():
    # a quarter disc: its arc must not be flattened beside the corners
    error = []
    for n in NUMBERS:
        angle = np.linspace(0.0, 0.5 * np.pi, n)
        points = np.concatenate([[[0.0, 0.0]], np.stack([np.cos(angle), np.sin(angle)], axis=1)])
        spline = LocalCubicSpline(Chain(points, True, sharp_corners(points, True, 40.0)))
        assert spline.chain.corner.sum() == 3
        x = spline.position(*everywhere(spline))[16:-16]
        error.append(np.abs(np.linalg.norm(x, axis=1) - 1.0).max())
        assert abs(spline.area - 0.25 * np.pi) < 0.5 * np.pi * error[-1]
    assert np.log2(np.array(error[:-1]) / error[1:]).min() > 3.9


def test_a_change_of_curvature_beside_an_end_is_followed():
    # y = e (x - 1.6)^3, so flat that its curvature is y'': linear, with its zero beyond point 1
    e, x = 1e-4, np.arange(4.0)
    spline = LocalCubicSpline(Chain(np.stack([x, e * (x - 1.6) ** 3], axis=1), False))
    tangent = spline.tangent(np.array([0]), np.array([0.0]))[0]
    chord = spline.chain.chord[0]
    exact = 3.0 * e * 1.6**2
    # the extrapolation is kept below 5/3 of the curvature at point 1; the line would give 2.11
    curvature = 6.0 * e * -0.6 * 5.0 / 3.0
    np.testing.assert_allclose(tangent[1] / tangent[0], chord[1] - 0.5 * curvature, rtol=1e-5)
    assert abs(tangent[1] / tangent[0] - exact) < 0.25 * abs(chord[1] - exact)


@pytest.mark.parametrize("closed", [True, False])
def test_a_moved_point_changes_only_its_neighbour_pieces(closed):
    points = ellipse(24, 2.0, 1.0, 0.6)
    before = LocalCubicSpline(Chain(points, closed)).control
    for moved in (0, 1, 2, 11, 22, 23):
        points_after = points.copy()
        points_after[moved] += [0.03, -0.02]
        after = LocalCubicSpline(Chain(points_after, closed)).control
        changed = np.flatnonzero((before != after).any(axis=(1, 2)))
        reach = np.minimum((changed - moved) % 24, (moved - 1 - changed) % 24)
        if not closed:
            reach = np.where(changed >= moved, changed - moved, moved - 1 - changed)
        assert reach.max() == 2  # three pieces on either side
    corner = np.zeros(24, dtype=bool)
    corner[12] = True
    before = LocalCubicSpline(Chain(points, closed, corner)).control
    points_after = points.copy()
    points_after[11] += [0.03, -0.02]
    after = LocalCubicSpline(Chain(points_after, closed, corner)).control
    np.testing.assert_array_equal(before[12:], after[12:])  # nothing passes a corner


@pytest.mark.parametrize("closed", [True, False])
def test_the_curve_turns_scales_and_reverses_with_its_points(closed):
    points = ellipse(24, 2.0, 1.0, 0.6)
    corner = np.zeros(24, dtype=bool)
    corner[[5, 6, 9]] = True
    control = LocalCubicSpline(Chain(points, closed, corner)).control
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    moved = LocalCubicSpline(Chain(3.0 * points @ turn.T + [5.0, 7.0], closed, corner)).control
    np.testing.assert_allclose(moved, 3.0 * control @ turn.T + [5.0, 7.0], atol=1e-13)
    back = LocalCubicSpline(Chain(points[::-1], closed, corner[::-1])).control[::-1, ::-1]
    if closed:  # its first piece led from the last point to the one before
        back = np.roll(back, -1, axis=0)
    np.testing.assert_allclose(back, control, atol=1e-13)


@pytest.mark.parametrize("closed", [True, False])
def test_the_bspline_is_the_same_curve(closed):
    points = ellipse(40, 2.0, 1.0, 0.6)
    corner = np.zeros(40, dtype=bool)
    corner[[0, 7, 8, 30]] = True
    spline = LocalCubicSpline(Chain(points, closed, corner))
    curve = spline.bspline()
    knot, times = np.unique(curve.t, return_counts=True)
    np.testing.assert_array_equal(knot, spline.knots)
    np.testing.assert_array_equal(times[1:-1], np.where(corner, 3, 2)[1 : len(spline)])
    assert (times[[0, -1]] == 4).all()
    segment, t = everywhere(spline)
    at = spline.knots[segment] + t * np.diff(spline.knots)[segment]
    assert np.abs(curve(at) - spline.position(segment, t)).max() < 1e-14
    unit_speed = curve.derivative()(spline.knots[1:7])  # C1 where there is no corner
    np.testing.assert_allclose(np.linalg.norm(unit_speed, axis=1), 1.0, atol=1e-12)


def test_the_polyline_lies_on_the_curve():
    spline = LocalCubicSpline(Chain(ellipse(8, 2.0, 1.0), True))
    line = spline.polyline(4)
    assert line.shape == (33, 2)
    np.testing.assert_array_equal(line[::4][:-1], spline.chain.points)
    np.testing.assert_array_equal(line[0], line[-1])


@pytest.mark.parametrize(
    ("points", "closed", "problem", "numbers"),
    [
        ([[0, 0], [1, 0], [1, 0], [0, 1]], True, "same point: points 1, 2", (1, 2)),
        ([[0, 0], [1, 0], [0, 1], [0, 0]], True, "same point: points 0, 3", (0, 3)),
        ([[1e6, 0], [1e6 + 1e-11, 0], [0, 1]], False, "same point: points 0, 1", (0, 1)),
        ([[0, 0], [1, 0]], True, "2 points are too few for a chain that is closed", (0, 1)),
        ([[0, 0]], False, "1 points are too few for a chain that is open", (0,)),
        ([[0, 0], [1, np.nan], [0, 1]], True, "points 1 are not numbers", (1,)),
        ([[0, 0, 0], [1, 0, 0]], False, "shape", ()),
    ],
)
def test_wrong_points_are_named(points, closed, problem, numbers):
    with pytest.raises(BadSurface, match=problem) as caught:
        Chain(points, closed)
    assert caught.value.numbers == numbers
    assert caught.value.remedy in str(caught.value)


def test_an_open_chain_has_no_area():
    with pytest.raises(BadSurface, match="an area needs a closed chain") as caught:
        _ = LocalCubicSpline(Chain(arc(9, 1.0, 1.0), False)).area
    assert caught.value.numbers == (8, 0)


def test_corner_flags_must_fit():
    with pytest.raises(BadSurface, match="3 corner flags for 4 points"):
        Chain(SQUARE, True, np.zeros(3, dtype=bool))


def test_the_tangent_between_two_straight_runs_does_not_follow_their_round_off():
    """A kink between runs that a linear field keeps straight: the tangent halves the angle."""
    x = np.linspace(0.0, 2.0, 9)
    points = np.stack([x, np.where(x < 1.0, 1e-4 * (x - 1.0), 3e-4 * (x - 1.0))], axis=1)
    middle = []
    for shift in (0.0, 1.5, -3.7):
        spline = LocalCubicSpline(Chain(points + shift, False))
        middle.append(spline.derivative(np.array([4]), np.array([0.0]))[0])
    slope = np.array([each[1] / each[0] for each in middle])
    np.testing.assert_allclose(slope, 2e-4, atol=1e-7)
