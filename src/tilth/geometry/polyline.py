# SPDX-License-Identifier: BSD-3-Clause
"""Straight segments from vertex to vertex in the plane (2D)."""

from __future__ import annotations

import numpy as np

from tilth.geometry.flat import Flat, left_normal, split_segments, unit
from tilth.geometry.protocol import Facets, Floats


class Polyline(Flat):
    """Open or closed chain of segments with the soil on its left or right.

    Args:
        vertices: [length], shape (n, 2); the last is joined to the first if `closed`.
        closed: whether it is.
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
        before, after = np.roll(self.normal, 1, axis=0), np.roll(self.normal, -1, axis=0)
        self._at_start, self._at_end = before + self.normal, self.normal + after
        if not closed:
            self._at_start[0], self._at_end[-1] = self.normal[0], self.normal[-1]

    def _nearest(self, x: Floats) -> tuple[Floats, Floats, Floats]:
        """Vectors from the nearest places, the normals there, and the signs of the sides."""
        edge = self.end - self.start
        arm = x[:, None] - self.start
        share = np.clip((arm * edge).sum(axis=2) / (edge**2).sum(axis=1), 0.0, 1.0)
        off = arm - share[:, :, None] * edge
        segment = (off**2).sum(axis=2).argmin(axis=1)
        chosen = np.arange(len(x)), segment
        arm, share = off[chosen], share[chosen]
        # between two segments the bisector of their normals tells the sides apart
        normal = self.normal[segment].copy()
        normal[share <= 0.0] = self._at_start[segment[share <= 0.0]]
        normal[share >= 1.0] = self._at_end[segment[share >= 1.0]]
        sign = np.where((arm * normal).sum(axis=1) < 0.0, -1.0, 1.0)
        return arm, self.normal[segment], sign

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        arm, _, sign = self._nearest(x)
        return np.asarray(sign * np.linalg.norm(arm, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; on the line its normal."""
        arm, normal, sign = self._nearest(x)
        length = np.linalg.norm(arm, axis=1)
        on_line = length < 1e-12 * np.ptp(self.start, axis=0).max()
        direction = sign[:, None] * arm / np.where(on_line, 1.0, length)[:, None]
        return np.where(on_line[:, None], normal, direction)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        corner, segment = split_segments(self.start, self.end, size)
        return Facets(corner, self.normal[segment], np.arange(len(corner)))
