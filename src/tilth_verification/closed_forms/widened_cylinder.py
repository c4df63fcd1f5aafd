# SPDX-License-Identifier: BSD-3-Clause
"""Thick cylinder of Hencky material at large widening."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.model import HenckyElastic
from tilth_verification.closed_forms.moduli import Moduli


@dataclass(frozen=True)
class WidenedCylinder:
    """Long cylinder, no axial strain, inner face displaced outwards by any amount, outer face free.

    With r(R) the radius of what was at R, stretches r' and r / R, and Kirchhoff stress
    tau = lambda tr(eps) + 2 mu eps of the logarithmic strain, the radial nominal stress is
    P = tau_rr / r' and equilibrium reads dP/dR + (P - tau_hoop R / r) / R = 0, with
    r(a) = a + u_a and P(b) = 0. Solved as a boundary value problem to 1e-9 by collocation.

    Attributes:
        inner_radius, outer_radius: initial [length].
        displacement: of the inner face, outwards [length], > 0.
        material: its density is not used.
    """

    inner_radius: float
    outer_radius: float
    displacement: float
    material: HenckyElastic

    @property
    def pressure(self) -> float:
        """Pressure on the inner face [stress], Cauchy, positive outwards."""
        a = self.inner_radius
        radius, nominal = self._solution(np.array([a]))
        return float(-nominal[0] * self.material.young_modulus * a / radius[0])

    @property
    def outer_displacement(self) -> float:
        """Displacement of the outer face [length]."""
        return float(self.radial_displacement(np.array([self.outer_radius]))[0])

    def radial_displacement(self, radius: npt.ArrayLike) -> Floats:
        """Returns the displacement of what was at these radii [length], of their shape."""
        at = np.asarray(radius, dtype=float)
        return np.asarray(self._solution(at)[0] - at)

    @cached_property
    def _solution(self) -> Callable[[Floats], Floats]:
        from scipy.integrate import solve_bvp

        a, b = self.inner_radius, self.outer_radius
        at = np.linspace(a, b, 50)
        state = np.stack([at, np.zeros_like(at)])
        parts = math.ceil(8.0 * abs(self.displacement) / a)
        for part in range(parts):
            inner = a + (part + 1) / parts * self.displacement

            def ends(left: Floats, right: Floats, inner: float = inner) -> Floats:
                return np.array([left[0] - inner, right[1]])

            solution = solve_bvp(self._slope, ends, at, state, tol=1e-9, max_nodes=20000)
            assert solution.success, solution.message
            at, state = solution.x, solution.y
        return solution.sol  # type: ignore[no-any-return]

    def _slope(self, at: Floats, state: Floats) -> Floats:
        moduli = Moduli.of(self.material)
        unit = self.material.young_modulus
        hoop = np.log(state[0] / at)
        nominal = state[1] * unit
        radial = np.zeros_like(hoop)  # logarithmic strain, from tau_rr = P exp(radial) by Newton
        for _ in range(50):
            tau = moduli.lame * (radial + hoop) + 2.0 * moduli.shear * radial
            slope = moduli.lame + 2.0 * moduli.shear - nominal * np.exp(radial)
            correction = (nominal * np.exp(radial) - tau) / slope
            radial = radial + correction
            if np.abs(correction).max() < 1e-14:
                break
        tau_hoop = moduli.lame * (radial + hoop) + 2.0 * moduli.shear * hoop
        nominal_slope = -(nominal - tau_hoop * at / state[0]) / at
        return np.stack([np.exp(radial), nominal_slope / unit])
