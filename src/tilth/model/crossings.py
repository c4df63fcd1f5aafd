# SPDX-License-Identifier: BSD-3-Clause
"""Whether a polygon or a polyline crosses itself or another one, and what is inside a polygon."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats

_PAIRS_PER_BATCH = 1_000_000
"""Pairs of edges that are compared at once, about, to bound the memory."""


def crosses_itself(corners: Sequence[Sequence[float]], closed: bool = True) -> bool:
    """Whether two edges intersect that are not neighbours, or two neighbours overlap.

    corners: vertices in order [length], shape (n, 2). closed: whether the last one is joined to the
    first.
    """
    start = np.array(corners, dtype=float)
    end = np.roll(start, -1, axis=0)
    if not closed:
        start, end = start[:-1], end[:-1]
    return _neighbours_overlap(start, end, closed) or _others_meet(start, end, closed)


def lines_meet(one: Floats, other: Floats) -> bool:
    """Whether the outlines of two closed polygons, vertices (n, 2) and (m, 2), meet.

    They are compared in parts that bound the memory, only where their bounding boxes meet.
    """
    a, b = one, np.roll(one, -1, axis=0)
    c, d = other, np.roll(other, -1, axis=0)
    low, high = np.minimum(c, d), np.maximum(c, d)
    rows = max(1, _PAIRS_PER_BATCH // len(other))
    for first in range(0, len(one), rows):
        part = slice(first, first + rows)
        least, most = np.minimum(a[part], b[part])[:, None], np.maximum(a[part], b[part])[:, None]
        i, j = np.nonzero(((least <= high) & (low <= most)).all(axis=2))
        if _segments_meet(a[part][i], b[part][i], c[j], d[j]).any():
            return True
    return False


def in_polygon(start: Floats, position: Floats) -> Flags:
    """Returns which positions (n, 2) are inside a polygon of vertices `start` (m, 2), (n,)."""
    end = np.roll(start, -1, axis=0)
    rising = start[:, 1] != end[:, 1]
    start, end = start[rising], end[rising]
    inside = np.zeros(len(position), dtype=bool)
    x, y = position.T
    rows = max(1, _PAIRS_PER_BATCH // max(1, len(position)))
    for first in range(0, len(start), rows):
        x0, y0 = start[first : first + rows].T[:, :, None]
        x1, y1 = end[first : first + rows].T[:, :, None]
        crossed = ((y0 <= y) != (y1 <= y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        inside ^= np.logical_xor.reduce(crossed, axis=0)
    return inside


def _neighbours_overlap(start: Floats, end: Floats, closed: bool) -> bool:
    """Whether an edge goes back along the one before it."""
    before = slice(None) if closed else slice(None, -1)
    a, b = start[before], end[before]
    c = np.roll(end, -1, axis=0)[before]
    back = _ahead(a, b, c) <= _ahead(a, b, b)
    return bool(((_turn(a, b, c) == 0.0) & back).any())


def _others_meet(start: Floats, end: Floats, closed: bool) -> bool:
    """Whether two edges meet that have no vertex in common.

    Edges are compared in the order of their least x, each with the later ones that begin before it
    ends.
    """
    least, greatest = np.minimum(start, end), np.maximum(start, end)
    order = np.argsort(least[:, 0], kind="stable")
    stop = np.searchsorted(least[order, 0], greatest[order, 0], side="right")
    number = stop - np.arange(len(order)) - 1
    first = 0
    while first < len(order):
        pairs = np.cumsum(number[first:])
        last = first + max(1, int(np.searchsorted(pairs, _PAIRS_PER_BATCH, side="right")))
        own = number[first:last]
        one = np.repeat(np.arange(first, last), own)
        other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(own) - own, own)
        i, j = order[one], order[other]
        apart = np.abs(i - j)
        candidate = (apart > 1) & ((apart < len(order) - 1) if closed else True)
        candidate &= (least[i, 1] <= greatest[j, 1]) & (least[j, 1] <= greatest[i, 1])
        i, j = i[candidate], j[candidate]
        if _segments_meet(start[i], end[i], start[j], end[j]).any():
            return True
        first = last
    return False


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Returns twice the signed area of each triangle, shape (n,)."""
    (x, y), (u, v) = (b - a).T, (c - a).T
    return np.asarray(x * v - y * u)


def _ahead(a: Floats, b: Floats, c: Floats) -> Floats:
    """Returns (b - a) . (c - a), shape (n,)."""
    return np.asarray(((b - a) * (c - a)).sum(axis=1))


def _segments_meet(a: Floats, b: Floats, c: Floats, d: Floats) -> npt.NDArray[np.bool_]:
    """Returns which segments a-b and c-d meet; their bounding boxes do, shape (n,)."""
    around = _turn(a, b, c) * _turn(a, b, d) <= 0.0
    return np.asarray(around & (_turn(c, d, a) * _turn(c, d, b) <= 0.0))
