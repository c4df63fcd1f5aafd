# SPDX-License-Identifier: BSD-3-Clause
"""A cylinder or a sphere pressed and drained at its rim, by series; time as in `consolidation`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv, spherical_jn

from tilth.arrays import Floats
from tilth_verification.closed_forms.consolidation import decay

TERMS = 100
"""Terms of the series."""


@dataclass(frozen=True)
class PressedBall:
    """A cylinder (de Leeuw 1964) or a sphere (Cryer 1963), loaded at once by a pressure q.

    Incompressible water. Lengths are over the radius, times over its square over c = kappa M,
    pressures over q. The displacement is the final one, proportional to r, less a sum of
    f(a r) exp(-a^2 T), f = J_1 or j_1, which are orthogonal with the weight r^(d-1); with p = 0 and
    no change of the radial stress at the rim the roots are those of

        a g(a) = (d - 1) 2G/M f(a),      g = J_0 or j_0.

    Derived here by separation of variables.

    dim: d, 2 for the cylinder in plane strain, 3 for the sphere. poisson_ratio: nu, drained.
    """

    dim: int
    poisson_ratio: float

    def pressure(self, radius: float, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the pressure at a distance from the centre; others: see `decay`."""
        root, amplitude = self._terms
        shape = self._function(0, root * radius) - self._function(0, root)
        return float((amplitude * shape) @ decay(root**2, time, steps))

    @cached_property
    def _terms(self) -> tuple[Floats, Floats]:
        """Roots and amplitudes of the pressure, shape (n,) each."""
        shear = (1.0 - 2.0 * self.poisson_ratio) / (1.0 - self.poisson_ratio)  # 2G/M

        def excess(a: float) -> float:
            bulge = (self.dim - 1) * shear * self._function(1, np.array(a))
            return float(a * self._function(0, np.array(a)) - bulge)

        place = np.arange(0.05, np.pi * (TERMS + 1), 0.05)
        sign = np.sign([excess(a) for a in place])
        where = np.flatnonzero(sign[1:] != sign[:-1])[:TERMS]
        root = np.array([brentq(excess, place[i], place[i + 1], xtol=1e-14) for i in where])
        final = 1.0 / (1.0 - (self.dim - 1) / self.dim * shear)  # M times the final strain over q
        node, weight = np.polynomial.legendre.leggauss(4 * TERMS)
        r, weight = 0.5 * (node + 1.0), 0.5 * weight
        mode = self._function(1, root[:, None] * r)
        volume = weight * r ** (self.dim - 1)
        amplitude = final / self.dim * (mode @ (volume * r)) / (mode**2 @ volume)
        return root, root * amplitude

    def _function(self, order: int, x: Floats) -> Floats:
        of = jv if self.dim == 2 else spherical_jn
        return np.asarray(of(order, x))
