# SPDX-License-Identifier: BSD-3-Clause
"""Which of many small polygons covers each pixel of an image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers

_ROOM = 0.4
"""Distance by which polygons are widened, so that neighbours have no seam [pixel]."""


def draw_polygons(area: Floats, width: int, height: int) -> Integers:
    """Returns which convex polygon, the last one of several, is at the centre of each pixel.

    ``area`` has their corners in pixels from the upper left, shape (n, k, 2). The result is of
    shape (height, width), -1 where there is none.
    """
    number = np.full((height, width), -1, dtype=np.int64)
    low = np.ceil(area.min(axis=1) - _ROOM - 0.5).astype(np.int64)
    high = np.ceil(area.max(axis=1) + _ROOM - 0.5).astype(np.int64)  # the first pixel beyond
    low, high = np.maximum(low, 0), np.minimum(high, [width, height])
    size = np.maximum(high - low, 0)
    there = np.flatnonzero(size.all(axis=1))
    across, along = _edges(area)
    large = size[there].max(axis=1) > 64
    for each in there[large]:
        rows, columns = np.mgrid[low[each, 1] : high[each, 1], low[each, 0] : high[each, 0]]
        inside = _inside(across[each], along[each], columns + 0.5, rows + 0.5)
        number[rows[inside], columns[inside]] = each
    there = there[~large]
    for y in range(int(size[there, 1].max(initial=0))):
        for x in range(int(size[there, 0].max(initial=0))):
            own = there[(size[there, 0] > x) & (size[there, 1] > y)]
            column, row = low[own, 0] + x, low[own, 1] + y
            inside = _inside(across[own].T, along[own].T, column + 0.5, row + 0.5)
            inside &= number[row, column] < own
            number[row[inside], column[inside]] = own[inside]
    return number


def _edges(area: Floats) -> tuple[Floats, Floats]:
    """Returns inward normals of the edges and their distances from the origin.

    Shapes (n, k, 2) and (n, k).
    """
    step = np.roll(area, -1, axis=1) - area
    normal = np.stack([-step[..., 1], step[..., 0]], axis=-1)
    x, y = area[..., 0], area[..., 1]
    twice = (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    length = np.linalg.norm(normal, axis=-1)
    normal *= (np.where(twice < 0.0, -1.0, 1.0)[:, None] / np.maximum(length, 1e-9))[..., None]
    return normal, np.einsum("nkd,nkd->nk", normal, area)


def _inside(normal: Floats, distance: Floats, x: Floats, y: Floats) -> NDArray[np.bool_]:
    """Returns whether positions are inside; normal: (k, 2), or (2, k, n) of the n positions."""
    if normal.ndim == 2:
        sides = [n[0] * x + n[1] * y - d for n, d in zip(normal, distance, strict=True)]
    else:
        sides = [
            nx * x + ny * y - d for nx, ny, d in zip(normal[0], normal[1], distance, strict=True)
        ]
    return np.asarray(np.min(sides, axis=0) >= -_ROOM)
