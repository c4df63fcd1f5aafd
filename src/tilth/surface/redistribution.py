# SPDX-License-Identifier: BSD-3-Clause
"""Insertion and merging of the points of a chain, so that their distances stay in a range."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import Chain
from tilth.curves.spline import LocalCubicSpline

# Points are not merged below this number: a closed curve needs three, one more is a margin.
MINIMUM_POINTS = 4


@dataclass(frozen=True)
class Redistribution:
    """A chain of n points, and their coordinates on the spline of the original chain.

    Attributes:
        chain: the new chain.
        segment: segment of the original spline on which a point lies, shape (n,).
        parameter: parameter there, 0 at an original point (1 at the last one of an open chain),
            shape (n,). Quantities of the original points are interpolated along the segment.
        inserted, merged: numbers of points added and removed.
    """

    chain: Chain
    segment: Integers
    parameter: Floats
    inserted: int
    merged: int


def redistribute_points(
    chain: Chain, longest: float, shortest: float, kept: Flags | None = None
) -> Redistribution:
    """Returns a chain without too long chords, and with as few too short ones as possible.

    A chord longer than `longest` [length] is divided evenly in the spline's parameter; a new
    point is not a corner. Two points nearer than `shortest` [length] are merged half way between
    them on the spline. A corner, a point flagged in `kept` (shape (n,)), point 0 and the ends of
    an open chain keep their position; two such points are not merged. Merging ends at
    `MINIMUM_POINTS` points.

    Raises:
        ValueError: `shortest` is not in the range from 0 to half of `longest`.
    """
    if not 0.0 <= shortest < 0.5 * longest:
        raise ValueError(f"shortest = {shortest:.6g} must be below half of longest = {longest:.6g}")
    spline = LocalCubicSpline(chain)
    at, corner = _merged(spline, shortest, chain.ends if kept is None else chain.ends | kept)
    point = _position(spline, at)
    number = len(at)
    ahead = np.append(at[1:], at[0] + len(spline))
    apart = np.linalg.norm(np.roll(point, -1, axis=0) - point, axis=1)
    parts = np.maximum(np.ceil(apart / longest * (1.0 - 1e-12)), 1.0).astype(np.int64)
    if not chain.closed:
        parts[-1] = 1
    first = np.repeat(np.cumsum(parts) - parts, parts)
    fraction = (np.arange(len(first)) - first) / np.repeat(parts, parts)
    old = np.repeat(np.arange(number), parts)
    at = at[old] + fraction * (ahead - at)[old]
    position = np.where((fraction == 0.0)[:, None], point[old], _position(spline, at))
    segment, parameter = _split(spline, at)
    return Redistribution(
        Chain(position, chain.closed, corner[old] & (fraction == 0.0)),
        segment,
        parameter,
        len(at) - number,
        len(chain) - number,
    )


def _merged(spline: LocalCubicSpline, shortest: float, fixed: Flags) -> tuple[Floats, Flags]:
    """Returns the remaining points: segment plus parameter, and whether a corner, shape (n,) each.

    Point 0, the origin of the arc length, is not moved.
    """
    chain = spline.chain
    at, corner, fixed = np.arange(len(chain), dtype=float), chain.corner, fixed.copy()
    fixed[0] = True
    while True:
        point = _position(spline, at)
        ahead = np.roll(point, -1, axis=0) - point
        short = np.linalg.norm(ahead, axis=1) < shortest
        short &= ~(fixed & np.roll(fixed, -1))
        if not chain.closed:
            short[-1] = False
        first = _every_other(short)[: max(len(at) - MINIMUM_POINTS, 0)]
        if not len(first):
            return at, corner
        # The pairs have no common points except point 0, which is not moved.
        second = (first + 1) % len(at)
        free = ~fixed[first] & ~fixed[second]
        at[first[free]] = 0.5 * (at[first[free]] + at[second[free]])
        removed = np.where(fixed[second], first, second)
        at, corner, fixed = (np.delete(values, removed) for values in (at, corner, fixed))


def _every_other(flags: Flags) -> Integers:
    """Returns the numbers of the first, third, fifth, ... flag of each run of flags."""
    number = np.arange(len(flags))
    last_off = np.maximum.accumulate(np.where(flags, -1, number))
    return np.flatnonzero(flags & ((number - last_off) % 2 == 1))


def _split(spline: LocalCubicSpline, at: Floats) -> tuple[Integers, Floats]:
    """Returns segment and parameter of points given by their sum, shape (n,) each."""
    segment = np.minimum(np.floor(at).astype(np.int64), len(spline) - 1)
    return segment, at - segment


def _position(spline: LocalCubicSpline, at: Floats) -> Floats:
    """Returns the positions of points given by segment plus parameter [length], (n, 2)."""
    return spline.position(*_split(spline, at))
