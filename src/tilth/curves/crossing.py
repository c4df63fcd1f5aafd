# SPDX-License-Identifier: BSD-3-Clause
"""Intersections of chains with themselves and with each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import Chain
from tilth.errors import BadInput


@dataclass(frozen=True)
class Crossings:
    """Pairs of chords that intersect; m pairs.

    Attributes:
        position: of the intersection [length], shape (m, 2); of chords on one line the middle of
            their common part.
        chain, chord: numbers of the chains and of the chords on them, shape (m, 2) each.
    """

    position: Floats
    chain: Integers
    chord: Integers

    def __len__(self) -> int:
        return len(self.position)


def require_no_crossing(chain: Chain, key: str) -> None:
    """Raises BadInput for `key` of the model if a declared chain crosses itself."""
    crossings = find_crossings([chain])
    if len(crossings.position):
        where = ", ".join(f"{x:.4g}" for x in crossings.position[0])
        raise BadInput(
            f"the curve crosses itself at ({where})",
            "give the vertices in order along it",
            key=key,
        )


def find_crossings(chains: Sequence[Chain]) -> Crossings:
    """Returns the intersections of chains' chords, other than the common points of neighbours.

    Neighbours that fold back onto each other count as intersecting. Chords are sorted into square
    cells, and only those that have a cell in common are compared.
    """
    start = np.concatenate([chain.points[: len(chain.chord)] for chain in chains])
    end = start + np.concatenate([chain.chord for chain in chains])
    chords = [len(chain.chord) for chain in chains]
    chain = np.repeat(np.arange(len(chains)), chords)
    begin = np.cumsum(chords) - chords
    following = np.arange(len(start)) + 1
    for number, of in enumerate(chains):
        following[begin[number] + chords[number] - 1] = begin[number] if of.closed else -1
    # The end of a chord must be bit for bit the start of the next one in the comparisons below.
    joined = following >= 0
    end[joined] = start[following[joined]]

    first, second = _in_one_cell(np.minimum(start, end), np.maximum(start, end))
    swapped = following[second] == first
    first, second = np.where(swapped, second, first), np.where(swapped, first, second)
    neighbours = following[first] == second
    intersecting = np.where(
        neighbours,
        _fold_back(start[first], end[first], end[second]),
        _intersect(start[first], end[first], start[second], end[second]),
    )
    first, second = first[intersecting], second[intersecting]
    pair = np.stack([first, second], axis=1)
    position = _intersections(start[first], end[first], start[second], end[second])
    return Crossings(position, np.asarray(chain[pair]), np.asarray(pair - begin[chain[pair]]))


def _in_one_cell(lower: Floats, upper: Floats) -> tuple[Integers, Integers]:
    """Returns pairs of bounding boxes (n, 2) with a common cell, each once, lower number first."""
    extent = (upper - lower).max(axis=1)
    # Cells a few chords wide, and so wide that no chord extends over many more cells than there are
    # chords.
    size = max(2.0 * float(extent.mean()), float(extent.max()) / np.sqrt(len(lower)))
    corner = lower.min(axis=0)
    low = np.floor((lower - corner) / size).astype(np.int64)
    width = np.floor((upper - corner) / size).astype(np.int64) - low + 1
    count = width.prod(axis=1)
    chord = np.repeat(np.arange(len(lower)), count)
    within = np.arange(len(chord)) - np.repeat(np.cumsum(count) - count, count)
    x, y = low[chord, 0] + within % width[chord, 0], low[chord, 1] + within // width[chord, 0]
    cell = x + (int(x.max()) + 1) * y
    order = np.argsort(cell, kind="stable")
    cell, chord = cell[order], chord[order]
    pairs = []
    shift, left = 1, np.arange(len(cell) - 1)
    while len(left := left[left + shift < len(cell)]):
        left = left[cell[left] == cell[left + shift]]
        pairs.append(chord[left] * len(lower) + chord[left + shift])
        shift += 1
    found = np.unique(np.concatenate(pairs)) if pairs else np.empty(0, np.int64)
    return found // len(lower), found % len(lower)


def _twice_area(a: Floats, b: Floats, c: Floats) -> Floats:
    """Returns twice the signed areas of triangles, > 0 if anticlockwise, shape (n,)."""
    first, second = b - a, c - a
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _intersect(a: Floats, b: Floats, c: Floats, d: Floats) -> Flags:
    """Returns whether the segments a-b and c-d have a point in common, shape (n,)."""
    apart = (_twice_area(a, b, c) * _twice_area(a, b, d) > 0.0) | (
        _twice_area(c, d, a) * _twice_area(c, d, b) > 0.0
    )
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.asarray(~apart & (low <= high).all(axis=1))


def _fold_back(a: Floats, b: Floats, c: Floats) -> Flags:
    """Returns whether the segment b-c runs back along a-b, shape (n,)."""
    return np.asarray((_twice_area(a, b, c) == 0.0) & (((b - a) * (c - b)).sum(axis=1) < 0.0))


def _intersections(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Returns the common points of the segments a-b and c-d, shape (n, 2)."""
    at_c, at_d = _twice_area(a, b, c), _twice_area(a, b, d)
    across = at_c - at_d
    on_line = across == 0.0
    parameter = np.where(on_line, 0.0, at_c / np.where(on_line, 1.0, across))
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.where(on_line[:, None], 0.5 * (low + high), c + parameter[:, None] * (d - c))
