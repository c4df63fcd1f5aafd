# SPDX-License-Identifier: BSD-3-Clause
"""Whether the patches of a base leave its soil free to tilt."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.boundaries.contact.forces import AssembledContact
from tilth.terms.balance import Balance

LEAST_ARM = 0.25
"""Least range of the middles of patches along an axis of the grid, over that of their points."""


def may_tilt(balance: Balance) -> bool:
    """Whether a boundary in contact bears hardly any moment about a horizontal axis, in space.

    A corner of a base on grid lines is a quarter of a face, and joins what is nearest: one patch
    may go around all of another one, so that both have their middles at one place. Half of the
    range is what two patches have that divide a base evenly.
    """
    for term in balance.terms:
        if isinstance(term, AssembledContact) and term.body is None:
            for patch in term._patches:
                part = patch.part
                if is_without_arm(part.multiplier, part.pose.position, part.pose.weight):
                    return True
    return False


def is_without_arm(multiplier: Integers, position: Floats, weight: Floats) -> bool:
    """The same of the patches of points: their numbers, places and areas."""
    horizontal = position[:, :-1]
    if len(multiplier) == 0 or horizontal.shape[1] < 2:
        return False
    area = np.bincount(multiplier, weight)
    sums = [np.bincount(multiplier, weight * along) for along in horizontal.T]
    middles = np.stack(sums, axis=1)[area > 0.0] / area[area > 0.0, None]
    least = LEAST_ARM * np.ptp(horizontal, axis=0)
    return len(middles) > 0 and bool((np.ptp(middles, axis=0) < least).any())
