# SPDX-License-Identifier: BSD-3-Clause
"""Which points of a three-dimensional body can be seen from outside."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers

_SAME_PLACE = 0.5
"""Sides are shared if their centres are closer than this share of their distance to the point."""


def free_sides(position: Floats, corners: Floats) -> Integers:
    """Numbers of the points with a side that is not shared with another point's domain, (k,).

    ``position`` has the shape (n, 3), ``corners`` of the domains, x fastest and seen from the
    points, (n, 8, 3).
    """
    from scipy.spatial import cKDTree

    numbers = np.arange(8)
    sides = [np.flatnonzero((numbers >> axis & 1) == end) for axis in range(3) for end in (0, 1)]
    reach = np.stack([corners[:, side].mean(axis=1) for side in sides], axis=1)
    centre = (position[:, None, :] + reach).reshape(-1, 3)
    apart = cKDTree(centre).query(centre, k=2)[0][:, 1].reshape(-1, 6)
    free = apart > _SAME_PLACE * np.linalg.norm(reach, axis=2)
    return np.flatnonzero(free.any(axis=1)).astype(np.int64)


def outer_points(position: Floats, half_lengths: Floats | None) -> Integers:
    """Numbers of the points with a free side, shape (k,).

    The points, shape (n, 3), are sorted into boxes as large as a point's domain (``half_lengths``,
    shape (n, 3)) or as the mean spacing; a point is an outer one if one of the six boxes beside
    its own is empty.
    """
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
