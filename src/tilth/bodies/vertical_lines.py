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
    order = np.argsort(at[:, 0], kind="stable")
    x = at[order, 0]
    first = np.searchsorted(x, corner[..., 0].min(axis=1), side="left")
    stop = np.searchsorted(x, corner[..., 0].max(axis=1), side="right")
    found = [
        (order[line[hit]], triangle[hit], height, sign)
        for triangle, line in pairs(first, stop)
        for hit, height, sign in [crossed(corner[triangle], at[order[line]])]
    ]
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
