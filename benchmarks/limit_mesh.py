# SPDX-License-Identifier: BSD-3-Clause
"""Triangles for limit analysis: a mapped mesh, bisected where the dissipation is largest."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tilth.arrays import Floats, Integers

Snap = Callable[[str, Floats], Floats]
"""Moves the middle of a new boundary edge of this part onto the boundary, e.g. onto an arc."""
Parts = tuple[list[str], list[str]]
"""Names of the boundary for the pieces of the inner and the outer line of a mapped mesh."""


@dataclass(frozen=True)
class Mesh:
    """Triangles, anticlockwise.

    Attributes:
        nodes: shape (n, 2) [length].
        triangles: node numbers, shape (m, 3).
        boundary: edge (start, end), with the soil on its left -> the part of the boundary.
    """

    nodes: Floats
    triangles: Integers
    boundary: Mapping[tuple[int, int], str]

    def corners(self) -> Floats:
        """Returns the positions of the triangles' corners, shape (m, 3, 2)."""
        return np.asarray(self.nodes[self.triangles])

    def areas(self) -> Floats:
        """Returns the areas of the triangles, shape (m,)."""
        a, b, c = np.moveaxis(self.corners(), 1, 0)
        return np.asarray(0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]))


def mapped_mesh(
    inner: Floats, outer: Floats, layers: int, ratio: float, sides: tuple[str, str], ends: Parts
) -> Mesh:
    """Returns triangles between two lines with as many points each, four to a quadrilateral.

    Args:
        inner, outer: points, shape (n, 2); the region is on the right of `inner`.
        layers: of quadrilaterals, each `ratio` times as deep as the one before.
        sides: names of the boundary at the first and at the last points.
        ends: name of the boundary for each of the n - 1 pieces of `inner`, and of `outer`.
    """
    share = np.cumsum(np.append(0.0, ratio ** np.arange(layers)))
    share /= share[-1]
    grid = inner[:, None] + share[None, :, None] * (outer - inner)[:, None]
    number = np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
    quads = np.stack(
        [number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]], axis=-1
    ).reshape(-1, 4)
    nodes = grid.reshape(-1, 2)
    centres = len(nodes) + np.arange(len(quads))
    triangles = np.concatenate(
        [np.stack([quads[:, i], quads[:, (i + 1) % 4], centres], axis=-1) for i in range(4)]
    )
    nodes = np.concatenate([nodes, nodes[quads].mean(axis=1)])
    boundary = {}
    for line, name in ((number[0], sides[0]), (number[-1], sides[1])):
        boundary |= dict.fromkeys(pairwise(line), name)
    for line, names in ((number[:, 0], ends[0]), (number[:, -1], ends[1])):
        boundary |= dict(zip(pairwise(line), names, strict=True))
    mesh = Mesh(nodes, triangles, {})
    if mesh.areas().sum() < 0.0:
        triangles = triangles[:, ::-1].copy()
    directed = {(int(t[i]), int(t[(i + 1) % 3])) for t in triangles for i in range(3)}
    turned = {
        (int(a), int(b)) if (a, b) in directed else (int(b), int(a)): name
        for (a, b), name in boundary.items()
    }
    return Mesh(nodes, triangles, turned)


def refined(mesh: Mesh, marked: Iterable[int], snap: Snap) -> Mesh:
    """Returns the mesh with marked triangles bisected at their longest edges (Rivara 1984).

    Neighbours are bisected as well until no node hangs on an edge.
    """
    nodes = [tuple(node) for node in mesh.nodes]
    triangles: list[tuple[int, int, int] | None] = [
        (int(a), int(b), int(c)) for a, b, c in mesh.triangles
    ]
    boundary = dict(mesh.boundary)
    owner = {}
    for number, triangle in enumerate(mesh.triangles):
        for i in range(3):
            owner[int(triangle[i]), int(triangle[(i + 1) % 3])] = number

    def longest(number: int) -> tuple[int, int, int]:
        triangle = triangles[number]
        assert triangle is not None
        turned = [(triangle[i], triangle[(i + 1) % 3], triangle[(i + 2) % 3]) for i in range(3)]
        place = [np.array([nodes[a], nodes[b]]) for a, b, _ in turned]
        length = [round(float(np.hypot(*(p[1] - p[0]))), 12) for p in place]
        ends = [tuple(sorted((a, b))) for a, b, _ in turned]
        return turned[max(range(3), key=lambda i: (length[i], ends[i]))]

    def halve(number: int, middle: int) -> None:
        a, b, c = longest(number)
        triangles[number] = None
        for each in ((a, middle, c), (middle, b, c)):
            triangles.append(each)
            for i in range(3):
                owner[each[i], each[(i + 1) % 3]] = len(triangles) - 1
        del owner[a, b]

    def bisect(number: int) -> None:
        while triangles[number] is not None:
            path = [number]
            while True:  # along longest edges to a pair that share theirs, or to the boundary
                a, b, _ = longest(path[-1])
                beyond = owner.get((b, a))
                if beyond is None or set(longest(beyond)[:2]) == {a, b}:
                    break
                path.append(beyond)
            point = 0.5 * (np.array(nodes[a]) + np.array(nodes[b]))
            middle = len(nodes)
            part = boundary.pop((a, b), None) if beyond is None else None
            if part is not None:
                point = snap(part, point)
                boundary[a, middle], boundary[middle, b] = part, part
            nodes.append((float(point[0]), float(point[1])))
            halve(path[-1], middle)
            if beyond is not None:
                halve(beyond, middle)

    for number in marked:
        bisect(int(number))
    kept = np.array([each for each in triangles if each is not None])
    return Mesh(np.array(nodes), kept, boundary)
