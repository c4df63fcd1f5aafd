# SPDX-License-Identifier: BSD-3-Clause
"""Material points of a polygon."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.bodies.lattice import anchored_axes, cut_lattice
from tilth.bodies.request import BodyPoints, Request
from tilth.model import Polygon

# Sub-cell centres within this fraction of a sub-cell of the outline are inside, on all sides.
OUTLINE_TOLERANCE = 1e-6


def polygon_points(shape: Polygon, request: Request) -> BodyPoints:
    """Returns the points of a simple polygon of either orientation.

    They are the centres of the grid's sub-cells that lie inside or on its outline. Raises BadInput
    if there are none, or if the polygon crosses the axis of symmetry.
    """
    vertices = np.asarray(shape.vertices, dtype=float)
    request.check_radius(vertices[:, 0].min(), "its outline")
    area, centroid = area_and_centroid(vertices)
    volume = area * (2.0 * math.pi * centroid[0] if request.axisymmetric else 1.0)
    axes, sizes = anchored_axes(request, vertices.min(axis=0), vertices.max(axis=0))
    margin = OUTLINE_TOLERANCE * float(request.requested_spacing().min())
    return cut_lattice(request, axes, sizes, inside_polygon(vertices, axes, margin), volume)


def area_and_centroid(vertices: Floats) -> tuple[float, Floats]:
    """Returns area (> 0 for either orientation) and centroid (2,) of a polygon (m, 2)."""
    start = vertices - vertices[0]
    end = np.roll(start, -1, axis=0)
    cross = start[:, 0] * end[:, 1] - end[:, 0] * start[:, 1]
    double_area = math.fsum(cross)
    moment = ((start + end) * cross[:, None]).sum(axis=0)
    return 0.5 * abs(double_area), vertices[0] + moment / (3.0 * double_area)


def inside_polygon(vertices: Floats, axes: list[Floats], margin: float) -> npt.NDArray[np.bool_]:
    """Returns which lattice points are inside the polygon or within `margin` of it, (ny, nx).

    Each row is intersected with the outline a margin above and a margin below, and the intervals
    between entry and exit are extended by the margin. So points on the outline are inside on every
    side of the body, and a symmetric outline gives symmetric points.
    """
    x, y = axes
    return _rows_inside(vertices, x, y - margin, margin) | _rows_inside(
        vertices, x, y + margin, margin
    )


def _rows_inside(vertices: Floats, x: Floats, y: Floats, margin: float) -> npt.NDArray[np.bool_]:
    """Returns which points x of rows at y are inside the polygon, shape (ny, nx)."""
    start, end = vertices, np.roll(vertices, -1, axis=0)
    straddles = (start[:, 1] <= y[:, None]) != (end[:, 1] <= y[:, None])
    row, edge = np.nonzero(straddles)
    run = (end - start)[edge]
    crossing = start[edge, 0] + (y[row] - start[edge, 1]) * run[:, 0] / run[:, 1]
    # A closed outline crosses every row an even number of times: sorted, they alternate.
    order = np.lexsort((crossing, row))
    row, entry, leave = row[order][::2], crossing[order][::2], crossing[order][1::2]
    jump = np.zeros((len(y), len(x) + 1), dtype=np.int32)
    np.add.at(jump, (row, np.searchsorted(x, entry - margin, side="left")), 1)
    np.add.at(jump, (row, np.searchsorted(x, leave + margin, side="right")), -1)
    inside: npt.NDArray[np.bool_] = np.cumsum(jump[:, :-1], axis=1) > 0
    return inside
