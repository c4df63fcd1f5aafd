# SPDX-License-Identifier: BSD-3-Clause
"""Points of a chain that drift apart get new ones between them, crowded ones merge."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import Chain
from tilth.curves.spline import LocalCubicSpline

# Points below which a chain keeps those it has: a closed curve needs three, one more is a margin.
FEWEST = 4


@dataclass(frozen=True)
class Upkeep:
    """A chain after its upkeep, and where its points come from; n points.

    Attributes:
        chain: the new chain.
        segment: segment of the old spline on which a point lies, shape (n,).
        parameter: place on it, 0 at an old point (1 at the last one of an open chain), shape (n,).
            A quantity of the old points is carried over by interpolation along the segment.
        inserted, merged: points more and less than before.
    """

    chain: Chain
    segment: Integers
    parameter: Floats
    inserted: int
    merged: int


def upkeep(chain: Chain, longest: float, shortest: float, kept: Flags | None = None) -> Upkeep:
    """Returns a chain without chords that are too long, and with as few too short ones as can be.

    A chord longer than `longest` [length] is divided evenly in the spline's parameter; a new
    point is not a corner. Of two points nearer than `shortest` [length] one remains: half way
    between them on the spline, or the one that is a corner, `kept` (shape (n,)), point 0 or an end
    of an open chain. Two such points both stay, and so do the last few points of a chain.
    """
    if not 0.0 <= shortest < 0.5 * longest:
        raise ValueError(f"shortest = {shortest:.6g} must be below half of longest = {longest:.6g}")
    spline = LocalCubicSpline(chain)
    at, corner = _merged(spline, shortest, chain.ends if kept is None else chain.ends | kept)
    place = _position(spline, at)
    number = len(at)
    ahead = np.append(at[1:], at[0] + len(spline))
    apart = np.linalg.norm(np.roll(place, -1, axis=0) - place, axis=1)
    parts = np.maximum(np.ceil(apart / longest * (1.0 - 1e-12)), 1.0).astype(np.int64)
    if not chain.closed:
        parts[-1] = 1
    first = np.repeat(np.cumsum(parts) - parts, parts)
    share = (np.arange(len(first)) - first) / np.repeat(parts, parts)
    old = np.repeat(np.arange(number), parts)
    at = at[old] + share * (ahead - at)[old]
    position = np.where((share == 0.0)[:, None], place[old], _position(spline, at))
    segment, parameter = _split(spline, at)
    return Upkeep(
        Chain(position, chain.closed, corner[old] & (share == 0.0)),
        segment,
        parameter,
        len(at) - number,
        len(chain) - number,
    )


def _merged(spline: LocalCubicSpline, shortest: float, fixed: Flags) -> tuple[Floats, Flags]:
    """The points that remain: segment plus parameter, shape (n,), and whether they are corners.

    Point 0, from which the arc length counts, stays where it is.
    """
    chain = spline.chain
    at, corner, fixed = np.arange(len(chain), dtype=float), chain.corner, fixed.copy()
    fixed[0] = True
    while True:
        place = _position(spline, at)
        ahead = np.roll(place, -1, axis=0) - place
        short = np.linalg.norm(ahead, axis=1) < shortest
        short &= ~(fixed & np.roll(fixed, -1))
        if not chain.closed:
            short[-1] = False
        first = _every_other(short)[: max(len(at) - FEWEST, 0)]
        if not len(first):
            return at, corner
        # No two of these pairs share a point but point 0, which stays.
        second = (first + 1) % len(at)
        free = ~fixed[first] & ~fixed[second]
        at[first[free]] = 0.5 * (at[first[free]] + at[second[free]])
        gone = np.where(fixed[second], first, second)
        at, corner, fixed = (np.delete(values, gone) for values in (at, corner, fixed))


def _every_other(flags: Flags) -> Integers:
    """Numbers of the first, third, fifth, ... flag of each run of flags, in order."""
    number = np.arange(len(flags))
    last_off = np.maximum.accumulate(np.where(flags, -1, number))
    return np.flatnonzero(flags & ((number - last_off) % 2 == 1))


def _split(spline: LocalCubicSpline, at: Floats) -> tuple[Integers, Floats]:
    """Segment and parameter of places given by their sum."""
    segment = np.minimum(np.floor(at).astype(np.int64), len(spline) - 1)
    return segment, at - segment


def _position(spline: LocalCubicSpline, at: Floats) -> Floats:
    return spline.position(*_split(spline, at))
