# SPDX-License-Identifier: BSD-3-Clause
"""How deep a rigid body or boundary is embedded, below the original or the current surface."""

from __future__ import annotations

import math

import numpy as np

from tilth.analysis.rigid_shapes import placed, rigid_shapes
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult
from tilth.arrays import Flags, Floats
from tilth.geometry.round import Circle, Sphere
from tilth.model import Model, Track
from tilth.mpm.domains import upper_edges
from tilth.mpm.points import MaterialPoints

_EDGE = 1e-9
"""Width by which the column of a point is larger than its domain, over the domain."""


class Embedment:
    """The depth of the lowest point of a rigid body or of a bounded implicit boundary.

    The original surface is the top of the domains of the undeformed soil of the first stage in the
    vertical through the lowest point. The current one is the highest top of the domains of the
    points now over the body, or beside it within half its width.

    Args:
        track: the tracked quantity.
        model: the whole model.
        initial: the undeformed points of all its bodies.
    """

    def __init__(self, track: Track, model: Model, initial: MaterialPoints) -> None:
        self._name = track.boundary or ""
        self._original = track.from_ == "original"
        self._axisymmetric = model.analysis.kind == "axisymmetric"
        self._facet = 0.5 * float(min(model.cell_size))
        self._shape = rigid_shapes(model, initial).get(self._name)
        first = model.of_stages[0]
        there = np.array([first.present(body.name) for body in model.bodies])[initial.body_id]
        half = initial.initial_half_length[there]
        self._column = initial.position[there, :-1], half[:, :-1]
        self._height = initial.position[there, -1] + half[:, -1]

    def depth(self, setup: Setup, state: State, result: StepResult | None) -> float:
        """Returns the depth [length] after a step; NaN where there is no soil or no boundary.

        All processes call it.
        """
        if self._shape is not None:
            if all(body.name != self._name for body in setup.model.rigid_bodies):
                return math.nan
            motion = placed(state, self._name)
            lowest, place = self._shape.lowest(*motion), self._shape.at(*motion).position
        else:
            found = self._of_boundary(state, result)
            if found is None:
                return math.nan
            lowest, place = found
        if self._original:
            centre, half = self._column
            return _above(self._height, _within(centre, half, lowest[:-1])) - float(lowest[-1])
        low, high = place[:, :-1].min(axis=0), place[:, :-1].max(axis=0)
        if self._axisymmetric:
            low = -high
        beside = 0.5 * (high - low)
        points = state.points
        across = points.position[:, :-1]
        near = ((across >= low - beside) & (across <= high + beside)).all(axis=1)
        tops = upper_edges(points)[:, -1]
        highest = state.comm.max(float(tops.max(initial=-math.inf, where=near)))
        return (highest if math.isfinite(highest) else math.nan) - float(lowest[-1])

    def _of_boundary(self, state: State, result: StepResult | None) -> tuple[Floats, Floats] | None:
        """Returns lowest point and vertices of an implicit boundary; None if it does not act."""
        boundary = next((b for b in state.implicit if b.name == self._name), None)
        if boundary is None:
            return None
        geometry = boundary.geometry
        columns, most = state.points.position.T, state.comm.max
        low = np.array([-most(-float(x.min(initial=np.inf))) for x in columns])
        high = np.array([most(float(x.max(initial=-np.inf))) for x in columns])
        factor = boundary.factor(0.0 if result is None else result.time)
        facets = geometry.facets(low, high, self._facet)
        place = boundary.motion.position(facets.corner.reshape(-1, geometry.dim), factor)
        lowest = place[np.argmin(place[:, -1])]
        if isinstance(geometry, Circle | Sphere) and boundary.declared.motion is None:
            lowest = boundary.motion.position(geometry.centre[None, :], factor)[0]
            lowest[-1] -= boundary.declared.radius(factor)
        return lowest, place


def _within(centre: Floats, half: Floats, place: Floats) -> Flags:
    return np.asarray((np.abs(centre - place) <= (1.0 + _EDGE) * half).all(axis=1))


def _above(height: Floats, chosen: Flags) -> float:
    return float(height[chosen].max()) if chosen.any() else math.nan
