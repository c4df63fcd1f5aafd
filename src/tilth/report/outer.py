# SPDX-License-Identifier: BSD-3-Clause
"""Which points of a three-dimensional body can be seen from outside."""

from __future__ import annotations

import numpy as np

from ..output.snapshot import FloatArray, IntArray


def outer_points(position: FloatArray, half_lengths: FloatArray | None) -> IntArray:
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
