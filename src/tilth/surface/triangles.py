# SPDX-License-Identifier: BSD-3-Clause
"""Surface of plane triangles, with the soil on the side of their normals; triangle quadrature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.curves.chain import BadSurface, listed

# A triangle whose height is below this many machine epsilons times the largest coordinate has no
# normal.
HEIGHT_EPSILONS = 16.0


@dataclass(frozen=True)
class TriangleRule:
    """Quadrature rule of a triangle; q points.

    An integral over triangle k is the sum over the points of
    weight |tangent[k, 0] x tangent[k, 1]| f; without the norm it is the integral of f dA, where
    dA points into the soil.

    Attributes:
        barycentric: barycentric coordinates of the points, shape (q, 3).
        weight: shape (q,); their sum is 1/2, the area of the triangle of the two parameters.
    """

    barycentric: Floats
    weight: Floats


class Triangles:
    """Triangles with common vertices; their normals point into the soil.

    The vertices of a triangle are anticlockwise seen from the soil, so that the normal follows
    from the right-hand rule. n vertices, m triangles.

    Args:
        vertices: [length], shape (n, 3).
        triangle: numbers of the vertices of each triangle, shape (m, 3).
        part: names of the parts of the surface that the triangles belong to.
        part_number: number of each triangle's part, shape (m,); the first if not given.

    Raises:
        BadSurface: wrong shapes or numbers, coordinates that are not finite, or triangles of
            zero height.
    """

    def __init__(
        self,
        vertices: npt.ArrayLike,
        triangle: npt.ArrayLike,
        part: Sequence[str] = ("surface",),
        part_number: npt.ArrayLike | None = None,
    ) -> None:
        self.vertices: Floats = np.array(vertices, dtype=np.float64)
        self.triangle: Integers = np.array(triangle, dtype=np.int64)
        for name, array in (("vertices", self.vertices), ("triangles", self.triangle)):
            if array.ndim != 2 or array.shape[1] != 3 or not len(array):
                raise BadSurface(f"{name} of shape {array.shape}", f"give three numbers for {name}")
        self.part = tuple(part)
        m = len(self.triangle)
        self.part_number: Integers = np.zeros(m, dtype=np.int64)
        if part_number is not None:
            self.part_number[:] = part_number
        self._check()

    def __len__(self) -> int:
        return len(self.triangle)

    @property
    def corner(self) -> Floats:
        """Vertices of the triangles [length], shape (m, 3, 3)."""
        return self.vertices[self.triangle]

    @property
    def tangent(self) -> Floats:
        """Edges from the first vertex to the second and to the third [length], shape (m, 2, 3).

        They are the derivatives of the position with respect to the barycentric coordinates of the
        second and the third vertex; half their cross product is the area vector.
        """
        corner = self.corner
        return np.asarray(corner[:, 1:] - corner[:, :1])

    @property
    def area_vector(self) -> Floats:
        """Areas times normals into the soil [length^2], shape (m, 3)."""
        tangent = self.tangent
        return np.asarray(0.5 * np.cross(tangent[:, 0], tangent[:, 1]))

    @property
    def area(self) -> Floats:
        """Areas of the triangles [length^2], shape (m,)."""
        return np.asarray(np.linalg.norm(self.area_vector, axis=1))

    @property
    def normal(self) -> Floats:
        """Unit normals of the triangles, into the soil, shape (m, 3)."""
        vector = self.area_vector
        return np.asarray(vector / np.linalg.norm(vector, axis=1, keepdims=True))

    @property
    def vertex_normal(self) -> Floats:
        """Unit normals at the vertices, into the soil, shape (n, 3).

        The mean over the triangles there, weighted by their areas; 0 at a vertex of no triangle.
        """
        total = np.zeros_like(self.vertices)
        np.add.at(total, self.triangle.ravel(), np.repeat(self.area_vector, 3, axis=0))
        size = np.linalg.norm(total, axis=1, keepdims=True)
        return np.asarray(total / np.where(size > 0.0, size, 1.0))

    @cached_property
    def closed(self) -> bool:
        """Whether every edge belongs to two triangles with opposite directions along it."""
        ahead = self.edge[..., 0] * len(self.vertices) + self.edge[..., 1]
        back = self.edge[..., 1] * len(self.vertices) + self.edge[..., 0]
        unique = np.unique(ahead)
        return len(unique) == ahead.size and np.array_equal(unique, np.unique(back))

    @property
    def edge(self) -> Integers:
        """Vertices of the edges in the order of each triangle's vertices, shape (m, 3, 2).

        Edge i leads from vertex i to the next one.
        """
        return np.stack([self.triangle, np.roll(self.triangle, -1, axis=1)], axis=2)

    @property
    def volume(self) -> float:
        """Enclosed volume [length^3], < 0 if the soil is outside.

        Raises:
            BadSurface: the surface is not closed.
        """
        if not self.closed:
            raise BadSurface(
                "a volume needs a closed surface", "each edge must belong to two triangles"
            )
        relative = self.vertices[self.triangle[:, 0]] - self.vertices[0]
        return -float((relative * self.area_vector).sum()) / 3.0

    def spread(self, values: Floats, known: Flags) -> Floats:
        """Returns values at the vertices, (n, k), those that are not known from their neighbours.

        From the mean of known neighbours, one layer after the other; 0 without such neighbours.
        known: at which vertices the values are known, shape (n,).
        """
        values, known = np.where(known[:, None], values, 0.0), known.copy()
        start, end = np.concatenate([self.edge, self.edge[..., ::-1]]).reshape(-1, 2).T
        while not known.all():
            used = known[start] & ~known[end]
            count = np.bincount(end[used], minlength=len(known))
            if not count.any():
                break
            np.add.at(values, end[used], values[start[used]] / count[end[used], None])
            known |= count > 0
        return values

    def in_part(self, name: str) -> Flags:
        """Returns which triangles belong to the part of this name, shape (m,).

        Raises:
            BadSurface: there is no such part.
        """
        if name not in self.part:
            raise BadSurface(
                f'the surface has no part "{name}"', f"choose from {', '.join(self.part)}"
            )
        return np.asarray(self.part_number == self.part.index(name))

    def _check(self) -> None:
        n = len(self.vertices)
        unknown = np.flatnonzero(((self.triangle < 0) | (self.triangle >= n)).any(axis=1))
        if len(unknown):
            raise BadSurface(
                f"triangles {listed(unknown)} have vertices that do not exist",
                f"number the {n} vertices from 0",
                unknown,
            )
        if ((self.part_number < 0) | (self.part_number >= len(self.part))).any():
            raise BadSurface(
                "triangles belong to parts that do not exist",
                f"number the {len(self.part)} parts from 0",
            )
        infinite = np.flatnonzero(~np.isfinite(self.corner).all(axis=(1, 2)))
        if len(infinite):
            raise BadSurface(
                f"coordinates of triangles {listed(infinite)} are not numbers",
                "give finite numbers",
                infinite,
            )
        corner = self.corner
        longest = np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2).max(axis=1)
        least = HEIGHT_EPSILONS * np.finfo(float).eps * float(np.abs(corner).max())
        flat = np.flatnonzero(2.0 * self.area <= least * longest)
        if len(flat):
            raise BadSurface(
                f"triangles {listed(flat)} have no height",
                "give each triangle three vertices that are not on one line",
                flat,
            )


def triangle_rule(number: int) -> TriangleRule:
    """Returns the quadrature rule of 3 points, exact for degree 2, or of 6, for degree 4.

    The points lie inside; all weights are positive. G. Strang & G. Fix (1973), An Analysis of the
    Finite Element Method, section 4.3; the six points in the closed form of the roots.

    Raises:
        ValueError: another number.
    """
    if number == 3:
        return _symmetric([(1.0 / 6.0, 1.0 / 6.0)])
    if number == 6:
        root = math.sqrt(38.0 - 44.0 * math.sqrt(0.4))
        heavy = math.sqrt(213125.0 - 53320.0 * math.sqrt(10.0))
        return _symmetric(
            [
                ((8.0 - math.sqrt(10.0) + root) / 18.0, (620.0 + heavy) / 7440.0),
                ((8.0 - math.sqrt(10.0) - root) / 18.0, (620.0 - heavy) / 7440.0),
            ]
        )
    raise ValueError(f"there are rules of 3 and 6 points, not {number}")


def _symmetric(orbits: list[tuple[float, float]]) -> TriangleRule:
    """Returns the symmetric rule of orbits (coordinate, weight) of three points each.

    Two barycentric coordinates of a point equal the given one, the third is the remainder to 1.
    """
    points = [np.roll([1.0 - 2.0 * a, a, a], i) for a, _ in orbits for i in range(3)]
    return TriangleRule(np.array(points), np.repeat([weight for _, weight in orbits], 3))
