# SPDX-License-Identifier: BSD-3-Clause
"""Flow boundaries in the picture of a set-up."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.analysis.state import State
from tilth.arrays import Floats
from tilth.geometry.make import make_shape
from tilth.model import ImplicitFlowBoundary, Model, PlaneFlowBoundary
from tilth.model.fields import AXES
from tilth.mpm.active_grid import ActiveGrid
from tilth.report.setup_data import Condition

SAME_PLACE = 1e-6
"""Distance, in cells, up to which a node lies on a plane or in a range."""


def flow_conditions(model: Model, state: State, active: ActiveGrid) -> Iterator[Condition]:
    """Yields the flow boundaries of a stage, with places on them near the soil.

    Those on tracked surfaces have no places of their own.
    """
    if model.flow is None or not model.water_flows:
        return
    keys = model.flow_boundary_keys()
    for each in model.flow.boundaries:
        place = np.zeros((0, model.dimension))
        if isinstance(each, PlaneFlowBoundary):
            place = _on_plane(each, active)
        elif isinstance(each, ImplicitFlowBoundary):
            place = _on_geometry(each, model, f"{keys[each.name]}.geometry", state)
        nothing = np.zeros(place.shape, dtype=bool)
        yield Condition(each.name, each.condition, place, nothing)


def _on_plane(declared: PlaneFlowBoundary, active: ActiveGrid) -> Floats:
    """Returns the nodes on a plane, shape (k, dim)."""
    position, near = active.position, SAME_PLACE * active.grid.largest_size
    ranges = {declared.axis: (declared.at, declared.at), **(declared.range or {})}
    chosen = np.ones(len(position), dtype=bool)
    for axis, (low, high) in ranges.items():
        k = AXES.index(axis)
        chosen &= (position[:, k] >= low - near[k]) & (position[:, k] <= high + near[k])
    return position[chosen]


def _on_geometry(declared: ImplicitFlowBoundary, model: Model, key: str, state: State) -> Floats:
    """Returns the middles of a geometry's facets within half a cell of the soil, (k, dim)."""
    points, grid = state.points, state.grid
    lower = (points.position - points.half_length).min(axis=0)
    upper = (points.position + points.half_length).max(axis=0)
    lower, upper = lower - 0.5 * grid.sizes_at(lower), upper + 0.5 * grid.sizes_at(upper)
    facets = make_shape(declared.geometry, model, key).facets(
        lower, upper, float(grid.cell_size.max())
    )
    middle = facets.corner.mean(axis=1)
    return np.asarray(middle[((middle >= lower) & (middle <= upper)).all(axis=1)])
