# SPDX-License-Identifier: BSD-3-Clause
"""A spline cut at the lines of a grid, and Gauss points on the pieces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.curves.spline import LocalCubicSpline, left

# Places nearer to a grid line than this, in cells, lie on it. So a segment along a line or one
# that only touches it is not cut by round-off.
ON_LINE = 1e-11
# The same in roundings of the coordinates in cells, which is more far from the grid's origin.
ROUNDINGS = 64.0
# Cuts of a segment nearer than this in its parameter are one.
SAME_CUT = 1e-12
# Iterations of the search for a cut; halving the bracket alone would end with these.
SEARCH = 60
# It ends with a step below this in the parameter; Newton's method squares it.
CONVERGED = 1e-14


@dataclass(frozen=True)
class Pieces:
    """Pieces of segments, each in one cell; m pieces in the order of the chain.

    Attributes:
        segment: number of the segment, shape (m,).
        begin, end: parameters on the segment between which the piece lies, shape (m,).
        cell: whole numbers of the cell along the axes, counted from the grid's origin, shape
            (m, 2). A piece along a grid line is in the cell on the side of the soil.
    """

    segment: Integers
    begin: Floats
    end: Floats
    cell: Integers


@dataclass(frozen=True)
class PiecePoints:
    """Gauss points of pieces; n points, those of a piece one after the other.

    A line integral is the sum of weight |derivative| f over the points; with the derivative itself
    in place of its norm it is the integral of f dC.

    Attributes:
        piece: number of the piece, shape (n,).
        segment, parameter: the place on the spline, shape (n,) each.
        position: on the spline [length], shape (n, 2).
        derivative: dC/d(xi~) [length], where the parent coordinate xi~ goes from -1 to 1 over the
            piece: dC/d(xi) of the segment times d(xi)/d(xi~), shape (n, 2).
        weight: Gauss's weights on [-1, 1], shape (n,).
    """

    piece: Integers
    segment: Integers
    parameter: Floats
    position: Floats
    derivative: Floats
    weight: Floats

    @property
    def length(self) -> Floats:
        """Length of curve that each point stands for [length], shape (n,)."""
        return np.asarray(self.weight * np.linalg.norm(self.derivative, axis=1))

    @property
    def area_vector(self) -> Floats:
        """Length that each point stands for times the normal into the soil [length], (n, 2).

        A pressure p on the soil is the force p times this. The sum over a piece is exact.
        """
        return np.asarray(self.weight[:, None] * left(self.derivative))


def cut_at_grid(spline: LocalCubicSpline, origin: Floats, cell_size: Floats) -> Pieces:
    """Returns the pieces of a spline between the lines of a regular grid.

    origin, cell_size: a crossing of grid lines and the sides of a cell [length], shape (2,).
    """
    control = (spline.control - origin) / cell_size
    segments = np.arange(len(spline))
    segment, t = [segments, segments], [np.zeros(len(spline)), np.ones(len(spline))]
    for axis in range(2):
        crossed, at = _cuts(_powers(control[:, :, axis]))
        segment.append(crossed)
        t.append(at)
    number, place = np.concatenate(segment), np.concatenate(t)
    order = np.lexsort((place, number))
    number, place = number[order], place[order]
    again = np.append(False, (np.diff(place) <= SAME_CUT) & (np.diff(number) == 0))
    number, place = number[~again], place[~again]
    inner = np.diff(number) == 0
    number, begin, end = number[:-1][inner], place[:-1][inner], place[1:][inner]
    return Pieces(number, begin, end, _cells(spline, number, begin, end, origin, cell_size))


def gauss_points(spline: LocalCubicSpline, pieces: Pieces, number: int = 4) -> PiecePoints:
    """Returns Gauss points on pieces, `number` on each.

    Chords and areas swept are exact from two and three points. So is, from five, the work of a
    constant pressure on bilinear shape functions, which has degree 8 in the parameter.
    """
    place, weight = np.polynomial.legendre.leggauss(number)
    half = np.repeat(0.5 * (pieces.end - pieces.begin), number)
    middle = np.repeat(0.5 * (pieces.end + pieces.begin), number)
    t = middle + half * np.tile(place, len(pieces.segment))
    segment = np.repeat(pieces.segment, number)
    return PiecePoints(
        piece=np.repeat(np.arange(len(pieces.segment)), number),
        segment=segment,
        parameter=t,
        position=spline.position(segment, t),
        derivative=spline.derivative(segment, t) * half[:, None],
        weight=np.tile(weight, len(pieces.segment)),
    )


def _cells(
    spline: LocalCubicSpline,
    segment: Integers,
    begin: Floats,
    end: Floats,
    origin: Floats,
    cell_size: Floats,
) -> Integers:
    middle = 0.5 * (begin + end)
    place = (spline.position(segment, middle) - origin) / cell_size
    line = np.rint(place)
    on_line = np.abs(place - line) <= _margin(place)
    behind = on_line & (spline.normal(segment, middle) < 0.0)
    return np.asarray(np.where(on_line, line - behind, np.floor(place)), dtype=np.int64)


def _margin(place: Floats) -> Floats:
    return np.asarray(ON_LINE + ROUNDINGS * np.finfo(float).eps * np.abs(place))


def _powers(control: Floats) -> Floats:
    """Coefficients of 1, t, t^2, t^3 of Bezier values (n, 4), shape (n, 4)."""
    a, b, c, d = control.T
    return np.stack([a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)], axis=1)


def _value(power: Floats, t: Floats) -> Floats:
    return np.asarray(power[:, 0] + t * (power[:, 1] + t * (power[:, 2] + t * power[:, 3])))


def _slope(power: Floats, t: Floats) -> Floats:
    return np.asarray(power[:, 1] + t * (2.0 * power[:, 2] + t * 3.0 * power[:, 3]))


def _turning_points(power: Floats) -> Floats:
    """The two parameters in [0, 1] where cubics may turn; 0 or 1 where there is none, (n, 2)."""
    a, half_b, c = 3.0 * power[:, 3], power[:, 2], power[:, 1]
    root = np.sqrt(np.maximum(half_b**2 - a * c, 0.0))
    large = -(half_b + np.where(half_b < 0.0, -root, root))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.stack([large / a, c / large], axis=1)
    # A cubic without turning points is cut anywhere without harm: it stays monotone in parts.
    return np.sort(np.clip(np.where(np.isfinite(found), found, 0.0), 0.0, 1.0), axis=1)


def _cuts(power: Floats) -> tuple[Integers, Floats]:
    """Where cubics (n, 4) cross whole numbers inside (0, 1): their numbers and parameters."""
    n = len(power)
    turn = _turning_points(power)
    t = np.stack([np.zeros(n), turn[:, 0], turn[:, 1], np.ones(n)], axis=1)
    value = np.stack([_value(power, t[:, i]) for i in range(4)], axis=1)
    line = np.rint(value)
    value = np.where(np.abs(value - line) <= _margin(value), line, value)
    at_turn = _through_turning_points(t, value)
    # Each part between two of the four parameters is monotone: one root for each number inside.
    low, high = np.minimum(value[:, :-1], value[:, 1:]), np.maximum(value[:, :-1], value[:, 1:])
    first, last = np.floor(low) + 1.0, np.ceil(high) - 1.0
    count = np.maximum(last - first + 1.0, 0.0).astype(np.int64).ravel()
    part = np.repeat(np.arange(3 * n), count)
    target = first.ravel()[part] + np.arange(len(part)) - np.repeat(np.cumsum(count) - count, count)
    cubic, interval = np.divmod(part, 3)
    begin, end = t[cubic, interval], t[cubic, interval + 1]
    falling = value[cubic, interval] > value[cubic, interval + 1]
    root = _roots(
        power[cubic], target, np.where(falling, end, begin), np.where(falling, begin, end)
    )
    cubic = np.concatenate([cubic, at_turn[0]])
    root = np.concatenate([root, at_turn[1]])
    inside = (root > SAME_CUT) & (root < 1.0 - SAME_CUT)
    return cubic[inside], root[inside]


def _through_turning_points(t: Floats, value: Floats) -> tuple[Integers, Floats]:
    """Where cubics go through a whole number at a turning point instead of only touching it."""
    found = []
    for i in (1, 2):
        here = value[:, i]
        # The next value that differs, on either side.
        before = np.where(value[:, i - 1] == here, value[:, 0], value[:, i - 1])
        after = np.where(value[:, i + 1] == here, value[:, 3], value[:, i + 1])
        passes = (here == np.rint(here)) & ((before - here) * (after - here) < 0.0)
        if i == 2:  # the first of two turning points on one line counts
            passes &= value[:, 1] != here
        found.append(np.flatnonzero(passes))
    return np.concatenate(found), np.concatenate([t[found[0], 1], t[found[1], 2]])


def _roots(power: Floats, target: Floats, below: Floats, above: Floats) -> Floats:
    """Where cubics are `target`, between parameters where they are below and above it, (n,).

    Newton's method; a step out of the bracket is replaced by its middle.
    """
    t = 0.5 * (below + above)
    for _ in range(SEARCH):
        value = _value(power, t) - target
        below, above = np.where(value < 0.0, t, below), np.where(value < 0.0, above, t)
        slope = _slope(power, t)
        newton = t - value / np.where(slope != 0.0, slope, np.inf)
        inside = (newton - below) * (newton - above) <= 0.0
        moved = np.where(inside & (slope != 0.0), newton, 0.5 * (below + above))
        step, t = np.abs(moved - t), moved
        if (step <= CONVERGED).all():
            break
    return t
