# SPDX-License-Identifier: BSD-3-Clause
"""Heave of a layer from which the soil above is removed, in one dimension."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Heave:
    """A Hencky-elastic layer under its own weight and that of soil that is then removed.

    With M the constrained modulus and z the height above the base, the stress at rest is
    M e0 = -gamma (H + R - z) of the undeformed layer. After the removal the layer is stretched by
    s, and its Cauchy stress M (e0 + ln s) / s carries what is left above: -gamma (H - z), for the
    weight of the layer does not change.

    Attributes:
        height, removed: H of the layer and R of the removed soil [length].
        unit_weight: gamma [force/length^3].
        modulus: M [stress].
    """

    height: float
    removed: float
    unit_weight: float
    modulus: float

    def total(self, pieces: int = 2000) -> float:
        """Returns the heave of the layer's top [length]; quadrature by the midpoint rule."""
        above = self.height * (1.0 - (np.arange(pieces) + 0.5) / pieces)
        before = self.unit_weight * (above + self.removed)
        stretch = np.ones(pieces)
        for _ in range(100):  # converges, as the stress is small against the modulus
            stretch = np.exp((before - stretch * self.unit_weight * above) / self.modulus)
        return float((stretch - 1.0).mean() * self.height)
