# SPDX-License-Identifier: BSD-3-Clause
"""Triangulated panels of simple shape, and the closed surface of adjoining panels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.surface.triangles import Triangles

# Vertices of panels nearer than this times the shortest edge are merged.
MERGE_TOLERANCE = 1e-3
# Least number of chords of a quarter of a circle.
MINIMUM_QUARTER_CHORDS = 4


@dataclass(frozen=True)
class Panel:
    """Triangles of a simple shape, such as a rectangle, that belong to one part of a surface.

    Attributes:
        part: name of the part.
        vertices: [length], shape (n, 3).
        triangle: numbers of the vertices, shape (m, 3).
    """

    part: str
    vertices: Floats
    triangle: Integers

    def flipped(self) -> Panel:
        """Returns the same panel with opposite normals."""
        return Panel(self.part, self.vertices, self.triangle[:, ::-1])

    def transformed(self, matrix: npt.ArrayLike, shift: npt.ArrayLike) -> Panel:
        """Returns the panel at matrix @ vertex + shift; a reflection keeps its side of the soil."""
        matrix = np.asarray(matrix, dtype=float)
        moved = Panel(self.part, self.vertices @ matrix.T + shift, self.triangle)
        return moved.flipped() if np.linalg.det(matrix) < 0.0 else moved


def triangulate_rows(part: str, rows: Sequence[Floats]) -> Panel:
    """Returns the panel of triangles between rows of evenly spaced points, (k, 3) each.

    A row may have any number of points, at least one. The normals have the direction of the cross
    product of the direction along a row and that from a row to the next.
    """
    first, triangle = 0, []
    for here, ahead in pairwise(rows):
        triangle.append(_strip(len(here) - 1, len(ahead) - 1) + first)
        first += len(here)
    return Panel(part, np.concatenate(rows), np.concatenate(triangle))


def _strip(here: int, ahead: int) -> Integers:
    """Returns the triangles between rows of `here` and `ahead` chords, shape (here + ahead, 3).

    The points of the second row are numbered after those of the first. Each triangle has a chord of
    one row and a point of the other; they are in the order of the chords' midpoints.
    """
    middle = np.concatenate([(np.arange(n) + 0.5) / max(n, 1) for n in (here, ahead)])
    on_here = (np.arange(here + ahead) < here)[np.argsort(middle, kind="stable")]
    i: Integers = np.cumsum(on_here) - on_here
    j: Integers = here + 1 + np.arange(here + ahead) - i
    return np.stack([i, np.where(on_here, i, j) + 1, j], axis=1)


def number_of_parts(length: float, spacing: float) -> int:
    """Returns the number of parts of at most `spacing` that a length is divided into."""
    return max(math.ceil(length / spacing * (1.0 - 1e-12)), 1)


def rectangle(part: str, corner: Floats, along: Floats, across: Floats, spacing: float) -> Panel:
    """Returns a rectangular panel; its normal is the cross product of its edges from `corner`."""
    columns, rows = (
        number_of_parts(float(np.linalg.norm(edge)), spacing) for edge in (along, across)
    )
    row = corner + np.linspace(0.0, 1.0, columns + 1)[:, None] * along
    return triangulate_rows(part, [row + k / rows * across for k in range(rows + 1)])


def chords_of_quarter(radius: float, spacing: float) -> int:
    """Returns the number of chords of at most `spacing` for a quarter of a circle."""
    return max(number_of_parts(0.5 * math.pi * radius, spacing), MINIMUM_QUARTER_CHORDS)


def arc(radius: float, chords: int) -> Floats:
    """Returns evenly spaced points on a quarter of a circle from the x to the y axis, (n, 3)."""
    if chords == 0:
        return np.zeros((1, 3))
    fraction = np.arange(chords + 1) / chords
    x, y = np.sin(0.5 * math.pi * (1.0 - fraction)), np.sin(0.5 * math.pi * fraction)
    return np.stack([radius * x, radius * y, 0.0 * fraction], axis=1)


def quarter_ring(part: str, inner: float, outer: float, spacing: float) -> Panel:
    """Returns a panel that is a quarter of a disc or ring at x, y >= 0, z = 0; its normal is z.

    Its outer and inner arcs have as many chords as `chords_of_quarter` returns.
    """
    rows = number_of_parts(outer - inner, spacing)
    last = chords_of_quarter(outer, spacing)
    first = chords_of_quarter(inner, spacing) if inner > 0.0 else 0
    arcs = [
        arc(inner + k / rows * (outer - inner), math.ceil(first + k / rows * (last - first)))
        for k in range(rows + 1)
    ]
    return triangulate_rows(part, arcs[::-1])


def octant(part: str, radius: float, spacing: float) -> Panel:
    """Returns a sphere's octant x, y, z >= 0 as a panel; its normals point to the centre.

    With evenly divided barycentric coordinates a, b and c the vertices are in the directions
    (sin(pi a / 2), sin(pi b / 2), sin(pi c / 2)). The three sides are evenly divided arcs; the
    edges inside are at most 1.47 times as long, and no angle is below 45 degrees.
    """
    n = chords_of_quarter(radius, spacing)
    rows = []
    for k in range(n + 1):
        i = np.arange(k + 1)
        direction = np.sin(0.5 * math.pi / n * np.stack([np.full(k + 1, n - k), k - i, i], axis=1))
        rows.append(radius * direction / np.linalg.norm(direction, axis=1, keepdims=True))
    return triangulate_rows(part, rows)


def joined(panels: Sequence[Panel]) -> Triangles:
    """Returns the surface of panels that have the same vertices along common edges."""
    vertices = np.concatenate([panel.vertices for panel in panels])
    sizes = np.array([len(panel.vertices) for panel in panels])
    first = np.cumsum(sizes) - sizes
    triangle = np.concatenate([p.triangle + f for p, f in zip(panels, first, strict=True)])
    corner = vertices[triangle]
    shortest = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min()
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(MERGE_TOLERANCE * shortest, output_type="ndarray")
    # Coincident vertices get the lowest of their numbers.
    merged = np.arange(len(vertices))
    np.minimum.at(merged, pairs.max(axis=1), pairs.min(axis=1))
    kept, number = np.unique(merged, return_inverse=True)
    part = tuple(dict.fromkeys(panel.part for panel in panels))
    part_number = [np.full(len(p.triangle), part.index(p.part)) for p in panels]
    return Triangles(vertices[kept], number[triangle], part, np.concatenate(part_number))
