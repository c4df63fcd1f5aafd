# SPDX-License-Identifier: BSD-3-Clause
"""Elevation of a surface: that from which depths are measured, or a horizon between layers."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.fields.grid_file import read_grid
from tilth.fields.tables import interpolate
from tilth.model.variation import GridFile, Level


def elevation(level: Level, position: Floats, key: str) -> Floats:
    """Returns the elevation of a surface above or below positions (n, dim) [length], shape (n,).

    key: of the surface in the case file, for messages.

    Raises:
        BadInput: a position beside a polyline or a grid.
    """
    dim = position.shape[1]
    if isinstance(level, GridFile):
        grid = read_grid(level.file, dim - 1, f"{key}.file")
        return grid.at(position, f"{key}.file", level.file)
    if not isinstance(level, tuple):
        return np.full(len(position), float(level))  # type: ignore[arg-type]
    return interpolate(level, position[:, 0], position, "x", key)
