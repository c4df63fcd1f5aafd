# SPDX-License-Identifier: BSD-3-Clause
"""The elastic self-weight column that stands in water, at large strain."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq
from scipy.special import lambertw

from tilth.arrays import Floats


@dataclass(frozen=True)
class WetColumn:
    """Column on a rigid base between frictionless walls, compressed by its weight in water.

    height: initial height l0 [length]. modulus: M = lambda + 2 mu of Hencky's law [stress].
    dry, wet: unit weights r per initial volume above and below the water [force/length^3], below
    it that with full pores less that of water. level: of the water above the base [length].

    Where the pores stay full, solids and water of the initial volume weigh r_sat V0 and the water
    that leaves them weighs gamma_w (1 - J) V0, while the buoyancy is gamma_w J V0: the difference
    is (r_sat - gamma_w) V0 for any compression. So the vertical effective stress is that of a dry
    column with the weights r of its parts: sigma'_yy = -T, dT/dY = -r. As for `SelfWeightColumn`
    T = M e exp(e) with e = W(T / M), W Lambert's function, and r dy = -d(M (e + e^2 / 2)). The
    material that is at the level has the initial height Y_w for which the column below it is as
    high as the level.
    """

    height: float
    modulus: float
    dry: float
    wet: float
    level: float

    @cached_property
    def wet_height(self) -> float:
        """Initial height Y_w of the material that is at the level [length]."""
        if self.level <= 0.0:
            return 0.0
        if self._height_below(self.height) <= self.level:
            return self.height
        found = brentq(lambda y: self._height_below(y) - self.level, 0.0, self.height, xtol=1e-14)
        return float(found)

    def vertical_stress(self, elevation: npt.ArrayLike) -> Floats:
        """Returns the effective sigma_yy (Cauchy) [stress] at initial heights, tension positive."""
        above = self.height - np.maximum(np.asarray(elevation, dtype=float), self.wet_height)
        below = np.maximum(self.wet_height - np.asarray(elevation, dtype=float), 0.0)
        return np.asarray(-(self.dry * above + self.wet * below))

    @property
    def base_stress(self) -> float:
        """Vertical effective stress at the base, its magnitude [stress]."""
        return float(-self.vertical_stress(0.0))

    @property
    def final_height(self) -> float:
        """Height of the compressed column [length]."""
        load = self.dry * (self.height - self.wet_height)
        return self._height_below(self.wet_height) + self._potential(load) / self.dry

    def _height_below(self, wet_height: float) -> float:
        """Returns the compressed height of the part below an initial height that is in water."""
        load = self.dry * (self.height - wet_height)
        base = load + self.wet * wet_height
        return (self._potential(base) - self._potential(load)) / self.wet

    def _potential(self, load: float) -> float:
        """Returns M (e + e^2 / 2) for a load T."""
        e = float(lambertw(load / self.modulus).real)
        return self.modulus * (e + 0.5 * e * e)
