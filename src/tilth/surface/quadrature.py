# SPDX-License-Identifier: BSD-3-Clause
"""Quadrature points on a body's surface, a curve in the plane or triangles in space."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from tilth.arrays import Floats, Integers


@dataclass(frozen=True)
class SurfaceQuadrature:
    """n quadrature points of a surface at the start of a load step.

    The edges at a point span the piece of surface that it stands for: one edge along a curve, with
    the soil on its left; two in space, whose cross product is the area times the normal into the
    soil. They hold the weight.

    Attributes:
        position: [length], shape (n, dim).
        edges: [length], shape (n, dim - 1, dim).
        initial_position, initial_edges: the same at time 0.
        patch: number of the segment or triangle, shape (n,).
        arc_length: at time 0 from the chain's first point [length], shape (n,); 0 in 3D.
    """

    position: Floats
    edges: Floats
    initial_position: Floats
    initial_edges: Floats
    patch: Integers
    arc_length: Floats

    @classmethod
    def joined(cls, parts: list[SurfaceQuadrature], patches: list[int]) -> SurfaceQuadrature:
        """Returns the points of several parts; their patches are counted on from part to part."""
        arrays = {
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(cls)
        }
        first = np.repeat(np.cumsum([0, *patches[:-1]]), [len(part.patch) for part in parts])
        return cls(**{**arrays, "patch": arrays["patch"] + first})

    def ordered(self, order: Integers) -> SurfaceQuadrature:
        """Returns the points in another order."""
        return SurfaceQuadrature(
            **{field.name: getattr(self, field.name)[order] for field in fields(self)}
        )


def area_vector(edges: Floats) -> Floats:
    """Returns area times normal into the soil [length^(dim-1)] of edges (n, dim - 1, dim)."""
    if edges.shape[1] == 1:
        return np.stack([-edges[:, 0, 1], edges[:, 0, 0]], axis=1)
    return np.asarray(np.cross(edges[:, 0], edges[:, 1]))


def area_derivative(edges: Floats) -> Floats:
    """Returns the derivative of `area_vector` by the edges, shape (n, dim - 1, dim, dim).

    Entry [n, e, i, k] is that of component i by component k of edge e.
    """
    if edges.shape[1] == 1:
        return np.broadcast_to([[[0.0, -1.0], [1.0, 0.0]]], (len(edges), 1, 2, 2))
    return np.stack([-_cross_matrix(edges[:, 1]), _cross_matrix(edges[:, 0])], axis=1)


def _cross_matrix(a: Floats) -> Floats:
    """Matrices of b -> a x b, shape (n, 3, 3)."""
    x, y, z = a.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
