# SPDX-License-Identifier: BSD-3-Clause
"""Soil that a step would carry behind an implicit boundary, and soil that is behind one.

A boundary holds the soil that touches it at the start of a step. Soil that is free there and
reaches it inside the step is not constrained, so a step that would end with such soil behind the
boundary is undone and shortened to the part in which it just reaches it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import StepFailed
from tilth.mpm.domains import half_edges
from tilth.mpm.points import MaterialPoints

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit


SMALL = 0.02
"""Depth behind a boundary, in cells, that needs no word."""

BESIDE = {2: 0.15, 3: 0.3}
"""Distance along a boundary from its nearest place, in cells, from which on soil is beside it.

A little more than that of its own places from each other, by dimension.
"""


HOLD_ACROSS = ("roller", "fixed")
"""Conditions that let no soil through."""

MOST_LOOKS = 64
"""Places on the way of the points in a step that are looked at, at most."""


@dataclass(frozen=True)
class Passage:
    """Soil that would pass through a boundary.

    Attributes:
        boundary: its name.
        point: index of the point that would reach it first.
        depth: greatest depth of the domains of free points behind it at the end [length].
        share: of the step after which the first of them has just reached it [-].
    """

    boundary: str
    point: int
    depth: float
    share: float


TRIES, FUTILE = 4, 0.95
"""Where so many shorter steps leave more than this part of the soil's depth behind a boundary, no
step is short enough."""


class PassageCheck:
    """Refuses steps in which soil that was free passes through an implicit boundary.

    Remembers the step that was shortened last: soil that jumps however short the step is passes.
    """

    def __init__(self) -> None:
        self._start, self._depth, self._tries = math.nan, math.inf, 0

    def require_in_front(
        self,
        boundaries: Sequence[Implicit],
        points: MaterialPoints,
        moved: Floats,
        before: float,
        after: float,
        cell_size: Floats,
    ) -> None:
        """Checks a step from time `before` to `after`; moved: as in `find_passage`.

        Raises:
            StepFailed: soil passes; it says which share of the step is possible.
        """
        found = [find_passage(b, points, moved, before, after, cell_size) for b in boundaries]
        passed = [passage for passage in found if passage is not None]
        if not passed:
            return
        passage = min(passed, key=lambda each: each.share)
        tries = self._tries + 1 if self._start == before else 0
        futile = tries >= TRIES and passage.depth > FUTILE * self._depth
        self._start, self._depth, self._tries = before, passage.depth, tries
        if futile:
            return
        raise StepFailed(
            f"soil reaches the boundary {passage.boundary!r} within the step and would end "
            f"{passage.depth:.3g} behind it",
            point=int(points.point_id[passage.point]),
            share=passage.share,
        )


def find_passage(
    boundary: Implicit,
    points: MaterialPoints,
    moved: Floats,
    before: float,
    after: float,
    cell_size: Floats,
) -> Passage | None:
    """Returns the soil that a step from time `before` to `after` takes through a boundary.

    Looks at the end of the step, and, so that no soil leaps over a boundary that ends or is curved,
    at places on the straight ways of the points, a cell apart.

    moved: where the points are at its end [length], shape (n, dim).
    """
    if boundary.declared.condition not in HOLD_ACROSS:
        return None
    way = moved - points.position
    looks = 1
    if not _is_endless(boundary):
        farthest = np.abs(way / cell_size).max(initial=0.0)
        looks = min(max(math.ceil(farthest), 1), MOST_LOOKS)
    for part in np.arange(1, looks + 1) / looks:
        time = before + part * (after - before)
        place = points.position + part * way
        passage = _passage_at(boundary, points, place, before, time, cell_size)
        if passage is not None:
            return replace(passage, share=float(part) * passage.share)
    return None


def _passage_at(
    boundary: Implicit,
    points: MaterialPoints,
    place: Floats,
    before: float,
    time: float,
    cell_size: Floats,
) -> Passage | None:
    """Returns the soil that has passed a boundary when the points are at `place`, (n, dim)."""
    small = SMALL * float(cell_size.min())
    chosen, distance, normal = _distances(boundary, place, points, time, cell_size)
    near = np.flatnonzero(distance < _widest(points))
    chosen, distance, normal = chosen[near], distance[near], normal[near]
    depth = _half_width(points, chosen, normal) - distance
    deep = np.flatnonzero(depth > small)
    if len(deep) == 0:
        return None
    chosen, depth = chosen[deep], depth[deep]
    at_start = points.position[chosen]
    those, distance, normal = _distances(boundary, at_start, None, before, cell_size)
    chosen, depth = chosen[those], depth[those]
    gap = distance - _half_width(points, chosen, normal)
    free = np.flatnonzero(gap > small)
    if len(free) == 0:
        return None
    share = (gap[free] + 0.5 * small) / (gap[free] + depth[free])
    first = int(share.argmin())
    point = int(chosen[free[first]])
    return Passage(boundary.name, point, float(depth[free].max()), float(share[first]))


def depth_behind(
    boundary: Implicit, points: MaterialPoints, time: float, cell_size: Floats
) -> float:
    """Returns how far the deepest point's centre is behind a boundary [length]; 0 if none is.

    0, too, where its condition lets soil through.
    """
    if boundary.declared.condition not in HOLD_ACROSS:
        return 0.0
    _, distance, _ = _distances(boundary, points.position, points, time, cell_size)
    return float(-distance.min(initial=0.0))


def _distances(
    boundary: Implicit,
    place: Floats,
    points: MaterialPoints | None,
    time: float,
    cell_size: Floats,
) -> tuple[Integers, Floats, Floats]:
    """Returns which places face or are behind a boundary, their distances and its normals there.

    Of a boundary that is curved or ends only those count that are not beside it, and, where their
    `points` are given, that are not farther in front than two cells, nor farther behind than these
    and as much as they have moved.
    """
    if _is_endless(boundary):
        at_rest = boundary.at_rest(place, time)
        normal = boundary.geometry.gradient(at_rest)
        return np.arange(len(place)), boundary.geometry.distance(at_rest), normal
    surface, normal, _ = boundary.surface_places(time)
    nothing = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros((0, place.shape[1]))
    if len(surface) == 0:
        return nothing
    reach = np.inf
    candidates = np.arange(len(place))
    if points is not None:
        way = np.linalg.norm(place - points.position, axis=1).max(initial=0.0)
        reach = float(way + 2.0 * cell_size.max())
        low, high = surface.min(axis=0) - reach, surface.max(axis=0) + reach
        candidates = np.flatnonzero(((place >= low) & (place <= high)).all(axis=1))
    from scipy.spatial import cKDTree

    apart, nearest = cKDTree(surface).query(place[candidates], distance_upper_bound=reach)
    known = np.isfinite(apart)
    candidates, nearest = candidates[known], nearest[known]
    away = place[candidates] - surface[nearest]
    distance = np.einsum("ni,ni->n", away, normal[nearest])
    along = np.linalg.norm(away - distance[:, None] * normal[nearest], axis=1)
    facing = along <= BESIDE[len(cell_size)] * cell_size.max()
    if points is not None:  # what is clearly in front needs no exact distance
        facing &= distance <= 2.0 * cell_size.max()
    candidates, nearest = candidates[facing], nearest[facing]
    if len(candidates) == 0:
        return nothing
    return candidates, boundary.distance(place[candidates], time), normal[nearest]


def _is_endless(boundary: Implicit) -> bool:
    """Whether it is one plane, so that each place is in front of it or behind it."""
    return boundary.geometry.flat and not boundary.geometry.bounded


def _widest(points: MaterialPoints) -> float:
    """Returns a length that half the width of no domain exceeds."""
    if points.corner.shape[1] > 0:
        return np.inf
    return float(np.sqrt((points.half_length**2).sum(axis=1).max(initial=0.0)))


def _half_width(points: MaterialPoints, chosen: Integers, normal: Floats) -> Floats:
    """Returns half the width of points' domains along normals, shape (n,)."""
    edge = half_edges(points, chosen)
    if edge is None:
        return np.asarray((points.half_length[chosen] * np.abs(normal)).sum(axis=1))
    return np.asarray(np.abs(np.einsum("nki,ni->nk", edge, normal)).sum(axis=1))
