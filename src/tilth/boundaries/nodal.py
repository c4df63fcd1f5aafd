# SPDX-License-Identifier: BSD-3-Clause
"""Conditions on the nodes of a grid line or plane, on a part of it, or on one node.

The domain of a GIMP point beside a constrained plane may reach beyond it and bring nodes to life
that hold next to no material. Were they free, the point would slip past the condition. So where no
point has its centre beyond the plane, the nodes there move with the plane.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Flags
from tilth.boundaries.protocol import Prescribed
from tilth.model import NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.model.load_curve import LoadCurve
from tilth.mpm.grid import ActiveGrid

TOLERANCE = 1e-6
"""A node belongs to a place or range within this share of a cell."""


class Nodal:
    """Holds components of the displacement on grid nodes, by elimination."""

    def __init__(self, declared: PlaneBoundary | NodeBoundary, dim: int, curve: LoadCurve) -> None:
        self.name = declared.name
        self._declared = declared
        self._curve = curve
        self._held = declared.prescribed(dim)

    def nodes(self, active: ActiveGrid) -> Flags:
        """Returns which active nodes the boundary holds, shape (nodes,)."""
        declared = self._declared
        if isinstance(declared, NodeBoundary):
            tolerance = TOLERANCE * active.grid.cell_size
            distance = np.abs(active.position - np.asarray(declared.at))
            return np.asarray((distance <= tolerance).all(axis=1))
        on_plane = self._on_plane(declared, active)
        return on_plane | self._beyond(declared, active, on_plane)

    @staticmethod
    def _on_plane(declared: PlaneBoundary, active: ActiveGrid) -> Flags:
        tolerance = TOLERANCE * active.grid.cell_size
        axis = AXES.index(declared.axis)
        chosen = np.abs(active.position[:, axis] - declared.at) <= tolerance[axis]
        for name, (low, high) in (declared.range or {}).items():
            k = AXES.index(name)
            along = active.position[:, k]
            chosen &= (along >= low - tolerance[k]) & (along <= high + tolerance[k])
        return np.asarray(chosen)

    @staticmethod
    def _beyond(declared: PlaneBoundary, active: ActiveGrid, on_plane: Flags) -> Flags:
        """Returns the nodes one cell beyond the plane with no point's centre in between.

        Beyond is the side away from the material: on the other side nodes are active, too.
        """
        beyond = np.zeros(active.nodes, dtype=bool)
        axis = AXES.index(declared.axis)
        other_axes = [k for k in range(active.grid.dim) if k != axis]
        for side in (-1, 1):
            step = np.zeros(3, dtype=np.int64)
            step[axis] = side
            foot = active.lattice[on_plane]
            node = active.find(foot + step)
            between = (node >= 0) & (active.find(foot - step) >= 0)
            foot, node = foot[between], node[between]
            if len(node) == 0:
                continue
            filled = np.zeros(len(node), dtype=bool)
            for shift in np.ndindex(*(4,) * len(other_axes)):
                cell = foot.copy()
                cell[:, axis] += min(side, 0)
                cell[:, other_axes] += 1 - np.array(shift)  # -2 to 1: a sliver beside soil is free
                filled |= np.isin(_core.node_keys(cell), active.occupied)
            beyond[node[~filled]] = True
        return beyond

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the constrained components and their increments from `before` to `after`."""
        constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        increment = np.zeros(constrained.shape)
        nodes = self.nodes(active)
        change = self._curve.factor(after) - self._curve.factor(before)
        for component, value in self._held.items():
            constrained[nodes, component] = True
            increment[nodes, component] = value * change
        return Prescribed(constrained, increment)
