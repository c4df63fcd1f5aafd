# SPDX-License-Identifier: BSD-3-Clause
"""An infinite line (2D) or plane (3D)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.flat import Flat, box_corners, pack, perpendicular, unit
from tilth.geometry.protocol import Facets


class Plane(Flat):
    """Line or plane through `point` [length] with `normal` into the soil, shape (dim,) each."""

    bounded = False

    def __init__(self, point: Floats, normal: Floats) -> None:
        self.point = np.asarray(point, dtype=float)
        self.normal = unit(np.asarray(normal, dtype=float))
        self.dim = len(self.point)
        if self.dim == 2:
            self._along = np.array([[-self.normal[1], self.normal[0]]])
        else:
            first = perpendicular(self.normal)
            self._along = np.stack([first, np.cross(self.normal, first)])

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        return np.asarray((x - self.point) @ self.normal)

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`."""
        return np.tile(self.normal, (len(x), 1))

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`, one group per cell of a lattice in the plane."""
        coordinate = (box_corners(lower, upper) - self.point) @ self._along.T / size
        low = np.floor(coordinate.min(axis=0)).astype(np.int64) - 1
        high = np.ceil(coordinate.max(axis=0)).astype(np.int64) + 1
        index = np.meshgrid(*map(np.arange, low, high), indexing="ij")
        lattice = np.stack([i.ravel() for i in index], axis=1)

        def at(shift: tuple[int, ...]) -> Floats:
            return np.asarray(self.point + size * (lattice + np.array(shift)) @ self._along)

        group = pack(*lattice.T)
        if self.dim == 2:
            corner = np.stack([at((0,)), at((1,))], axis=1)
        else:
            a, b, c, d = at((0, 0)), at((1, 0)), at((1, 1)), at((0, 1))
            halves = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
            corner = np.stack(halves, axis=1).reshape(-1, 3, 3)
            group = np.repeat(group, 2)
        return Facets(corner, np.tile(self.normal, (len(corner), 1)), group)
