# SPDX-License-Identifier: BSD-3-Clause
"""Nearest points of a spline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.spline import LocalCubicSpline

# Sampling intervals of a segment; between two samples the distance has one minimum.
SAMPLES_PER_SEGMENT = 8
# Maximum iterations of the root search between two samples; bisection alone converges in these.
MAXIMUM_ITERATIONS = 60
# The root search ends with a correction of the parameter below this.
PARAMETER_TOLERANCE = 1e-14
# Points per batch, to bound the memory.
POINTS_PER_BATCH = 1 << 12
# Upper bound of the ratio of the largest curvature to that of the samples.
CURVATURE_RATIO = 2.0
# Relative margin of the candidates' distance for the round-off of the search.
DISTANCE_MARGIN = 1e-9


@dataclass(frozen=True)
class Nearest:
    """Points of a spline nearest to n given points.

    Attributes:
        segment, parameter: coordinates of the nearest point on the spline, shape (n,) each.
        offset: vectors from there to the given points [length], shape (n, 2).
    """

    segment: Integers
    parameter: Floats
    offset: Floats


class NearestPoints:
    """Finds the points of a spline nearest to many given points at once.

    The minimum near the nearest sample gives an upper bound of the distance. The minima near all
    other samples that may be below this bound are computed as well.
    """

    def __init__(self, spline: LocalCubicSpline) -> None:
        self.spline = spline
        self._segment = np.repeat(np.arange(len(spline)), SAMPLES_PER_SEGMENT + 1)
        self._t = np.tile(np.linspace(0.0, 1.0, SAMPLES_PER_SEGMENT + 1), len(spline))
        from scipy.spatial import cKDTree

        self._tree = cKDTree(spline.position(self._segment, self._t))
        edge = np.linalg.norm(np.diff(spline.control, axis=1), axis=2)
        # The speed is at most three times the longest edge of the control polygon.
        self._half_interval = 1.5 * float(edge.max()) / SAMPLES_PER_SEGMENT
        curvature = np.abs(spline.curvature(self._segment, self._t))
        self._curvature = CURVATURE_RATIO * float(curvature.max())

    def find(self, x: Floats) -> Nearest:
        """Returns the points of the spline nearest to points (n, 2) [length]."""
        segment, t = np.empty(len(x), np.int64), np.empty(len(x))
        for begin in range(0, len(x), POINTS_PER_BATCH):
            part = slice(begin, begin + POINTS_PER_BATCH)
            segment[part], t[part] = self._find(x[part])
        return Nearest(segment, t, x - self.spline.position(segment, t))

    def _find(self, x: Floats) -> tuple[Integers, Floats]:
        _, sample = self._tree.query(x)
        segment, t = self._segment[sample], self._minimum(sample, x)
        bound = np.linalg.norm(x - self.spline.position(segment, t), axis=1)
        candidates = self._tree.query_ball_point(
            x, self._sample_distance(bound) * (1.0 + DISTANCE_MARGIN)
        )
        count = np.array([len(found) for found in candidates])
        point = np.repeat(np.arange(len(x)), count)
        sample = np.concatenate([np.asarray(found, dtype=np.int64) for found in candidates])
        lowest = self._lowest(sample, x[point])
        point, sample = point[lowest], sample[lowest]
        t_all = self._minimum(sample, x[point])
        distance = np.linalg.norm(
            x[point] - self.spline.position(self._segment[sample], t_all), axis=1
        )
        # The nearest candidate of each point.
        order = np.lexsort((sample, distance, point))
        best = order[np.unique(point[order], return_index=True)[1]]
        return self._segment[sample[best]], t_all[best]

    def _sample_distance(self, distance: Floats) -> Floats:
        """Returns an upper bound of the distance to the nearest sample, shape (n,).

        distance: upper bound of the distance to the spline, shape (n,).
        A sample is within half a sampling interval of the nearest point along the curve. Between
        them half the second derivative of the squared distance is at most 1 + curvature * distance.
        """
        farthest = distance + self._half_interval
        square = distance**2 + self._half_interval**2 * (1.0 + self._curvature * farthest)
        return np.asarray(np.minimum(farthest, np.sqrt(square)))

    def _lowest(self, sample: Integers, x: Floats) -> Flags:
        """Returns whether samples are as near to points (n, 2) as both neighbours, shape (n,)."""
        here = self._distance(sample, x)
        first, last = self._t[sample] == 0.0, self._t[sample] == 1.0
        before = self._distance(np.where(first, sample, sample - 1), x)
        after = self._distance(np.where(last, sample, sample + 1), x)
        return np.asarray((here <= before) & (here <= after))

    def _distance(self, sample: Integers, x: Floats) -> Floats:
        return np.asarray(np.linalg.norm(x - self._tree.data[sample], axis=1))

    def _minimum(self, sample: Integers, x: Floats) -> Floats:
        """Returns the parameters of the least distance from points (n, 2) near a sample, (n,).

        Newton's method for (C - x) . C' = 0 between the neighbouring samples; a correction out of
        the bracket is replaced by bisection.
        """
        parameter = self._t[sample].copy()
        active, segment, t = np.arange(len(sample)), self._segment[sample], parameter.copy()
        below, above = (
            np.maximum(t - 1.0 / SAMPLES_PER_SEGMENT, 0.0),
            np.minimum(t + 1.0 / SAMPLES_PER_SEGMENT, 1.0),
        )
        for _ in range(MAXIMUM_ITERATIONS):
            offset = self.spline.position(segment, t) - x
            first = self.spline.derivative(segment, t)
            value = (offset * first).sum(axis=1)
            below, above = np.where(value < 0.0, t, below), np.where(value > 0.0, t, above)
            slope = (first**2).sum(axis=1)
            slope += (offset * self.spline.second_derivative(segment, t)).sum(axis=1)
            newton = t - value / np.where(slope > 0.0, slope, np.inf)
            inside = (slope > 0.0) & (newton >= below) & (newton <= above)
            new = np.where(inside, newton, 0.5 * (below + above))
            # at an end of the segment towards which the distance decreases, and at a minimum
            finished = ((t == 0.0) & (value > 0.0)) | ((t == 1.0) & (value < 0.0)) | (value == 0.0)
            new = np.where(finished, t, new)
            parameter[active] = new
            moving = np.abs(new - t) > PARAMETER_TOLERANCE
            if not moving.any():
                break
            active, segment, t = active[moving], segment[moving], new[moving]
            below, above, x = below[moving], above[moving], x[moving]
        return parameter
