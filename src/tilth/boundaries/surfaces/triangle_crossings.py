# SPDX-License-Identifier: BSD-3-Clause
"""Crossings of lines with the triangles of a tracked surface in space."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.boundaries.surfaces.crossings import (
    LINES_PER_BATCH,
    AlongLines,
    Window,
    candidate_pairs,
    joined,
    summarised,
)
from tilth.errors import BadInput
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.surface.triangles import Triangles

EDGE_TOLERANCE = 1e-9
"""A line this far outside of a triangle, in barycentric coordinates, still crosses it."""


class TriangleSurface:
    """The triangles of one body, see `SoilSurface`."""

    def __init__(self, triangles: Triangles) -> None:
        self._triangles = triangles
        self._corner = triangles.corner
        self._centre = self._corner.mean(axis=1)
        self._radius = np.linalg.norm(self._corner - self._centre[:, None], axis=2).max(axis=1)
        self._tangent, self._normal = triangles.tangent, triangles.normal

    def cross(self, position: Floats, normal: Floats, window: Window) -> AlongLines:
        """As `SoilSurface.cross`."""
        parts = []
        for begin in range(0, len(position), LINES_PER_BATCH):
            own = slice(begin, begin + LINES_PER_BATCH)
            parts.append(self._cross(position[own], normal[own], window.of(own)))
        return joined(parts)

    def _cross(self, position: Floats, normal: Floats, window: Window) -> AlongLines:
        line, number = candidate_pairs(self._centre, self._radius, position, normal, window)
        # Cramer's rule for x + s n = first corner + u first edge + v second edge
        first, second = self._tangent[number, 0], self._tangent[number, 1]
        offset, direction = position[line] - self._corner[number, 0], normal[line]
        area = np.cross(first, second)
        volume = (direction * area).sum(axis=1)
        size = np.linalg.norm(area, axis=1)
        oblique = np.abs(volume) > 1e-12 * size
        volume = np.where(oblique, volume, 1.0)
        turned = np.cross(direction, offset)
        u = (turned * second).sum(axis=1) / volume
        v = -(turned * first).sum(axis=1) / volume
        at = -(offset * area).sum(axis=1) / volume
        hit = oblique & (u >= -EDGE_TOLERANCE) & (v >= -EDGE_TOLERANCE)
        hit &= u + v <= 1.0 + EDGE_TOLERANCE
        return summarised(len(position), line[hit], at[hit], np.sign(volume[hit]), window)

    def contains(self, position: Floats) -> Flags | None:
        """As `SoilSurface.contains`: by the signed distance from a closed surface."""
        corner = self._corner.reshape(-1, 3)
        inside = ((position >= corner.min(axis=0)) & (position <= corner.max(axis=0))).all(axis=1)
        if inside.any():
            try:
                mesh = TriangleMesh(self._corner, inside=True)
            except BadInput:  # it is not closed, or encloses nothing
                return None
            inside[inside] = mesh.distance(position[inside]) > 0.0
        return np.asarray(inside)
