# SPDX-License-Identifier: BSD-3-Clause
"""Regular lattices of points along the coordinate axes, and the part inside a shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tilth import grid_lines
from tilth.arrays import Floats
from tilth.bodies.request import BodyPoints, Request

Scalar = TypeVar("Scalar", np.float64, np.bool_)


def anchored_axes(
    request: Request, lower: Floats, upper: Floats
) -> tuple[list[Floats], list[Floats]]:
    """Returns centres and sizes, per direction, of the sub-cells between `lower` and `upper` (d,).

    The sub-cells have the requested spacing and are counted from the grid's origin, so that with
    `points_per_cell` every cell contains the same whole number of them.
    """
    grid, spacing = request.grid, request.requested_spacing()
    first = np.floor((lower - grid.origin) / spacing)
    last = np.ceil((upper - grid.origin) / spacing)
    for i, per_cell in request.per_graded_cell.items():
        ends = np.array([lower[i], upper[i]]) - grid.origin[i]
        below, above = per_cell * grid_lines.in_cells(ends, grid.lines[i])
        first[i], last[i] = np.floor(below), np.ceil(above)
    request.check_number(float(np.prod(last - first)))
    number = [np.arange(low, high) for low, high in zip(first, last, strict=True)]
    centres = [grid.origin[i] + spacing[i] * (own + 0.5) for i, own in enumerate(number)]
    sizes = [np.full(len(own), size) for own, size in zip(number, spacing, strict=True)]
    for i, per_cell in request.per_graded_cell.items():
        cells = (number[i] + 0.5) / per_cell
        centres[i] = grid.origin[i] + grid_lines.distance(cells, grid.lines[i])
        cell = np.floor(cells).astype(np.int64)
        sizes[i] = grid_lines.size(cell, grid.lines[i]) / per_cell
    return centres, sizes


def spread(axis: npt.NDArray[Scalar], direction: int) -> npt.NDArray[Scalar]:
    """Returns values along one direction, shaped to broadcast over a lattice stored (z, y, x)."""
    return axis.reshape((-1,) + (1,) * direction)


def full_lattice(axes: Sequence[Floats]) -> Floats:
    """Returns all lattice points of the axes' values, shape (n, d), x fastest, then y, then z."""
    position = np.empty((*(len(axis) for axis in reversed(axes)), len(axes)))
    for i, axis in enumerate(axes):
        position[..., i] = spread(axis, i)
    return position.reshape(-1, len(axes))


def cut_lattice(
    request: Request,
    axes: Sequence[Floats],
    sizes: Sequence[Floats],
    inside: npt.NDArray[np.bool_],
    volume: float,
) -> BodyPoints:
    """Returns the sub-cells of a lattice whose centre is `inside` as the points of a body.

    axes, sizes: centres and sizes of the sub-cells along each direction.
    inside: shape (nz, ny, nx) or (ny, nx).
    volume: the body's exact volume. Every sub-cell's own volume is multiplied by one common
        factor so that they sum to it; the domains have the sub-cell's size.
    Points are ordered x fastest, then y, then z. Raises BadInput if none is inside.
    """
    dimension = len(axes)
    index = np.nonzero(inside)
    position = np.empty((len(index[0]), dimension))
    half_length = np.empty_like(position)
    for i, (axis, size) in enumerate(zip(axes, sizes, strict=True)):
        position[:, i] = axis[index[dimension - 1 - i]]
        half_length[:, i] = 0.5 * size[index[dimension - 1 - i]]
    if len(position) == 0:
        raise request.refused(
            "no material point falls inside it",
            "use more points per cell, a smaller spacing or a finer grid",
            request.resolution,
        )
    weight = request.circumference(position)
    for i in request.per_graded_cell:
        weight *= half_length[:, i]
    return BodyPoints(position, weight * (volume / weight.sum()), half_length)
