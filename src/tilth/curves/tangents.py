# SPDX-License-Identifier: BSD-3-Clause
"""Tangents of a curve through a chain of points, each from at most two points on either side.

The angle theta between two neighbouring chords, of lengths l and l', is the curvature averaged over
both with the weight of a hat function: theta = c (l + l') / 2 with c the curvature at the hat's
centroid, to second order. The angle from the chord before a point to the tangent there is l / 2
times the curvature at a third of this chord from the point. So the tangent divides theta in the
ratio f = l A / (l A + l' B), where A and B are the curvatures at a third of either chord. They are
interpolated between the c of neighbouring points, harmonically: where the neighbour has no
curvature A or B vanishes, and the tangent is the chord of the straight run.

This is the rule of The NURBS Book, section 9.3, for the tangents of local interpolation with other
weights. Those of the book, A = |q_{k-1} x q_k| and B = |q_{k+1} x q_{k+2}| with chords q, suit
equal distances: straight runs and evenly divided circles have the same tangents. Where neighbouring
distances differ, as they do after points were inserted or merged, they are of first order only.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.curves.chain import Chain, turning_angle

# Turning angle of round-off [rad]; a run of points this straight is treated as a circle's arc.
STRAIGHT_ANGLE = 1e-15

# Curvatures on either side over that of the point below which both are alike: between two straight
# runs the ratio of their round-off would decide. Beside a curved run its square is round-off.
STRAIGHT_RUNS = 1e-7


def tangents(chain: Chain) -> tuple[Floats, Floats]:
    """Returns unit tangents at the start and at the end of each chord, shape (chords, 2) each.

    They differ at corners only; there and at the ends of an open chain they are one-sided. The
    error is of third order in the distance of the points, also for unequal distances; next to a
    change of the curvature's sign it is of second order. A run of two points is straight.
    """
    # An open chain is treated as a closed one without its last chord: its ends separate the two.
    ahead = np.roll(chain.points, -1, axis=0) - chain.points
    length = np.linalg.norm(ahead, axis=1)
    before = np.roll(length, 1)
    angle = turning_angle(np.roll(ahead, 1, axis=0), ahead)
    curvature = 2.0 * angle / (before + length)
    inner = ~chain.ends
    mirrored = _mirror(curvature, length, inner)
    one = _relative_curvature(curvature, length, inner)
    other = _relative_curvature(*mirrored)[::-1]
    least = STRAIGHT_RUNS**2 / (one + other + STRAIGHT_RUNS)
    weight_before, weight_after = before * (one + least), length * (other + least)
    fraction = weight_before / (weight_before + weight_after)
    to_start = np.where(inner, (1.0 - fraction) * angle, _at_end(curvature, length, inner))
    to_end = np.where(inner, fraction * angle, _at_end(*mirrored)[::-1])
    direction = ahead / length[:, None]
    start, end = _rotated(direction, -to_start), _rotated(direction, np.roll(to_end, -1))
    return (start, end) if chain.closed else (start[:-1], end[:-1])


def _mirror(curvature: Floats, length: Floats, inner: Flags) -> tuple[Floats, Floats, Flags]:
    """Returns the data of the reversed chain, with the sign of the original curvature."""
    return curvature[::-1], np.roll(length[::-1], -1), inner[::-1]


def _relative_curvature(curvature: Floats, length: Floats, inner: Flags) -> Floats:
    """Returns the curvature at a third of the chord before each point over that of the point."""
    far, before, after = np.roll(length, 2), np.roll(length, 1), length
    here, neighbour = np.abs(curvature), np.abs(np.roll(curvature, 1))
    part, least = after / (far + before + after), STRAIGHT_ANGLE / (before + after)
    between = (neighbour + least) / (part * here + (1.0 - part) * neighbour + least)
    outside = _extrapolated(curvature, inner, after / (before + after + np.roll(length, -1)))
    return np.where(np.roll(inner, 1), between, outside)


def _at_end(curvature: Floats, length: Floats, inner: Flags) -> Floats:
    """Returns the angle from tangent to chord if a curve begins at the point [rad], shape (n,)."""
    two = np.roll(length, 1) + length
    factor = _extrapolated(curvature, inner, two / (two + np.roll(length, -1)))
    first = np.where(inner, curvature * factor, 0.0)
    return np.asarray(0.5 * length * np.roll(first, -1))


def _extrapolated(curvature: Floats, inner: Flags, distance: Floats) -> Floats:
    """Returns the curvature before each point over that at the point, extrapolated, shape (n,).

    distance: distance before the point over the distance to the next one, < 1, shape (n,). The
    linear extrapolation is limited to the range from 1 - distance to 1 + distance.
    """
    ahead = np.roll(curvature, -1)
    ahead = np.where(curvature * ahead > 0.0, np.abs(ahead), 0.0)
    here = np.abs(curvature)
    greatest = np.maximum(here, ahead)
    difference = (here - ahead) / np.where(greatest > 0.0, greatest, 1.0)
    return np.where(np.roll(inner, -1), 1.0 + distance * difference, 1.0)


def _rotated(direction: Floats, angle: Floats) -> Floats:
    """Returns vectors (n, 2) rotated anticlockwise by angles (n,) [rad]."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = direction.T
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], axis=1)
