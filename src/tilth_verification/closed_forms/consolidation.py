# SPDX-License-Identifier: BSD-3-Clause
"""Consolidation at small strain by series, with exact time or with steps of backward Euler.

The problems are linear: each term of a series has an amplitude that decays at its own rate r. After
steps of the sizes h_i it is exp(-r sum h_i), and by backward Euler prod 1 / (1 + r h_i), without
any error of a grid: what an analysis with these steps finds on ever finer grids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from tilth.arrays import Floats

TERMS = 400
"""Terms of the series; their amplitudes have decayed long before at the times of interest."""


def decay(rate: Floats, time: float, steps: Sequence[float] = ()) -> Floats:
    """Returns what is left of amplitudes [-], shape (n,).

    Args:
        rate: at which they decay [1 / time], shape (n,).
        time: that has passed.
        steps: sizes of the steps of backward Euler up to this time; exact if there are none.
    """
    left = np.exp(-rate * time)
    if len(steps):
        left = np.ones_like(rate)
        for size in steps:
            left /= 1.0 + rate * size
    return np.asarray(left)


@dataclass(frozen=True)
class Layer:
    """Soil between two planes.

    height: [length]. conductivity: kappa = k / gamma_w [length^4 / (force time)].
    modulus: M = lambda + 2 mu, drained [stress].
    """

    height: float
    conductivity: float
    modulus: float


@dataclass(frozen=True)
class LayerOnDrain:
    """One layer, drained at its base and sealed at its top, loaded at once (Terzaghi 1923).

    With the storage S = 1/M + n/K_w the pressure p obeys kappa p'' = S p', the load q gives it the
    start q / (M S), and the strain is (q - p) / M. So

        p(z) = q / (M S) sum 2/w sin(w z/H) exp(-w^2 c t / H^2),
        w = (2 m + 1) pi/2,  c = kappa / S,

    z the distance from the drain; the degree of consolidation is 1 - mean p / q.

    layer: the soil. storage: n/K_w of the water in its pores [1 / stress], 0 if incompressible.
    """

    layer: Layer
    storage: float = 0.0

    @property
    def unit(self) -> float:
        """H^2 / c [time]: the time that is 1 without dimension."""
        storage = 1.0 / self.layer.modulus + self.storage
        return self.layer.height**2 * storage / self.layer.conductivity

    @property
    def start(self) -> float:
        """Pressure over the load right after it [-]."""
        return 1.0 / (1.0 + self.layer.modulus * self.storage)

    def pressure(self, distance: float, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the pressure over the load at a distance from the drain; others: see `decay`."""
        root = self._root
        shape = 2.0 / root * np.sin(root * distance / self.layer.height)
        return self.start * float(shape @ decay(root**2 / self.unit, time, steps))

    def settlement(self, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the settlement over the final one [-]."""
        root = self._root
        mean = 2.0 / root**2 @ decay(root**2 / self.unit, time, steps)
        return 1.0 - self.start * float(mean)

    @cached_property
    def _root(self) -> Floats:
        return np.asarray((np.arange(TERMS) + 0.5) * np.pi)


@dataclass(frozen=True)
class TwoLayers:
    """Two layers, drained at the base and sealed at the top, loaded at once.

    Incompressible water. The terms are sin(a z) in the lower layer, a^2 = r / c, and
    B cos(b (H - z)) in the upper one, b^2 = r / c', with the same pressure and flux at the
    interface; they are orthogonal with the weight 1/M. Derived here by separation of variables.
    """

    lower: Layer
    upper: Layer

    @cached_property
    def _terms(self) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        """Roots of the rates, a, b, B and amplitudes, shape (n,) each."""
        low, up = self.lower, self.upper
        slow, slow_up = (
            1.0 / np.sqrt(each.conductivity * each.modulus) for each in (low, up)
        )  # a = slow w, b = slow_up w
        across, across_up = slow * low.height, slow_up * up.height
        flux, flux_up = low.conductivity * slow, up.conductivity * slow_up

        def excess(w: float) -> float:
            left = flux * np.cos(w * across) * np.cos(w * across_up)
            return float(left - flux_up * np.sin(w * across) * np.sin(w * across_up))

        step = 0.02 / (across + across_up)
        place = step * np.arange(1, int(1.05 * np.pi * TERMS / 0.02))
        sign = np.sign([excess(w) for w in place])
        where = np.flatnonzero(sign[1:] != sign[:-1])[:TERMS]
        root = np.array([brentq(excess, place[i], place[i + 1], xtol=1e-15) for i in where])
        a, b = root * slow, root * slow_up
        by_pressure = np.abs(np.cos(b * up.height)) > 0.5
        factor = np.where(
            by_pressure,
            np.sin(a * low.height) / np.where(by_pressure, np.cos(b * up.height), 1.0),
            flux * np.cos(a * low.height)
            / np.where(by_pressure, 1.0, flux_up * np.sin(b * up.height)),
        )  # fmt: skip
        squared = (low.height / 2 - np.sin(2 * a * low.height) / (4 * a)) / low.modulus
        squared += factor**2 * (up.height / 2 + np.sin(2 * b * up.height) / (4 * b)) / up.modulus
        whole = (1.0 - np.cos(a * low.height)) / a / low.modulus
        whole += factor * np.sin(b * up.height) / b / up.modulus
        return root, a, b, factor, whole / squared

    def pressure(self, distance: float, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the pressure over the load at a distance from the drain; others: see `decay`."""
        root, a, b, factor, amplitude = self._terms
        top = self.lower.height + self.upper.height
        inside = distance <= self.lower.height
        shape = np.sin(a * distance) if inside else factor * np.cos(b * (top - distance))
        return float((amplitude * shape) @ decay(root**2, time, steps))

    def settlement(self, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the settlement over the final one [-]."""
        root, a, b, factor, amplitude = self._terms
        low, up = self.lower, self.upper
        whole = (1.0 - np.cos(a * low.height)) / a / low.modulus
        whole += factor * np.sin(b * up.height) / b / up.modulus
        final = low.height / low.modulus + up.height / up.modulus
        return 1.0 - float((amplitude * whole) @ decay(root**2, time, steps)) / final


@dataclass(frozen=True)
class Mandel:
    """A slab between rigid smooth plates, drained at its sides, loaded at once (Mandel 1953).

    Incompressible water, as in Cheng and Detournay (1988), with nu_u = 1/2. Lengths are over the
    half width, times over its square over c = kappa M, pressures over half of the mean stress under
    the plates. With the roots a of tan(a) = (1 - nu) / (1/2 - nu) a

        p(x) = sum 2 sin(a) / (a - sin(a) cos(a)) (cos(a x) - cos(a)) exp(-a^2 T).

    poisson_ratio: nu.
    """

    poisson_ratio: float

    @cached_property
    def _terms(self) -> tuple[Floats, Floats]:
        """The roots and sin(a) / (a - sin(a) cos(a)), shape (n,) each."""
        slope = (1.0 - self.poisson_ratio) / (0.5 - self.poisson_ratio)
        low = np.pi * np.arange(TERMS) + 1e-6
        root = np.array(
            [brentq(lambda a: np.tan(a) - slope * a, x, x + 0.5 * np.pi - 2e-6) for x in low]
        )
        return root, np.sin(root) / (root - np.sin(root) * np.cos(root))

    def strain(self, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the vertical strain times G over the mean stress, compression positive."""
        root, share = self._terms
        sum_ = float((share * np.cos(root)) @ decay(root**2, time, steps))
        return 0.5 * (1.0 - self.poisson_ratio) - 0.5 * sum_

    def pressure(self, x: float, time: float, steps: Sequence[float] = ()) -> float:
        """Returns the pressure at a distance from the middle; others: see `decay`."""
        root, share = self._terms
        shape = np.cos(root * x) - np.cos(root)
        return float((2.0 * share * shape) @ decay(root**2, time, steps))
