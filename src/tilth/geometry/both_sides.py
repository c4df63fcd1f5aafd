# SPDX-License-Identifier: BSD-3-Clause
"""A thin plate or skirt: a surface with soil on both sides."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.flat import Flat, join
from tilth.geometry.protocol import Facets, Geometry


class BothSides(Flat):
    """Both sides of an open or closed surface whose facets are exact.

    Its distance is nowhere negative. Its quadrature points come in pairs, one for each side.
    """

    bounded = True

    def __init__(self, side: Geometry) -> None:
        self.dim = side.dim
        self._side = side

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`: that to the surface, >= 0."""
        return np.abs(self._side.distance(x))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`: away from the surface; on it the normal of the first side."""
        sign = np.where(self._side.distance(x) < 0.0, -1.0, 1.0)
        return np.asarray(sign[:, None] * self._side.gradient(x))

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: those of the first side, then the same ones turned over."""
        first = self._side.facets(lower, upper, size)
        corner = first.corner[:, ::-1] if self.dim == 2 else first.corner[:, [0, 2, 1]]
        return join([first, Facets(corner, -first.normal, first.group)])
