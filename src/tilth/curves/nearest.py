# SPDX-License-Identifier: BSD-3-Clause
"""The places of a spline nearest to given places."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.spline import LocalCubicSpline

# Samples of a segment; between two of them the distance has one minimum.
SAMPLES = 8
# Iterations of the search between two samples; halving alone ends with these.
SEARCH = 60
# The search ends with a step below this in the parameter; Newton's method squares it.
CONVERGED = 1e-14
# Places that are searched at once, and pairs of a place and a candidate.
CHUNK = 1 << 12
# The greatest curvature over that of the samples, taken with a margin.
SHARPER = 2.0
# Margin of the candidates' distance, relative, for the round-off of the search.
MARGIN = 1e-9


@dataclass(frozen=True)
class Nearest:
    """Places of a spline nearest to n places.

    Attributes:
        segment, parameter: the place on the spline, shape (n,) each.
        arm: vectors from there to the given places [length], shape (n, 2).
    """

    segment: Integers
    parameter: Floats
    arm: Floats


class NearestPlaces:
    """Finds the nearest places of one spline, for many places at once.

    The nearest sample of the spline gives a first place and an upper bound of the distance. Every
    other sample that may belong to a nearer place is tried as well.
    """

    def __init__(self, spline: LocalCubicSpline) -> None:
        self.spline = spline
        self._segment = np.repeat(np.arange(len(spline)), SAMPLES + 1)
        self._t = np.tile(np.linspace(0.0, 1.0, SAMPLES + 1), len(spline))
        from scipy.spatial import cKDTree

        self._tree = cKDTree(spline.position(self._segment, self._t))
        leg = np.linalg.norm(np.diff(spline.control, axis=1), axis=2)
        # The speed is at most three times the longest leg of the control polygon.
        self._reach = 1.5 * float(leg.max()) / SAMPLES
        curvature = np.abs(spline.curvature(self._segment, self._t))
        self._curvature = SHARPER * float(curvature.max())

    def find(self, x: Floats) -> Nearest:
        """Returns the nearest places of the spline for places (n, 2) [length]."""
        segment, t = np.empty(len(x), np.int64), np.empty(len(x))
        for begin in range(0, len(x), CHUNK):
            part = slice(begin, begin + CHUNK)
            segment[part], t[part] = self._find(x[part])
        return Nearest(segment, t, x - self.spline.position(segment, t))

    def _find(self, x: Floats) -> tuple[Integers, Floats]:
        _, sample = self._tree.query(x)
        segment, t = self._segment[sample], self._minimum(sample, x)
        bound = np.linalg.norm(x - self.spline.position(segment, t), axis=1)
        candidates = self._tree.query_ball_point(x, self._farthest(bound) * (1.0 + MARGIN))
        count = np.array([len(found) for found in candidates])
        place = np.repeat(np.arange(len(x)), count)
        sample = np.concatenate([np.asarray(found, dtype=np.int64) for found in candidates])
        lowest = self._lowest(sample, x[place])
        place, sample = place[lowest], sample[lowest]
        t_all = self._minimum(sample, x[place])
        away = np.linalg.norm(x[place] - self.spline.position(self._segment[sample], t_all), axis=1)
        # The first of each place's candidates, sorted by their distance.
        order = np.lexsort((sample, away, place))
        best = order[np.unique(place[order], return_index=True)[1]]
        return self._segment[sample[best]], t_all[best]

    def _farthest(self, distance: Floats) -> Floats:
        """Distance of the nearest sample of a place whose distance is at most this, shape (n,).

        A sample is within `reach` of the nearest place along the curve. On the way there half the
        second derivative of the squared distance is at most 1 + curvature distance.
        """
        farthest = distance + self._reach
        square = distance**2 + self._reach**2 * (1.0 + self._curvature * farthest)
        return np.asarray(np.minimum(farthest, np.sqrt(square)))

    def _lowest(self, sample: Integers, x: Floats) -> Flags:
        """Whether samples are as near to places (n, 2) as the samples beside them, shape (n,)."""
        here = self._distance(sample, x)
        first, last = self._t[sample] == 0.0, self._t[sample] == 1.0
        before = self._distance(np.where(first, sample, sample - 1), x)
        after = self._distance(np.where(last, sample, sample + 1), x)
        return np.asarray((here <= before) & (here <= after))

    def _distance(self, sample: Integers, x: Floats) -> Floats:
        return np.asarray(np.linalg.norm(x - self._tree.data[sample], axis=1))

    def _minimum(self, sample: Integers, x: Floats) -> Floats:
        """Parameters where the distance from places (n, 2) is least beside a sample, shape (n,).

        Newton's method for (C - x) . C' = 0 between the samples on either side; a step out of the
        bracket is replaced by its middle.
        """
        parameter = self._t[sample].copy()
        active, segment, t = np.arange(len(sample)), self._segment[sample], parameter.copy()
        below, above = np.maximum(t - 1.0 / SAMPLES, 0.0), np.minimum(t + 1.0 / SAMPLES, 1.0)
        for _ in range(SEARCH):
            arm = self.spline.position(segment, t) - x
            first = self.spline.derivative(segment, t)
            value = (arm * first).sum(axis=1)
            below, above = np.where(value < 0.0, t, below), np.where(value > 0.0, t, above)
            slope = (first**2).sum(axis=1)
            slope += (arm * self.spline.second_derivative(segment, t)).sum(axis=1)
            newton = t - value / np.where(slope > 0.0, slope, np.inf)
            inside = (slope > 0.0) & (newton >= below) & (newton <= above)
            moved = np.where(inside, newton, 0.5 * (below + above))
            # at an end of the segment beyond which the distance would fall, and on a minimum
            stays = ((t == 0.0) & (value > 0.0)) | ((t == 1.0) & (value < 0.0)) | (value == 0.0)
            moved = np.where(stays, t, moved)
            parameter[active] = moved
            moving = np.abs(moved - t) > CONVERGED
            if not moving.any():
                break
            active, segment, t = active[moving], segment[moving], moved[moving]
            below, above, x = below[moving], above[moving], x[moving]
        return parameter
