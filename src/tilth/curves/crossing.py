# SPDX-License-Identifier: BSD-3-Clause
"""Chains that cross or touch themselves or each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import Chain
from tilth.errors import BadInput


@dataclass(frozen=True)
class Crossings:
    """Pairs of chords that meet; m pairs.

    Attributes:
        place: where they meet [length], shape (m, 2); of chords on one line the middle of what they
            share.
        chain, chord: numbers of the chains and of the chords on them, shape (m, 2) each.
    """

    place: Floats
    chain: Integers
    chord: Integers

    def __len__(self) -> int:
        return len(self.place)


def require_no_crossing(chain: Chain, key: str) -> None:
    """Raises BadInput at `key` of the model where a declared chain crosses itself."""
    crossings = find_crossings([chain])
    if len(crossings.place):
        where = ", ".join(f"{x:.4g}" for x in crossings.place[0])
        raise BadInput(
            f"the curve crosses itself at ({where})",
            "give the vertices in order along it",
            key=key,
        )


def find_crossings(chains: Sequence[Chain]) -> Crossings:
    """Returns where the chords of chains meet, other than neighbours in their common point.

    Neighbours that fold back onto each other meet, too. Chords are sorted into square cells, and
    only those that share one are compared.
    """
    start = np.concatenate([chain.points[: len(chain.chord)] for chain in chains])
    end = start + np.concatenate([chain.chord for chain in chains])
    chords = [len(chain.chord) for chain in chains]
    chain = np.repeat(np.arange(len(chains)), chords)
    begin = np.cumsum(chords) - chords
    following = np.arange(len(start)) + 1
    for number, of in enumerate(chains):
        following[begin[number] + chords[number] - 1] = begin[number] if of.closed else -1
    # The ends must be the next chord's very numbers, for the comparisons below to agree.
    joined = following >= 0
    end[joined] = start[following[joined]]

    first, second = _in_one_cell(np.minimum(start, end), np.maximum(start, end))
    swapped = following[second] == first
    first, second = np.where(swapped, second, first), np.where(swapped, first, second)
    neighbours = following[first] == second
    meet = np.where(
        neighbours,
        _fold_back(start[first], end[first], end[second]),
        _meet(start[first], end[first], start[second], end[second]),
    )
    first, second = first[meet], second[meet]
    pair = np.stack([first, second], axis=1)
    place = _meeting_place(start[first], end[first], start[second], end[second])
    return Crossings(place, np.asarray(chain[pair]), np.asarray(pair - begin[chain[pair]]))


def _in_one_cell(lower: Floats, upper: Floats) -> tuple[Integers, Integers]:
    """Pairs of bounding boxes (n, 2) that share a cell, each once, the lesser number first."""
    extent = (upper - lower).max(axis=1)
    # Cells a few chords wide, but so wide that no chord covers many more than there are chords.
    size = max(2.0 * float(extent.mean()), float(extent.max()) / np.sqrt(len(lower)))
    corner = lower.min(axis=0)
    low = np.floor((lower - corner) / size).astype(np.int64)
    wide = np.floor((upper - corner) / size).astype(np.int64) - low + 1
    count = wide.prod(axis=1)
    chord = np.repeat(np.arange(len(lower)), count)
    within = np.arange(len(chord)) - np.repeat(np.cumsum(count) - count, count)
    x, y = low[chord, 0] + within % wide[chord, 0], low[chord, 1] + within // wide[chord, 0]
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


def _turn(a: Floats, b: Floats, c: Floats) -> Floats:
    """Twice the signed area of triangles."""
    first, second = b - a, c - a
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def _meet(a: Floats, b: Floats, c: Floats, d: Floats) -> Flags:
    """Whether the segments a-b and c-d have a point in common."""
    apart = (_turn(a, b, c) * _turn(a, b, d) > 0.0) | (_turn(c, d, a) * _turn(c, d, b) > 0.0)
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.asarray(~apart & (low <= high).all(axis=1))


def _fold_back(a: Floats, b: Floats, c: Floats) -> Flags:
    """Whether the segment b-c runs back along a-b."""
    return np.asarray((_turn(a, b, c) == 0.0) & (((b - a) * (c - b)).sum(axis=1) < 0.0))


def _meeting_place(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    at_c, at_d = _turn(a, b, c), _turn(a, b, d)
    across = at_c - at_d
    on_line = across == 0.0
    share = np.where(on_line, 0.0, at_c / np.where(on_line, 1.0, across))
    low = np.maximum(np.minimum(a, b), np.minimum(c, d))
    high = np.minimum(np.maximum(a, b), np.maximum(c, d))
    return np.where(on_line[:, None], 0.5 * (low + high), c + share[:, None] * (d - c))
