# SPDX-License-Identifier: BSD-3-Clause
"""Types of mesh elements: subdivision into k^d pieces, and tiling by points' domains."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.corners import corner_signs


class Element(Protocol):
    """An element type."""

    @property
    def name(self) -> str:
        """Name of the element in messages."""
        ...

    @property
    def mirror(self) -> list[int]:
        """Order of the corners that reverses the element's orientation."""
        ...

    @property
    def edges(self) -> Integers:
        """Edges as pairs of corners; the edges of a row have the same number of segments.

        Shape (rows, edges, 2): a row for each direction of a quadrilateral or hexahedron, a single
        one for a triangle or tetrahedron.
        """
        ...

    @property
    def least_segments(self) -> int:
        """The number of segments along an edge must be a multiple of this."""
        ...

    def pieces(self, corners: Floats, cuts: int) -> tuple[Floats, Floats]:
        """Returns centroids (n, cuts^d, d) and signed volumes (n, cuts^d) of the pieces.

        corners: shape (n, corners, d).
        """
        ...

    def required_segments(self, corners: Floats, volume: Floats, spacing: Floats) -> Floats:
        """Returns the real number of segments per row of edges that matches the spacing, (n, rows).

        corners: shape (n, corners, d). volume: shape (n,). spacing: shape (n, d).
        """
        ...

    def number_of_tiles(self, segments: Floats) -> Floats:
        """Returns the numbers of tiles (n,) for segments along each row of edges (n, rows)."""
        ...

    def tiles(self, segments: tuple[int, ...]) -> Floats:
        """Returns the weights of the element's corners for the corners of its tiles.

        segments: along the edges of each row.
        Shape (tiles, 2^d, corners): tiles are quadrilaterals or hexahedra, their corners x fastest,
        with positive volume if the element's is positive. Together they fill the element, and the
        tiles of neighbours with the same segments along common edges have common corners.
        """
        ...

    def corner_jacobians(self, corners: Floats) -> Floats:
        """Returns the Jacobian determinants of the element map at the corners, shape (n, corners).

        For an affine map shape (n, 1).
        """
        ...


@dataclass(frozen=True)
class Simplex:
    """Triangle or tetrahedron; its pieces have equal volumes, and so have its tiles."""

    name: str
    mirror: list[int]

    @property
    def edges(self) -> Integers:
        """As `Element.edges`."""
        return np.array([list(itertools.combinations(range(len(self.mirror)), 2))])

    @property
    def least_segments(self) -> int:
        """As `Element.least_segments`: tiles have corners at the midpoints of edges."""
        return 2

    def pieces(self, corners: Floats, cuts: int) -> tuple[Floats, Floats]:
        """As `Element.pieces`."""
        dimension = corners.shape[2]
        weight = simplex_weights(dimension, cuts)
        volume = self.corner_jacobians(corners) / math.factorial(dimension) / len(weight)
        centroid = np.einsum("qc,nci->nqi", weight, corners)
        return centroid, np.repeat(volume, len(weight), axis=1)

    def corner_jacobians(self, corners: Floats) -> Floats:
        """As `Element.corner_jacobians`."""
        jacobian: Floats = np.linalg.det(corners[:, 1:] - corners[:, :1])
        return jacobian[:, None]

    def required_segments(self, corners: Floats, volume: Floats, spacing: Floats) -> Floats:
        """As `Element.required_segments`, by the volume of the tiles."""
        dimension = corners.shape[2]
        pieces = volume / spacing.prod(axis=1) / (dimension + 1)
        return np.asarray(2.0 * pieces[:, None] ** (1.0 / dimension))

    def number_of_tiles(self, segments: Floats) -> Floats:
        """As `Element.number_of_tiles`."""
        vertices = len(self.mirror)
        return np.asarray(vertices * (segments[:, 0] / self.least_segments) ** (vertices - 1))

    def tiles(self, segments: tuple[int, ...]) -> Floats:
        """As `Element.tiles`: each piece has one tile at each of its vertices.

        There the barycentric coordinate of the vertex is the largest. It is a quadrilateral or
        hexahedron between the vertex and the centres of its edges, its faces and the piece.
        """
        return simplex_tiles(len(self.mirror) - 1, segments[0] // self.least_segments)


@dataclass(frozen=True)
class Brick:
    """Quadrilateral or hexahedron: the multilinear map of a square or cube."""

    name: str
    mirror: list[int]
    corner: Integers

    @property
    def edges(self) -> Integers:
        """As `Element.edges`."""
        rows = []
        for axis in range(self.corner.shape[1]):
            order = np.lexsort((self.corner[:, axis], *np.delete(self.corner, axis, axis=1).T))
            rows.append(order.reshape(-1, 2))
        return np.stack(rows)

    @property
    def least_segments(self) -> int:
        """As `Element.least_segments`."""
        return 1

    def pieces(self, corners: Floats, cuts: int) -> tuple[Floats, Floats]:
        """As `Element.pieces`."""
        # The Jacobian times the position has degree 3 along each reference axis: two Gauss
        # points per piece and direction integrate volume and centroid exactly.
        dimension = corners.shape[2]
        local = np.array([-1.0, 1.0]) / math.sqrt(3.0)
        axis = (-1.0 + (2.0 * np.arange(cuts)[:, None] + 1.0 + local) / cuts).ravel()
        point = np.stack(np.meshgrid(*[axis] * dimension, indexing="ij"), axis=-1)
        weight, gradient = self._shape(point.reshape(-1, dimension))
        jacobian = np.linalg.det(np.einsum("qck,nci->nqki", gradient, corners))
        position = np.einsum("qc,nci->nqi", weight, corners)
        split = (len(corners),) + (cuts, 2) * dimension
        within = tuple(range(2, 2 + 2 * dimension, 2))
        volume = jacobian.reshape(split).sum(axis=within).reshape(len(corners), -1)
        moment = (jacobian[..., None] * position).reshape((*split, dimension)).sum(axis=within)
        centroid = moment.reshape(len(corners), -1, dimension) / volume[..., None]
        return centroid, volume / cuts**dimension

    def corner_jacobians(self, corners: Floats) -> Floats:
        """As `Element.corner_jacobians`."""
        _, gradient = self._shape(self.corner.astype(float))
        jacobian: Floats = np.linalg.det(np.einsum("qck,nci->nqki", gradient, corners))
        return jacobian

    def required_segments(self, corners: Floats, volume: Floats, spacing: Floats) -> Floats:
        """As `Element.required_segments`, by the mean of the edges of each direction."""
        start, end = np.moveaxis(self.edges, 2, 0)
        edge = (corners[:, end] - corners[:, start]).mean(axis=2)
        return np.asarray(np.linalg.norm(edge / spacing[:, None], axis=2))

    def number_of_tiles(self, segments: Floats) -> Floats:
        """As `Element.number_of_tiles`."""
        return np.asarray(segments.prod(axis=1))

    def tiles(self, segments: tuple[int, ...]) -> Floats:
        """As `Element.tiles`: the multilinear map of equal boxes."""
        dimension = len(segments)
        box = np.indices(segments).reshape(dimension, -1).T
        point = 2.0 * (box[:, None] + 0.5 * (1.0 + corner_signs(dimension))) / segments - 1.0
        weight, _ = self._shape(point.reshape(-1, dimension))
        return weight.reshape(len(box), 2**dimension, -1)

    def _shape(self, point: Floats) -> tuple[Floats, Floats]:
        """Returns shape functions (q, corners) and gradients (q, corners, d) at points (q, d)."""
        factor = 0.5 * (1.0 + self.corner * point[:, None, :])
        gradient = np.empty_like(factor)
        for i in range(point.shape[1]):
            others = np.delete(factor, i, axis=2).prod(axis=2)
            gradient[..., i] = 0.5 * self.corner[:, i] * others
        return factor.prod(axis=2), gradient


@cache
def simplex_weights(dimension: int, cuts: int) -> Floats:
    """Returns barycentric coordinates of the centroids of pieces, shape (cuts^d, d + 1)."""
    return _barycentric(_simplex_pieces(dimension, cuts)[0] / cuts)


def simplex_tiles(dimension: int, cuts: int) -> Floats:
    """Returns barycentric coordinates of the corners of a simplex's tiles.

    There are d + 1 tiles in each of cuts^d pieces; shape ((d + 1) cuts^d, 2^d, d + 1). Corner c of
    the tile at a vertex is the mean of this vertex and of those other vertices whose bits are set
    in c; the others are in the order that makes the volume positive.
    """
    vertex = _barycentric(_simplex_pieces(dimension, cuts)[1] / cuts)
    found = []
    for own in range(dimension + 1):
        others = [i for i in range(dimension + 1) if i != own]
        if own % 2:
            others[:2] = others[1::-1]
        for c in range(2**dimension):
            chosen = [own] + [others[k] for k in range(dimension) if c >> k & 1]
            found.append(vertex[:, chosen].mean(axis=1))
    tiles = np.stack(found, axis=1)
    return tiles.reshape(-1, 2**dimension, dimension + 1)


def _simplex_pieces(dimension: int, cuts: int) -> tuple[Floats, Floats]:
    """Returns centroids (cuts^d, d) and vertices (cuts^d, d + 1, d) of pieces of equal volume.

    The simplex cuts >= x_1 >= x_2 >= ... >= 0 is the union of those pieces of the unit cubes'
    Freudenthal subdivision (one per cube and order of the axes) that lie inside it. The vertices
    are in the order that makes the volume positive.
    """
    cube = np.indices((cuts,) * dimension).reshape(dimension, -1).T
    centroids, vertices = [], []
    for order in itertools.permutations(range(dimension)):
        steps = np.zeros((dimension + 1, dimension))
        for i, axis in enumerate(order):
            steps[i + 1 :, axis] = 1.0
        centre = cube + steps.mean(axis=0)
        inside = (np.diff(centre, axis=1) < 0.0).all(axis=1)
        centroids.append(centre[inside])
        if np.linalg.det(np.diff(steps, axis=0)) < 0.0:
            steps[[-2, -1]] = steps[[-1, -2]]
        vertices.append(cube[inside, None] + steps)
    centroid = np.concatenate(centroids)
    sort = np.lexsort(centroid.T[::-1])
    return centroid[sort], np.concatenate(vertices)[sort]


def _barycentric(point: Floats) -> Floats:
    """Returns barycentric coordinates (..., d + 1) in the simplex 1 >= x_1 >= x_2 >= ... >= 0."""
    end = [(0, 0)] * (point.ndim - 1)
    padded = np.pad(np.pad(point, [*end, (1, 0)], constant_values=1.0), [*end, (0, 1)])
    return -np.diff(padded, axis=-1)


_SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
_CUBE = np.array([[*c, z] for z in (-1, 1) for c in _SQUARE])

ELEMENTS: dict[str, Element] = {
    "triangle": Simplex("triangle", [0, 2, 1]),
    "tetra": Simplex("tetrahedron", [0, 2, 1, 3]),
    "quad": Brick("quadrilateral", [0, 3, 2, 1], _SQUARE),
    "hexahedron": Brick("hexahedron", [4, 5, 6, 7, 0, 1, 2, 3], _CUBE),
}
