# SPDX-License-Identifier: BSD-3-Clause
"""Conditions on the nodes of a grid line or plane, on a part of it, or on one node."""

from __future__ import annotations

import numpy as np

from tilth.boundaries.protocol import Flags, Prescribed
from tilth.grid import ActiveGrid
from tilth.model import Model, NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES

TOLERANCE = 1e-6
"""A node belongs to a place or range within this share of a cell."""


class Nodal:
    """Holds components of the displacement on grid nodes, by elimination."""

    def __init__(self, declared: PlaneBoundary | NodeBoundary, model: Model) -> None:
        self.name = declared.name
        self._declared = declared
        self._model = model
        self._held = declared.held(model.dimension)

    def nodes(self, active: ActiveGrid) -> Flags:
        """Returns which active nodes the boundary holds, shape (nodes,)."""
        declared = self._declared
        tolerance = TOLERANCE * active.grid.cell_size
        if isinstance(declared, NodeBoundary):
            distance = np.abs(active.position - np.asarray(declared.at))
            return np.asarray((distance <= tolerance).all(axis=1))
        axis = AXES.index(declared.axis)
        chosen = np.abs(active.position[:, axis] - declared.at) <= tolerance[axis]
        for name, (low, high) in (declared.range or {}).items():
            k = AXES.index(name)
            along = active.position[:, k]
            chosen &= (along >= low - tolerance[k]) & (along <= high + tolerance[k])
        return np.asarray(chosen)

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the held components with the change of their table from `before` to `after`."""
        held = np.zeros((active.nodes, active.grid.dim), dtype=bool)
        increment = np.zeros(held.shape)
        nodes = self.nodes(active)
        model, declared = self._model, self._declared
        change = model.factor(declared, after) - model.factor(declared, before)
        for component, value in self._held.items():
            held[nodes, component] = True
            increment[nodes, component] = value * change
        return Prescribed(held, increment)
