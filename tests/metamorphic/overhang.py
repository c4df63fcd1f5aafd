# SPDX-License-Identifier: BSD-3-Clause
"""How far soil reaches into cells that it hardly touches."""

from __future__ import annotations

from itertools import product

import numpy as np

from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.bodies.corners import corner_signs

ROUND_OFF = 1e-9
"""Distance from a line, in cells, at which soil ends on it."""


def overhang(simulation: Simulation) -> float:
    """The least of the greatest values of the nodes' hats on soil, in cells, times a cell [length].

    At the corners of the points' domains, with linear functions at the points.
    """
    grid = simulation.state.grid
    cells = grid.in_cells(_places(simulation))
    low = np.floor(cells)
    share = cells - low
    keys, values = [], []
    for side in product((0, 1), repeat=grid.dim):
        value = np.where(np.array(side) == 1, share, 1.0 - share).prod(axis=1)
        keys.append((low + side)[value > ROUND_OFF])
        values.append(value[value > ROUND_OFF])
    node, number = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    greatest = np.zeros(len(node))
    np.maximum.at(greatest, number.ravel(), np.concatenate(values))
    return float(greatest.min() * np.min(grid.cell_size))


def _places(simulation: Simulation) -> Floats:
    points, dim, found = simulation.state.points, simulation.state.grid.dim, []
    signs = corner_signs(dim)
    for range_ in points.ranges:
        own = slice(range_.start, range_.stop)
        position = points.position[own, None, :]
        if simulation.setup.model.bodies[0].basis == "linear":
            found.append(position)
        elif range_.has_corners:
            found.append(position + points.corner[own])
        else:
            found.append(position + signs * points.half_length[own, None, :])
    return np.concatenate([each.reshape(-1, dim) for each in found])


def on_lines(simulation: Simulation) -> bool:
    """Whether the places of points with linear functions are on lines of the grid."""
    cells = simulation.state.grid.in_cells(simulation.state.points.position)
    linear = simulation.setup.model.bodies[0].basis == "linear"
    return linear and bool((np.abs(cells - np.round(cells)) < ROUND_OFF).any())
