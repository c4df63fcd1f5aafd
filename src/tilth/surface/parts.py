# SPDX-License-Identifier: BSD-3-Clause
"""Parts of tracked surfaces that a case file declares: those with loads, and those with flow."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.comm import together
from tilth.errors import StepFailed
from tilth.model import Model, SurfaceFlowBoundary, SurfaceLoad
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.quadrature import PointsInCells, locate_in_cells, near_process, near_soil

LAYERS = 2
"""Layers of cells around a process' own from where surfaces act on its nodes.

A place in a cell without soil belongs to the nearest one with soil."""

DeclaredPart = SurfaceLoad | SurfaceFlowBoundary


def load_key(number: int) -> str:
    """Returns where a load stands in the case file, by its index among all loads."""
    return f"loads[{number}]"


def declared_parts(model: Model, body: str) -> dict[str, DeclaredPart]:
    """Returns the parts of the surface of a body, of all stages, by their keys in the case file."""
    of_loads = {load_key(i): load for i, load in enumerate(model.loads)}
    keys = model.flow_boundary_keys()
    of_flow = {keys[each.name]: each for each in model.all_flow_boundaries()}
    return {
        key: each
        for key, each in (of_loads | of_flow).items()
        if isinstance(each, DeclaredPart) and each.body == body
    }


def locate_part(active: ActiveGrid, body: str, position: Floats) -> tuple[Integers, PointsInCells]:
    """Returns the rows of the points that act on nodes of this process, and these in their cells.

    All processes call it.

    position: of all points of a part [length], shape (n, dim).

    Raises:
        StepFailed: a point is more than a cell away from the soil.
    """
    overlay = active.points.overlay_of_body(body)
    with together(active.comm):
        mine = position[near_process(active, position)]
        if not near_soil(active, mine, overlay).all():
            raise StepFailed(f"a part of the surface of {body!r} left the soil")
    near = np.flatnonzero(near_process(active, position, LAYERS))
    order, at = locate_in_cells(active, position[near], overlay)
    return near[order], at
