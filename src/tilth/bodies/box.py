# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a box, along the grid axes or rotated."""

from __future__ import annotations

import numpy as np

from tilth import grid_lines
from tilth.arrays import Floats
from tilth.bodies.lattice import full_lattice
from tilth.bodies.request import ON_LINE, BodyPoints, Request
from tilth.model import Box

# A side lies on a line of sub-cells within this fraction of the sub-cell.
ALIGNMENT_TOLERANCE = 1e-9


def box_points(shape: Box, request: Request) -> BodyPoints:
    """Returns the points of a box, one at the centre of each of equal sub-boxes, x fastest.

    The number along each side is `points`, or the side over the requested spacing, rounded to an
    integer of at least 1; the sub-boxes fill the box exactly. With `points_per_cell` and sides on
    the grid lines each sub-box is a sub-cell of the grid; on a graded grid the sub-boxes follow the
    cells. A rotated box and its domains are divided along its own axes: half lengths along these
    axes, directions in `frame`; on a graded grid its spacing is that of the smallest cells in it.
    """
    lower, upper = np.asarray(shape.lower, dtype=float), np.asarray(shape.upper, dtype=float)
    side, frame = upper - lower, None
    number, edges = _number(shape, side, request), {}
    if not shape.angle:
        edges = {k: _edges(lower[k], upper[k], k, request) for k in request.per_graded_cell}
    for k, lines in edges.items():
        number[k] = len(lines) - 1
    request.check_spacing(number / np.maximum(side / request.cell_size, 1.0))
    request.check_number(float(np.prod(number)))
    request.check_radius(shape.bounds()[0][0], "its corner")
    axes = [(np.arange(n) + 0.5) * (length / n) for n, length in zip(number, side, strict=True)]
    sizes = [np.full(int(n), width) for n, width in zip(number, side / number, strict=True)]
    if shape.angle:
        frame = np.array(shape.axes).T
        position = full_lattice(axes) @ frame.T + lower
    else:
        axes = [corner + axis for corner, axis in zip(lower, axes, strict=True)]
        axes = _on_grid(axes, lower, upper, request)
        for k, lines in edges.items():
            axes[k], sizes[k] = 0.5 * (lines[1:] + lines[:-1]), np.diff(lines)
        position = full_lattice(axes)
    size = full_lattice(sizes)
    volume = request.circumference(position) * np.prod(size, axis=1)
    size *= 0.5
    return BodyPoints(position, volume, size, frame)


def _number(shape: Box, side: Floats, request: Request) -> Floats:
    """Returns the number of equal parts of each side, as floats, shape (d,)."""
    if request.points is not None:
        return request.points.copy()
    lower, upper = (np.array([corner]) for corner in shape.bounds())
    spacing = request.spacing_within(lower, upper)[0]
    return np.asarray(np.maximum(np.rint(side / spacing), 1.0))


def _edges(lower: float, upper: float, k: int, request: Request) -> Floats:
    """Returns the edges of the sub-boxes along a graded axis, which follow the cells, (m + 1,).

    The part of the box in each cell is divided into equal sub-boxes: `points_per_cell` in a whole
    cell, in a part of it as many as is its share, rounded. A part without any, if it is less than
    half a sub-box of the cell beside it, belongs to the sub-boxes of that cell.
    """
    line, origin = request.grid.lines[k], request.grid.origin[k]
    low, high = grid_lines.in_cells(np.array([lower, upper]) - origin, line)
    inner = np.arange(np.floor(low + ON_LINE) + 1.0, np.ceil(high - ON_LINE))
    cells = np.concatenate([[low], inner, [high]])
    place = np.concatenate([[lower], origin + grid_lines.distance(inner, line), [upper]])
    number = np.rint(np.diff(cells) * request.per_graded_cell[k]).astype(np.int64)
    for end, inwards in (0, 1), (-1, -2):
        if number[end] == 0 and len(number) > 1:
            own, beside = np.diff(place)[[end, inwards]]
            if own <= 0.5 * beside / max(number[inwards], 1):
                number, place = np.delete(number, end), np.delete(place, inwards)
    number = np.maximum(number, 1)
    request.check_number(float(number.sum()))
    part = np.repeat(np.arange(len(number)), number)
    share = (np.arange(len(part)) - np.repeat(np.cumsum(number) - number, number)) / number[part]
    return np.append(place[part] + share * np.diff(place)[part], upper)


def _on_grid(axes: list[Floats], lower: Floats, upper: Floats, request: Request) -> list[Floats]:
    """Returns the axes; where both ends lie on lines of sub-cells, counted from the grid's origin.

    This only removes round-off: cells far from the box's corner get the same lattice.
    """
    if request.points_per_cell is None:
        return axes
    spacing, origin = request.requested_spacing(), request.grid.origin
    ends = (np.stack([lower, upper]) - origin) / spacing
    aligned = np.all(np.abs(ends - np.rint(ends)) < ALIGNMENT_TOLERANCE, axis=0)
    first = np.rint(ends[0])
    return [
        origin[i] + spacing[i] * (first[i] + 0.5 + np.arange(len(axis))) if aligned[i] else axis
        for i, axis in enumerate(axes)
    ]
