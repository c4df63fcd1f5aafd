# SPDX-License-Identifier: BSD-3-Clause
"""Points of a three-dimensional body that are visible from outside."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.report.domains import corners_of_boxes

_COMMON_SIDE_TOLERANCE = 0.5
"""Sides are common if the distance of their centres over that to the point is below this."""

_EVEN = 1.5
"""Ratio of most domains' sides, at most, with which they count as equal."""


def points_with_free_sides(position: Floats, corners: Floats) -> Integers:
    """Returns numbers of the points with a side that is no side of another domain, shape (k,).

    ``position`` has the shape (n, 3), ``corners`` of the domains, x fastest and relative to the
    points, (n, 8, 3).
    """
    from scipy.spatial import cKDTree

    numbers = np.arange(8)
    sides = [np.flatnonzero((numbers >> axis & 1) == end) for axis in range(3) for end in (0, 1)]
    to_side = np.stack([corners[:, side].mean(axis=1) for side in sides], axis=1)
    centre = (position[:, None, :] + to_side).reshape(-1, 3)
    distance = cKDTree(centre).query(centre, k=2)[0][:, 1].reshape(-1, 6)
    free = distance > _COMMON_SIDE_TOLERANCE * np.linalg.norm(to_side, axis=2)
    return np.flatnonzero(free.any(axis=1)).astype(np.int64)


def uneven(half_lengths: Floats) -> bool:
    """Returns whether some domains are much larger or smaller than most, as on a graded grid."""
    small, middle, large = np.quantile(half_lengths, [0.05, 0.5, 0.95], axis=0)
    return bool(((large > _EVEN * middle) | (middle > _EVEN * small)).any())


def exterior_points(position: Floats, half_lengths: Floats | None) -> Integers:
    """Returns the numbers of the points at the boundary of a body, shape (k,).

    The points, shape (n, 3), are sorted into boxes as large as a point's domain (``half_lengths``,
    shape (n, 3)) or as the mean spacing; a point is at the boundary if one of the six neighbours
    of its box is empty. Uneven domains have free sides there instead.
    """
    if half_lengths is not None and uneven(half_lengths):
        return points_with_free_sides(position, corners_of_boxes(half_lengths))
    lower = position.min(axis=0)
    if half_lengths is None:
        extent = np.maximum(position.max(axis=0) - lower, 1e-300)
        size = np.full(3, float(np.cbrt(np.prod(extent) / len(position))))
    else:
        size = 2.0 * np.median(half_lengths, axis=0)
    box = np.floor((position - lower) / (1.05 * size)).astype(np.int64) + 1
    shape = box.max(axis=0) + 2
    strides = np.array([shape[1] * shape[2], shape[2], 1])
    key = box @ strides
    filled = np.unique(key)
    free = np.zeros(len(position), dtype=bool)
    for step in strides:
        for neighbour in (key - step, key + step):
            slot = np.minimum(np.searchsorted(filled, neighbour), len(filled) - 1)
            free |= filled[slot] != neighbour
    return np.flatnonzero(free).astype(np.int64)
