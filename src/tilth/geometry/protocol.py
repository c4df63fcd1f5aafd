# SPDX-License-Identifier: BSD-3-Clause
"""Interface of the geometry of an implicit boundary."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers


@dataclass(frozen=True)
class Facets:
    """Discretisation of a boundary by n segments (2D) or triangles (3D).

    Attributes:
        corner: [length], shape (n, dim, dim): facets, corners, coordinates.
        normal: unit, into the soil, shape (n, dim).
        group: permanent number of the group of neighbouring facets that a facet belongs to, shape
            (n,). A group has the same facets in the same order in every region that contains it.
    """

    corner: Floats
    normal: Floats
    group: Integers


@dataclass(frozen=True)
class QuadraturePoints:
    """Quadrature points of a boundary; n points.

    Attributes:
        position: on the boundary [length], shape (n, dim).
        weight: quadrature weight, an area [length^(dim - 1)], shape (n,).
        normal: unit, into the soil, shape (n, dim).
        group: group of the facet, see `Facets`, shape (n,).
        tributary: tributary part of the boundary [length], shape (n, dim, dim). The first row is
            the vector from the point to a corner of this part, the others are its edges from there.
            On a segment the part is an interval as long as the weight, on a triangle the quadrangle
            between a corner, the midpoints of two sides and the centroid.
    """

    position: Floats
    weight: Floats
    normal: Floats
    group: Integers
    tributary: Floats

    def of(self, chosen: npt.NDArray[np.bool_]) -> QuadraturePoints:
        """Returns the points with the flags `chosen`, shape (n,)."""
        return QuadraturePoints(
            self.position[chosen],
            self.weight[chosen],
            self.normal[chosen],
            self.group[chosen],
            self.tributary[chosen],
        )


class Geometry(Protocol):
    """A boundary in its reference configuration: signed distance, facets and projection.

    Attributes:
        dim: number of directions, 2 or 3.
        bounded: whether it is finite; planes, cylinders and functions are not.
        flat: whether its facets are exact, so that their normals are those of the boundary.
    """

    dim: int
    bounded: bool
    flat: bool

    def distance(self, x: Floats) -> Floats:
        """Returns the signed distance [length] of points (n, dim), > 0 in the soil, shape (n,)."""
        ...

    def gradient(self, x: Floats) -> Floats:
        """Returns the distance's gradient at points (n, dim): unit vectors into the soil."""
        ...

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """Returns facets not much longer than `size` [length].

        The facets of a bounded geometry are all of it; those of an unbounded one extend at least
        over the box from `lower` to `upper` [length], shape (dim,).
        """
        ...

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """Projects points on facets, shape (n, dim), with the facets' normals, onto the boundary.

        Returns the projections [length], shape (n, dim), and the ratio of the area on the boundary
        to that on the facet, shape (n,).
        """
        ...


@runtime_checkable
class RoundGeometry(Geometry, Protocol):
    """A geometry with a radius [length], which may change with time; it has no edge."""

    radius: float

    def radial(self, x: Floats) -> Floats:
        """Returns the vectors from the centre or axis to points [length], shape (n, dim)."""
        ...
