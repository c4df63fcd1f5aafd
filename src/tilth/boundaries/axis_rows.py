# SPDX-License-Identifier: BSD-3-Clause
"""Where soil reaches the axis of symmetry: on which rows of nodes.

A point stands for a ring. With its half width L along the radius at the start, when it stood at R,
the ring's inner edge was at R - L; now that it stands at r and is stretched by F_rr, it is at

    a^2 = r^2 - F_rr (r / R) [R^2 - (R - L)^2],

for F_rr r / R is the ratio of areas across the axis. (The half width F_rr L would do for rings far
away only: of a hole that closes, the last ring is far wider inside than outside of its point.)
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.model import Model
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints

GAP = 0.05
"""Radius of a hole, in cells, up to which it counts as none."""

OVERLAP = 1e-6
"""Part of a cell along the axis, in cells, that a point's domain must reach into to count."""


class AxisRows:
    """Finds the rows of nodes of cells in which soil reaches the axis.

    Args:
        model: the declared problem, axisymmetric.
        initial: its points at time 0, in the order of their permanent numbers.
    """

    def __init__(self, model: Model, initial: MaterialPoints) -> None:
        self._at_start = _beside_the_axis(model, initial)

    def find(self, active: ActiveGrid) -> tuple[Integers, Floats]:
        """Returns the rows' lattice places along y, ascending, and the soil's Young's modulus.

        Of several soils the stiffest [stress]; shape (n,) each.
        """
        points, grid = active.points, active.grid
        number = np.flatnonzero(self._reaching(points, grid.cell_size[0]))
        height = (points.position[number, 1] - grid.origin[1]) / grid.cell_size[1]
        reach = points.half_length[number, 1] / grid.cell_size[1]
        low = np.floor(height - reach + OVERLAP).astype(np.int64)
        high = np.ceil(height + reach - OVERLAP).astype(np.int64)
        many = high - low + 1
        first = np.cumsum(many) - many
        row, where = np.unique(
            np.repeat(low - first, many) + np.arange(many.sum()), return_inverse=True
        )
        modulus = np.zeros(len(row))
        np.maximum.at(modulus, where, points.elastic_moduli().young[np.repeat(number, many)])
        return row, modulus

    def _reaching(self, points: MaterialPoints, cell_width: float) -> Flags:
        """Returns which points' soil reaches the axis, shape (n,).

        Those whose ring has no hole. What stood at the axis at the start leaves it only where
        something comes between: of that a ring may also be as far off as it is wide, since rings
        do not fit together where the stretch varies.
        """
        radius = points.position[:, 0]
        half = np.abs(points.deformation_gradient[:, 0, 0]) * points.initial_half_length[:, 0]
        start = radius - points.displacement[:, 0]
        hole = radius * (radius - half * (2.0 - points.initial_half_length[:, 0] / start))
        own = self._at_start[points.point_id] & (radius <= 2.0 * half)
        return np.asarray(own | (hole <= (GAP * cell_width) ** 2))


def _beside_the_axis(model: Model, initial: MaterialPoints) -> Flags:
    """Returns which points stand beside the axis at time 0, in bodies that reach it, shape (n,).

    Lattices that are counted from the grid's origin end up to half a spacing before the axis, and
    the squares that stand for the pieces of a mesh anywhere near it.
    """
    beside = initial.position[:, 0] <= (2.0 + OVERLAP) * initial.initial_half_length[:, 0]
    for body, declared in zip(initial.bodies, model.bodies, strict=True):
        bounds = declared.shape.bounds()
        if bounds is not None and bounds[0][0] > GAP * model.cell_size[0]:
            beside[body.start : body.stop] = False
    return np.asarray(beside)
