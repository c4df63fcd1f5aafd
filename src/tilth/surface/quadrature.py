# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points on a body's surface, a curve in the plane or triangles in space."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tilth.arrays import Floats, Integers


@dataclass(frozen=True)
class SurfaceQuadrature:
    """n quadrature points of a surface at the start of a load step.

    The edges at a point are tangent vectors of the surface that include the quadrature weight: one
    along a curve, with the soil on its left; two in space, whose cross product is the area times
    the normal into the soil.

    Attributes:
        position: [length], shape (n, dim).
        edges: [length], shape (n, dim - 1, dim).
        initial_position, initial_edges: the same at time 0.
        element: number of the segment or triangle, shape (n,).
        arc_length: initial arc length from the chain's first point [length], shape (n,); 0 in 3D.
    """

    position: Floats
    edges: Floats
    initial_position: Floats
    initial_edges: Floats
    element: Integers
    arc_length: Floats

    @classmethod
    def joined(cls, parts: list[SurfaceQuadrature], elements: list[int]) -> SurfaceQuadrature:
        """Returns the points of several parts; elements are numbered through all parts.

        elements: number of elements of each part.
        """
        arrays = {
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(cls)
        }
        first = np.repeat(np.cumsum([0, *elements[:-1]]), [len(part.element) for part in parts])
        return cls(**{**arrays, "element": arrays["element"] + first})

    def ordered(self, order: Integers) -> SurfaceQuadrature:
        """Returns the points with these row numbers, in this order."""
        return SurfaceQuadrature(
            **{field.name: getattr(self, field.name)[order] for field in fields(self)}
        )


def area_vector(edges: Floats) -> Floats:
    """Returns the area vectors into the soil [length^(dim-1)] of edges, shape (n, dim)."""
    if edges.shape[1] == 1:
        return np.stack([-edges[:, 0, 1], edges[:, 0, 0]], axis=1)
    return np.asarray(np.cross(edges[:, 0], edges[:, 1]))


def area_derivative(edges: Floats) -> Floats:
    """Returns the derivative of `area_vector` with respect to the edges (n, dim - 1, dim).

    Shape (n, dim - 1, dim, dim); entry [n, e, i, k] is the derivative of component i with respect
    to component k of edge e.
    """
    if edges.shape[1] == 1:
        return np.broadcast_to([[[0.0, -1.0], [1.0, 0.0]]], (len(edges), 1, 2, 2))
    return np.stack([-_cross_matrix(edges[:, 1]), _cross_matrix(edges[:, 0])], axis=1)


def _cross_matrix(a: Floats) -> Floats:
    """Returns the matrices of the map b -> a x b, shape (n, 3, 3)."""
    x, y, z = a.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
