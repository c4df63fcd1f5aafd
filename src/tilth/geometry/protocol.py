# SPDX-License-Identifier: BSD-3-Clause
"""What the geometry of an implicit boundary must offer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers


@dataclass(frozen=True)
class Facets:
    """Straight pieces that cover a boundary: n segments (2D) or triangles (3D).

    Attributes:
        corner: [length], shape (n, dim, dim): facets, corners, coordinates.
        normal: unit, into the soil, shape (n, dim).
        patch: permanent number of the patch of surface that a facet belongs to, shape (n,). Asked
            for a larger region, the same patch has the same facets in the same order.
    """

    corner: Floats
    normal: Floats
    patch: Integers


@dataclass(frozen=True)
class QuadraturePoints:
    """Points that integrate over a boundary; n points.

    Attributes:
        position: on the boundary [length], shape (n, dim).
        weight: area that a point stands for [length^(dim - 1)], shape (n,).
        normal: unit, into the soil, shape (n, dim).
        patch: of the facet, shape (n,).
        part: the part of the boundary that a point stands for, of a facet's segment its share, of
            a triangle the quadrangle between a corner, the middles of two sides and the centroid:
            from the point to the corner, and the edges from there [length], shape (n, dim, dim).
    """

    position: Floats
    weight: Floats
    normal: Floats
    patch: Integers
    part: Floats

    def of(self, chosen: npt.NDArray[np.bool_]) -> QuadraturePoints:
        """Returns some of the points."""
        return QuadraturePoints(
            self.position[chosen],
            self.weight[chosen],
            self.normal[chosen],
            self.patch[chosen],
            self.part[chosen],
        )


class Geometry(Protocol):
    """A boundary at rest, described by its signed distance and by facets; n places.

    Attributes:
        dim: number of directions, 2 or 3.
        bounded: whether it ends; planes, cylinders and functions do not.
        flat: whether it is made of flat pieces, whose normals are those of the facets.
    """

    dim: int
    bounded: bool
    flat: bool

    def distance(self, x: Floats) -> Floats:
        """Returns the signed distance [length], > 0 in the soil, (n, dim) -> (n,)."""
        ...

    def gradient(self, x: Floats) -> Floats:
        """Returns the gradient of the distance: unit vectors into the soil, shape (n, dim)."""
        ...

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns facets not much longer than `size` [length].

        One without end covers at least the box from `lower` to `upper`, shape (dim,); one that
        ends is covered whole.
        """
        ...

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Moves places on facets, whose normals are given, onto the boundary itself.

        Returns the places there, shape (n, dim), and the ratio of the areas, shape (n,).
        """
        ...


class RoundGeometry(Geometry, Protocol):
    """One whose radius may change; `radius` [length]."""

    radius: float

    def radial(self, x: Floats) -> Floats:
        """Returns the vectors from the centre or axis [length], shape (n, dim)."""
        ...
