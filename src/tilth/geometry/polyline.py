# SPDX-License-Identifier: BSD-3-Clause
"""Straight segments from vertex to vertex in the plane (2D)."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.geometry.flat import Flat, left_normal, split_segments, unit
from tilth.geometry.protocol import Facets


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
        corners = np.concatenate([self.start, self.end])
        extent, reach = float(np.ptp(corners, axis=0).max()), float(np.abs(corners).max())
        # Places nearer to a vertex than this are on it; far from the origin round-off is larger.
        self._at_vertex = max(1e-12 * extent, 16.0 * float(np.finfo(float).eps) * reach)
        before, after = np.roll(self.normal, 1, axis=0), np.roll(self.normal, -1, axis=0)
        self._at_start, self._at_end = before + self.normal, self.normal + after
        if not closed:
            self._at_start[0], self._at_end[-1] = self.normal[0], self.normal[-1]

    def _nearest(self, x: Floats) -> tuple[Floats, Floats, Floats, Flags]:
        """Vectors from the nearest places, the normals there, and the signs of the sides.

        Also whether these places are vertices, shape (n,).
        """
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
        return arm, self.normal[segment], sign, (share <= 0.0) | (share >= 1.0)

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        arm, _, sign, _ = self._nearest(x)
        return np.asarray(sign * np.linalg.norm(arm, axis=1))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; at a vertex the normal of one segment."""
        arm, normal, sign, at_end = self._nearest(x)
        length = np.linalg.norm(arm, axis=1)
        # Beside a segment its normal is exact, where the arm on the line is only round-off.
        turned = at_end & (length > self._at_vertex)
        direction = sign[:, None] * arm / np.where(turned, length, 1.0)[:, None]
        return np.where(turned[:, None], direction, normal)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        corner, segment = split_segments(self.start, self.end, size)
        return Facets(corner, self.normal[segment], np.arange(len(corner)))
