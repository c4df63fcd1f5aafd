# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points of a boundary, from facets that are cut at the grid lines."""

from __future__ import annotations

import math

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.geometry.flat import split_segments
from tilth.geometry.protocol import Geometry, QuadraturePoints
from tilth.grid.background import Grid

SEGMENT_RULE = (
    0.5 * (1.0 + np.array([-math.sqrt(0.6), 0.0, math.sqrt(0.6)])),
    np.array([5, 8, 5]) / 18,
)
"""Gauss rule of three points on [0, 1], exact to degree 5: coordinates and weights."""

SEGMENT_PART_START = np.cumsum(SEGMENT_RULE[1]) - SEGMENT_RULE[1]
"""Coordinates in [0, 1] where the tributary parts of a segment begin."""

TRIANGLE_RULE = (np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0, np.full(3, 1.0 / 3.0))
"""Rule of three points in a triangle, exact to degree 2: area coordinates and weights."""

PIECE_AREA_TOLERANCE = 1e-12
"""Pieces with an area below this fraction of a cell's are round-off and dropped."""


def make_quadrature(
    geometry: Geometry,
    lower: Floats,
    upper: Floats,
    grid: Grid,
    size: float,
    facet_size: float | None = None,
    local: bool = False,
) -> QuadraturePoints:
    """Returns the quadrature points of a boundary; those of a facet group do not depend on others.

    Args:
        lower, upper: box in which an unbounded geometry is discretised [length], shape (dim,).
        grid: at whose lines facets are cut.
        size: largest length of a piece [length]; in 3D the approximate size of an uncut facet.
        facet_size: length of the facets [length]; `size` if not given.
        local: whether pieces in larger cells may be longer, by the ratio of the cells' smallest
            edges to that of the smallest cell.
    """
    facets = geometry.facets(lower, upper, facet_size or size)
    piece, facet = _core.cut_simplices(facets.corner, grid)
    piece, facet = np.asarray(piece), np.asarray(facet)
    if geometry.dim == 2:
        piece, facet = _sorted_along(facets.corner, piece, facet)
        longest = _size_in_cells(piece, grid, size) if local and grid.graded else size
        piece, part = split_segments(piece[:, 0], piece[:, 1], longest)
        facet = facet[part]
        area = np.linalg.norm(piece[:, 1] - piece[:, 0], axis=1)
        shape, weight = np.stack([1.0 - SEGMENT_RULE[0], SEGMENT_RULE[0]], axis=1), SEGMENT_RULE[1]
    else:
        cross = np.cross(piece[:, 1] - piece[:, 0], piece[:, 2] - piece[:, 0])
        area = 0.5 * np.linalg.norm(cross, axis=1)
        shape, weight = TRIANGLE_RULE
    kept = area > PIECE_AREA_TOLERANCE * float(grid.cell_size.min()) ** (geometry.dim - 1)
    piece, facet, area = piece[kept], facet[kept], area[kept]
    number: Integers = np.repeat(facet, len(weight))
    normal = facets.normal[number]
    point = np.einsum("qc,nci->nqi", shape, piece).reshape(-1, geometry.dim)
    tributary = _tributary_parts(piece)
    tributary[:, 0] -= point
    position, ratio = geometry.project(point, normal)
    return QuadraturePoints(
        position=np.ascontiguousarray(position),
        weight=(area[:, None] * weight).ravel() * ratio,
        normal=normal if geometry.flat else geometry.gradient(position),
        group=facets.group[number],
        tributary=tributary,
    )


def _size_in_cells(piece: Floats, grid: Grid, size: float) -> Floats:
    """Returns the largest length of pieces (n, 2, 2) in their cells [length], shape (n,)."""
    smallest_edge = grid.sizes_at(piece.mean(axis=1)).min(axis=1)
    return np.asarray(size * smallest_edge / grid.cell_size.min())


def _tributary_parts(piece: Floats) -> Floats:
    """Returns corner and edges of the points' tributary parts, shape (points, dim, dim)."""
    if piece.shape[1] == 2:
        edge = piece[:, 1] - piece[:, 0]
        corner = piece[:, :1] + SEGMENT_PART_START[:, None] * edge[:, None]
        edges = SEGMENT_RULE[1][:, None] * edge[:, None]
        return np.stack([corner, edges], axis=2).reshape(-1, 2, 2)
    after, before = np.roll(piece, -1, axis=1), np.roll(piece, 1, axis=1)
    return np.stack([piece, 0.5 * (after - piece), 0.5 * (before - piece)], axis=2).reshape(
        -1, 3, 3
    )


def _sorted_along(corner: Floats, piece: Floats, facet: Integers) -> tuple[Floats, Integers]:
    """Returns pieces (m, 2, 2) of segments (n, 2, 2) sorted by segment, then along it.

    The pieces are cut in the direction of the grid's axes, which may be opposite to the segment's.
    """
    start, end = corner[facet, 0], corner[facet, 1]
    distance = ((piece[:, 0] - start) * (end - start)).sum(axis=1)
    order = np.lexsort((distance, facet))
    return piece[order], facet[order]
