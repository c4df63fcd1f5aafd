# SPDX-License-Identifier: BSD-3-Clause
"""Where the soil's face ends along a surface: there it has patches of its own.

The resultant of tractions that are constant on patches cannot come nearer to the end of the face
than the middle of the last patch: a block of two cells tipped under 0.71 of the force that tips
it. A narrow strip along the end that is a patch of its own lets the resultant come there
(docs/decisions/0046-ends-of-the-face.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.law import first_slip
from tilth.boundaries.surfaces.measure import Measured, SurfaceParts
from tilth.boundaries.surfaces.patches import LEAST_COSINE
from tilth.boundaries.surfaces.points import PointsNearSoil

if TYPE_CHECKING:
    from tilth.boundaries.contact.constraint import ContactConstraint

STRIP = 0.06
"""Greatest distance in cells from the end of the soil's face to the middle of a part in the strip.
It is less than the width of a part, so that the strip has one part or two."""

AROUND, LEAST_RATIO = 2.0, 1.5
"""Distance in cells within which contact has a mean pressure, and the pressure at the end over it
from which on the strip is a patch of its own [-]. Where the pressure is uniform there is none: in
so narrow a strip it would be inexact by some percent."""

HELD = 0.5
"""Distance in cells from a condition that holds the soil within which its face has no end."""


def at_soil_end(parts: SurfaceParts, measured: Measured, chosen: Integers, cell: float) -> Flags:
    """Returns which of the chosen points are in the strip along an end of the soil's face, (k,).

    None in space, where parts are wider than the strip.

    chosen: numbers of points opposite soil. cell: the smallest edge of a cell [length].
    """
    share = measured.share
    if parts.position.shape[1] == 3 or len(chosen) == 0 or (share == 1.0).all():
        return np.zeros(len(chosen), dtype=bool)
    partly = np.flatnonzero((share > 0.0) & (share < 1.0))
    without = np.flatnonzero(share == 0.0)
    width = np.linalg.norm(parts.tributary[:, 1], axis=1)
    length = np.linalg.norm(measured.shift[partly], axis=1)
    inward = measured.shift[partly] / np.where(length > 0.0, length, 1.0)[:, None]
    middle = parts.position + measured.shift
    within = 0.5 * share * width  # from the middle of a share to the end
    end = middle[partly] - within[partly, None] * inward
    distance = np.where(share[chosen] < 1.0, within[chosen], np.inf)
    for place, normal, nearer in (
        (end, parts.normal[partly], np.zeros(len(partly))),
        (parts.position[without], parts.normal[without], 0.5 * width[without]),
    ):
        distance = np.minimum(
            distance, _nearest(place, normal, nearer, middle[chosen], parts.normal[chosen])
        )
    return np.asarray(distance <= STRIP * cell)


def _nearest(
    place: Floats, normal: Floats, nearer: Floats, position: Floats, own: Floats
) -> Floats:
    """Returns the distances of positions (k, dim) from the nearest place with a similar normal.

    nearer: by how much each place, shape (m,), counts as nearer [length].
    """
    from scipy.spatial import cKDTree

    if len(place) == 0:
        return np.full(len(position), np.inf)
    distance, found = cKDTree(place).query(position)
    alike = np.einsum("ki,ki->k", normal[found], own) >= LEAST_COSINE
    return np.where(alike, distance - nearer[found], np.inf)


def at_free_end(
    part: ContactConstraint, held: Sequence[PointsNearSoil], constrained: Flags
) -> Flags:
    """Returns which points of the strip have a patch of their own, shape (n,).

    None where conditions hold the soil: at a wall, or in a plane of symmetry, the face goes on as
    by a reflection. Nor where the soil slides, so that other points come to the end in each step,
    nor where the pressure is not greatest at the end: the resultant is not near it.

    held: boundaries that hold soil. constrained: prescribed components of nodes, (nodes, dim).
    """
    from scipy.spatial import cKDTree

    if not part.at_end.any():
        return part.at_end
    found = part.at_end & _presses(part)
    along = 1.0 - part.pose.normal**2
    nodes = np.asarray(constrained[part.at.node].any(axis=1))[part.at.cell]
    found[(nodes * along).max(axis=1) >= 0.5] = False
    for other in held:
        near = np.flatnonzero(found)
        distance = cKDTree(other.pose.position).query(part.pose.position[near])[0]
        found[near[distance <= HELD * float(part.at.size.min())]] = False
    return found


def _presses(part: ContactConstraint) -> Flags:
    """Returns which points did not slide in the last step, and pressed more than those around."""
    from scipy.spatial import cKDTree

    normal, traction, position = part.pose.normal, part.before, part.pose.position
    pressed = np.einsum("ni,ni->n", normal, traction)
    shear = np.linalg.norm(traction - pressed[:, None] * normal, axis=1)
    law = part.law.under(part.pore_pressure)
    slides = first_slip(law, np.stack([pressed, shear], axis=1)).any(axis=1)
    found = np.zeros(len(pressed), dtype=bool)
    reach = AROUND * float(part.at.size.min())
    tree = cKDTree(position)
    for point in np.flatnonzero(part.at_end & ~slides & (pressed < 0.0)):
        near = np.array(tree.query_ball_point(position[point], reach))
        near = near[normal[near] @ normal[point] >= LEAST_COSINE]
        area = part.area[near]
        found[point] = -pressed[point] * area.sum() >= LEAST_RATIO * (-pressed[near] @ area)
    return found
