# SPDX-License-Identifier: BSD-3-Clause
"""Conditions on the nodes of a grid line or plane, on a part of it, or on one node.

The domain of a GIMP point next to a constrained plane may extend beyond it and activate nodes with
hardly any material. If these were free, the point could move through the plane. So where no point
has its centre beyond the plane, the nodes beyond it are constrained to move with the plane. Where
the user says that one side is solid, they are in any case: soil that is thrown against the plane
may be pressed into it by a part of its domain.
"""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Integers
from tilth.boundaries.protocol import Prescribed
from tilth.grid.keys import lattice_keys
from tilth.model import NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid

POSITION_TOLERANCE = 1e-6
"""Distance, in cells, up to which a node lies at a position or in a range."""


class Nodal:
    """Prescribes components of the displacement of grid nodes, by elimination."""

    def __init__(self, declared: PlaneBoundary | NodeBoundary, dim: int, curve: LoadCurve) -> None:
        self.name = declared.name
        self._declared = declared
        self._curve = curve
        self._prescribed = declared.prescribed(dim)

    def nodes(self, active: ActiveGrid) -> Flags:
        """Returns which active nodes the boundary constrains, shape (nodes,)."""
        declared = self._declared
        if isinstance(declared, NodeBoundary):
            tolerance = POSITION_TOLERANCE * active.grid.largest_size
            distance = np.abs(active.position - np.asarray(declared.at))
            return np.asarray((distance <= tolerance).all(axis=1))
        on_plane = self.on_plane(active)
        if declared.solid_side is not None:
            return on_plane
        return on_plane | self._beyond(declared, active, on_plane)

    def on_plane(self, active: ActiveGrid) -> Flags:
        """Returns which active nodes are on the plane, or behind it on its solid side, (nodes,)."""
        declared = self._declared
        assert isinstance(declared, PlaneBoundary)
        tolerance = POSITION_TOLERANCE * active.grid.largest_size
        axis = AXES.index(declared.axis)
        distance = active.position[:, axis] - declared.at
        if declared.solid_side == "lower":
            distance = np.maximum(distance, 0.0)
        elif declared.solid_side == "upper":
            distance = np.minimum(distance, 0.0)
        chosen = np.abs(distance) <= tolerance[axis]
        for name, (low, high) in (declared.range or {}).items():
            k = AXES.index(name)
            along = active.position[:, k]
            chosen &= (along >= low - tolerance[k]) & (along <= high + tolerance[k])
        return np.asarray(chosen)

    def _occupied(self, active: ActiveGrid) -> Integers:
        """Returns the sorted keys of the cells with soil on which the condition acts."""
        return active.occupied

    def _beyond(self, declared: PlaneBoundary, active: ActiveGrid, on_plane: Flags) -> Flags:
        """Returns the nodes one cell beyond the plane without a point's centre in between.

        Beyond the plane is the side away from the material, where the nodes on the other side of
        the plane are active, too.
        """
        beyond = np.zeros(active.nodes, dtype=bool)
        axis = AXES.index(declared.axis)
        other_axes = [k for k in range(active.grid.dim) if k != axis]
        for side in (-1, 1):
            step = np.zeros(3, dtype=np.int64)
            step[axis] = side
            foot, overlay = active.lattice[on_plane], active.overlay[on_plane]
            node = active.find(foot + step, overlay)
            on_both_sides = (node >= 0) & (active.find(foot - step, overlay) >= 0)
            foot, node, overlay = foot[on_both_sides], node[on_both_sides], overlay[on_both_sides]
            if len(node) == 0:
                continue
            filled = np.zeros(len(node), dtype=bool)
            for shift in np.ndindex(*(4,) * len(other_axes)):
                cell = foot.copy()
                cell[:, axis] += min(side, 0)
                cell[:, other_axes] += 1 - np.array(shift)  # -2 to 1: nodes near soil stay free
                filled |= np.isin(lattice_keys(cell, overlay), self._occupied(active))
            beyond[node[~filled]] = True
        return beyond

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the constrained components and their increments from `before` to `after`."""
        constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        increment = np.zeros(constrained.shape)
        nodes = self.nodes(active)
        factor = self._curve.factor(after) - self._curve.factor(before)
        for component, value in self._prescribed.items():
            constrained[nodes, component] = True
            increment[nodes, component] = value * factor
        return Prescribed(constrained, increment)

    def distance_from(self, active: ActiveGrid) -> float:
        """As `Boundary.distance_from`."""
        declared, dim = self._declared, active.grid.dim
        if isinstance(declared, NodeBoundary):
            lower = upper = np.asarray(declared.at, dtype=float)
        else:
            lower, upper = np.full(dim, -np.inf), np.full(dim, np.inf)
            for name, (low, high) in (declared.range or {}).items():
                lower[AXES.index(name)], upper[AXES.index(name)] = low, high
            lower[AXES.index(declared.axis)] = upper[AXES.index(declared.axis)] = declared.at
        beyond = np.maximum(np.maximum(lower - active.position, active.position - upper), 0.0)
        return float(np.linalg.norm(beyond, axis=1).min())
