# SPDX-License-Identifier: BSD-3-Clause
"""Signed distance to a spline, and the spline as the geometry of an implicit boundary."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tilth.curves import Chain, LocalCubicSpline
from tilth.curves.nearest import NearestPoints
from tilth.geometry.polyline import Polyline
from tilth.geometry.quadrature import make_quadrature
from tilth.geometry.spline import SplineGeometry
from tilth.grid.background import Grid

NUMBERS = (32, 64, 128, 256)
STAR = np.array([[1, 0.1], [0.35, 0.4], [0.1, 1], [-0.3, 0.2], [-1, -0.2], [0.1, -0.25]])


def circle(n):
    angle = 2.0 * np.pi * np.arange(n) / n
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def geometry(points, closed=True, corner=None):
    return SplineGeometry(LocalCubicSpline(Chain(points, closed, corner)))


def places(n=2000, reach=1.6):
    return reach * np.random.default_rng(3).uniform(-1.0, 1.0, (n, 2))


def test_the_distance_to_a_circle_converges():
    x = places()
    x = x[np.linalg.norm(x, axis=1) > 0.2]  # towards the centre the direction is worse
    radius = np.linalg.norm(x, axis=1)
    for sign, way in ((1.0, 1), (-1.0, -1)):
        error = []
        for n in NUMBERS:
            spline = geometry(circle(n)[::way])
            gradient = spline.gradient(x)
            error.append(
                [
                    np.abs(spline.distance(x) - sign * (1.0 - radius)).max(),
                    np.linalg.norm(gradient + sign * x / radius[:, None], axis=1).max(),
                ]
            )
        rate = np.log2(np.array(error[:-1]) / error[1:])
        assert rate[:, 0].min() > 3.9
        assert rate[:, 1].min() > 2.8
        assert error[-1][0] < 1e-9


def test_the_nearest_place_is_the_nearest_of_all():
    # against a dense polyline of a curve with corners and hollows
    corner = np.array([True, False, True, False, False, False])
    for closed in (True, False):
        spline = LocalCubicSpline(Chain(STAR, closed, corner))
        x = places()
        nearest = NearestPoints(spline).find(x)
        dense = spline.polyline(4000)
        away, _ = cKDTree(dense).query(x)
        found = np.linalg.norm(nearest.offset, axis=1)
        spacing = np.linalg.norm(np.diff(dense, axis=0), axis=1).max()
        assert (away - found).min() > -1e-14
        assert (away**2 - found**2).max() < 2.0 * spacing**2
        position = spline.position(nearest.segment, nearest.parameter)
        np.testing.assert_allclose(position + nearest.offset, x, atol=1e-15)
        # away from corners and ends the arm is a normal
        inner = (nearest.parameter > 0.0) & (nearest.parameter < 1.0)
        tangent = spline.tangent(nearest.segment[inner], nearest.parameter[inner])
        assert np.abs((tangent * nearest.offset[inner]).sum(axis=1)).max() < 1e-13
        assert inner.sum() > 500


def test_the_centre_of_a_circle_has_a_distance():
    spline = geometry(circle(64))
    assert abs(spline.distance(np.zeros((1, 2)))[0] - 1.0) < 1e-6
    np.testing.assert_allclose(np.linalg.norm(spline.gradient(np.zeros((1, 2)))), 1.0)


@pytest.mark.parametrize("closed", [True, False])
def test_corners_everywhere_give_the_polyline(closed):
    x = places()
    ours = geometry(STAR, closed, np.ones(6, dtype=bool))
    line = Polyline(STAR, closed=closed, left=True)
    np.testing.assert_allclose(ours.distance(x), line.distance(x), atol=1e-14)
    np.testing.assert_allclose(ours.gradient(x), line.gradient(x), atol=1e-12)
    at_corner = ours.gradient(STAR)
    np.testing.assert_allclose(np.linalg.norm(at_corner, axis=1), 1.0)


def test_the_side_beyond_a_sharp_corner_is_told_by_both_its_edges():
    lens = np.array([[0.0, -1.0], [0.05, 0.0], [0.0, 1.0], [-0.05, 0.0]])
    spline = geometry(lens, True, np.array([True, False, True, False]))
    x = np.array([[0.0, 1.1], [0.02, 1.05], [-0.02, 1.05], [0.0, 0.9], [0.2, 1.0], [-0.2, -1.0]])
    np.testing.assert_array_equal(spline.distance(x) > 0.0, [False] * 3 + [True] + [False] * 2)


def test_quadrature_of_an_implicit_boundary_integrates_over_the_curve():
    spline = LocalCubicSpline(Chain(circle(24) * [1.0, 0.6], True))
    error = []
    for size in (0.2, 0.1, 0.05, 0.025):
        points = make_quadrature(
            SplineGeometry(spline),
            np.full(2, -2.0),
            np.full(2, 2.0),
            Grid(np.array([0.03, 0.07]), np.array([20.0, 20.0])),
            size,
        )
        assert np.abs(NearestPoints(spline).find(points.position).offset).max() < 1e-14
        vector = points.weight[:, None] * points.normal
        area = -0.5 * (vector * points.position).sum()
        error.append([abs(points.weight.sum() - spline.length), abs(area - spline.area)])
    # three Gauss points a piece; over the whole range, since the pieces are not halved evenly
    assert np.log2(np.array(error[0]) / error[-1]).min() / 3.0 > 5.5
    assert np.max(error[-1]) < 1e-9
