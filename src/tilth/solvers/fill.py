# SPDX-License-Identifier: BSD-3-Clause
"""Fill of a direct solver's factors on a box of nodes, without a matrix.

Geometric nested dissection (cpp/tilth/sparse/nested_dissection.hpp) makes every separator couple
with all nodes at the edge of its box that are eliminated later. Summed over all separators this
gives about n log n entries in 2D and n^(4/3) in 3D (George 1973), and less for slender bodies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache

LEAF = 24
"""Nodes that are not dissected further."""


def factor_blocks(sides: Sequence[int], thickness: int) -> float:
    """Returns the number of node blocks in the lower triangle of the factors.

    Args:
        sides: nodes of the box along each direction, shape (dim,).
        thickness: of a separator: largest number of cells between two nodes that are coupled.
    """
    _dissected.cache_clear()
    ordered = tuple(sorted(sides, reverse=True))
    return _dissected(ordered, (0,) * len(ordered), thickness)


@cache
def _dissected(sides: tuple[int, ...], separators: tuple[int, ...], thickness: int) -> float:
    """As `factor_blocks`, for a box with separators at 0, 1 or 2 of its faces per direction."""
    nodes = math.prod(sides)
    around = math.prod(s + thickness * n for s, n in zip(sides, separators, strict=True)) - nodes
    axis = max(range(len(sides)), key=lambda k: sides[k])
    if nodes <= LEAF or sides[axis] < thickness + 2:
        return 0.5 * nodes * (nodes + around)
    separator = thickness * nodes // sides[axis]
    total = separator * (0.5 * separator + around)
    below = (sides[axis] - thickness) // 2
    faces = [1, 1] if separators[axis] == 0 else [2, separators[axis]]
    for side, beside in zip((below, sides[axis] - thickness - below), faces, strict=True):
        part = list(zip(sides, separators, strict=True))
        part[axis] = (side, beside)
        part.sort(reverse=True)
        total += _dissected(tuple(s for s, _ in part), tuple(n for _, n in part), thickness)
    return total
