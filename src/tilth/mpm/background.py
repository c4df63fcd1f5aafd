# SPDX-License-Identifier: BSD-3-Clause
"""The background grid that a model declares."""

from __future__ import annotations

import numpy as np

from tilth.model import Model
from tilth.mpm.grid import Grid


def background_grid(model: Model) -> Grid:
    """Returns the grid of a model at the start; `analysis/grid_motion.py` has it over time."""
    limits, lines = model.grid.limits, model.lines
    return Grid(
        origin=np.array(model.origin, dtype=float),
        cell_size=np.array(model.cell_size, dtype=float),
        lower=None if limits is None else np.array(limits.lower, dtype=float),
        upper=None if limits is None else np.array(limits.upper, dtype=float),
        lines=lines if any(len(line) for line in lines) else (),
    )


def largest_face(grid: Grid) -> float:
    """Returns the area of the largest face of a cell, per unit thickness in 2D a length."""
    size = grid.largest_size
    return float(np.prod(size) / size.max())
