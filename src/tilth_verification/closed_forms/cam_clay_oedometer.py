# SPDX-License-Identifier: BSD-3-Clause
"""Modified Cam Clay in an oedometer, by its rate equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

from tilth.arrays import Floats
from tilth_verification.closed_forms.material_column import Law

MOST = 0.7
"""Largest strain -ln(l) of the curve [-]."""


@dataclass(frozen=True)
class CamClayOedometer:
    """Normally consolidated clay, compressed from an isotropic stress without lateral strain.

    start: that stress [stress]. slope: M [-]. compression, swelling: slopes lambda and kappa of
    ln(volume) over the logarithm of the mean Kirchhoff stress P [-]. shear_modulus: [stress].

    With the elastic strains e_v and e_s, P = P0 exp(e_v / kappa), Q = 3 mu e_s and the strain
    x = -ln(l), whose deviatoric part is 2 x / 3, yielding f = Q^2/M^2 + P (P - P_c) = 0 goes on
    with the multiplier g of the normal (f_P, f_Q) = (2 P - P_c, 2 Q / M^2):

        e_v' = 1 - g f_P,  e_s' = 2/3 - g f_Q,  P_c' = P_c g f_P / (lambda - kappa),  f' = 0.

    The rate equations are integrated by an explicit method of high order, without a return to the
    yield surface.
    """

    start: float
    slope: float
    compression: float
    swelling: float
    shear_modulus: float

    def curve(self) -> Law:
        """Returns the rise of the axial Cauchy stress over the stretch, compression positive."""
        solution = solve_ivp(
            self._rate, (0.0, MOST), [0.0, 0.0, self.start], "DOP853",
            np.linspace(0.0, MOST, 1401), rtol=1e-10, atol=1e-12,
        )  # fmt: skip
        strain, (elastic, shear, _) = solution.t, solution.y
        axial = self.start * np.exp(elastic / self.swelling) + 2.0 * self.shear_modulus * shear
        spline = CubicSpline(strain, axial * np.exp(strain) - self.start)
        return lambda stretch: np.asarray(spline(-np.log(stretch)))

    def _rate(self, strain: float, state: Floats) -> list[float]:
        elastic, shear, size = state
        mean = self.start * np.exp(elastic / self.swelling)
        bulk, modulus = mean / self.swelling, 3.0 * self.shear_modulus
        f_p, f_q = 2.0 * mean - size, 2.0 * modulus * shear / self.slope**2
        hardening = size / (self.compression - self.swelling)
        resistance = f_p**2 * bulk + f_q**2 * modulus + mean * f_p * hardening
        g = (f_p * bulk + f_q * modulus * 2.0 / 3.0) / resistance
        return [1.0 - g * f_p, 2.0 / 3.0 - g * f_q, hardening * g * f_p]
