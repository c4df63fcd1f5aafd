# SPDX-License-Identifier: BSD-3-Clause
"""The thick cylinder at small strain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.model import HenckyElastic
from tilth_verification.closed_forms.moduli import Moduli


@dataclass(frozen=True)
class ThickCylinder:
    """Long cylinder, no axial strain, its inner face displaced outwards, its outer face free.

    inner_radius a < outer_radius b; displacement u_a << a of the inner face [length].

    Lame's solution of small-strain elasticity: u = A r + B / r, hence
    sigma_rr = 2 (lambda + mu) A - 2 mu B / r^2 and sigma_hoop = 2 (lambda + mu) A + 2 mu B / r^2.
    The free face gives (lambda + mu) A = mu B / b^2, that is A = (1 - 2 nu) B / b^2, and
    u(a) = u_a gives B = u_a / (1 / a + (1 - 2 nu) a / b^2).
    Timoshenko and Goodier, Theory of Elasticity, article 28, in displacements.
    """

    inner_radius: float
    outer_radius: float
    displacement: float
    material: HenckyElastic

    @property
    def pressure(self) -> float:
        """Pressure on the inner face [stress], positive outwards, -sigma_rr(a)."""
        return -float(self.stress(self.inner_radius)[0])

    def radial_displacement(self, radius: npt.ArrayLike) -> Floats:
        """Returns u [length] at the initial radii `radius`."""
        r = np.asarray(radius, dtype=float)
        linear, inverse = self._coefficients()
        return linear * r + inverse / r

    def stress(self, radius: npt.ArrayLike) -> Floats:
        """Returns radial, axial and hoop stress (xx, yy, zz) [stress], shape (..., 3)."""
        r = np.asarray(radius, dtype=float)
        linear, inverse = self._coefficients()
        moduli = Moduli.of(self.material)
        mean = np.full_like(r, 2.0 * (moduli.lame + moduli.shear) * linear)
        difference = 2.0 * moduli.shear * inverse / r**2
        axial = np.full_like(r, 2.0 * moduli.lame * linear)
        return np.stack([mean - difference, axial, mean + difference], axis=-1)

    def _coefficients(self) -> tuple[float, float]:
        a, b = self.inner_radius, self.outer_radius
        ratio = (1.0 - 2.0 * self.material.poisson_ratio) / b**2
        inverse = self.displacement / (1.0 / a + ratio * a)
        return ratio * inverse, inverse
