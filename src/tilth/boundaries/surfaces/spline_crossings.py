# SPDX-License-Identifier: BSD-3-Clause
"""Crossings of lines with the splines of a tracked surface in the plane."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.crossings import (
    LINES_PER_BATCH,
    AlongLines,
    Window,
    candidate_pairs,
    joined,
    summarised,
)
from tilth.curves.chain import Chain
from tilth.curves.spline import LocalCubicSpline

PIECES = 8
"""Straight pieces per segment, each of which a line crosses at most once."""
ITERATIONS = 60
"""Most iterations of the root search; bisection alone converges in these."""
PARAMETER_TOLERANCE = 1e-15
"""The root search ends with a correction of the parameter below this."""
ON_LINE = 1e-9
"""Ends of an open curve nearer than this to a vertical line, relative to its size, are on it."""


class SplineSurface:
    """The curves of one body, see `SoilSurface`; none of them crosses itself or another one."""

    def __init__(self, chains: Sequence[Chain]) -> None:
        self._splines = [LocalCubicSpline(chain) for chain in chains]
        self._lines = [spline.polyline(PIECES) for spline in self._splines]
        self._bounds_soil = all(map(_bounds_soil, chains))

    def cross(self, position: Floats, normal: Floats, window: Window) -> AlongLines:
        """As `SoilSurface.cross`."""
        parts = []
        for begin in range(0, len(position), LINES_PER_BATCH):
            own = slice(begin, begin + LINES_PER_BATCH)
            parts.append(self._cross(position[own], normal[own], window.of(own)))
        return joined(parts)

    def _cross(self, position: Floats, normal: Floats, window: Window) -> AlongLines:
        found = []
        for spline, vertices in zip(self._splines, self._lines, strict=True):
            start, end = vertices[:-1], vertices[1:]
            # the curve bulges from a piece by less than the piece's length
            radius = 1.5 * np.linalg.norm(end - start, axis=1)
            line, piece = candidate_pairs(0.5 * (start + end), radius, position, normal, window)
            across = normal[line][:, ::-1] * [1.0, -1.0]  # f = (C - x) . across changes sign
            at_start = ((start[piece] - position[line]) * across).sum(axis=1)
            at_end = ((end[piece] - position[line]) * across).sum(axis=1)
            crosses = (at_start < 0.0) != (at_end < 0.0)
            line, piece, across = line[crosses], piece[crosses], across[crosses]
            rises = at_start[crosses] < 0.0
            segment = piece // PIECES
            t = _root(spline, segment, piece % PIECES / PIECES, rises, position[line], across)
            at = ((spline.position(segment, t) - position[line]) * normal[line]).sum(axis=1)
            found.append((line, at, np.where(rises, 1.0, -1.0)))
        line, at, sign = (np.concatenate(each) for each in zip(*found, strict=True))
        return summarised(len(position), line, at, sign, window)

    def contains(self, position: Floats) -> Flags | None:
        """As `SoilSurface.contains`: the winding number, with a horizontal line to +x."""
        if not self._bounds_soil:
            return None
        winding = np.zeros(len(position))
        order = np.argsort(position[:, 1])
        x, y = position[order].T
        for vertices in self._lines:
            start, end = vertices[:-1], vertices[1:]
            low = np.searchsorted(y, np.minimum(start[:, 1], end[:, 1]), side="left")
            high = np.searchsorted(y, np.maximum(start[:, 1], end[:, 1]), side="left")
            count = high - low
            piece = np.repeat(np.arange(len(start)), count)
            point = np.arange(len(piece)) + np.repeat(low - np.cumsum(count) + count, count)
            run = end[piece] - start[piece]
            crossing = start[piece, 0] + (y[point] - start[piece, 1]) * run[:, 0] / run[:, 1]
            ahead = crossing > x[point]
            np.add.at(winding, order[point[ahead]], np.sign(run[ahead, 1]))
        return winding > 0.5


def _bounds_soil(chain: Chain) -> bool:
    """Whether a curve is closed, or open between two points of a vertical line on its left.

    A curve in axisymmetry ends on the axis like this: no horizontal line to +x meets its gap.
    """
    if chain.closed:
        return True
    ends, left = chain.points[[0, -1], 0], chain.points[:, 0].min()
    return bool((ends <= left + ON_LINE * np.ptp(chain.points, axis=0).max()).all())


def _root(
    spline: LocalCubicSpline,
    segment: Integers,
    begin: Floats,
    rises: Flags,
    position: Floats,
    across: Floats,
) -> Floats:
    """Returns the parameters where (C(t) - position) . across vanishes on a piece, shape (n,).

    Newton's method; a correction out of the bracket is replaced by bisection.

    Args:
        spline: the curve C.
        segment, begin: segment, and parameter at the begin of the piece, shape (n,) each.
        rises: whether the value increases from the begin to the end of the piece, shape (n,).
        position, across: shape (n, 2) each.
    """
    low, high = begin, begin + 1.0 / PIECES
    t = 0.5 * (low + high)
    for _ in range(ITERATIONS):
        value = ((spline.position(segment, t) - position) * across).sum(axis=1)
        slope = (spline.derivative(segment, t) * across).sum(axis=1)
        beyond = (value > 0.0) == rises
        low, high = np.where(beyond, low, t), np.where(beyond, t, high)
        new = t - value / np.where(slope == 0.0, np.inf, slope)
        good = (slope != 0.0) & (new >= low) & (new <= high)
        new = np.where(good, new, 0.5 * (low + high))
        done = np.abs(new - t) <= PARAMETER_TOLERANCE
        t = new
        if done.all():
            break
    return t
