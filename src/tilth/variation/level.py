# SPDX-License-Identifier: BSD-3-Clause
"""Elevation of a surface: that from which depths are measured, or a horizon between layers."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.variation import GridFile, Level, at_survey_points
from tilth.variation.grid_file import RegularGrid
from tilth.variation.heights import read_heights
from tilth.variation.survey import Survey, read_survey
from tilth.variation.tables import interpolate, place_text


def elevation(level: Level, position: Floats, key: str) -> Floats:
    """Returns the elevation of a surface above or below positions (n, dim) [length], shape (n,).

    key: of the surface in the case file, for messages.

    Raises:
        BadInput: a position beside a polyline, a grid or the survey points.
    """
    dim = position.shape[1]
    if isinstance(level, GridFile):
        height = read_file(level, dim - 1, key).at(position, f"{key}.file", level.file)
        if len(missing := np.flatnonzero(np.isnan(height))):
            raise BadInput(
                f"the grid has no height at or next to {place_text(position[missing[0], :-1])} "
                f"({len(missing)} of {len(height)} places)",
                "fill the gaps of the grid, or keep the soil away from them",
                key=f"{key}.file",
                value=level.file,
            )
        return height
    if not isinstance(level, tuple):
        return np.full(len(position), float(level))  # type: ignore[arg-type]
    return interpolate(level, position[:, 0], position, "x", key)


def read_file(level: GridFile, axes: int, key: str) -> RegularGrid | Survey:
    """Returns the heights of a file.

    axes: number of horizontal axes. key: of the level in the case file, for messages.

    Raises:
        BadInput: the file cannot be read, or its heights are not at such places.
    """
    read = read_survey if at_survey_points(level) else read_heights
    return read(level.file, axes, f"{key}.file")


def nodes(level: Level, axes: int, axis: int, key: str) -> Floats:
    """Returns the coordinates between which a surface is linear along an axis [length], shape (n,).

    None of survey points, which have no lines.

    axes: number of horizontal axes. axis: number of the axis. key: as in `elevation`.

    Raises:
        BadInput: as `elevation`.
    """
    if isinstance(level, GridFile) and not at_survey_points(level):
        grid = read_heights(level.file, axes, f"{key}.file")
        return grid.lines[grid.axes.index(axis)] if axis in grid.axes else np.zeros(0)
    if isinstance(level, tuple):
        return np.array([x for x, _ in level], dtype=np.float64)
    return np.zeros(0)
