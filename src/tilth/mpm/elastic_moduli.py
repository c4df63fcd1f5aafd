# SPDX-License-Identifier: BSD-3-Clause
"""Elastic moduli of material points."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.arrays import Floats


@dataclass(frozen=True)
class ElasticModuli:
    """Tangent elastic moduli of isotropic laws at the points' states.

    Attributes:
        bulk, shear: [stress], shape (n,).
        young: Young's modulus E = 9 K G / (3 K + G) [stress], shape (n,).
    """

    bulk: Floats
    shear: Floats
    young: Floats

    @property
    def constrained(self) -> Floats:
        """Constrained modulus M = K + 4 G / 3 [stress], shape (n,)."""
        return self.bulk + 4.0 / 3.0 * self.shear

    @property
    def poisson(self) -> Floats:
        """Poisson's ratio (3 K - 2 G) / (6 K + 2 G) [-], shape (n,)."""
        return (3.0 * self.bulk - 2.0 * self.shear) / (6.0 * self.bulk + 2.0 * self.shear)
