# SPDX-License-Identifier: BSD-3-Clause
"""How points of a tracked surface move with the grid, and which of them are away from the soil."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.comm import from_owners, together
from tilth.errors import StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.quadrature import locate_in_cells, near_process, near_soil


def moved_with_grid(
    active: ActiveGrid, position: Floats, displacement: Floats, name: str
) -> Floats:
    """Returns positions (n, dim) after the grid's displacement; in empty cells it is extrapolated.

    Each process moves those in its cells; all have the result.

    Args:
        active: the grid of the step.
        position: [length], shape (n, dim).
        displacement: of the nodes [length], shape (nodes, dim).
        name: name of the body, for messages.

    Raises:
        StepFailed: a point is more than a cell away from the soil.
    """
    overlay = active.points.overlay_of_body(name)
    mine = near_process(active, position)
    moved = position[mine]
    with together(active.comm):
        if not near_soil(active, moved, overlay).all():
            raise StepFailed(f"a boundary point of {name!r} left the soil")
    order, at = locate_in_cells(active, moved, overlay)
    moved[order] += at.interpolate(displacement)
    return from_owners(active.comm, mine, moved)


def points_near_soil(active: ActiveGrid, position: Floats, name: str) -> Flags:
    """Returns which positions (n, dim) of all processes are near the soil of a body, shape (n,)."""
    mine = near_process(active, position)
    with together(active.comm):
        near = near_soil(active, position[mine], active.points.overlay_of_body(name))
    return np.asarray(from_owners(active.comm, mine, near.astype(np.float64)) > 0.0)


def lost_points(name: str, remedy: str) -> str:
    """Returns the warning of boundary points that are away from the soil."""
    return (
        f"boundary points of {name!r} are more than a cell away from its soil, as on soil that "
        f"crumbles; its surface, on which no load acts, {remedy}"
    )
