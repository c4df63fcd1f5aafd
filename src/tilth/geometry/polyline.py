# SPDX-License-Identifier: BSD-3-Clause
"""Polyline: straight segments from vertex to vertex (2D)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.geometry.flat import Flat, left_normal, split_segments, unit
from tilth.geometry.protocol import Facets


class Polyline(Flat):
    """Open or closed chain of segments with the soil on its left or right.

    Args:
        vertices: [length], shape (n, 2); the last is joined to the first if `closed`.
        closed: whether the polyline is closed.
        left: whether the soil is on the left, seen along the vertices.
    """

    dim = 2
    bounded = True

    def __init__(self, vertices: Floats, closed: bool, left: bool) -> None:
        vertex = np.asarray(vertices, dtype=float)
        self.start = vertex if closed else vertex[:-1]
        self.end = np.roll(vertex, -1, axis=0) if closed else vertex[1:]
        normal = unit(left_normal(self.end - self.start))
        self.normal = normal if left else -normal
        corners = np.concatenate([self.start, self.end])
        extent, greatest = float(np.ptp(corners, axis=0).max()), float(np.abs(corners).max())
        # Points nearer to a vertex than this are on it; round-off grows with the coordinates.
        self._at_vertex = max(1e-12 * extent, 16.0 * float(np.finfo(float).eps) * greatest)
        before, after = np.roll(self.normal, 1, axis=0), np.roll(self.normal, -1, axis=0)
        self._at_start, self._at_end = before + self.normal, self.normal + after
        if not closed:
            self._at_start[0], self._at_end[-1] = self.normal[0], self.normal[-1]

    def _nearest(self, x: Floats) -> tuple[Floats, Floats, Floats, Flags]:
        """Returns vectors from the nearest points (n, 2), the normals there, and the sides' signs.

        The fourth result is whether the nearest points are vertices, shape (n,).
        """
        edge = self.end - self.start
        offset = x[:, None] - self.start
        parameter = np.clip((offset * edge).sum(axis=2) / (edge**2).sum(axis=1), 0.0, 1.0)
        off = offset - parameter[:, :, None] * edge
        segment = (off**2).sum(axis=2).argmin(axis=1)
        chosen = np.arange(len(x)), segment
        offset, parameter = off[chosen], parameter[chosen]
        # at a vertex the sum of the two normals determines the side
        normal = self.normal[segment].copy()
        normal[parameter <= 0.0] = self._at_start[segment[parameter <= 0.0]]
        normal[parameter >= 1.0] = self._at_end[segment[parameter >= 1.0]]
        sign = np.where((offset * normal).sum(axis=1) < 0.0, -1.0, 1.0)
        return offset, self.normal[segment], sign, (parameter <= 0.0) | (parameter >= 1.0)

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        offset, _, sign, _ = self._nearest(x)
        return np.asarray(sign * np.linalg.norm(offset, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; at a vertex the normal of one segment."""
        offset, normal, sign, at_end = self._nearest(x)
        length = np.linalg.norm(offset, axis=1)
        # Nearest to a segment its normal is exact; the offset of a point on it is round-off only.
        from_vertex = at_end & (length > self._at_vertex)
        direction = sign[:, None] * offset / np.where(from_vertex, length, 1.0)[:, None]
        return np.where(from_vertex[:, None], direction, normal)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        corner, segment = split_segments(self.start, self.end, size)
        return Facets(corner, self.normal[segment], np.arange(len(corner)))
