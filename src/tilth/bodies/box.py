# SPDX-License-Identifier: BSD-3-Clause
"""Points of a box, along the grid axes or turned."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.lattice import full_lattice
from tilth.bodies.request import BodyPoints, Request
from tilth.model import Box

# A side is taken to lie on a line of sub-cells within this fraction of the sub-cell.
ALIGNMENT = 1e-9


def box_points(shape: Box, request: Request) -> BodyPoints:
    """Points of a box: equal sub-boxes, a point at the centre of each, x fastest, then y, then z.

    The number along each side is `points`, or the side over the wanted spacing to the nearest
    whole number, at least 1; the sub-boxes fill the box exactly. With `points_per_cell` and sides
    on the grid lines this is the lattice of the cells themselves. A turned box is divided along
    its own axes, and so are its domains: half lengths along these axes, directions in `frame`.
    """
    lower, upper = np.asarray(shape.lower, dtype=float), np.asarray(shape.upper, dtype=float)
    side = upper - lower
    number = _number(side, request)
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
    """Points along each side, whole numbers as floats, shape (d,)."""
    if request.points is not None:
        return request.points
    return np.maximum(np.rint(side / request.wanted_spacing()), 1.0)


def _on_grid(axes: list[Floats], lower: Floats, upper: Floats, request: Request) -> list[Floats]:
    """The axes, with those whose ends lie on lines of sub-cells counted from the grid's origin.

    This only removes round-off: cells far from the box's corner hold the same lattice.
    """
    if request.points_per_cell is None:
        return axes
    spacing = request.wanted_spacing()
    ends = (np.stack([lower, upper]) - request.grid_origin) / spacing
    aligned = np.all(np.abs(ends - np.rint(ends)) < ALIGNMENT, axis=0)
    first = np.rint(ends[0])
    return [
        request.grid_origin[i] + spacing[i] * (first[i] + 0.5 + np.arange(len(axis)))
        if aligned[i]
        else axis
        for i, axis in enumerate(axes)
    ]
