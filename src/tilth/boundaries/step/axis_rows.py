# SPDX-License-Identifier: BSD-3-Clause
"""The rows of nodes on which soil extends to the axis of symmetry.

A material point represents a ring. At time 0, with the point at R and the half width L along the
radius, the ring's inner edge is at R - L. With the point at r and the stretch F_rr it is at

    a^2 = r^2 - F_rr (r / R) [R^2 - (R - L)^2],

since F_rr r / R is the ratio of the areas normal to the axis. (The half width F_rr L is accurate
far from the axis only: in a closing hole the last ring is much wider on the inner side of its
point than on the outer side.)

The ring in front of a cone's tip has no hole, and never gets one; yet the cone pushes it aside.
So a row is left out where the axis is behind a boundary and the ring in front of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints

if TYPE_CHECKING:
    from tilth.boundaries.surfaces.boundary import Implicit

HOLE_RADIUS_TOLERANCE = 0.05
"""Radius of a ring's hole, in cells, up to which the soil extends to the axis."""

OVERLAP_TOLERANCE = 1e-6
"""Least overlap of a point's domain with a cell along the axis, in cells."""

LARGEST_DEPTH = 0.5
"""Depth of a point behind a boundary, in cells, up to which it counts as in front of it."""

ON_BOUNDARY_TOLERANCE = 1e-6
"""Distance from a boundary, in cells, up to which a node on the axis lies on it."""

_ROW_BITS = 32


class AxisRows:
    """Finds the rows of nodes of the cells in which soil extends to the axis.

    Args:
        model: the declared problem, axisymmetric.
        initial: its points at time 0, in the order of their permanent numbers.
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._next_to_axis = _initially_next_to_axis(model, initial)
        self._initial_radius = initial.position[:, 0].copy()

    def find(
        self, active: ActiveGrid, boundaries: Sequence[Implicit] = (), time: float = 0.0
    ) -> tuple[Integers, Integers, Floats]:
        """Returns the rows' lattice coordinates along y, overlays, and the soil's Young's modulus.

        boundaries: those that can be between soil and axis, at `time`.

        Overlay after overlay, in each of which the rows ascend. The largest modulus where soils of
        one overlay meet [stress]; shape (n,) each.
        """
        points, grid = active.points, active.grid
        number = np.flatnonzero(self._at_axis(points, _width_at_axis(grid)))
        position, half = points.position[number], points.half_length[number]
        lower, upper = (grid.in_cells(end)[:, 1] for end in (position - half, position + half))
        low = np.floor(lower + OVERLAP_TOLERANCE).astype(np.int64)
        high = np.ceil(upper - OVERLAP_TOLERANCE).astype(np.int64)
        count = high - low + 1
        first = np.cumsum(count) - count
        every = np.repeat(low - first, count) + np.arange(count.sum())
        kept = ~_behind_boundaries(
            np.repeat(position, count, axis=0), every, grid, boundaries, time
        )
        number, every = np.repeat(number, count)[kept], every[kept]
        overlay = np.broadcast_to(points.overlays_of(number), len(number))
        code, index = np.unique((overlay << _ROW_BITS) + every, return_inverse=True)
        overlays = (code + (1 << (_ROW_BITS - 1))) >> _ROW_BITS
        row = code - (overlays << _ROW_BITS)
        modulus = np.zeros(len(row))
        np.maximum.at(modulus, index, points.elastic_moduli().young[number])
        return row, overlays, modulus

    def _at_axis(self, points: MaterialPoints, cell_width: float) -> Flags:
        """Returns which points' soil extends to the axis, shape (n,).

        These are the points whose ring has no hole. A point that was next to the axis at time 0
        may also be as far from it as its ring is wide, since rings do not fit together exactly
        where the stretch varies.
        """
        radius = points.position[:, 0]
        half = np.abs(points.deformation_gradient[:, 0, 0]) * points.initial_half_length[:, 0]
        start = self._initial_radius[points.point_id]
        hole = radius * (radius - half * (2.0 - points.initial_half_length[:, 0] / start))
        initially = self._next_to_axis[points.point_id] & (radius <= 2.0 * half)
        return np.asarray(initially | (hole <= (HOLE_RADIUS_TOLERANCE * cell_width) ** 2))


def _width_at_axis(grid: Grid) -> float:
    """Returns the width of the cells on the positive side of the axis [length]."""
    return float(grid.sizes_at(np.zeros(2))[0])


def _behind_boundaries(
    position: Floats, row: Integers, grid: Grid, boundaries: Sequence[Implicit], time: float
) -> Flags:
    """Returns in which pairs of a ring and a row the axis is behind a boundary, shape (n,).

    That is from the row of nodes below to the one above, while the ring is in front of it.

    Args:
        position: of the rings [length], shape (n, 2).
        row: lattice coordinates along y, shape (n,).
    """
    behind = np.zeros(len(row), dtype=bool)
    if len(row) == 0:
        return behind
    width = _width_at_axis(grid)
    rows = (row[:, None] + np.array([-1.0, 0.0, 1.0])).ravel()
    on_axis = grid.position(np.stack([np.zeros(len(rows)), rows], axis=1))
    on_axis[:, 0] = 0.0
    for boundary in boundaries:
        axis = boundary.distance(on_axis, time).reshape(-1, 3).max(axis=1)
        in_front = boundary.distance(position, time) > -LARGEST_DEPTH * width
        behind |= in_front & (axis <= ON_BOUNDARY_TOLERANCE * width)
    return behind


def _initially_next_to_axis(model: Model, initial: MaterialPoints) -> Flags:
    """Returns which points are next to the axis at time 0, in bodies that extend to it, shape (n,).

    A lattice of points counted from the grid's origin may end half a spacing from the axis. The
    squares that represent the pieces of a mesh may end anywhere near it.
    """
    half = initial.initial_half_length[:, 0]
    at_axis = initial.position[:, 0] <= (2.0 + OVERLAP_TOLERANCE) * half
    for body, own in initial.whole_bodies():
        bounds = model.bodies[body.body].shape.bounds()
        if bounds is not None and bounds[0][0] > HOLE_RADIUS_TOLERANCE * model.cell_size[0]:
            at_axis[own] = False
    return np.asarray(at_axis)
