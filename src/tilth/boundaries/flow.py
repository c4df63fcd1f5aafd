# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries at which the excess pore pressure or the flux of water is given."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.boundaries.nodal import Nodal
from tilth.model import Model, PlaneBoundary, PlaneFlowBoundary
from tilth.model.load_curve import LoadCurve
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.pore_water import WaterInStep
from tilth.terms.protocol import Term

UNSCALED = ((0.0, 1.0),)
"""Table of a flow boundary without one."""


class FlowBoundaries:
    """The flow boundaries that act in a stage of a model.

    Where two planes meet, the later one counts.

    Args:
        model: with flowing water.
    """

    def __init__(self, model: Model) -> None:
        assert model.flow is not None
        self._planes = [
            _OnPlane(each, model.dimension)
            for each in model.flow.boundaries
            if isinstance(each, PlaneFlowBoundary)
        ]

    def on_nodes(self, active: ActiveGrid, time: float) -> tuple[Flags, Floats]:
        """Returns which nodes have a given pressure at a time, and this, shape (nodes, 1) each."""
        held, value = np.zeros((active.nodes, 1), dtype=bool), np.zeros((active.nodes, 1))
        for plane in self._planes:
            nodes = plane.nodes.nodes(active)
            held[nodes], value[nodes] = True, plane.value(time)
        return active.updated(held), active.updated(value)

    def terms(self, water: WaterInStep, before: float, after: float) -> Sequence[Term]:
        """Returns the terms of the boundaries that are not on nodes."""
        return []


class _OnPlane:
    """A pressure on the nodes of a plane.

    Attributes:
        nodes: tells which they are.
    """

    def __init__(self, declared: PlaneFlowBoundary, dim: int) -> None:
        self._declared = declared
        self._curve = LoadCurve(declared.factor or UNSCALED)
        plane = PlaneBoundary(
            name=declared.name, axis=declared.axis, at=declared.at, range=declared.range,
            condition="fixed",
        )  # fmt: skip
        self.nodes = Nodal(plane, dim, self._curve)

    def value(self, time: float) -> float:
        """Returns the excess pore pressure at a time [stress]."""
        return self._declared.value * self._curve.factor(time)
