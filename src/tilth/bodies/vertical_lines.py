# SPDX-License-Identifier: BSD-3-Clause
"""Vertical lines through triangles in space: which of them they cross, and where."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats, Integers

PAIRS_PER_BATCH = 1_000_000
"""Pairs of triangles and lines that are compared at once, about, to bound the memory."""

Crossed = tuple[Integers, Floats, Floats]
"""Numbers of what is crossed, heights [length], and 1 where a line that goes up leaves the body
whose outward side the triangles turn, -1 where it enters; shape (k,) each."""


def crossed_by_lines(corner: Floats, at: Floats) -> tuple[Integers, Integers, Floats, Floats]:
    """Returns where vertical lines cross triangles, normals outwards.

    Args:
        corner: of the triangles [length], shape (n, 3, 3).
        at: places of the lines in plan [length], shape (m, 2).

    Returns:
        Numbers of the lines and of the triangles, heights and signs as of `Crossed`, (k,) each.
    """
    low, high = corner[..., :2].min(axis=1), corner[..., :2].max(axis=1)
    left, bottom = at.min(axis=0)
    extent = np.ptp(at, axis=0)
    extent[extent == 0.0] = 1.0  # a single line
    columns = max(int(np.sqrt(len(at))), 1)

    def column_of(x: Floats) -> Integers:
        share = np.clip((x - left) / extent[0], 0.0, 1.0)
        return np.asarray(np.minimum((share * columns).astype(np.int64), columns - 1))

    def key_of(column: Integers, y: Floats) -> Floats:
        """Along each column in turn; 0.25 to 0.75 within it, as round-off must not leave it."""
        return np.asarray(column + 0.25 + 0.5 * np.clip((y - bottom) / extent[1], -0.25, 1.25))

    own = key_of(column_of(at[:, 0]), at[:, 1])
    order = np.argsort(own, kind="stable")
    ordered = own[order]
    found = []
    for triangle, column in pairs(column_of(low[:, 0]), column_of(high[:, 0]) + 1):
        margin = 1e-12 * columns
        first = np.searchsorted(ordered, key_of(column, low[triangle, 1]) - margin, side="left")
        stop = np.searchsorted(ordered, key_of(column, high[triangle, 1]) + margin, side="right")
        for row, line in pairs(first, stop):
            hit, height, sign = crossed(corner[triangle[row]], at[order[line]])
            found.append((order[line[hit]], triangle[row[hit]], height, sign))
    line, number, height, sign = (np.concatenate(each) for each in zip(*found, strict=True))
    return line, number, height, sign


def pairs(first: Integers, stop: Integers) -> Iterator[tuple[Integers, Integers]]:
    """Yields, in batches, pairs of a row number and each number from `first` to before `stop`."""
    count = np.maximum(stop - first, 0)
    batch = np.cumsum(count) // PAIRS_PER_BATCH
    for rows in np.split(np.arange(len(count)), np.flatnonzero(np.diff(batch)) + 1):
        own = count[rows]
        row = np.repeat(rows, own)
        yield row, first[row] + np.arange(len(row)) - np.repeat(np.cumsum(own) - own, own)


def crossed(corner: Floats, place: Floats) -> Crossed:
    """Returns which triangles (n, 3, 3) the vertical line at its place (n, 2) crosses, and where.

    The numbers are those of the pairs of a triangle and a line.
    """
    first, edge, other = corner[:, 0], corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    to = place - first[:, :2]
    turn = edge[:, 0] * other[:, 1] - edge[:, 1] * other[:, 0]
    some = np.where(turn == 0.0, 1.0, turn)  # a vertical triangle is not crossed
    u = (to[:, 0] * other[:, 1] - to[:, 1] * other[:, 0]) / some
    v = (edge[:, 0] * to[:, 1] - edge[:, 1] * to[:, 0]) / some
    hit = np.flatnonzero((turn != 0.0) & (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0))
    height = first[hit, 2] + u[hit] * edge[hit, 2] + v[hit] * other[hit, 2]
    return hit, height, np.sign(turn[hit])
