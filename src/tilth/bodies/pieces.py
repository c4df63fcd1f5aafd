# SPDX-License-Identifier: BSD-3-Clause
"""Elements of a mesh and their regular subdivision into k^d pieces."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth.bodies.request import FloatArray

IntArray = npt.NDArray[np.int64]


class Element(Protocol):
    """An element type."""

    @property
    def name(self) -> str:
        """What the element is called in messages."""
        ...

    @property
    def mirror(self) -> list[int]:
        """The order of the corners that turns the element's orientation round."""
        ...

    def pieces(self, corners: FloatArray, cuts: int) -> tuple[FloatArray, FloatArray]:
        """Centroids (n, cuts^d, d) and signed volumes (n, cuts^d) of the elements' pieces.

        corners: shape (n, corners, d).
        """
        ...

    def corner_jacobians(self, corners: FloatArray) -> FloatArray:
        """Determinants of the map from the reference element at its corners, shape (n, corners).

        For an affine map one of them, shape (n, 1).
        """
        ...


@dataclass(frozen=True)
class Simplex:
    """Triangle or tetrahedron; its pieces all have the same volume."""

    name: str
    mirror: list[int]

    def pieces(self, corners: FloatArray, cuts: int) -> tuple[FloatArray, FloatArray]:
        """As `Element.pieces`."""
        dimension = corners.shape[2]
        weight = simplex_weights(dimension, cuts)
        volume = self.corner_jacobians(corners) / math.factorial(dimension) / len(weight)
        centroid = np.einsum("qc,nci->nqi", weight, corners)
        return centroid, np.repeat(volume, len(weight), axis=1)

    def corner_jacobians(self, corners: FloatArray) -> FloatArray:
        """As `Element.corner_jacobians`."""
        jacobian: FloatArray = np.linalg.det(corners[:, 1:] - corners[:, :1])
        return jacobian[:, None]


@dataclass(frozen=True)
class Brick:
    """Quadrilateral or hexahedron: the multilinear map of a square or cube."""

    name: str
    mirror: list[int]
    corner: IntArray

    def pieces(self, corners: FloatArray, cuts: int) -> tuple[FloatArray, FloatArray]:
        """As `Element.pieces`."""
        # The Jacobian times the position has degree 3 along each reference axis: two Gauss
        # points per piece and direction integrate volume and centroid exactly.
        dimension = corners.shape[2]
        local = np.array([-1.0, 1.0]) / math.sqrt(3.0)
        axis = (-1.0 + (2.0 * np.arange(cuts)[:, None] + 1.0 + local) / cuts).ravel()
        place = np.stack(np.meshgrid(*[axis] * dimension, indexing="ij"), axis=-1)
        weight, gradient = self._shape(place.reshape(-1, dimension))
        jacobian = np.linalg.det(np.einsum("qck,nci->nqki", gradient, corners))
        position = np.einsum("qc,nci->nqi", weight, corners)
        split = (len(corners),) + (cuts, 2) * dimension
        within = tuple(range(2, 2 + 2 * dimension, 2))
        volume = jacobian.reshape(split).sum(axis=within).reshape(len(corners), -1)
        moment = (jacobian[..., None] * position).reshape((*split, dimension)).sum(axis=within)
        centroid = moment.reshape(len(corners), -1, dimension) / volume[..., None]
        return centroid, volume / cuts**dimension

    def corner_jacobians(self, corners: FloatArray) -> FloatArray:
        """As `Element.corner_jacobians`."""
        _, gradient = self._shape(self.corner.astype(float))
        jacobian: FloatArray = np.linalg.det(np.einsum("qck,nci->nqki", gradient, corners))
        return jacobian

    def _shape(self, place: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Shape functions (q, corners) and gradients (q, corners, d) at reference places (q, d)."""
        factor = 0.5 * (1.0 + self.corner * place[:, None, :])
        gradient = np.empty_like(factor)
        for i in range(place.shape[1]):
            others = np.delete(factor, i, axis=2).prod(axis=2)
            gradient[..., i] = 0.5 * self.corner[:, i] * others
        return factor.prod(axis=2), gradient


@cache
def simplex_weights(dimension: int, cuts: int) -> FloatArray:
    """Barycentric coordinates of the centroids of a simplex's pieces, shape (cuts^d, d + 1).

    The simplex cuts >= x_1 >= x_2 >= ... >= 0 is the union of those pieces of the unit cubes'
    Freudenthal subdivision (one per cube and order of the axes) that lie inside it; they are
    cuts^d pieces of equal volume.
    """
    cube = np.indices((cuts,) * dimension).reshape(dimension, -1).T
    found = []
    for order in itertools.permutations(range(dimension)):
        steps = np.zeros((dimension + 1, dimension))
        for i, axis in enumerate(order):
            steps[i + 1 :, axis] = 1.0
        centre = cube + steps.mean(axis=0)
        inside = (np.diff(centre, axis=1) < 0.0).all(axis=1)
        found.append(centre[inside])
    place = np.concatenate(found) / cuts
    place = place[np.lexsort(place.T[::-1])]
    padded = np.hstack([np.ones((len(place), 1)), place, np.zeros((len(place), 1))])
    return -np.diff(padded, axis=1)


_SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
_CUBE = np.array([[*c, z] for z in (-1, 1) for c in _SQUARE])

ELEMENTS: dict[str, Element] = {
    "triangle": Simplex("triangle", [0, 2, 1]),
    "tetra": Simplex("tetrahedron", [0, 2, 1, 3]),
    "quad": Brick("quadrilateral", [0, 3, 2, 1], _SQUARE),
    "hexahedron": Brick("hexahedron", [4, 5, 6, 7, 0, 1, 2, 3], _CUBE),
}
