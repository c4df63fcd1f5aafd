# SPDX-License-Identifier: BSD-3-Clause
"""Boundary along the cubic spline through a chain of points (2D)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.curves.nearest import Nearest, NearestPoints
from tilth.curves.spline import LocalCubicSpline
from tilth.geometry.flat import left_normal, unit
from tilth.geometry.protocol import Facets


class SplineGeometry:
    """Open or closed local cubic spline with the soil on its left.

    Args:
        spline: the curve.
    """

    dim = 2
    bounded = True
    flat = False

    def __init__(self, spline: LocalCubicSpline) -> None:
        self.spline = spline
        self._nearest = NearestPoints(spline)
        chain = spline.chain
        segments = np.arange(len(spline))
        first = spline.normal(segments, np.zeros(len(spline)))
        last = spline.normal(segments, np.ones(len(spline)))
        # At a corner the sum of the two normals determines the side.
        self._at_start, self._at_end = (
            np.roll(last, 1, axis=0) + first,
            last + np.roll(first, -1, 0),
        )
        self._start_is_end = chain.ends[: len(spline)]
        self._end_is_end = np.roll(chain.ends, -1)[: len(spline)]
        if not chain.closed:
            self._at_start[0], self._at_end[-1] = first[0], last[-1]
        extent, greatest = np.ptp(chain.points, axis=0).max(), np.abs(chain.points).max()
        # Points nearer to a corner than this are on it; round-off grows with the coordinates.
        self._on_corner = max(1e-12 * extent, 16.0 * np.finfo(float).eps * greatest)

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        nearest = self._nearest.find(x)
        _, sign, _ = self._sides(nearest)
        return np.asarray(sign * np.linalg.norm(nearest.offset, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; at a corner the normal of one segment."""
        nearest = self._nearest.find(x)
        normal, sign, at_end = self._sides(nearest)
        length = np.linalg.norm(nearest.offset, axis=1)
        # Nearest to a segment its normal is exact; the offset of a point on it is round-off only.
        from_end = at_end & (length > self._on_corner)
        direction = sign[:, None] * nearest.offset / np.where(from_end, length, 1.0)[:, None]
        return np.where(from_end[:, None], direction, normal)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: chords with their corners on the curve."""
        control = self.spline.control
        # The speed is at most three times the longest leg of the control polygon.
        fastest = 3.0 * np.linalg.norm(np.diff(control, axis=1), axis=2).max(axis=1)
        parts = np.maximum(1, np.ceil(fastest / size - 1e-9).astype(np.int64))
        segment = np.repeat(np.arange(len(control)), parts)
        number = np.arange(len(segment)) - np.repeat(np.cumsum(parts) - parts, parts)
        start = self.spline.position(segment, number / parts[segment])
        end = self.spline.position(segment, (number + 1) / parts[segment])
        normal = unit(left_normal(end - start))
        return Facets(np.stack([start, end], axis=1), normal, np.arange(len(segment)))

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """As `Geometry.project`: to the nearest points of the spline."""
        nearest = self._nearest.find(x)
        at = nearest.segment, nearest.parameter
        # From (C - x) . C' = 0: ds (1 - curvature distance) = T . dx, with dx along the facet.
        along = np.abs((left_normal(normal) * self.spline.tangent(*at)).sum(axis=1))
        distance = (nearest.offset * self.spline.normal(*at)).sum(axis=1)
        return self.spline.position(*at), along / (1.0 - self.spline.curvature(*at) * distance)

    def _sides(self, nearest: Nearest) -> tuple[Floats, Floats, Flags]:
        """Returns normals at the nearest points, signs of the sides, and which points are ends.

        Ends are corners and the ends of an open chain.
        """
        segment, t = nearest.segment, nearest.parameter
        normal = self.spline.normal(segment, t)
        side = normal.copy()
        side[t == 0.0] = self._at_start[segment[t == 0.0]]
        side[t == 1.0] = self._at_end[segment[t == 1.0]]
        sign = np.where((nearest.offset * side).sum(axis=1) < 0.0, -1.0, 1.0)
        at_end = ((t == 0.0) & self._start_is_end[segment]) | (
            (t == 1.0) & self._end_is_end[segment]
        )
        return normal, sign, at_end
