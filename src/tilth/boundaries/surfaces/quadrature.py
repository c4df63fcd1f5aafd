# SPDX-License-Identifier: BSD-3-Clause
"""The Dirichlet function of an implicit boundary, and the quadrature of its surface or band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.geometry.protocol import QuadraturePoints
from tilth.geometry.quadrature import SEGMENT_RULE


def dirichlet_function(s: Floats) -> tuple[Floats, Floats]:
    """Returns d = 1 - (1 - s)^2 and its derivative by s [-], shape (n,) each.

    s: distance from the boundary over the width of the band [-], 0 to 1, shape (n,). It is 0 on
    the boundary, and 1 with zero slope at the other side of the band (Kumar et al. 2008).
    """
    return 1.0 - (1.0 - s) ** 2, 2.0 * (1.0 - s)


@dataclass(frozen=True)
class BoundaryQuadrature:
    """The n quadrature points of a boundary's surface or band in the reference configuration.

    d is the Dirichlet function (`dirichlet_function`) and d' its derivative by the distance.

    Attributes:
        reference: positions [length], shape (n, dim).
        normal: unit, into the soil, shape (n, dim).
        weight: area [length^(dim - 1)], or volume of the band [length^dim], shape (n,).
        surface: the m quadrature points of the surface [length], shape (m, dim).
        surface_normal: their normals, shape (m, dim).
        tributary: their tributary parts of the surface [length], see `QuadraturePoints`.
        on_surface: the surface point to which each point belongs, shape (n,).
        d: Dirichlet function [-], shape (n,).
        d_prime: its derivative [1/length], shape (n,); 0 omits K2.
        square: the factor of K3 [1/length^2], or [1/length] on the surface, shape (n,).
        group: see `QuadraturePoints`, shape (n,).
    """

    reference: Floats
    normal: Floats
    weight: Floats
    surface: Floats
    surface_normal: Floats
    tributary: Floats
    on_surface: Integers
    d: Floats
    d_prime: Floats
    square: Floats
    group: Integers


def surface_quadrature(points: QuadraturePoints, delta: float) -> BoundaryQuadrature:
    """Returns the quadrature of a narrow band: K3 alone, the integral of d'^2 is 4 / (3 delta)."""
    n = len(points.weight)
    return BoundaryQuadrature(
        reference=points.position,
        normal=points.normal,
        weight=points.weight,
        surface=points.position,
        surface_normal=points.normal,
        tributary=points.tributary,
        on_surface=np.arange(n),
        d=np.zeros(n),
        d_prime=np.zeros(n),
        square=np.full(n, 4.0 / (3.0 * delta)),
        group=points.group,
    )


def band_quadrature(points: QuadraturePoints, delta: float) -> BoundaryQuadrature:
    """Returns the quadrature for K1, K2 and K3, with three Gauss points across the band."""
    n = len(points.weight)
    share, weight = SEGMENT_RULE
    surface = np.repeat(np.arange(n), len(share))
    s = np.tile(share, n)
    d, derivative = dirichlet_function(s)
    d_prime = derivative / delta
    normal = points.normal[surface]
    return BoundaryQuadrature(
        reference=points.position[surface] + (delta * s)[:, None] * normal,
        normal=normal,
        weight=points.weight[surface] * delta * np.tile(weight, n),
        surface=points.position,
        surface_normal=points.normal,
        tributary=points.tributary,
        on_surface=surface,
        d=d,
        d_prime=d_prime,
        square=d_prime**2,
        group=points.group[surface],
    )
