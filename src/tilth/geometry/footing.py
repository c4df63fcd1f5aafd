# SPDX-License-Identifier: BSD-3-Clause
"""A finite flat patch with edges: a footing, a platen, a blade."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.geometry.flat import (
    Flat,
    left_normal,
    perpendicular,
    split_rectangle,
    split_segments,
    unit,
)
from tilth.geometry.protocol import Facets


class Footing(Flat):
    """Segment (2D) or rectangle (3D) around `centre` with `normal` into the soil.

    Args:
        centre: [length], shape (dim,).
        normal: shape (dim,), of any length.
        widths: edge lengths [length], shape (dim - 1,).
        along: in 3D the direction of the first width, made perpendicular to the normal; a
            direction at right angles to it if None.
    """

    bounded = True

    def __init__(
        self, centre: Floats, normal: Floats, widths: Floats, along: Floats | None = None
    ) -> None:
        self.centre = np.asarray(centre, dtype=float)
        self.normal = unit(np.asarray(normal, dtype=float))
        self.half = 0.5 * np.asarray(widths, dtype=float)
        self.dim = len(self.centre)
        if self.dim == 2:
            self._axes = -left_normal(self.normal[None, :])
        else:
            first = perpendicular(self.normal)
            if along is not None:
                given = np.asarray(along, dtype=float)
                first = unit(given - (given @ self.normal) * self.normal)
            self._axes = np.stack([first, np.cross(self.normal, first)])

    def _to_nearest(self, x: Floats) -> tuple[Floats, Floats, Flags]:
        """Vectors from the nearest places on the patch, and heights above its plane.

        Also whether a place is beside the patch, (n,): its nearest place is then on an edge.
        """
        arm = x - self.centre
        along = arm @ self._axes.T
        nearest = np.clip(along, -self.half, self.half)
        beside = (np.abs(along) > self.half).any(axis=1)
        return arm - nearest @ self._axes, arm @ self.normal, beside

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`; the sign is that of the side of the patch's plane."""
        arm, height, _ = self._to_nearest(x)
        return np.asarray(np.where(height < 0.0, -1.0, 1.0) * np.linalg.norm(arm, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; over the patch and on its edges its normal."""
        arm, height, beside = self._to_nearest(x)
        length = np.linalg.norm(arm, axis=1)
        # Over the patch the normal is exact, where the arm on it is only round-off. Far from the
        # origin the round-off at the edges is larger.
        reach = float(np.abs(self.centre).max() + self.half.max())
        beside &= length > 16.0 * float(np.finfo(float).eps) * reach
        away = np.where(height < 0.0, -1.0, 1.0)[:, None] * arm
        away = away / np.where(beside, length, 1.0)[:, None]
        return np.where(beside[:, None], away, self.normal)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        edges = 2.0 * self.half[:, None] * self._axes
        start = self.centre - 0.5 * edges.sum(axis=0)
        if self.dim == 2:
            corner, _ = split_segments(start[None], start[None] + edges, size)
        else:
            corner = split_rectangle(start, edges[0], edges[1], size)
        normal = np.tile(self.normal, (len(corner), 1))
        return Facets(corner, normal, np.arange(len(corner)))
