# SPDX-License-Identifier: BSD-3-Clause
"""Whether what the user's boundaries prescribe leaves the soil on the axis of symmetry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.boundaries.agreement import TOLERANCE
from tilth.boundaries.axis import Axis, leaves_the_axis
from tilth.boundaries.protocol import Boundary
from tilth.boundaries.together import Conditions
from tilth.mpm.grid import ActiveGrid

if TYPE_CHECKING:
    from tilth.boundaries.implicit.boundary import Implicit

BISECTIONS = 60
"""Halvings of the distance between two rows of nodes in which a boundary crosses the axis."""


def require_on_axis(
    axis: Axis,
    boundaries: list[Boundary],
    implicit: list[Implicit],
    active: ActiveGrid,
    times: list[float],
) -> None:
    """Checks the boundaries where they are at the start, with their motions of several times.

    boundaries: those that act by elimination. times: see `turning_times`.

    Raises:
        BadInput: names a boundary that prescribes a radial displacement on the axis.
    """
    row, height = axis.heights(active)
    if len(row) == 0:
        return
    meeting = [_meets_axis(boundary, height, np.diff(row) == 1) for boundary in implicit]
    for time in times:
        axis.hold(active, Conditions.gather(boundaries, active, 0.0, time))
        for boundary, place in zip(implicit, meeting, strict=True):
            if len(place):
                _require_no_radial_motion(boundary, place, time)


def _meets_axis(boundary: Implicit, height: Floats, following: Flags) -> Floats:
    """Returns where a boundary at rest meets the axis beside soil [length], shape (n, 2).

    Rows of nodes, at `height` (m,), that lie on it, and its crossings between two rows that are
    next to each other, `following` (m - 1,).
    """

    def distance(y: Floats) -> Floats:
        return boundary.distance(np.column_stack([np.zeros(len(y)), y]), 0.0)

    found = distance(height)
    crossed = np.flatnonzero(following & (found[:-1] * found[1:] < 0.0))
    low, high, sign = height[crossed], height[crossed + 1], np.sign(found[crossed])
    for _ in range(BISECTIONS if len(crossed) else 0):
        middle = 0.5 * (low + high)
        before = distance(middle) * sign > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    candidates = np.unique(np.concatenate([height, low]))
    met = candidates[np.abs(distance(candidates)) <= boundary.delta]
    return np.column_stack([np.zeros(len(met)), met])


def _require_no_radial_motion(boundary: Implicit, place: Floats, time: float) -> None:
    """Looks for an axial displacement that is what the boundary wants at its places (n, 2)."""
    wanted = boundary.motion.place(place, boundary.factor(time)) - place
    projector = boundary.projector_at(place)
    wanted = np.einsum("nij,nj->ni", projector, wanted)
    axial = projector[:, :, 1]
    share = (wanted * axial).sum(axis=1) / np.maximum((axial**2).sum(axis=1), 1e-300)
    rest = np.abs(wanted - share[:, None] * axial).max(axis=1)
    worst = int(rest.argmax())
    if rest[worst] > TOLERANCE * float(np.abs(wanted).max()):
        raise leaves_the_axis(boundary.name, boundary.key, float(place[worst, 1]))
