# SPDX-License-Identifier: BSD-3-Clause
"""Gauss points on a spline that is cut at the lines of a grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tilth import grid_lines
from tilth.arrays import Floats, Integers
from tilth.curves.spline import LocalCubicSpline, left

if TYPE_CHECKING:
    from tilth.grid.background import Grid

# A point nearer to a grid line than this [cell sizes] is on it. So round-off does not cut a segment
# along a line, nor one that is tangent to it.
LINE_TOLERANCE = 1e-11
# The same in machine epsilons times the coordinates [cell sizes]; larger far from the origin.
LINE_EPSILONS = 64.0
# Cuts of a segment nearer than this in its parameter coincide.
CUT_TOLERANCE = 1e-12
# Maximum iterations of the root search for a cut; bisection alone converges in these.
MAXIMUM_ITERATIONS = 60
# The root search ends with a correction of the parameter below this.
PARAMETER_TOLERANCE = 1e-14


@dataclass(frozen=True)
class Pieces:
    """Pieces of segments, each in one cell; m pieces in the order of the chain.

    Attributes:
        segment: number of the segment, shape (m,).
        begin, end: parameters on the segment between which the piece lies, shape (m,).
        cell: indices of the cell along the axes, counted from the grid's origin, shape (m, 2). A
            piece along a grid line is in the cell on the side of the soil.
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
        segment, parameter: coordinates on the spline, shape (n,) each.
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
        """Tributary length of each point [length], shape (n,)."""
        return np.asarray(self.weight * np.linalg.norm(self.derivative, axis=1))

    @property
    def area_vector(self) -> Floats:
        """Tributary length of each point times the normal into the soil [length], shape (n, 2).

        A pressure p on the soil gives the force p times this. The sum over a piece is exact.
        """
        return np.asarray(self.weight[:, None] * left(self.derivative))


def cut_at_grid(spline: LocalCubicSpline, grid: Grid) -> Pieces:
    """Returns the pieces of a spline between the lines of a grid in the plane."""
    control = spline.control - grid.origin
    segments = np.arange(len(spline))
    segment, t = [segments, segments], [np.zeros(len(spline)), np.ones(len(spline))]
    for axis in range(2):
        along = control[:, :, axis]
        if axis in grid.graded:
            crossed, at = _cuts(_powers(along), grid.lines[axis])
        else:
            crossed, at = _cuts(_powers(along / grid.cell_size[axis]))
        segment.append(crossed)
        t.append(at)
    number, parameter = np.concatenate(segment), np.concatenate(t)
    order = np.lexsort((parameter, number))
    number, parameter = number[order], parameter[order]
    repeated = np.append(False, (np.diff(parameter) <= CUT_TOLERANCE) & (np.diff(number) == 0))
    number, parameter = number[~repeated], parameter[~repeated]
    inner = np.diff(number) == 0
    number, begin, end = number[:-1][inner], parameter[:-1][inner], parameter[1:][inner]
    return Pieces(number, begin, end, _cells(spline, number, begin, end, grid))


def gauss_points(spline: LocalCubicSpline, pieces: Pieces, number: int = 4) -> PiecePoints:
    """Returns Gauss points on pieces, `number` on each.

    Chords are exact from two points, swept areas from three. The work of a constant pressure on
    bilinear shape functions has degree 8 in the parameter and is exact from five points.
    """
    coordinate, weight = np.polynomial.legendre.leggauss(number)
    half = np.repeat(0.5 * (pieces.end - pieces.begin), number)
    middle = np.repeat(0.5 * (pieces.end + pieces.begin), number)
    t = middle + half * np.tile(coordinate, len(pieces.segment))
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
    spline: LocalCubicSpline, segment: Integers, begin: Floats, end: Floats, grid: Grid
) -> Integers:
    """Returns the cells of pieces, on a grid line those on the side of the soil, shape (m, 2)."""
    middle = 0.5 * (begin + end)
    x = grid.in_cells(spline.position(segment, middle))
    line = np.rint(x)
    on_line = np.abs(x - line) <= _tolerance(x)
    negative_side = on_line & (spline.normal(segment, middle) < 0.0)
    return np.asarray(np.where(on_line, line - negative_side, np.floor(x)), dtype=np.int64)


def _tolerance(x: Floats) -> Floats:
    """Returns the distance from a grid line below which coordinates [cell sizes] are on it."""
    return np.asarray(LINE_TOLERANCE + LINE_EPSILONS * np.finfo(float).eps * np.abs(x))


def _powers(control: Floats) -> Floats:
    """Returns the coefficients of 1, t, t^2, t^3 of Bezier values (n, 4), shape (n, 4)."""
    a, b, c, d = control.T
    return np.stack([a, 3.0 * (b - a), 3.0 * (a - 2.0 * b + c), d - a + 3.0 * (b - c)], axis=1)


def _value(power: Floats, t: Floats) -> Floats:
    return np.asarray(power[:, 0] + t * (power[:, 1] + t * (power[:, 2] + t * power[:, 3])))


def _slope(power: Floats, t: Floats) -> Floats:
    return np.asarray(power[:, 1] + t * (2.0 * power[:, 2] + t * 3.0 * power[:, 3]))


def _turning_points(power: Floats) -> Floats:
    """Returns the parameters in [0, 1] of the two turning points; 0 or 1 where none, (n, 2)."""
    a, half_b, c = 3.0 * power[:, 3], power[:, 2], power[:, 1]
    root = np.sqrt(np.maximum(half_b**2 - a * c, 0.0))
    large = -(half_b + np.where(half_b < 0.0, -root, root))
    with np.errstate(divide="ignore", invalid="ignore"):
        found = np.stack([large / a, c / large], axis=1)
    # A cubic without turning points is monotone between any parameters.
    return np.sort(np.clip(np.where(np.isfinite(found), found, 0.0), 0.0, 1.0), axis=1)


def _cuts(power: Floats, lines: Floats | None = None) -> tuple[Integers, Floats]:
    """Returns the cubics (n, 4) that cross lines inside (0, 1), and the parameters there.

    lines: places of the lines (`tilth/grid_lines.py`); the integers if not given.
    """
    n = len(power)
    turn = _turning_points(power)
    t = np.stack([np.zeros(n), turn[:, 0], turn[:, 1], np.ones(n)], axis=1)
    value = np.stack([_value(power, t[:, i]) for i in range(4)], axis=1)
    if lines is not None:
        value = grid_lines.in_cells(value, lines)
    line = np.rint(value)
    value = np.where(np.abs(value - line) <= _tolerance(value), line, value)
    at_turn = _through_turning_points(t, value)
    # Each part between two of the four parameters is monotone: one root for each line inside.
    low, high = np.minimum(value[:, :-1], value[:, 1:]), np.maximum(value[:, :-1], value[:, 1:])
    first, last = np.floor(low) + 1.0, np.ceil(high) - 1.0
    count = np.maximum(last - first + 1.0, 0.0).astype(np.int64).ravel()
    part = np.repeat(np.arange(3 * n), count)
    target = first.ravel()[part] + np.arange(len(part)) - np.repeat(np.cumsum(count) - count, count)
    if lines is not None:
        target = grid_lines.distance(target, lines)
    cubic, interval = np.divmod(part, 3)
    begin, end = t[cubic, interval], t[cubic, interval + 1]
    falling = value[cubic, interval] > value[cubic, interval + 1]
    root = _roots(
        power[cubic], target, np.where(falling, end, begin), np.where(falling, begin, end)
    )
    cubic = np.concatenate([cubic, at_turn[0]])
    root = np.concatenate([root, at_turn[1]])
    inside = (root > CUT_TOLERANCE) & (root < 1.0 - CUT_TOLERANCE)
    return cubic[inside], root[inside]


def _through_turning_points(t: Floats, value: Floats) -> tuple[Integers, Floats]:
    """Returns cubics that cross a line at a turning point or inflection, and parameters.

    t, value: at the ends and turning points, values in cells, shape (n, 4). Turning points where a
    cubic is only tangent to the line are none of them.
    """
    found = []
    for i in (1, 2):
        here = value[:, i]
        # The next value that differs, on either side.
        before = np.where(value[:, i - 1] == here, value[:, 0], value[:, i - 1])
        after = np.where(value[:, i + 1] == here, value[:, 3], value[:, i + 1])
        passes = (here == np.rint(here)) & ((before - here) * (after - here) < 0.0)
        if i == 2:  # of two turning points on one line the first is used
            passes &= value[:, 1] != here
        found.append(np.flatnonzero(passes))
    return np.concatenate(found), np.concatenate([t[found[0], 1], t[found[1], 2]])


def _roots(power: Floats, target: Floats, below: Floats, above: Floats) -> Floats:
    """Returns the parameters where cubics are `target`, shape (n,).

    below, above: parameters where they are below and above it, shape (n,). Newton's method; a
    correction out of the bracket is replaced by bisection.
    """
    t = 0.5 * (below + above)
    for _ in range(MAXIMUM_ITERATIONS):
        value = _value(power, t) - target
        below, above = np.where(value < 0.0, t, below), np.where(value < 0.0, above, t)
        slope = _slope(power, t)
        newton = t - value / np.where(slope != 0.0, slope, np.inf)
        inside = (newton - below) * (newton - above) <= 0.0
        new = np.where(inside & (slope != 0.0), newton, 0.5 * (below + above))
        correction, t = np.abs(new - t), new
        if (correction <= PARAMETER_TOLERANCE).all():
            break
    return t
