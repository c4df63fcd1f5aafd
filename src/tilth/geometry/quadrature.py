# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points of a boundary: facets cut at the grid's lines, Gauss points, projection."""

from __future__ import annotations

import math

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.geometry.flat import split_segments
from tilth.geometry.protocol import Geometry, QuadraturePoints

SEGMENT = (0.5 * (1.0 + np.array([-math.sqrt(0.6), 0.0, math.sqrt(0.6)])), np.array([5, 8, 5]) / 18)
"""Gauss's three points on [0, 1], exact to degree 5: place and weight."""

SEGMENT_START = np.cumsum(SEGMENT[1]) - SEGMENT[1]
"""Where the parts of a segment begin that the points stand for."""

TRIANGLE = (np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6.0, np.full(3, 1.0 / 3.0))
"""Three points in a triangle, exact to degree 2: area coordinates and weight."""

LEAST = 1e-12
"""Pieces smaller than this, relative to a cell, are round-off of the cutting."""


def make_quadrature(
    geometry: Geometry,
    lower: Floats,
    upper: Floats,
    origin: Floats,
    cell_size: Floats,
    size: float,
    facet_size: float | None = None,
) -> QuadraturePoints:
    """Returns the quadrature points of a boundary; those of a patch depend on the patch alone.

    Args:
        lower, upper: box in which a boundary without end is needed [length], shape (dim,).
        origin, cell_size: the grid whose lines cut the boundary [length], shape (dim,).
        size: largest length of a piece [length]; in 3D about that of a facet that is not cut.
        facet_size: length of the facets [length]; `size` if not given.
    """
    facets = geometry.facets(lower, upper, facet_size or size)
    piece, facet = _core.cut_simplices(facets.corner, origin, cell_size)
    piece, facet = np.asarray(piece), np.asarray(facet)
    if geometry.dim == 2:
        piece, facet = _along(facets.corner, piece, facet)
        piece, part = split_segments(piece[:, 0], piece[:, 1], size)
        facet = facet[part]
        area = np.linalg.norm(piece[:, 1] - piece[:, 0], axis=1)
        share, weight = np.stack([1.0 - SEGMENT[0], SEGMENT[0]], axis=1), SEGMENT[1]
    else:
        cross = np.cross(piece[:, 1] - piece[:, 0], piece[:, 2] - piece[:, 0])
        area = 0.5 * np.linalg.norm(cross, axis=1)
        share, weight = TRIANGLE
    kept = area > LEAST * float(cell_size.min()) ** (geometry.dim - 1)
    piece, facet, area = piece[kept], facet[kept], area[kept]
    number: Integers = np.repeat(facet, len(weight))
    normal = facets.normal[number]
    place = np.einsum("qc,nci->nqi", share, piece).reshape(-1, geometry.dim)
    parts = _parts(piece)
    parts[:, 0] -= place
    position, ratio = geometry.project(place, normal)
    return QuadraturePoints(
        position=np.ascontiguousarray(position),
        weight=(area[:, None] * weight).ravel() * ratio,
        normal=normal if geometry.flat else geometry.gradient(position),
        patch=facets.patch[number],
        part=parts,
    )


def _parts(piece: Floats) -> Floats:
    """Returns the parts of segments or triangles that the points stand for, (n, dim, dim)."""
    if piece.shape[1] == 2:
        edge = piece[:, 1] - piece[:, 0]
        corner = piece[:, :1] + SEGMENT_START[:, None] * edge[:, None]
        edges = SEGMENT[1][:, None] * edge[:, None]
        return np.stack([corner, edges], axis=2).reshape(-1, 2, 2)
    after, before = np.roll(piece, -1, axis=1), np.roll(piece, 1, axis=1)
    return np.stack([piece, 0.5 * (after - piece), 0.5 * (before - piece)], axis=2).reshape(
        -1, 3, 3
    )


def _along(corner: Floats, piece: Floats, facet: Integers) -> tuple[Floats, Integers]:
    """Sorts pieces (m, 2, 2) of segments (n, 2, 2) by segment, then from its start to its end.

    The cutting goes with the grid's axes, which need not be the way the segment goes.
    """
    start, end = corner[facet, 0], corner[facet, 1]
    covered = ((piece[:, 0] - start) * (end - start)).sum(axis=1)
    order = np.lexsort((covered, facet))
    return piece[order], facet[order]
