# SPDX-License-Identifier: BSD-3-Clause
"""Patches of triangles between rows of points, and the surface of patches that meet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.surface.triangles import Triangles

# Vertices of patches nearer than this, in the shortest edge, are the same one.
SAME_VERTEX = 1e-3
# Fewest chords of a quarter of a circle.
QUARTER_CHORDS = 4


@dataclass(frozen=True)
class Patch:
    """Triangles of one part of a surface.

    Attributes:
        part: its name.
        vertices: [length], shape (n, 3).
        triangle: numbers of the vertices, shape (m, 3).
    """

    part: str
    vertices: Floats
    triangle: Integers

    def turned(self) -> Patch:
        """Returns the same patch with its normals on the other side."""
        return Patch(self.part, self.vertices, self.triangle[:, ::-1])

    def mapped(self, matrix: npt.ArrayLike, shift: npt.ArrayLike) -> Patch:
        """Returns the patch at matrix @ vertex + shift; reflected normals stay on their side."""
        matrix = np.asarray(matrix, dtype=float)
        moved = Patch(self.part, self.vertices @ matrix.T + shift, self.triangle)
        return moved.turned() if np.linalg.det(matrix) < 0.0 else moved


def between_rows(part: str, rows: Sequence[Floats]) -> Patch:
    """Returns the patch of triangles between rows of evenly divided points, (k, 3) each.

    A row may have any number of points, one as well; the normals are along the way through a row
    crossed with the way from a row to the next.
    """
    first, triangle = 0, []
    for here, ahead in pairwise(rows):
        triangle.append(_strip(len(here) - 1, len(ahead) - 1) + first)
        first += len(here)
    return Patch(part, np.concatenate(rows), np.concatenate(triangle))


def _strip(here: int, ahead: int) -> Integers:
    """Triangles between two rows of chords, of points 0 to `here` and those that follow them.

    The triangles come in the order of the chords' middles, each on the chord of one row and on a
    point of the other.
    """
    middle = np.concatenate([(np.arange(n) + 0.5) / max(n, 1) for n in (here, ahead)])
    on_here = (np.arange(here + ahead) < here)[np.argsort(middle, kind="stable")]
    i: Integers = np.cumsum(on_here) - on_here
    j: Integers = here + 1 + np.arange(here + ahead) - i
    return np.stack([i, np.where(on_here, i, j) + 1, j], axis=1)


def parts_of(length: float, spacing: float) -> int:
    """Returns into how many parts of at most `spacing` a length is divided, at least 1."""
    return max(math.ceil(length / spacing * (1.0 - 1e-12)), 1)


def rectangle(part: str, corner: Floats, along: Floats, across: Floats, spacing: float) -> Patch:
    """Returns the patch on a rectangle from a corner and two edges; its normal is their product."""
    columns, rows = (parts_of(float(np.linalg.norm(edge)), spacing) for edge in (along, across))
    row = corner + np.linspace(0.0, 1.0, columns + 1)[:, None] * along
    return between_rows(part, [row + k / rows * across for k in range(rows + 1)])


def chords_of_quarter(radius: float, spacing: float) -> int:
    """Returns into how many chords of at most `spacing` a quarter of a circle is divided."""
    return max(parts_of(0.5 * math.pi * radius, spacing), QUARTER_CHORDS)


def arc(radius: float, chords: int) -> Floats:
    """Returns evenly spaced points on a quarter of a circle from the x to the y axis, (n, 3)."""
    if chords == 0:
        return np.zeros((1, 3))
    share = np.arange(chords + 1) / chords
    x, y = np.sin(0.5 * math.pi * (1.0 - share)), np.sin(0.5 * math.pi * share)
    return np.stack([radius * x, radius * y, 0.0 * share], axis=1)


def quarter_ring(part: str, inner: float, outer: float, spacing: float) -> Patch:
    """Returns the patch on a quarter of a disc or ring at x, y >= 0, z = 0; its normal is z.

    Its outer and inner arc have the chords of `chords_of_quarter`.
    """
    rows = parts_of(outer - inner, spacing)
    last = chords_of_quarter(outer, spacing)
    first = chords_of_quarter(inner, spacing) if inner > 0.0 else 0
    arcs = [
        arc(inner + k / rows * (outer - inner), math.ceil(first + k / rows * (last - first)))
        for k in range(rows + 1)
    ]
    return between_rows(part, arcs[::-1])


def octant(part: str, radius: float, spacing: float) -> Patch:
    """Returns the patch on a sphere's octant x, y, z >= 0; its normals point to the centre.

    With a, b and c the three shares of a triangle, divided evenly, the vertices are along
    (sin(pi a / 2), sin(pi b / 2), sin(pi c / 2)). The three sides are evenly divided arcs; the
    edges inside are at most 1.47 times as long, and no angle is below 45 degrees.
    """
    n = chords_of_quarter(radius, spacing)
    rows = []
    for k in range(n + 1):
        i = np.arange(k + 1)
        way = np.sin(0.5 * math.pi / n * np.stack([np.full(k + 1, n - k), k - i, i], axis=1))
        rows.append(radius * way / np.linalg.norm(way, axis=1, keepdims=True))
    return between_rows(part, rows)


def joined(patches: Sequence[Patch]) -> Triangles:
    """Returns the surface of patches that have the same vertices where they meet."""
    vertices = np.concatenate([patch.vertices for patch in patches])
    sizes = np.array([len(patch.vertices) for patch in patches])
    first = np.cumsum(sizes) - sizes
    triangle = np.concatenate([p.triangle + f for p, f in zip(patches, first, strict=True)])
    corner = vertices[triangle]
    shortest = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).min()
    from scipy.spatial import cKDTree

    pairs = cKDTree(vertices).query_pairs(SAME_VERTEX * shortest, output_type="ndarray")
    # Every vertex is the first of those at its place.
    same = np.arange(len(vertices))
    np.minimum.at(same, pairs.max(axis=1), pairs.min(axis=1))
    kept, number = np.unique(same, return_inverse=True)
    part = tuple(dict.fromkeys(patch.part for patch in patches))
    part_number = [np.full(len(p.triangle), part.index(p.part)) for p in patches]
    return Triangles(vertices[kept], number[triangle], part, np.concatenate(part_number))
