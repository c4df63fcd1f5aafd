# SPDX-License-Identifier: BSD-3-Clause
"""The thick ring of perfectly plastic material at small strain, up to its limit pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass

from tilth.model import VonMises


@dataclass(frozen=True)
class PlasticRing:
    """Long ring, no axial strain, radii a < b [length], under inner pressure, outer face free.

    The material yields where hoop and radial stress differ by Y = 2 sigma_y / sqrt 3, as von
    Mises's does in plane strain once elastic strains are small compared with plastic ones. Up to
    the radius c of the plastic part (Hill, The Mathematical Theory of Plasticity, chapter V.2)

        p = Y (ln(c / a) + (1 - c^2 / b^2) / 2),    u_b = Y (1 - nu^2) c^2 / (E b),

    where u_b is the displacement of the outer face; c = b gives the limit pressure Y ln(b / a).
    """

    inner_radius: float
    outer_radius: float
    material: VonMises

    @property
    def limit_pressure(self) -> float:
        """Pressure at which the whole ring yields [stress]."""
        return self._strength * math.log(self.outer_radius / self.inner_radius)

    def outer_displacement(self, pressure: float) -> float:
        """Returns the outer face's displacement [length] under a pressure [stress] below the limit.

        Lame's solution where the ring is elastic.
        """
        a, b = self.inner_radius, self.outer_radius
        compliance = (1.0 - self.material.poisson_ratio**2) / self.material.young_modulus
        first_yield = 0.5 * self._strength * (1.0 - a**2 / b**2)
        if pressure <= first_yield:
            return 2.0 * pressure * compliance * b / (b**2 / a**2 - 1.0)
        return self._strength * compliance * self._plastic_radius(pressure) ** 2 / b

    @property
    def _strength(self) -> float:
        return 2.0 / math.sqrt(3.0) * self.material.initial_yield_stress

    def _plastic_radius(self, pressure: float) -> float:
        from scipy.optimize import brentq

        a, b = self.inner_radius, self.outer_radius

        def excess(c: float) -> float:
            sustained = self._strength * (math.log(c / a) + 0.5 * (1.0 - c**2 / b**2))
            return sustained - pressure

        return float(brentq(excess, a, b, xtol=1e-12 * b))
