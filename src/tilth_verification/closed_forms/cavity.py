# SPDX-License-Identifier: BSD-3-Clause
"""Cavities in clay and in frictional soil, enlarged by any amount."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tilth.arrays import Floats
from tilth.model import MohrCoulomb, Tresca
from tilth_verification.closed_forms.moduli import Moduli


@dataclass(frozen=True)
class CavityInClay:
    """Cavity in unbounded incompressible Tresca clay of logarithmic elasticity.

    m is 1 for a cylinder without axial strain and 2 for a sphere, n = m + 1. As volume is kept,
    t = 1 - (R / r)^n = k / r^n with k = a^n - a0^n, where r is the radius of what was at R. The
    hoop strain is -ln(1 - t) / n, so that hoop and radial stress differ by -2 G ln(1 - t), in the
    plastic part, t > t_p = 1 - exp(-s_u / G), by 2 s_u. Equilibrium, dp = m (difference) dr / r
    with dr / r = -dt / (n t), gives

        p = (2 m / n) [s_u ln((1 - (a0 / a)^n) / t_p) + G Li2(t_p)],

    with the dilogarithm Li2(t) = -int_0^t ln(1 - x) / x dx. For a >> a0 and G >> s_u it is the
    limit pressure (2 m / n) s_u (1 + ln(G / s_u)) (R. Hill, The Mathematical Theory of Plasticity,
    chapter V.2).
    """

    is_sphere: bool
    shear_modulus: float
    strength: float

    @property
    def limit_pressure(self) -> float:
        """Pressure of an infinite expansion, s_u much smaller than G [stress]."""
        rigidity = self.shear_modulus / self.strength
        return self._factor * self.strength * (1.0 + math.log(rigidity))

    def pressure(self, radius_ratio: float) -> float:
        """Returns the pressure [stress] at a / a0, once the wall has yielded."""
        from scipy.special import spence

        yielding = -math.expm1(-self.strength / self.shear_modulus)
        wall = 1.0 - radius_ratio ** (-self._power)
        assert wall >= yielding
        plastic = self.strength * math.log(wall / yielding)
        elastic = self.shear_modulus * float(spence(1.0 - yielding))
        return self._factor * (plastic + elastic)

    @property
    def _power(self) -> int:
        return 3 if self.is_sphere else 2

    @property
    def _factor(self) -> float:
        return 2.0 * (self._power - 1) / self._power


@dataclass(frozen=True)
class CylinderInSoil:
    """Long cylindrical cavity in Mohr-Coulomb soil or Tresca clay, no axial strain, by integration.

    The soil, radii a0 < b0 at the start, has an isotropic pressure p0 at first, which remains on
    the outer face; the inner one is moved to a. r(R) is the radius of what was at R, and the radial
    nominal stress is P = tau_rr / r'. Equilibrium is dP/dR + (P - tau_hoop R / r) / R = 0.

    The directions of the stress are fixed, and the hoop stress is the largest, the radial one the
    smallest. So plastic strains have a constant direction, (1 + sin psi) of hoop to -(1 - sin psi)
    of radial strain, and the stress is that of a single return of the whole logarithmic strain to
    tau_hoop (1 + sin phi) - tau_rr (1 - sin phi) = 2 c cos phi. The two equations of first order
    are integrated inwards to a relative 1e-10, from the outer displacement for which r(a0) = a.

    Attributes:
        inner_radius, outer_radius: initial [length].
        pressure_at_rest: p0, compression positive [stress].
        soil: without softening and tension cut-off.
    """

    inner_radius: float
    outer_radius: float
    pressure_at_rest: float
    soil: MohrCoulomb | Tresca

    def pressure(self, radius: float) -> float:
        """Returns the pressure on the wall, Cauchy [stress], at its radius a > a0 [length]."""
        from scipy.optimize import brentq

        inner, outer = self.inner_radius, self.outer_radius
        kept = (radius**2 - inner**2) / (2.0 * outer)  # displacement without change of volume

        def excess(outward: float) -> float:
            return self._inwards(outward)[0] - radius

        outward = brentq(excess, 1e-3 * kept, 10.0 * kept, xtol=1e-13 * kept, rtol=1e-12)
        place, nominal = self._inwards(outward)
        return -nominal * inner / place

    def _inwards(self, outward: float) -> tuple[float, float]:
        """Position and radial nominal stress of the wall, by the outer displacement [length]."""
        from scipy.integrate import solve_ivp

        outer = self.outer_radius
        nominal = -self.pressure_at_rest * (outer + outward) / outer
        path = solve_ivp(
            self._slope,
            (outer, self.inner_radius),
            [outer + outward, nominal],
            method="DOP853",
            rtol=1e-10,
            atol=1e-10 * np.array([self.inner_radius, self._moduli.shear]),
        )
        assert path.success, path.message
        return float(path.y[0, -1]), float(path.y[1, -1])

    def _slope(self, at: float, state: Floats) -> tuple[float, float]:
        place, nominal = state
        hoop = math.log(place / at)
        radial = -hoop
        for _ in range(50):  # Newton's method for tau_rr = P exp(radial)
            tau_radial, tau_hoop, slope = self._stress(radial, hoop)
            stretch = math.exp(radial)
            correction = (nominal * stretch - tau_radial) / (slope - nominal * stretch)
            radial += correction
            if abs(correction) < 1e-14:
                break
        tau_radial, tau_hoop, _ = self._stress(radial, hoop)
        return math.exp(radial), -(nominal - tau_hoop * at / place) / at

    def _stress(self, radial: float, hoop: float) -> tuple[float, float, float]:
        """Radial and hoop Kirchhoff stress, and the derivative of the former by its strain."""
        lame, double_shear = self._moduli.lame, 2.0 * self._moduli.shear
        sin_phi, sin_psi, strength = self._strength
        volume = lame * (radial + hoop) - self.pressure_at_rest
        tau_radial, tau_hoop = volume + double_shear * radial, volume + double_shear * hoop
        slope = lame + double_shear
        excess = (1.0 + sin_phi) * tau_hoop - (1.0 - sin_phi) * tau_radial - strength
        if excess <= 0.0:
            return tau_radial, tau_hoop, slope
        per_radial = 2.0 * lame * sin_psi - double_shear * (1.0 - sin_psi)
        per_hoop = 2.0 * lame * sin_psi + double_shear * (1.0 + sin_psi)
        hardening = (1.0 + sin_phi) * per_hoop - (1.0 - sin_phi) * per_radial
        flow = excess / hardening
        excess_slope = (1.0 + sin_phi) * lame - (1.0 - sin_phi) * slope
        slope -= per_radial * excess_slope / hardening
        return tau_radial - flow * per_radial, tau_hoop - flow * per_hoop, slope

    @cached_property
    def _moduli(self) -> Moduli:
        return Moduli.of(self.soil)

    @cached_property
    def _strength(self) -> tuple[float, float, float]:
        """sin phi, sin psi and 2 c cos phi."""
        if isinstance(self.soil, Tresca):
            return 0.0, 0.0, 2.0 * self.soil.undrained_shear_strength
        phi, psi = math.radians(self.soil.friction_angle), math.radians(self.soil.dilation_angle)
        return math.sin(phi), math.sin(psi), 2.0 * self.soil.cohesion * math.cos(phi)
