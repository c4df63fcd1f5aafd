# SPDX-License-Identifier: BSD-3-Clause
"""How far soil is from a free rigid body in the direction of the force on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.constraint import Supports

LEAST_COSINE = 0.1
"""Least cosine between the force on a body and the normal where the body can come down on soil."""

FIRST_OVERLAP = 0.01
"""Depth in the soil, in cells, of the first guess for a free body that nothing holds."""


def distance_to_soil(
    supports: Sequence[Supports],
    moved: Sequence[Floats],
    still: Floats,
    direction: Floats,
    of_support: Callable[[Floats], float],
) -> float | None:
    """Returns how far soil is from a body in a direction [length]; None if it is in contact.

    None, too, where no distance is finite.

    Args:
        supports: of the body's surfaces.
        moved: prescribed displacements of their points in the step [length], (n, dim) each.
        still: nodal displacement of zero, shape (nodes, dim).
        direction: unit, shape (dim,).
        of_support: the distance of a support for those of its points that are nearest to the soil.
    """
    nearest = np.inf
    for support, motion in zip(supports, moved, strict=True):
        response = support.respond(support.slips(still, motion))
        if (response.closed & (support.area > 0.0)).any():
            return None
        towards = support.part.pose.normal @ direction
        faces = (towards > LEAST_COSINE) & support.active
        distance = support.part.touch.gap[faces] / towards[faces]
        nearest = min(nearest, of_support(distance))
    return nearest if np.isfinite(nearest) else None
