# SPDX-License-Identifier: BSD-3-Clause
"""Soil that comes over lines of the grid."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from metamorphic.runs import Moment


def come_into_other_cells(moments: Sequence[Moment]) -> bool:
    """Whether points are in other cells after a step than after the one before."""
    return any(
        before.cell.shape == after.cell.shape and bool((before.cell != after.cell).any())
        for before, after in pairwise(moments)
    )


def hang_over(moments: Sequence[Moment]) -> list[bool]:
    """Whether soil hangs less far over a line at the start of each step than its edge moves.

    In it, or in the step before; of all moments but the first. The edge moves at most twice as far
    as a point, as in one row of them on a base.

    A node beyond the line, that only a strip of the width d touches, moves h / d times as far as
    the strip, h being a cell, until its force is zero, as exactly as that of any other node. With
    soil out of balance by the stress s, of the modulus E, its force is of the order s d / h against
    the stiffness E (d / h)^2 / h: the strip moves by h s / E, however narrow it is. A motion u
    changes d by u, and what is in balance by the share u / d: the strip is in balance again, and
    the results of steps come nearer to each other, only once these motions are small against d.
    """
    ways = [motion(before, after) for before, after in pairwise(moments)]
    last = [float(np.abs(moments[0].displacement).max()), *ways[:-1]][: len(ways)]
    return [
        before.overhang < 2.0 * max(way, earlier)
        for before, way, earlier in zip(moments[:-1], ways, last, strict=True)
    ]


def motion(before: Moment, after: Moment) -> float:
    """The greatest motion of a point that there was before [length]."""
    same = np.isin(before.number, after.number), np.isin(after.number, before.number)
    return float(np.abs(after.position[same[1]] - before.position[same[0]]).max(initial=0.0))
