# SPDX-License-Identifier: BSD-3-Clause
"""Local cubic B-spline interpolation of a chain of points (The NURBS Book, section 9.3.4)."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.curves.chain import Chain
from tilth.curves.tangents import tangents

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

# Gauss points per segment for arc lengths. The speed is nearly constant, so that their error is
# round-off for a curve that is sufficiently resolved.
ARC_LENGTH_POINTS = 10


class LocalCubicSpline:
    """Curve through the points of a chain: a cubic piece on every chord; n segments.

    Segment i begins at point i of the chain and has the parameter t from 0 to 1. The pieces meet
    with the same tangent, and the same speed in the parameter `knots`; at corners only the
    position is continuous. The soil is on the left, and the normal points to it. Methods take the
    number of the segment and t, arrays of one shape S, and return values of that shape, vectors of
    shape (*S, 2).

    Attributes:
        chain: the points.
        control: Bezier points of the segments [length], shape (n, 4, 2).
        knots: parameter at the chain's points [length], close to the arc length, shape (n + 1,).
    """

    def __init__(self, chain: Chain) -> None:
        self.chain = chain
        start = chain.points[: len(chain.chord)]
        end = start + chain.chord
        end[:-1] = start[1:]
        end[-1] = chain.points[0 if chain.closed else -1]
        at_start, at_end = tangents(chain)
        speed = _speed(end - start, at_start + at_end)
        arm = speed[:, None] / 3.0
        self.control: Floats = np.stack(
            [start, start + arm * at_start, end - arm * at_end, end], axis=1
        )
        self.knots: Floats = np.concatenate([[0.0], np.cumsum(speed)])

    def __len__(self) -> int:
        return len(self.control)

    def position(self, segment: Integers, t: Floats) -> Floats:
        """Returns positions on the curve [length]."""
        s = 1.0 - t
        return _sum(self.control[segment], s**3, 3.0 * s**2 * t, 3.0 * s * t**2, t**3)

    def derivative(self, segment: Integers, t: Floats) -> Floats:
        """Returns the derivatives with respect to t [length]."""
        s = 1.0 - t
        leg = 3.0 * np.diff(self.control, axis=1)
        return _sum(leg[segment], s**2, 2.0 * s * t, t**2)

    def second_derivative(self, segment: Integers, t: Floats) -> Floats:
        """Returns the second derivatives with respect to t [length]."""
        bend = 6.0 * np.diff(self.control, n=2, axis=1)
        return _sum(bend[segment], 1.0 - t, t)

    def tangent(self, segment: Integers, t: Floats) -> Floats:
        """Returns unit vectors along the curve."""
        along = self.derivative(segment, t)
        return np.asarray(along / np.linalg.norm(along, axis=-1, keepdims=True))

    def normal(self, segment: Integers, t: Floats) -> Floats:
        """Returns unit vectors into the soil: the tangents turned anticlockwise by 90 degrees."""
        return left(self.tangent(segment, t))

    def curvature(self, segment: Integers, t: Floats) -> Floats:
        """Returns the curvatures [1/length], > 0 where the curve turns left, into the soil."""
        first, second = self.derivative(segment, t), self.second_derivative(segment, t)
        cross = (left(first) * second).sum(axis=-1)
        return np.asarray(cross / np.linalg.norm(first, axis=-1) ** 3)

    def arc_length(self, segment: Integers, t: Floats) -> Floats:
        """Returns lengths of the curve from its beginning at point 0 [length]."""
        begin = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return np.asarray(begin[segment] + self._length_to(segment, t))

    @cached_property
    def lengths(self) -> Floats:
        """Arc lengths of the segments [length], shape (n,)."""
        return self._length_to(np.arange(len(self)), np.ones(len(self)))

    @property
    def length(self) -> float:
        """Arc length of the whole curve [length]."""
        return float(self.lengths.sum())

    @property
    def area(self) -> float:
        """Enclosed area [length^2], exact for the cubic pieces; < 0 if the curve is clockwise.

        Raises:
            BadSurface: the chain is open.
        """
        self.chain.require_closed("an area")
        # x dy - y dx has degree 5 in t, less where the coordinates are relative: three points.
        coordinate, weight = gauss(3)
        segment, t = np.repeat(np.arange(len(self)), 3), np.tile(coordinate, len(self))
        arm = self.position(segment, t) - self.chain.points[0]
        swept = (left(arm) * self.derivative(segment, t)).sum(axis=1)
        return 0.5 * float(swept @ np.tile(weight, len(self)))

    def bspline(self) -> BSpline:
        """Returns the same curve as one B-spline over `knots`.

        Its inner knots are double, at corners triple, where the corner is a control point; the
        ends are clamped, as are those of a closed curve.
        """
        from scipy.interpolate import BSpline

        n = len(self)
        corner = self.chain.corner[1:n]
        count = np.where(corner, 3, 2)
        knots = np.repeat(self.knots, np.concatenate([[4], count, [4]]))
        kept = np.ones((n, 4), dtype=bool)
        kept[1:, 0] = False
        kept[:-1, 3] = corner
        return BSpline(knots, self.control[kept], 3)

    def polyline(self, parts: int) -> Floats:
        """Returns points along the curve, `parts` per segment, including both ends.

        Shape (n parts + 1, 2) [length].
        """
        segment = np.repeat(np.arange(len(self)), parts)
        t = np.tile(np.arange(parts) / parts, len(self))
        return np.concatenate([self.position(segment, t), self.control[-1:, 3]])

    def _length_to(self, segment: Integers, t: Floats) -> Floats:
        """Returns arc lengths from the beginning of the segment [length]."""
        coordinate, weight = gauss(ARC_LENGTH_POINTS)
        t = np.asarray(t, dtype=float)[..., None]
        inner = np.broadcast_to(np.asarray(segment)[..., None], (*t.shape[:-1], len(coordinate)))
        speed = np.linalg.norm(self.derivative(inner, t * coordinate), axis=-1)
        return np.asarray(t[..., 0] * (speed @ weight))


def gauss(number: int) -> tuple[Floats, Floats]:
    """Returns the coordinates and weights of the Gauss rule on [0, 1], shape (number,) each."""
    coordinate, weight = np.polynomial.legendre.leggauss(number)
    return 0.5 * (1.0 + coordinate), 0.5 * weight


def left(vector: Floats) -> Floats:
    """Returns vectors (..., 2) turned anticlockwise by 90 degrees."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def _speed(chord: Floats, tangent_sum: Floats) -> Floats:
    """Returns the common speed [length] of cubic pieces at their ends and middle, shape (n,).

    The positive root of The NURBS Book's quadratic equation of section 9.3.4. Its first
    coefficient is at least 12 and its last negative, so that it exists for any tangents.
    """
    a = 16.0 - (tangent_sum**2).sum(axis=1)
    b = 12.0 * (chord * tangent_sum).sum(axis=1)
    c = -36.0 * (chord**2).sum(axis=1)
    return np.asarray((np.sqrt(b**2 - 4.0 * a * c) - b) / (2.0 * a))


def _sum(vector: Floats, *factor: npt.NDArray[np.float64]) -> Floats:
    """Returns the sum of vectors (..., k, 2) times k factors (...)."""
    return np.asarray(
        np.einsum("...k,...ki->...i", np.stack(np.broadcast_arrays(*factor), -1), vector)
    )
