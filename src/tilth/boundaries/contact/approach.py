# SPDX-License-Identifier: BSD-3-Clause
"""How far soil is from a free rigid body in the direction of the force on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.patches import Patches

LEAST_COSINE = 0.1
"""Least cosine between the force on a body and the normal where the body can come down on soil."""

FIRST_OVERLAP = 0.01
"""Depth in the soil, in cells, of the first guess for a free body that nothing holds."""


def distance_to_soil(
    patches: Sequence[Patches],
    moved: Sequence[Floats],
    still: Floats,
    direction: Floats,
    of_patch: Callable[[Floats], float],
) -> float | None:
    """Returns how far soil is from a body in a direction [length]; None if it is in contact.

    None, too, where no distance is finite.

    Args:
        patches: of the body's surfaces.
        moved: prescribed displacements of their points in the step [length], (n, dim) each.
        still: nodal displacement of zero, shape (nodes, dim).
        direction: unit, shape (dim,).
        of_patch: the distance of a patch for those of its points that are nearest to the soil.
    """
    nearest = np.inf
    for patch, motion in zip(patches, moved, strict=True):
        closed = patch.law.holds(patch.trial(patch.slips(still, motion))[:, 0])
        if (closed & (patch.area > 0.0)).any():
            return None
        towards = patch.part.pose.normal @ direction
        faces = (towards > LEAST_COSINE) & patch.active
        distance = patch.part.touch.gap[faces] / towards[faces]
        nearest = min(nearest, of_patch(distance))
    return nearest if np.isfinite(nearest) else None
