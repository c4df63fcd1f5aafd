# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a shape with holes in the plane: those that are in no hole."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.bodies.polygon import OUTLINE_TOLERANCE, area_and_centroid
from tilth.bodies.request import BodyPoints, Request
from tilth.model.crossings import in_polygon
from tilth.model.holes import Disc, HoledShape, Ring
from tilth.model.shape_base import DeclaredShape


def without_holes(points: BodyPoints, shape: DeclaredShape, request: Request) -> BodyPoints:
    """Returns the points of a shape that are in none of its holes.

    Points on the outline of a hole stay. All volumes are multiplied by one factor so that they sum
    to the volume of the shape without the holes. Raises BadInput for a hole without points, which
    the body would not have.

    Args:
        points: of the whole shape.
        shape: the shape.
        request: its resolution.
    """
    within, volume = [], math.fsum(points.volume)
    margin = 2.0 * OUTLINE_TOLERANCE * float(points.half_length.min())
    for hole in shape.cavities():
        assert isinstance(hole, HoledShape), "holes are shapes in the plane"
        outline = hole.outline()
        within.append(_deep_in(outline, points.position, margin))
        volume -= _volume(outline, hole.whole(), request)
    return remaining(points, within, volume, request)


def remaining(
    points: BodyPoints, within: list[Flags], volume: float, request: Request
) -> BodyPoints:
    """Returns the points that are in no hole, with volumes that sum to one.

    Args:
        points: of the whole shape, n of them.
        within: for each hole which points are in it, shape (n,).
        volume: of the shape without its holes.
        request: its resolution.

    Raises:
        BadInput: no point is in a hole, or between the holes.
    """
    kept = np.ones(len(points.position), dtype=bool)
    for i, own in enumerate(within):
        if not own.any():
            raise request.refused(
                "no material point lies in this hole, so that the body would not have it",
                "use more points per cell, a smaller spacing or a finer grid, or leave it out",
                f"shape.holes[{i}]",
            )
        kept &= ~own
    if not kept.any():
        raise request.refused(
            "no material point lies between its holes",
            "use more points per cell, a smaller spacing or a finer grid",
            request.resolution,
        )
    left = points.ordered(np.flatnonzero(kept))
    return replace(left, volume=left.volume * (volume / math.fsum(left.volume)))


def _volume(outline: Ring, area: float, request: Request) -> float:
    """Returns the volume of a hole: per unit length [length^2], or in full circle [length^3]."""
    if not request.axisymmetric:
        return area
    centre = outline.centre if isinstance(outline, Disc) else area_and_centroid(outline)[1]
    return area * 2.0 * math.pi * float(centre[0])


def _deep_in(outline: Ring, position: Floats, margin: float) -> Flags:
    """Returns which positions are inside an outline, farther than a margin from it, shape (n,)."""
    if isinstance(outline, Disc):
        distance = np.linalg.norm(position - outline.centre, axis=1)
        return np.asarray(distance < outline.radius - margin)
    within = in_polygon(outline, position)
    near = np.flatnonzero(within)
    for start, end in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        edge, to = end - start, position[near] - start
        share = np.clip(to @ edge / (edge @ edge), 0.0, 1.0)
        away = np.linalg.norm(to - share[:, None] * edge, axis=1) > margin
        within[near[~away]] = False
        near = near[away]
    return within
