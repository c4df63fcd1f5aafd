# SPDX-License-Identifier: BSD-3-Clause
"""A finite segment (2D) or rectangle (3D) with edges: a footing, a platen, a blade."""

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
    """Segment (2D) or rectangle (3D) centred at `centre`, with `normal` into the soil.

    Args:
        centre: [length], shape (dim,).
        normal: shape (dim,), of any length.
        widths: edge lengths [length], shape (dim - 1,).
        along: in 3D the direction of the first width, made perpendicular to the normal; any
            perpendicular direction if None.

    Attributes:
        centre, normal: as given, the normal of unit length.
        half: half the widths [length], shape (dim - 1,).
        axes: unit vectors along the widths as rows, shape (dim - 1, dim).
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
            self.axes = -left_normal(self.normal[None, :])
        else:
            first = perpendicular(self.normal)
            if along is not None:
                given = np.asarray(along, dtype=float)
                first = unit(given - (given @ self.normal) * self.normal)
            self.axes = np.stack([first, np.cross(self.normal, first)])

    def _to_nearest(self, x: Floats) -> tuple[Floats, Floats, Flags]:
        """Returns vectors from the nearest points of the footing, and heights above its plane.

        The third result is whether the nearest point lies on an edge, shape (n,).
        """
        offset = x - self.centre
        along = offset @ self.axes.T
        nearest = np.clip(along, -self.half, self.half)
        on_edge = (np.abs(along) > self.half).any(axis=1)
        return offset - nearest @ self.axes, offset @ self.normal, on_edge

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`; the sign is that of the side of the footing's plane."""
        offset, height, _ = self._to_nearest(x)
        return np.asarray(np.where(height < 0.0, -1.0, 1.0) * np.linalg.norm(offset, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; over the footing and on its edges its normal."""
        offset, height, on_edge = self._to_nearest(x)
        length = np.linalg.norm(offset, axis=1)
        # Over the footing the normal is exact, whereas the vector from a point on it is round-off.
        # Round-off at the edges grows with the coordinates.
        greatest = float(np.abs(self.centre).max() + self.half.max())
        on_edge &= length > 16.0 * float(np.finfo(float).eps) * greatest
        direction = np.where(height < 0.0, -1.0, 1.0)[:, None] * offset
        direction = direction / np.where(on_edge, length, 1.0)[:, None]
        return np.where(on_edge[:, None], direction, self.normal)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        edges = 2.0 * self.half[:, None] * self.axes
        start = self.centre - 0.5 * edges.sum(axis=0)
        if self.dim == 2:
            corner, _ = split_segments(start[None], start[None] + edges, size)
        else:
            corner = split_rectangle(start, edges[0], edges[1], size)
        normal = np.tile(self.normal, (len(corner), 1))
        return Facets(corner, normal, np.arange(len(corner)))
