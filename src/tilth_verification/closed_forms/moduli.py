# SPDX-License-Identifier: BSD-3-Clause
"""Elastic moduli of an isotropic material."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.model import HenckyElastic, MohrCoulomb, Tresca, VonMises


@dataclass(frozen=True)
class Moduli:
    """Isotropic elastic moduli [stress]: bulk K, shear mu, Lame's first lambda = K - 2 mu / 3."""

    bulk: float
    shear: float

    @classmethod
    def of(cls, material: HenckyElastic | MohrCoulomb | Tresca | VonMises) -> Moduli:
        """Returns K = E / (3 (1 - 2 nu)), mu = E / (2 (1 + nu)) of a declared material."""
        young, poisson = material.young_modulus, material.poisson_ratio
        return cls(young / (3.0 * (1.0 - 2.0 * poisson)), young / (2.0 * (1.0 + poisson)))

    @property
    def lame(self) -> float:
        """Lame's first modulus lambda [stress]."""
        return self.bulk - 2.0 / 3.0 * self.shear

    @property
    def constrained(self) -> float:
        """Stiffness under uniaxial strain, lambda + 2 mu [stress]; E where nu = 0."""
        return self.bulk + 4.0 / 3.0 * self.shear
