# SPDX-License-Identifier: BSD-3-Clause
"""The faces of cells with wet soil that lie on a grid line or plane."""

from __future__ import annotations

import math

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.boundaries.nodal import POSITION_TOLERANCE
from tilth.grid.keys import lattice_keys, places_of_keys
from tilth.model import PlaneFlowBoundary
from tilth.model.fields import AXES
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pore_water import POROSITY
from tilth.mpm.quadrature import points_in_cells
from tilth.terms.surface_flow import FlowSurface

GAUSS = 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0)
"""Points of equal weight on [0, 1], exact to degree 3: shape functions times the radius."""


def wet_cells(active: ActiveGrid) -> Integers:
    """Returns the sorted keys of the cells with centres of points that have water in their pores.

    Of all points that the process knows, so that the cells around its nodes are among them.
    """
    points = active.points
    wet = np.flatnonzero(points.water[:, POROSITY] > 0.0)
    cell = np.floor(active.grid.in_cells(points.position[wet])).astype(np.int64)
    return np.unique(lattice_keys(cell, points.overlays_of(wet)))


def faces_on_plane(
    declared: PlaneFlowBoundary, active: ActiveGrid, axisymmetric: bool
) -> FlowSurface:
    """Returns quadrature points of the faces on a plane that have wet soil beside them.

    A face between two such cells has points in both. The range of the plane cuts faces.
    """
    grid, dim, axis = active.grid, active.grid.dim, AXES.index(declared.axis)
    key = np.intersect1d(wet_cells(active), active.cell_keys)
    cell = places_of_keys(key, active.overlays)[0][:, :dim]
    lower, size = grid.position(cell.astype(float)), grid.sizes(cell)
    others = [k for k in range(dim) if k != axis]
    start, end = np.zeros(lower.shape), np.ones(lower.shape)
    for name, (low, high) in (declared.range or {}).items():
        k = AXES.index(name)
        start[:, k], end[:, k] = (
            np.clip((each - lower[:, k]) / size[:, k], 0.0, 1.0) for each in (low, high)
        )
    area = ((end - start) * size)[:, others].prod(axis=1)
    choice = GAUSS[np.array(list(np.ndindex(*(2,) * len(others))))]
    faces: list[tuple[Integers, Floats, Floats]] = []
    for side in (0.0, 1.0):
        away = lower[:, axis] + side * size[:, axis] - declared.at
        on = np.flatnonzero((np.abs(away) <= POSITION_TOLERANCE * size[:, axis]) & (area > 0.0))
        local = np.full((len(on), len(choice), dim), side)
        for j, k in enumerate(others):
            local[:, :, k] = start[on, None, k] + (end - start)[on, None, k] * choice[:, j]
        normal = np.zeros(local.shape)
        normal[:, :, axis] = 2.0 * side - 1.0
        faces.append((np.repeat(on, len(choice)), local.reshape(-1, dim), normal.reshape(-1, dim)))
    which, local, normal = (np.concatenate(each) for each in zip(*faces, strict=True))
    order = np.argsort(which, kind="stable")
    which, local = which[order], local[order]
    position = lower[which] + local * size[which]
    weight = area[which] / len(choice)
    if axisymmetric:
        weight = weight * 2.0 * np.pi * position[:, 0]
    return FlowSurface(points_in_cells(active, key[which], local), normal[order], weight, position)
