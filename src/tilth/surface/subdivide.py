# SPDX-License-Identifier: BSD-3-Clause
"""Long edges of triangles are halved, both neighbours of an edge together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.surface.triangles import Triangles


@dataclass(frozen=True)
class Subdivision:
    """A surface after its long edges were halved; the first n vertices are the old ones.

    Attributes:
        triangles: the new surface.
        parents: the two vertices half way between which each new vertex lies, shape (new, 2). A
            parent may be new itself; its number is smaller than that of the vertex.
        origin: number of the old triangle in which each new one lies, shape (m,).
        passes: number of the vertices before the first pass and after each one; the parents of the
            vertices of a pass come from earlier ones.
    """

    triangles: Triangles
    parents: Integers
    origin: Integers
    passes: tuple[int, ...]

    def carried(self, values: Floats) -> Floats:
        """Returns values of the old vertices (n, ...) with those of the new ones behind them."""
        total = np.empty((self.passes[-1], *values.shape[1:]))
        total[: self.passes[0]] = values
        for begin, end in zip(self.passes[:-1], self.passes[1:], strict=True):
            parents = self.parents[begin - self.passes[0] : end - self.passes[0]]
            total[begin:end] = 0.5 * (total[parents[:, 0]] + total[parents[:, 1]])
        return total


def subdivide(triangles: Triangles, longest: float) -> Subdivision:
    """Returns a surface without edges longer than `longest` [length].

    The longest edge of a triangle is halved before its other ones (M.C. Rivara, 1984, Algorithms
    for refining triangular grids suitable for adaptive and multigrid techniques): the least angle
    stays above half of what it was. A closed surface stays closed; flat parts stay what they are.

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
        # Long edges that are not the longest of any triangle wait for a later pass. A triangle with
        # a halved edge has a longest edge that is halved as well.
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
    """The edges (e, 2), their numbers on the triangles (m, 3) and their lengths (e,)."""
    both = np.sort(np.stack([triangle, np.roll(triangle, -1, axis=1)], axis=2), axis=2)
    key, side = np.unique(both[..., 0] * len(vertices) + both[..., 1], return_inverse=True)
    edges = np.stack(np.divmod(key, len(vertices)), axis=1)
    length = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    return edges, side.reshape(triangle.shape), length


def _halves(
    triangle: Integers, middle: Integers, longest_side: Integers
) -> tuple[Integers, Integers]:
    """Parts of the triangles between the middles of their edges (m, 3), and where they come from.

    middle: numbers of the vertices half way along the edges, -1 where an edge is not halved.
    """
    number = np.arange(len(triangle))
    turn = (number[:, None], (longest_side[:, None] + np.arange(3)) % 3)
    # From a to b leads the longest edge.
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
