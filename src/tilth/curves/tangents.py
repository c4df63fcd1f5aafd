# SPDX-License-Identifier: BSD-3-Clause
"""Tangents of a chain of points, each from at most two points on either side.

The angle theta between two neighbouring chords, of lengths l and l', is the curvature averaged over
both with the weight of a hat function: theta = c (l + l') / 2 with c the curvature at the hat's
centroid, to second order. The angle from the chord before a point to the tangent there is l / 2
times the curvature at a third of this chord from the point. So the tangent divides theta in the
ratio f = l A / (l A + l' B), where A and B are the curvatures at a third of either chord. They are
interpolated between the c of neighbouring points, harmonically: where the neighbour has no
curvature A or B vanishes, and the tangent is the chord of the straight run.

This is the rule of The NURBS Book, section 9.3, for the tangents of local interpolation with other
weights. Those of the book, A = |q_{k-1} x q_k| and B = |q_{k+1} x q_{k+2}| with chords q, suit even
distances: straight runs and evenly divided circles have the same tangents. Where neighbouring
distances differ, as they do after points were inserted or merged, they are of first order only.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.curves.chain import Chain, turning

# Turning angles of round-off; a run as straight as this is divided like a circle's arc.
STRAIGHT = 1e-15


def tangents(chain: Chain) -> tuple[Floats, Floats]:
    """Returns unit tangents at the start and at the end of each chord, shape (chords, 2) each.

    They differ at corners only; there and at the ends of an open chain they are those of the one
    side. The error is of third order in the distance of the points, also if the distances vary;
    of second order beside a change of the curvature's sign. A run of two points is straight.
    """
    # An open chain is a closed one whose last chord is dropped: nothing passes its ends.
    ahead = np.roll(chain.points, -1, axis=0) - chain.points
    length = np.linalg.norm(ahead, axis=1)
    before = np.roll(length, 1)
    angle = turning(np.roll(ahead, 1, axis=0), ahead)
    curvature = 2.0 * angle / (before + length)
    inner = ~chain.ends
    mirrored = _mirror(curvature, length, inner)
    behind = before * _to_this_side(curvature, length, inner)
    in_front = length * _to_this_side(*mirrored)[::-1]
    share = behind / (behind + in_front)
    to_start = np.where(inner, (1.0 - share) * angle, _at_end(curvature, length, inner))
    to_end = np.where(inner, share * angle, _at_end(*mirrored)[::-1])
    direction = ahead / length[:, None]
    start, end = _turned(direction, -to_start), _turned(direction, np.roll(to_end, -1))
    return (start, end) if chain.closed else (start[:-1], end[:-1])


def _mirror(curvature: Floats, length: Floats, inner: Flags) -> tuple[Floats, Floats, Flags]:
    """The chain from its last point to its first; the curvature keeps the chain's own sign."""
    return curvature[::-1], np.roll(length[::-1], -1), inner[::-1]


def _to_this_side(curvature: Floats, length: Floats, inner: Flags) -> Floats:
    """Curvature at a third of the chord before each point, over that of the point, shape (n,)."""
    far, before, after = np.roll(length, 2), np.roll(length, 1), length
    here, neighbour = np.abs(curvature), np.abs(np.roll(curvature, 1))
    part, least = after / (far + before + after), STRAIGHT / (before + after)
    between = (neighbour + least) / (part * here + (1.0 - part) * neighbour + least)
    outside = _extrapolated(curvature, inner, after / (before + after + np.roll(length, -1)))
    return np.where(np.roll(inner, 1), between, outside)


def _at_end(curvature: Floats, length: Floats, inner: Flags) -> Floats:
    """Angle from the tangent to the chord if a curve begins at the point [rad], shape (n,)."""
    two = np.roll(length, 1) + length
    factor = _extrapolated(curvature, inner, two / (two + np.roll(length, -1)))
    first = np.where(inner, curvature * factor, 0.0)
    return np.asarray(0.5 * length * np.roll(first, -1))


def _extrapolated(curvature: Floats, inner: Flags, reach: Floats) -> Floats:
    """Curvature before each point from those at the point and at the next, over that at the point.

    reach: distance before the point over the distance of the two, < 1. The straight line through
    the two is bent so that the result stays between 1 - reach and 1 + reach.
    """
    ahead = np.roll(curvature, -1)
    ahead = np.where(curvature * ahead > 0.0, np.abs(ahead), 0.0)
    here = np.abs(curvature)
    greatest = np.maximum(here, ahead)
    change = (here - ahead) / np.where(greatest > 0.0, greatest, 1.0)
    return np.where(np.roll(inner, -1), 1.0 + reach * change, 1.0)


def _turned(direction: Floats, angle: Floats) -> Floats:
    """Vectors (n, 2) turned anticlockwise by angles (n,)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = direction.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
