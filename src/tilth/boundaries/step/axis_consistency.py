# SPDX-License-Identifier: BSD-3-Clause
"""Check that no boundary prescribes a radial displacement on the axis of symmetry."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.boundaries.protocol import Boundary
from tilth.boundaries.step.axis import Axis, radial_motion_error
from tilth.boundaries.step.conditions import Conditions
from tilth.boundaries.step.consistency import DISPLACEMENT_TOLERANCE
from tilth.mpm.active_grid import ActiveGrid

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

BISECTIONS = 60
"""Number of bisections between two rows of nodes to find where a boundary crosses the axis."""


def require_no_radial_motion(
    axis: Axis,
    boundaries: list[Boundary],
    implicit: list[Implicit],
    active: ActiveGrid,
    times: list[float],
) -> None:
    """Checks the boundaries at their initial positions, with their motions up to several times.

    boundaries: those that act by elimination. times: see `table_times`.

    Raises:
        BadInput: a boundary prescribes a radial displacement on the axis.
    """
    row, height = axis.heights(active)
    if len(row) == 0:
        return
    intersections = [_on_axis(boundary, height, np.diff(row) == 1) for boundary in implicit]
    for time in times:
        axis.constrain(active, Conditions.gather(boundaries, active, 0.0, time))
        for boundary, position in zip(implicit, intersections, strict=True):
            if len(position):
                _refuse_radial_motion(boundary, position, time)


def _on_axis(boundary: Implicit, height: Floats, adjacent: Flags) -> Floats:
    """Returns the points of a boundary's reference position on the axis [length], shape (n, 2).

    These are the rows of nodes, at `height` (m,), that lie on the boundary, and its intersections
    with the axis between `adjacent` rows (m - 1,).
    """

    def distance(y: Floats) -> Floats:
        return boundary.distance(np.column_stack([np.zeros(len(y)), y]), 0.0)

    found = distance(height)
    crossed = np.flatnonzero(adjacent & (found[:-1] * found[1:] < 0.0))
    low, high, sign = height[crossed], height[crossed + 1], np.sign(found[crossed])
    for _ in range(BISECTIONS if len(crossed) else 0):
        middle = 0.5 * (low + high)
        before = distance(middle) * sign > 0.0
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    candidates = np.unique(np.concatenate([height, low]))
    on_boundary = candidates[np.abs(distance(candidates)) <= boundary.delta]
    return np.column_stack([np.zeros(len(on_boundary)), on_boundary])


def _refuse_radial_motion(boundary: Implicit, position: Floats, time: float) -> None:
    """Refuses a condition that no axial displacement satisfies at some position (n, 2).

    By the residual of the least-squares axial displacement.
    """
    increment = boundary.motion.position(position, boundary.factor(time)) - position
    projector = boundary.projector_at(position)
    prescribed = np.einsum("nij,nj->ni", projector, increment)
    axial = projector[:, :, 1]
    factor = (prescribed * axial).sum(axis=1) / np.maximum((axial**2).sum(axis=1), 1e-300)
    residual = np.abs(prescribed - factor[:, None] * axial).max(axis=1)
    worst = int(residual.argmax())
    if residual[worst] > DISPLACEMENT_TOLERANCE * float(np.abs(prescribed).max()):
        raise radial_motion_error(boundary.name, boundary.key, float(position[worst, 1]))
