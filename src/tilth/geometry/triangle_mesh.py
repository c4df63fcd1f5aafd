# SPDX-License-Identifier: BSD-3-Clause
"""Closed triangulated surface, read from an STL file; that of open ones is `OpenSurface`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.stl_file import DEGENERACY_TOLERANCE, closed_surface, read_stl
from tilth.errors import NOT_GIVEN, BadInput
from tilth.geometry.protocol import Facets

# A point nearer than this, relative to the largest extent or coordinate, is on the surface: its
# gradient is the normal. Also the margin for round-off in the search.
SURFACE_TOLERANCE = 1e-12
# Pairs of points and triangles, and points, per batch; they bound the memory.
PAIRS_PER_BATCH = 1 << 20
POINTS_PER_BATCH = 1 << 14


class TriangleMesh:
    """A closed triangulated surface with the soil inside or outside.

    corner: coordinates of the triangles' corners (n, 3, 3) [length]. Corners that differ by no
        more than the round-off of a file in single precision are merged. The surface must be
        closed: each edge belongs to two triangles with opposite directions along it. It may have
        several separate parts and cavities. Triangles of zero area are dropped.
    inside: whether the soil is inside.
    key, value: key and value of the mesh in the case file, for messages.
    Raises BadInput if the surface is not closed or encloses no volume.
    """

    dim = 3
    bounded = True
    flat = True

    def __init__(
        self, corner: Floats, inside: bool, *, key: str = "geometry", value: Any = NOT_GIVEN
    ) -> None:
        try:
            vertex, node, self.volume = closed_surface(corner)
        except BadInput as error:
            raise BadInput(error.problem, error.remedy, key=key, value=value) from None
        self._set(vertex, node, -1.0 if inside else 1.0)

    def _set(self, vertex: Floats, node: Integers, sign: float) -> Integers:
        """Sets the triangles of a surface; returns those of some area, shape (n, 3).

        sign: 1 if the soil is where the triangles are anticlockwise, -1 if on the other side.
        """
        extent = float(np.ptp(vertex, axis=0).max())
        self._sign = sign
        twice_area = np.cross(
            vertex[node[:, 1]] - vertex[node[:, 0]], vertex[node[:, 2]] - vertex[node[:, 0]]
        )
        longest = np.linalg.norm(vertex[node] - vertex[np.roll(node, 1, axis=1)], axis=2).max(
            axis=1
        )
        norm = np.linalg.norm(twice_area, axis=1)
        kept = norm > DEGENERACY_TOLERANCE * longest**2
        node, outward = node[kept], twice_area[kept] / norm[kept, None]
        self.corner = vertex[node]
        self._tolerance = SURFACE_TOLERANCE * max(extent, float(np.abs(vertex).max()))
        self._pseudo_normal = _pseudo_normals(node, self.corner, outward)
        self._centre = self.corner.mean(axis=1)
        self._radius = np.linalg.norm(self.corner - self._centre[:, None], axis=2).max(axis=1)
        self._size_classes = _size_classes(self._centre, self._radius)
        return node

    @classmethod
    def from_file(cls, path: str | Path, soil: str, *, key: str = "geometry.file") -> TriangleMesh:
        """Returns the surface in an STL file, text or binary.

        soil: "inside" or "outside" of it.
        Raises BadInput for a file that is missing or cannot be read, a surface that is not closed,
        and if the package meshio is missing.
        """
        return cls(read_stl(Path(path), key), soil == "inside", key=key, value=str(path))

    def distance(self, x: Floats) -> Floats:
        """Returns the exact signed distance [length] of points (n, 3), > 0 in the soil, (n,)."""
        offset, pseudo_normal, _number, _feature = self._nearest(x)
        outside = np.sum(offset * pseudo_normal, axis=1)
        side = np.where(outside < 0.0, -self._sign, self._sign)
        return np.asarray(side * np.linalg.norm(offset, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """Returns the direction into the soil at points (n, 3): unit vectors, same shape.

        It is the normal where the nearest point lies inside a triangle, and at distance zero, where
        that of an edge or a corner is the mean of the triangles' normals.
        """
        offset, pseudo_normal, _number, feature = self._nearest(x)
        length = np.linalg.norm(offset, axis=1)
        outside = np.where(np.sum(offset * pseudo_normal, axis=1) < 0.0, -1.0, 1.0)
        by_normal = (feature == 0) | (length <= self._tolerance)
        direction = np.where(by_normal[:, None], pseudo_normal, outside[:, None] * offset)
        return np.asarray(self._sign * direction / np.linalg.norm(direction, axis=1)[:, None])

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns all triangles, each cut into k^2 equal ones with edges up to `size` [length].

        The box from `lower` to `upper` is not used. The group is the triangle's number.
        """
        del lower, upper
        edge = np.linalg.norm(self.corner - np.roll(self.corner, 1, axis=1), axis=2).max(axis=1)
        cuts = np.maximum(np.ceil(edge / size * (1.0 - 1e-12)), 1.0).astype(np.int64)
        number = cuts**2
        first = np.cumsum(number) - number
        corner = np.empty((int(number.sum()), 3, 3))
        for k in np.unique(cuts):
            chosen = np.flatnonzero(cuts == k)
            where = first[chosen][:, None] + np.arange(k * k)
            corner[where] = np.einsum("pcv,tvi->tpci", _pieces(int(k)), self.corner[chosen])
        group = np.repeat(np.arange(len(cuts)), number)
        order = [0, 1, 2] if self._sign > 0.0 else [0, 2, 1]  # anticlockwise seen from the soil
        return Facets(corner[:, order], self._sign * self._pseudo_normal[group, 0], group)

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Returns the points themselves (n, 3) and the ratio 1 (n,): the facets are exact."""
        del normal
        return x, np.ones(len(x))

    def _nearest(self, x: Floats) -> tuple[Floats, Floats, Integers, Integers]:
        """Returns the nearest points of the surface to points (n, 3).

        The results are x minus the nearest point (n, 3), the outward pseudo-normal there (n, 3),
        not a unit vector on edges and corners, the triangle (n,) and its feature (n,), see
        `_closest`.
        """
        x = np.asarray(x, dtype=np.float64)
        number = np.empty(len(x), dtype=np.int64)
        for start in range(0, len(x), POINTS_PER_BATCH):
            number[start : start + POINTS_PER_BATCH] = self._nearest_triangle(
                x[start : start + POINTS_PER_BATCH]
            )
        offset, feature = _closest(x, self.corner[number])
        return offset, self._pseudo_normal[number, feature], number, feature

    def _nearest_triangle(self, x: Floats) -> Integers:
        """Returns the numbers of the triangles nearest to points (n, 3), shape (n,).

        The triangle with the nearest centre in each size class gives an upper bound of the
        distance. All triangles whose bounding sphere is within this bound are then compared.
        """
        best = np.full(len(x), np.inf)
        nearest = np.zeros(len(x), dtype=np.int64)
        for tree, member, _radius in self._size_classes:
            guess = member[tree.query(x)[1]]
            length = np.linalg.norm(_closest(x, self.corner[guess])[0], axis=1)
            nearest, best = np.where(length < best, guess, nearest), np.minimum(length, best)
        for tree, member, radius in self._size_classes:
            search_radius = (best + radius) * (1.0 + 1e-9) + self._tolerance
            found = np.asarray(tree.query_ball_point(x, search_radius, return_length=True))
            total = np.cumsum(found)
            start = 0
            while start < len(x):  # as many points as fill one batch of pairs, at least one
                passed = total[start - 1] if start else 0
                stop = max(
                    int(np.searchsorted(total, passed + PAIRS_PER_BATCH, side="right")), start + 1
                )
                rows = np.arange(start, stop)
                lists = tree.query_ball_point(x[rows], search_radius[rows], return_sorted=True)
                point = np.repeat(rows, found[rows])
                if len(point):
                    local = np.concatenate(lists).astype(np.int64)
                    length, tried = self._distances(x, best, point, member[local])
                    _reduce(best, nearest, point[tried], member[local[tried]], length)
                start = stop
        return nearest

    def _distances(
        self, x: Floats, best: Floats, point: Integers, triangle: Integers
    ) -> tuple[Floats, Integers]:
        """Returns distances of the pairs that may be below `best`, and the numbers of these pairs.

        A triangle is no nearer than its bounding disc about its centre.
        """
        to = x[point] - self._centre[triangle]
        square = np.einsum("ni,ni->n", to, to)
        height = np.einsum("ni,ni->n", to, self._pseudo_normal[triangle, 0])
        beyond_disc = np.sqrt(np.maximum(square - height * height, 0.0)) - self._radius[triangle]
        lower_bound = np.hypot(height, np.maximum(beyond_disc, 0.0))
        margin = 1e-6 * self._radius[triangle] + self._tolerance  # thin triangles' normals
        tried = np.flatnonzero(lower_bound <= best[point] * (1.0 + 1e-9) + margin)
        offset, _feature = _closest(x[point[tried]], self.corner[triangle[tried]])
        return np.linalg.norm(offset, axis=1), tried


def _reduce(
    best: Floats, nearest: Integers, point: Integers, triangle: Integers, length: Floats
) -> None:
    """Updates `best` and `nearest` in place with the nearer ones of the point-triangle pairs."""
    order = np.lexsort((triangle, length, point))
    point, triangle, length = point[order], triangle[order], length[order]
    first = np.ones(len(point), dtype=bool)
    first[1:] = point[1:] != point[:-1]
    point, triangle, length = point[first], triangle[first], length[first]
    nearer = length < best[point]
    best[point[nearer]], nearest[point[nearer]] = length[nearer], triangle[nearer]


def _closest(x: Floats, corner: Floats) -> tuple[Floats, Integers]:
    """Returns vectors (n, 3) to points x from the nearest points of one triangle (n, 3, 3) each.

    The second result is the feature of the triangle on which the nearest point lies (n,): 0 its
    interior, 1 to 3 the edges from corners 0, 1 and 2 to the next ones, 4 to 6 the corners.
    """
    to = x[:, None] - corner
    edge = np.roll(corner, -1, axis=1) - corner
    normal = np.cross(edge[:, 0], edge[:, 1])
    inward = np.cross(normal[:, None], edge)
    inside = (np.einsum("nij,nij->ni", inward, to) > 0.0).all(axis=1)
    # Outside the triangle's prism: the nearest of the three edges.
    square = np.einsum("nij,nij->ni", edge, edge)
    along = np.clip(np.einsum("nij,nij->ni", edge, to) / square, 0.0, 1.0)
    offsets = to - along[..., None] * edge
    which = np.argmin(np.einsum("nij,nij->ni", offsets, offsets), axis=1)
    row = np.arange(len(x))
    at = along[row, which]
    feature = np.where(at == 0.0, 4 + which, np.where(at == 1.0, 4 + (which + 1) % 3, 1 + which))
    height = np.einsum("ni,ni->n", to[:, 0], normal) / np.einsum("ni,ni->n", normal, normal)
    offset = np.where(inside[:, None], height[:, None] * normal, offsets[row, which])
    return offset, np.where(inside, 0, feature)


def _pseudo_normals(node: Integers, corner: Floats, outward: Floats) -> Floats:
    """Returns outward pseudo-normals (n, 7, 3) of the triangles' features, as in `_closest`.

    On an edge it is the sum of the two triangles' normals, at a corner the sum of those of all
    triangles there, weighted by their angles: with these the sign of the distance is correct
    (Baerentzen and Aanaes 2005, https://doi.org/10.1109/TVCG.2005.49).
    """
    normals = np.empty((len(node), 7, 3))
    normals[:, 0] = outward
    ends = np.sort(np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, edge = np.unique(ends, axis=0, return_inverse=True)
    edge = edge.reshape(-1, 3)
    ahead = np.roll(corner, -1, axis=1) - corner
    back = np.roll(corner, 1, axis=1) - corner
    sine = np.linalg.norm(np.cross(ahead, back), axis=2)
    angle = np.arctan2(sine, np.einsum("nij,nij->ni", ahead, back))
    for columns, number, weight in (
        (slice(1, 4), edge, np.ones_like(angle)),
        (slice(4, 7), node, angle),
    ):
        total = np.zeros((int(number.max()) + 1, 3))
        np.add.at(total, number, weight[..., None] * outward[:, None])
        # Two triangles folded onto each other have no pseudo-normal on their edge.
        undefined = np.linalg.norm(total, axis=1)[number] <= 1e-12
        normals[:, columns] = np.where(undefined[..., None], outward[:, None], total[number])
    return normals


def _size_classes(centre: Floats, radius: Floats) -> list[tuple[Any, Integers, float]]:
    """Returns size classes of triangles, one per factor of 2.

    Each has a tree of the centres, the triangles' numbers and the largest bounding radius.
    """
    from scipy.spatial import cKDTree  # takes 0.2 s: only where there is such a surface

    size = np.floor(np.log2(radius)).astype(np.int64)
    members = [np.flatnonzero(size == s) for s in np.unique(size)]
    return [(cKDTree(centre[m]), m, float(radius[m].max())) for m in members]


def _pieces(k: int) -> Floats:
    """Returns barycentric coordinates (k^2, 3, 3) of the corners of a triangle's k^2 parts."""
    pieces = []
    for i in range(k):
        for j in range(k - i):
            pieces.append([(i, j), (i + 1, j), (i, j + 1)])
            if i + j < k - 1:
                pieces.append([(i + 1, j), (i + 1, j + 1), (i, j + 1)])
    steps = np.array(pieces, dtype=np.float64)
    return np.concatenate([k - steps.sum(axis=2, keepdims=True), steps], axis=2) / k
