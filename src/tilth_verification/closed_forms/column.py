# SPDX-License-Identifier: BSD-3-Clause
"""The self-weight column at large strain, elastic or von Mises."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import wrightomega

from tilth.arrays import Floats
from tilth.model import HenckyElastic, VonMises
from tilth_verification.closed_forms.moduli import Moduli


@dataclass(frozen=True)
class SelfWeightColumn:
    """Column on a rigid base between frictionless walls, compressed by its weight.

    height: initial height l0 [length]; gravity: g > 0 [acceleration], downwards.
    material: declared material with its density rho0.

    The strain is uniaxial, so the cross-section is constant, the vertical Cauchy stress equals
    the nominal one, and equilibrium over the initial height Y gives, for any material,
    sigma_yy(Y) = -T(Y), T = rho0 g (l0 - Y). With e = -ln(stretch) >= 0 the Kirchhoff stress is
    tau_yy = -(a + b e), where

    * elastic: a = 0, b = M = lambda + 2 mu (E for nu = 0);
    * von Mises with yield stress Y0 and hardening modulus H, from e_y = Y0 / (2 mu) on: the
      Mises stress q = 2 mu e - 3 mu p = Y0 + H p gives the plastic strain
      p = (2 mu e - Y0) / (3 mu + H), and tau_yy = -(K e + 2 q / 3),
      so that a = 2 mu Y0 / (3 mu + H), b = K + 4 mu H / (3 (3 mu + H)).

    T = (a + b e) exp(e) is solved by e = W(exp(a/b) T / b) - a/b with Lambert's function W, and
    the position of the elevation Y follows from dy = exp(-e) dY and exp(-e) dT = (a + b + b e) de:
    rho0 g y(Y) is the difference, base less elevation, of M (e + e^2/2) on the elastic branch,
    continued by (a + b) e + b e^2/2 on the plastic one.

    The elastic column is that of Coombs and Augarde, AMPLE: A Material Point Learning
    Environment, Adv. Eng. Softw. 139 (2020) 102748; the closed form is derived here.
    """

    height: float
    gravity: float
    material: HenckyElastic | VonMises

    @property
    def base_stress(self) -> float:
        """rho0 g l0 [stress], the greatest vertical stress in magnitude."""
        return self._weight * self.height

    @property
    def final_height(self) -> float:
        """Height of the compressed column [length]."""
        return float(self.position(self.height))

    def vertical_stress(self, elevation: npt.ArrayLike) -> Floats:
        """Returns sigma_yy (Cauchy) [stress], tension positive, at initial heights `elevation`."""
        return -self._load(elevation)

    def lateral_stress(self, elevation: npt.ArrayLike) -> Floats:
        """Returns sigma_xx = sigma_zz (Cauchy) [stress] at initial heights `elevation`."""
        e, moduli = self.compression(elevation), Moduli.of(self.material)
        mises = 2.0 * moduli.shear * e - 3.0 * moduli.shear * self.plastic_strain(elevation)
        return np.asarray(-(moduli.bulk * e - mises / 3.0) * np.exp(e))

    def compression(self, elevation: npt.ArrayLike) -> Floats:
        """Returns the compressive strain e = -ln(stretch) at initial heights `elevation`."""
        load = self._load(elevation)
        log_load = np.log(load, where=load > 0.0, out=np.full_like(load, -np.inf))

        def on_branch(a: float, b: float) -> Floats:
            # wrightomega(x) is W(exp(x)), without the overflow of exp(a/b)
            return np.asarray(wrightomega(log_load - math.log(b) + a / b) - a / b)

        e = on_branch(0.0, Moduli.of(self.material).constrained)
        return np.where(e > self._yield_strain, on_branch(*self._plastic_branch()), e)

    def stretch(self, elevation: npt.ArrayLike) -> Floats:
        """Returns the vertical stretch, current over initial length, at heights `elevation`."""
        return np.exp(-self.compression(elevation))

    def plastic_strain(self, elevation: npt.ArrayLike) -> Floats:
        """Returns the equivalent plastic strain at initial heights `elevation`; zero if elastic."""
        if isinstance(self.material, HenckyElastic):
            return np.zeros_like(self._load(elevation))
        shear, hardening = Moduli.of(self.material).shear, self.material.hardening_modulus
        excess = 2.0 * shear * self.compression(elevation) - self.material.initial_yield_stress
        return np.maximum(excess, 0.0) / (3.0 * shear + hardening)

    def position(self, elevation: npt.ArrayLike) -> Floats:
        """Returns the heights y after compression [length] of initial heights `elevation`."""
        base = self._potential(self.compression(0.0))
        return (base - self._potential(self.compression(elevation))) / self._weight

    def stress_error(self, vertical_stress: Floats, elevation: Floats, volume: Floats) -> float:
        """Returns AMPLE's error: volume-weighted mean |sigma_yy - exact| over the base stress [-].

        vertical_stress, elevation, volume: Cauchy stress, initial height and initial volume of the
        material points, shape (n,) each.
        """
        difference = np.abs(vertical_stress - self.vertical_stress(elevation))
        return float(difference @ volume / (self.base_stress * volume.sum()))

    @property
    def _weight(self) -> float:
        assert self.material.density is not None, "a column under its own weight needs a density"
        return self.material.density * self.gravity

    @property
    def _yield_strain(self) -> float:
        if isinstance(self.material, HenckyElastic):
            return math.inf
        return self.material.initial_yield_stress / (2.0 * Moduli.of(self.material).shear)

    def _plastic_branch(self) -> tuple[float, float]:
        """(a, b) of tau_yy = -(a + b e) beyond yield; the elastic ones if there is no yield."""
        moduli = Moduli.of(self.material)
        if isinstance(self.material, HenckyElastic):
            return 0.0, moduli.constrained
        hardening = self.material.hardening_modulus
        both = 3.0 * moduli.shear + hardening
        a = 2.0 * moduli.shear * self.material.initial_yield_stress / both
        return a, moduli.bulk + 4.0 * moduli.shear * hardening / (3.0 * both)

    def _load(self, elevation: npt.ArrayLike) -> Floats:
        return self._weight * (self.height - np.asarray(elevation, dtype=float))

    def _potential(self, e: Floats) -> Floats:
        """Integral of exp(-e) dT from no load to the compression e."""
        a, b = self._plastic_branch()
        elastic = np.minimum(e, self._yield_strain)
        modulus = Moduli.of(self.material).constrained
        result = modulus * elastic * (1.0 + 0.5 * elastic)
        return result + (e - elastic) * (a + b + 0.5 * b * (e + elastic))
