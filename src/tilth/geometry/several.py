# SPDX-License-Identifier: BSD-3-Clause
"""Several shapes that are one body: what of one lies in another is no surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.geometry.protocol import Geometry

TOUCHING = 1e-9
"""Distance, relative to the largest coordinate, below which a place is on another shape."""


def outside_of_others(
    shapes: Sequence[Geometry], number: int, position: Floats, normal: Floats
) -> Flags:
    """Returns which places on one of several shapes are on the surface of all together, (n,).

    A place in another shape is none, and neither is one where two shapes touch with their faces
    turned to each other. Where the faces of two shapes coincide, that of the first one counts.

    Args:
        shapes: that are one body.
        number: of the shape among them, from 0.
        position: on this shape [length], shape (n, dim).
        normal: unit, from it into the soil, shape (n, dim).
    """
    outside = np.ones(len(position), dtype=bool)
    near = TOUCHING * float(np.abs(position).max(initial=0.0))
    for other, shape in enumerate(shapes):
        if other == number:
            continue
        distance = shape.distance(position)
        touching = np.abs(distance) <= near
        outside &= touching | (distance > 0.0)
        alike = np.einsum("ni,ni->n", shape.gradient(position[touching]), normal[touching])
        coincide = np.abs(alike) > 1.0 - TOUCHING
        kept = ~coincide | ((alike > 0.0) & (number < other))
        outside[touching] &= kept
    return outside
