# SPDX-License-Identifier: BSD-3-Clause
"""Refinement of triangles by bisection of their long edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.surface.triangles import Triangles


@dataclass(frozen=True)
class Subdivision:
    """A refined surface; its first n vertices are those of the original one.

    Attributes:
        triangles: the new surface.
        parents: the ends of the edge whose midpoint each new vertex is, shape (new, 2). A parent
            may be new itself; its number is smaller than that of the vertex.
        origin: number of the original triangle that contains each new one, shape (m,).
        passes: numbers of vertices before the first pass and after each pass; the parents of new
            vertices are from earlier passes.
    """

    triangles: Triangles
    parents: Integers
    origin: Integers
    passes: tuple[int, ...]

    def interpolated(self, values: Floats) -> Floats:
        """Returns values of the original vertices (n, ...) followed by those of the new ones."""
        total = np.empty((self.passes[-1], *values.shape[1:]))
        total[: self.passes[0]] = values
        for begin, end in zip(self.passes[:-1], self.passes[1:], strict=True):
            parents = self.parents[begin - self.passes[0] : end - self.passes[0]]
            total[begin:end] = 0.5 * (total[parents[:, 0]] + total[parents[:, 1]])
        return total


def subdivide(triangles: Triangles, longest: float) -> Subdivision:
    """Returns a surface without edges longer than `longest` [length].

    The longest edge of a triangle is halved before its other ones (M.C. Rivara, 1984, Algorithms
    for refining triangular grids suitable for adaptive and multigrid techniques): the smallest
    angle remains above half of its original value. A closed surface remains closed; plane parts
    remain the same.

    Raises:
        ValueError: `longest` is not above zero.
    """
    if not longest > 0.0:
        raise ValueError(f"longest = {longest:.6g} must be above zero")
    vertices, triangle = triangles.vertices, triangles.triangle
    origin = np.arange(len(triangle))
    parents, passes = [np.empty((0, 2), dtype=np.int64)], [len(vertices)]
    while True:
        edges, side, length = _edges(vertices, triangle)
        longest_side = np.argmax(length[side], axis=1)
        own_longest = side[np.arange(len(side)), longest_side]
        # Long edges that are not the longest of any triangle are halved in a later pass. The
        # longest edge of a triangle with a halved edge is halved as well.
        halved = np.zeros(len(edges), dtype=bool)
        halved[own_longest] = length[own_longest] > longest
        if not halved.any():
            break
        middle = np.full(len(edges), -1)
        middle[halved] = len(vertices) + np.arange(halved.sum())
        parents.append(edges[halved])
        vertices = np.concatenate([vertices, vertices[edges[halved]].mean(axis=1)])
        passes.append(len(vertices))
        triangle, from_triangle = _halves(triangle, middle[side], longest_side)
        origin = origin[from_triangle]
    return Subdivision(
        Triangles(vertices, triangle, triangles.part, triangles.part_number[origin]),
        np.concatenate(parents),
        origin,
        tuple(passes),
    )


def _edges(vertices: Floats, triangle: Integers) -> tuple[Integers, Integers, Floats]:
    """Returns the edges (e, 2), their numbers in the triangles (m, 3) and lengths (e,)."""
    both = np.sort(np.stack([triangle, np.roll(triangle, -1, axis=1)], axis=2), axis=2)
    key, side = np.unique(both[..., 0] * len(vertices) + both[..., 1], return_inverse=True)
    edges = np.stack(np.divmod(key, len(vertices)), axis=1)
    length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    return edges, side.reshape(triangle.shape), length


def _halves(
    triangle: Integers, middle: Integers, longest_side: Integers
) -> tuple[Integers, Integers]:
    """Returns the refined triangles (k, 3), and the number of the original one of each (k,).

    middle: numbers of the vertices at the edges' midpoints (m, 3), -1 where one is not halved.
    longest_side: position of the longest edge in each triangle (m,).
    """
    number = np.arange(len(triangle))
    turn = (number[:, None], (longest_side[:, None] + np.arange(3)) % 3)
    # The longest edge is that from a to b.
    (a, b, c), (ab, bc, ca) = triangle[turn].T, middle[turn].T
    cut = ab >= 0
    groups = [
        (~cut, a, b, c),
        (cut & (bc < 0), ab, b, c),
        (cut & (bc >= 0), ab, b, bc),
        (cut & (bc >= 0), ab, bc, c),
        (cut & (ca < 0), a, ab, c),
        (cut & (ca >= 0), a, ab, ca),
        (cut & (ca >= 0), ca, ab, c),
    ]
    parts = [np.stack(corners, axis=1)[chosen] for chosen, *corners in groups]
    return np.concatenate(parts), np.concatenate([number[chosen] for chosen, *_ in groups])
