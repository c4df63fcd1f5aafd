# SPDX-License-Identifier: BSD-3-Clause
"""Lines and areas in a view of a boundary's facets: clipping, projection and joining."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats, Integers

_EDGE_ON_TOLERANCE = 0.005
"""A facet is seen edge on if its normal's component along the line of sight is below this."""
_CREASE_COSINE = 0.8
"""Cosine of the angle between normals below which the edge between two facets is drawn."""


def clip_segments(segment: Floats, lower: Floats, upper: Floats) -> tuple[Floats, Integers]:
    """Returns the parts of segments, shape (n, 2, dim), in a box with corners of shape (dim,).

    The results are the m parts, shape (m, 2, dim), and their segments, shape (m,).
    """
    # Liang and Barsky: each side of the box bounds the part of the segment from one end.
    start, step = segment[:, 0], segment[:, 1] - segment[:, 0]
    level = np.abs(step) <= 1e-15 * float((upper - lower).max())
    safe = np.where(level, 1.0, step)
    low, high = (lower - start) / safe, (upper - start) / safe
    enter = np.where(level, 0.0, np.minimum(low, high)).max(axis=1, initial=0.0)
    leave = np.where(level, 1.0, np.maximum(low, high)).min(axis=1, initial=1.0)
    outside = np.any(level & ((start < lower) | (start > upper)), axis=1)
    seen = np.flatnonzero((enter < leave) & ~outside)  # not single common points
    part = np.stack([enter[seen], leave[seen]], axis=1)[:, :, None]
    return start[seen, None, :] + part * step[seen, None, :], seen


def clip_triangles(corner: Floats, lower: Floats, upper: Floats) -> tuple[list[Floats], Integers]:
    """Returns the parts of triangles, shape (n, 3, 3), in a box with corners of shape (3,).

    The results are the m parts, polygons of shape (k, 3), and their triangles, shape (m,).
    """
    near = np.all((corner.max(axis=1) >= lower) & (corner.min(axis=1) <= upper), axis=1)
    within = np.all((corner >= lower) & (corner <= upper), axis=(1, 2))
    parts: list[Floats] = []
    seen: list[int] = []
    for index in np.flatnonzero(near):
        polygon = corner[index]
        if not within[index]:
            for axis in range(3):
                polygon = _cut(polygon, polygon[:, axis] - lower[axis])
                polygon = _cut(polygon, upper[axis] - polygon[:, axis])
        if len(polygon) > 2:
            parts.append(polygon)
            seen.append(int(index))
    return parts, np.array(seen, dtype=np.int64)


def _cut(polygon: Floats, height: Floats) -> Floats:
    """Returns the part of a convex polygon, shape (k, 3), where ``height``, shape (k,), is >= 0."""
    kept: list[Floats] = []
    for k in range(len(polygon)):
        following = (k + 1) % len(polygon)
        if height[k] >= 0.0:
            kept.append(polygon[k])
        if height[k] * height[following] < 0.0:
            part = height[k] / (height[k] - height[following])
            kept.append(polygon[k] + part * (polygon[following] - polygon[k]))
    return np.array(kept).reshape(-1, 3)


def moved_corners(corner: Floats, displacement: Floats) -> Floats:
    """Returns corners, shape (n, dim, dim), after displacements of the facets' centres, (n, dim).

    A displacement that is linear in the position, such as a translation, rotation or change of
    radius, is extrapolated to the corners exactly; the remainder of any other one is averaged over
    the facets at a corner.
    """
    centre = corner.mean(axis=1)
    middle = centre.mean(axis=0)
    size = float(np.ptp(corner.reshape(-1, corner.shape[2]), axis=0).max()) or 1.0
    offset, mean = (centre - middle) / size, displacement.mean(axis=0)
    gradient = np.linalg.lstsq(offset, displacement - mean, rcond=1e-9)[0]
    remainder = displacement - mean - offset @ gradient
    vertex = _vertex_numbers(corner, 1e-7 * size)
    total = np.zeros((int(vertex.max()) + 1, corner.shape[2]))
    np.add.at(total, vertex, remainder[:, None, :])
    average = total / np.bincount(vertex.reshape(-1))[:, None]
    moved: Floats = corner + mean + (corner - middle) / size @ gradient + average[vertex]
    return moved


def _vertex_numbers(corner: Floats, tolerance: float) -> Integers:
    """Returns numbers of the distinct vertices, shape (n, k) for corners of shape (n, k, dim)."""
    # The offset keeps round numbers away from rounding limits.
    whole = np.round(corner.reshape(-1, corner.shape[2]) / tolerance + 0.123)
    number: Integers = np.unique(whole, axis=0, return_inverse=True)[1]
    return number.reshape(corner.shape[:2])


def seen_edge_on(corner: Floats, normal: Floats, chosen: list[int]) -> tuple[Floats, Floats, Flags]:
    """Returns the edges of triangles that are drawn in the view of two axes.

    These are the outline, the border, the creases, and facets seen edge on. The results are the m
    edges in space, shape (m, 2, 3), the unit normals in the view, shape (m, 2), and which of them
    show the surface edge on, so that the soil lies on one side of the line, shape (m,).
    """
    (sight,) = set(range(3)) - set(chosen)
    size = float(np.ptp(corner.reshape(-1, 3), axis=0).max()) or 1.0
    vertex = _vertex_numbers(corner, 1e-7 * size)
    ends = np.concatenate([vertex[:, [0, 1]], vertex[:, [1, 2]], vertex[:, [2, 0]]])
    segment = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    facet = np.tile(np.arange(len(corner)), 3)
    first, group = np.unique(np.sort(ends, axis=1), axis=0, return_index=True, return_inverse=True)[
        1:
    ]
    group, count = group.reshape(-1), len(first)
    towards = normal[:, sight]
    side = np.where(np.abs(towards) < _EDGE_ON_TOLERANCE, 0, np.sign(towards))[facet]
    least, most = np.full(count, 2.0), np.full(count, -2.0)
    np.minimum.at(least, group, side)
    np.maximum.at(most, group, side)
    total = np.zeros((count, 3))
    np.add.at(total, group, normal[facet])
    shared = np.bincount(group, minlength=count)
    # |n1 + n2|^2 = 2 + 2 cos for two facets at an edge
    crease = (shared == 2) & (np.sum(total**2, axis=1) < 2.0 + 2.0 * _CREASE_COSINE)
    edge_on = (least == 0) | (most == 0) | (least != most)
    along = total[:, chosen]
    length = np.linalg.norm(along, axis=1)
    edge_on &= length > 1e-9
    along = along / np.maximum(length, 1e-300)[:, None]
    drawn = np.flatnonzero(edge_on | crease | (shared == 1))
    return segment[first[drawn]], along[drawn], edge_on[drawn]


def join_collinear(segment: Floats, normal: Floats) -> tuple[Floats, Floats]:
    """Returns segments (n, 2, 2) and normals (n, 2) of one view, with overlapping ones joined."""
    if len(segment) == 0:
        return segment, normal
    size = float(np.ptp(segment.reshape(-1, 2), axis=0).max()) or 1.0
    tangent = np.column_stack([normal[:, 1], -normal[:, 0]])
    height = np.einsum("ij,ij->i", segment.mean(axis=1), normal)
    key = np.round(np.column_stack([normal, height / size]) * 1e4 + 0.123)
    group = np.unique(key, axis=0, return_inverse=True)[1].reshape(-1)
    joined: list[Floats] = []
    normals: list[Floats] = []
    for line in range(int(group.max()) + 1):
        own = np.flatnonzero(group == line)
        n, t, h = normal[own[0]], tangent[own[0]], height[own[0]]
        for span in _union(np.sort(segment[own] @ t, axis=1), 1e-6 * size):
            joined.append(np.outer(span, t) + h * n)
            normals.append(n)
    return np.array(joined).reshape(-1, 2, 2), np.array(normals).reshape(-1, 2)


def _union(span: Floats, tolerance: float) -> list[list[float]]:
    """Returns the union of intervals, shape (n, 2); intervals of zero length are left out."""
    result: list[list[float]] = []
    for low, high in span[np.argsort(span[:, 0])]:
        if high - low <= tolerance:
            continue
        if result and low <= result[-1][1] + tolerance:
            result[-1][1] = max(result[-1][1], float(high))
        else:
            result.append([float(low), float(high)])
    return result


def oriented(segment: Floats, normal: Floats) -> Floats:
    """Returns segments (n, 2, 2) in the direction in which their normals (n, 2) are on the left."""
    step = segment[:, 1] - segment[:, 0]
    wrong = normal[:, 1] * step[:, 0] - normal[:, 0] * step[:, 1] < 0.0
    return np.where(wrong[:, None, None], segment[:, ::-1], segment)


def chains(segment: Floats) -> list[Integers]:
    """Returns chains of segments (n, 2, 2), each beginning at the end of the one before it."""
    if len(segment) == 0:
        return []
    size = float(np.ptp(segment.reshape(-1, 2), axis=0).max()) or 1.0
    vertex = _vertex_numbers(segment, 1e-5 * size)
    starting: dict[int, list[int]] = {}
    for k, start in enumerate(vertex[:, 0]):
        starting.setdefault(int(start), []).append(k)
    endings = set(vertex[:, 1].tolist())
    order = sorted(range(len(segment)), key=lambda k: (int(vertex[k, 0]) in endings, k))
    used = np.zeros(len(segment), dtype=bool)
    result = []
    for k in order:
        chain: list[int] = []
        following: int | None = k
        while following is not None and not used[following]:
            used[following] = True
            chain.append(following)
            candidates = starting.get(int(vertex[following, 1]), [])
            following = next((c for c in candidates if not used[c]), None)
        if chain:
            result.append(np.array(chain))
    return result


def polyline(segment: Floats, chain: Integers) -> Floats:
    """Returns points (k, 2) along one of :func:`chains`; slightly different ends are averaged."""
    own = segment[chain]
    inner = 0.5 * (own[:-1, 1] + own[1:, 0])
    return np.concatenate([own[:1, 0], inner, own[-1:, 1]])
