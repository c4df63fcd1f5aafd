# SPDX-License-Identifier: BSD-3-Clause
"""Regular lattices of points along the coordinate axes, and the part inside a shape."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.request import BodyPoints, Request

Scalar = TypeVar("Scalar", np.float64, np.bool_)


def anchored_axes(request: Request, lower: Floats, upper: Floats) -> list[Floats]:
    """Returns the centres, per direction, of the sub-cells between `lower` and `upper` (d,).

    The sub-cells have the requested spacing and are counted from the grid's origin, so that with
    `points_per_cell` every cell contains the same whole number of them.
    """
    spacing = request.requested_spacing()
    first = np.floor((lower - request.grid_origin) / spacing)
    last = np.ceil((upper - request.grid_origin) / spacing)
    request.check_number(float(np.prod(last - first)))
    return [
        request.grid_origin[i] + spacing[i] * (np.arange(first[i], last[i]) + 0.5)
        for i in range(len(spacing))
    ]


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
    request: Request, axes: Sequence[Floats], inside: npt.NDArray[np.bool_], volume: float
) -> BodyPoints:
    """Returns the sub-cells of a lattice whose centre is `inside` as the points of a body.

    inside: shape (nz, ny, nx) or (ny, nx).
    volume: the body's exact volume. Every sub-cell's own volume is multiplied by one common
        factor so that they sum to it; the domains have the sub-cell's size.
    Points are ordered x fastest, then y, then z. Raises BadInput if none is inside.
    """
    dimension = len(axes)
    index = np.nonzero(inside)
    position = np.empty((len(index[0]), dimension))
    for i, axis in enumerate(axes):
        position[:, i] = axis[index[dimension - 1 - i]]
    if len(position) == 0:
        raise request.refused(
            "no material point falls inside it",
            "use more points per cell, a smaller spacing or a finer grid",
            request.resolution,
        )
    weight = request.circumference(position)
    half_length = np.empty_like(position)
    half_length[:] = 0.5 * request.requested_spacing()
    return BodyPoints(position, weight * (volume / weight.sum()), half_length)
