# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a box, along the grid axes or rotated."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.lattice import full_lattice
from tilth.bodies.request import BodyPoints, Request
from tilth.model import Box

# A side lies on a line of sub-cells within this fraction of the sub-cell.
ALIGNMENT_TOLERANCE = 1e-9


def box_points(shape: Box, request: Request) -> BodyPoints:
    """Returns the points of a box, one at the centre of each of equal sub-boxes, x fastest.

    The number along each side is `points`, or the side over the requested spacing, rounded to an
    integer of at least 1; the sub-boxes fill the box exactly. With `points_per_cell` and sides on
    the grid lines each sub-box is a sub-cell of the grid. A rotated box and its domains are divided
    along its own axes: half lengths along these axes, directions in `frame`.
    """
    lower, upper = np.asarray(shape.lower, dtype=float), np.asarray(shape.upper, dtype=float)
    side = upper - lower
    number = _number(side, request)
    request.check_spacing(number / np.maximum(side / request.cell_size, 1.0))
    request.check_number(float(np.prod(number)))
    request.check_radius(shape.bounds()[0][0], "its corner")
    axes = [(np.arange(n) + 0.5) * (length / n) for n, length in zip(number, side, strict=True)]
    if shape.angle:
        frame = np.array(shape.axes).T
        position = full_lattice(axes) @ frame.T + lower
    else:
        frame = None
        own = [corner + axis for corner, axis in zip(lower, axes, strict=True)]
        position = full_lattice(_on_grid(own, lower, upper, request))
    volume = request.circumference(position) * float(np.prod(side / number))
    half_length = np.empty_like(position)
    half_length[:] = 0.5 * side / number
    return BodyPoints(position, volume, half_length, frame)


def _number(side: Floats, request: Request) -> Floats:
    """Returns the number of points along each side, as floats, shape (d,)."""
    if request.points is not None:
        return request.points
    return np.maximum(np.rint(side / request.requested_spacing()), 1.0)


def _on_grid(axes: list[Floats], lower: Floats, upper: Floats, request: Request) -> list[Floats]:
    """Returns the axes; where both ends lie on lines of sub-cells, counted from the grid's origin.

    This only removes round-off: cells far from the box's corner get the same lattice.
    """
    if request.points_per_cell is None:
        return axes
    spacing = request.requested_spacing()
    ends = (np.stack([lower, upper]) - request.grid_origin) / spacing
    aligned = np.all(np.abs(ends - np.rint(ends)) < ALIGNMENT_TOLERANCE, axis=0)
    first = np.rint(ends[0])
    return [
        request.grid_origin[i] + spacing[i] * (first[i] + 0.5 + np.arange(len(axis)))
        if aligned[i]
        else axis
        for i, axis in enumerate(axes)
    ]
