# SPDX-License-Identifier: BSD-3-Clause
"""Clay around a vertical drain, by series and by Barron (1948); time as in `consolidation`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq
from scipy.special import jv, yv

from tilth.arrays import Floats
from tilth_verification.closed_forms.consolidation import decay

TERMS = 200
"""Terms of the series."""


@dataclass(frozen=True)
class RadialDrain:
    """A ring of clay drained at its inner wall, sealed at its outer one, loaded at once.

    Incompressible water. Lengths are over the radius of the drain, times over 4 r_e^2 / c,
    c = kappa M, pressures over the load q. A rigid smooth plate presses the ring and both of its
    walls are held, so that the radial equilibrium M e' = p' and the plate's p - M e = q in the mean
    give p - M e = q everywhere (e: expansion), and e_t = kappa (lap p) is diffusion of p from the
    start q, whatever Poisson's ratio: what Barron (1948) calls free strain. With

        f(r) = J_0(a r) Y_0(a) - Y_0(a r) J_0(a),      f'(n) = 0,

    p is the sum of A f(r) exp(-4 n^2 a^2 T); the f are orthogonal with the weight r.

    ratio: n, radius of the outer wall over that of the drain, > 1.
    """

    ratio: float

    def pressure(self, radius: float, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the pressure at a distance from the axis; others: see `decay`."""
        root, amplitude, _ = self._terms
        return float((amplitude * _shape(0, root, radius)) @ self._decay(time, steps))

    def degree(self, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the degree of consolidation U [-], the settlement over the final one."""
        _, amplitude, mean = self._terms
        return 1.0 - float((amplitude * mean) @ self._decay(time, steps))

    def equal_strain(self, time: float) -> float:
        """Returns U by Barron's equal strain [-].

        He makes each ring of soil settle by the same at every time, and its water flow to the drain
        radially, as though soil moved along the vertical only.
        """
        return float(-np.expm1(-8.0 * time / self.resistance))

    @property
    def resistance(self) -> float:
        """Barron's mu [-], by which the time of equal strain is divided."""
        n = self.ratio
        return float(n**2 / (n**2 - 1.0) * np.log(n) - (3.0 * n**2 - 1.0) / (4.0 * n**2))

    def _decay(self, time: float, steps: Sequence[float]) -> Floats:
        return decay(4.0 * (self.ratio * self._terms[0]) ** 2, time, steps)

    @cached_property
    def _terms(self) -> tuple[Floats, Floats, Floats]:
        """Roots a, amplitudes A and means of f over the ring, shape (n,) each."""
        n = self.ratio

        def slope(a: float) -> float:
            return float(_shape(1, np.array(a), n))

        place = np.arange(0.02, np.pi * (TERMS + 1), 0.02) / (n - 1.0)
        sign = np.sign(_shape(1, place, n))
        where = np.flatnonzero(sign[1:] != sign[:-1])[:TERMS]
        root = np.array([brentq(slope, place[i], place[i + 1], xtol=1e-14) for i in where])
        # the integrals of f r and f^2 r; by the Wronskian a f'(1) = -2 / pi
        whole = -2.0 / (np.pi * root**2)
        squared = 0.5 * (n * _shape(0, root, n)) ** 2 - 2.0 / (np.pi * root) ** 2
        return root, whole / squared, 2.0 * whole / (n**2 - 1.0)


def _shape(order: int, a: Floats, radius: float) -> Floats:
    """Returns f (order 0) or -f'/a (order 1) at a distance from the axis."""
    value = jv(order, a * radius) * yv(0, a) - yv(order, a * radius) * jv(0, a)
    return np.asarray(value)
