# SPDX-License-Identifier: BSD-3-Clause
"""Parts of triangles in a region in plan.

The region is cut by each triangle, both in the plan of the undeformed body. What is left, a polygon
inside the triangle, is a fan of triangles around its first corner. Their areas have signs, so that
they sum to the polygon's area and moments also where it is not convex. In the barycentric
coordinates of the triangle they stay where they are as the surface moves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers

EDGE_ON = 1e-9
"""Area in plan, over the area, of a triangle that is seen edge-on and cut by no region."""

WHOLE = 1e-12
"""A triangle less than this part of which is outside a region is inside, one with less inside is
outside."""


@dataclass(frozen=True)
class ClippedTriangles:
    """Small triangles that fill a region of a surface; k of them.

    Attributes:
        element: number of the triangle of the surface that holds each, shape (k,).
        corner: barycentric coordinates of the corners, shape (k, 3, 3).
        share: its area over that of that triangle, shape (k,); see above for their signs.
    """

    element: Integers
    corner: Floats
    share: Floats


def clip_in_plan(corner: Floats, chosen: Flags, region: Floats) -> ClippedTriangles:
    """Returns the parts of triangles in a region in plan.

    Args:
        corner: of the triangles [length], shape (m, 3, 3).
        chosen: which triangles may be loaded, shape (m,).
        region: corners of the region in order [length], shape (n, 2).
    """
    if _signed_area(region) < 0.0:
        region = region[::-1]
    plan = corner[:, :, :2]
    edges = plan[:, 1:] - plan[:, :1]
    twice = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    area = np.linalg.norm(np.cross(*np.moveaxis(corner[:, 1:] - corner[:, :1], 1, 0)), axis=1)
    near = (plan.max(axis=1) > region.min(axis=0)) & (plan.min(axis=1) < region.max(axis=0))
    candidates = np.flatnonzero(chosen & near.all(axis=1) & (np.abs(twice) > EDGE_ON * area))
    elements, corners, shares = [], [], []
    for number in candidates:
        map_to_barycentric = np.linalg.inv(edges[number].T)
        local = (region - plan[number, 0]) @ map_to_barycentric.T
        polygon = _inside_triangle(np.column_stack([1.0 - local.sum(axis=1), local]))
        if np.linalg.det(map_to_barycentric) < 0.0:
            polygon = polygon[::-1]
        fan = _fan(polygon)
        share = 2.0 * np.array([_signed_area(each[:, 1:]) for each in fan])
        total = float(share.sum())
        if total > 1.0 - WHOLE:
            fan, share = np.eye(3)[None], np.ones(1)
        elif total < WHOLE:
            continue
        keep = share != 0.0
        elements.append(np.full(np.count_nonzero(keep), number))
        corners.append(fan[keep])
        shares.append(share[keep])
    if not elements:
        return ClippedTriangles(np.zeros(0, dtype=np.int64), np.zeros((0, 3, 3)), np.zeros(0))
    return ClippedTriangles(*map(np.concatenate, (elements, corners, shares)))


def area_in_plan(corner: Floats, clipped: ClippedTriangles) -> float:
    """Returns the area in plan that clipped triangles cover [length^2]."""
    edges = (corner[:, 1:] - corner[:, :1])[clipped.element, :, :2]
    twice = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    return 0.5 * float(np.abs(twice) @ clipped.share)


def _inside_triangle(polygon: Floats) -> Floats:
    """Returns the part of a polygon where all barycentric coordinates are >= 0, shape (k, 3).

    I.E. Sutherland & G.W. Hodgman (1974), Reentrant polygon clipping, Communications of the ACM 17.
    """
    for side in range(3):
        if not len(polygon):
            break
        here, after = polygon, np.roll(polygon, -1, axis=0)
        value, next_value = here[:, side], after[:, side]
        inside, crossing = value >= 0.0, (value >= 0.0) != (next_value >= 0.0)
        part = np.zeros(len(polygon))
        part[crossing] = value[crossing] / (value[crossing] - next_value[crossing])
        cut = here + part[:, None] * (after - here)
        cut[:, side] = 0.0
        both = np.stack([here, cut], axis=1).reshape(-1, 3)
        polygon = both[np.stack([inside, crossing], axis=1).ravel()]
    return polygon


def _fan(polygon: Floats) -> Floats:
    """Returns the triangles around the first corner of a polygon, shape (n - 2, 3, 3)."""
    count = max(len(polygon) - 2, 0)
    rows = np.arange(count)[:, None] + np.array([0, 1, 2])
    rows[:, 0] = 0
    return np.asarray(polygon[rows])


def _signed_area(corners: Floats) -> float:
    """Returns the area of a polygon, shape (n, 2), > 0 if its corners are anticlockwise."""
    x, y = (corners - corners[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
