# SPDX-License-Identifier: BSD-3-Clause
"""Size of a declared body in points and cells, from its shape alone: no points are made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.discretise import requested
from tilth.bodies.forms import Form, form_of
from tilth.bodies.inside import inside_of
from tilth.bodies.lattice import full_lattice
from tilth.bodies.mesh import Elements, measured_blocks
from tilth.bodies.request import Request
from tilth.bodies.tiling import spacing_of
from tilth.model import Body, Box, Circle

if TYPE_CHECKING:
    from tilth.grid.background import Grid

SAMPLES = 48
"""Places along each axis of a graded grid at which a shape is sampled."""

ALIGNMENT_TOLERANCE = 1e-6
"""Sides within this fraction of a cell of a grid line lie on it."""


@dataclass(frozen=True)
class BodySize:
    """Size of a body before its points are made.

    Attributes:
        points: number of its material points, to a few per cent.
        cells: number of grid cells that it touches, to a few per cent if it is convex.
        lower, upper: lattice indices of the first cell and one past the last, shape (dim,).
    """

    points: float
    cells: float
    lower: Floats
    upper: Floats


def body_size(body: Body, kind: str, grid: Grid) -> BodySize:
    """Returns the size of a body; files are read, other shapes take no time.

    kind: plane_strain, axisymmetric or 3d.

    Raises:
        BadInput: a mesh that cannot be used, or so many points that it can only be an error.
    """
    request = requested(body, kind, grid)
    if request.points is None:
        request.check_spacing(request.cell_size / request.requested_spacing())
    shape = form_of(body.shape, request)
    if isinstance(shape, Elements):
        points, cells, lower, upper = _of_mesh(shape, request)
    else:
        lower, upper = (np.array(corner, dtype=float) for corner in shape.bounds())
        measure: float = shape.measure()
        if isinstance(shape, Circle) and request.axisymmetric and lower[0] < 0.0:
            lower[0], measure = 0.0, measure - 0.5 * shape.whole()  # centred on the axis
        cells = _cells(shape, measure, lower, upper, grid)
        points = _points(body, request, measure, cells)
    request.check_number(points)
    below, above = grid.in_cells(lower), grid.in_cells(upper)
    first = np.floor(below + ALIGNMENT_TOLERANCE)
    end = np.ceil(above - ALIGNMENT_TOLERANCE)
    if isinstance(shape, Box) and not shape.angle:
        return BodySize(points, float(np.prod(end - first)), first, end)
    cells = _touched(cells, above - below)
    return BodySize(points, min(cells, float(np.prod(end - first))), first, end)


def _cells(shape: Form, measure: float, lower: Floats, upper: Floats, grid: Grid) -> float:
    """Returns the area or volume of a shape, not a mesh, in cells; within bounds (dim,)."""
    if not grid.graded:
        return measure / float(np.prod(grid.cell_size))
    ends = zip(grid.in_cells(lower), grid.in_cells(upper), strict=True)
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    cells = full_lattice([low + share * (high - low) for low, high in ends])
    inside = inside_of(shape)(grid.position(cells))
    return float(inside.mean() * np.prod(grid.in_cells(upper) - grid.in_cells(lower)))


def _points(body: Body, request: Request, measure: float, cells: float) -> float:
    """Returns the number of points of a body that is not a mesh; cells: its size in them."""
    share = 1.0  # of a box that is left between its holes
    if isinstance(body.shape, Box):
        share = measure / body.shape.whole()
    if request.points is not None:
        return float(np.prod(request.points)) * share
    if request.points_per_cell is not None and request.grid.graded:
        return max(cells * float(np.prod(request.points_per_cell)), 1.0)
    spacing = request.requested_spacing()
    if isinstance(body.shape, Box):
        side = np.subtract(body.shape.upper, body.shape.lower)
        return float(np.prod(np.maximum(np.rint(side / spacing), 1.0))) * share
    return max(measure / float(np.prod(spacing)), 1.0)


def _of_mesh(shape: Elements, request: Request) -> tuple[float, float, Floats, Floats]:
    """Returns points, area or volume in cells, and bounds of a mesh."""
    blocks, measures = measured_blocks(shape, request)
    points = cells = 0.0
    for block, own in zip(blocks, measures, strict=True):
        pieces = own / spacing_of(block, request).prod(axis=1)
        points += float(np.maximum(np.rint(pieces), 1.0).sum())
        cells += float((own / request.grid.sizes_at(block.corners.mean(axis=1)).prod(axis=1)).sum())
    lower, upper = (np.array(corner) for corner in shape.bounds())
    return points, cells, lower, upper


def _touched(measure: float, sides: Floats) -> float:
    """Returns the number of cells that contain points of a convex body.

    The mean number of cells that it touches, over all its places on the grid, is the measure of
    the Minkowski sum of body and cell. Of those that it only cuts, half count: there are no points
    in the corner of a cell, and plane sides often lie on grid lines. Projections onto a plane are
    those of the bounding box with the same ratio of areas.

    Args:
        measure: area or volume in cells.
        sides: of the bounding box in cells, shape (dim,).
    """
    dim = len(sides)
    box = float(np.prod(sides))
    ratio = min(measure / box, 1.0) ** ((dim - 1) / dim)
    cut = float(sides.sum()) + 1.0
    if dim == 3:
        cut += ratio * sum(math.prod(np.delete(sides, i).tolist()) for i in range(3))
    return measure + 0.5 * cut
