# SPDX-License-Identifier: BSD-3-Clause
"""Rectangle (2D) or cuboid (3D), with the soil inside or outside."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.flat import Flat, join, split_rectangle, split_segments
from tilth.geometry.protocol import Facets


class Box(Flat):
    """Box with the corner `lower` from which it extends along its local axes.

    Args:
        lower, upper: corners before the rotation about `lower` [length], shape (dim,).
        axes: unit vectors of the box's local axes as rows, shape (dim, dim).
        inside: whether the soil is inside the box.
        faces: names of the faces that belong to the boundary, such as "x-" for the face of least x
            in the box's local axes; all if None. The distance is always that to the closed box.
    """

    bounded = True

    def __init__(
        self,
        lower: Floats,
        upper: Floats,
        axes: Floats,
        inside: bool,
        faces: Sequence[str] | None = None,
    ) -> None:
        self.lower = np.asarray(lower, dtype=float)
        self.size = np.asarray(upper, dtype=float) - self.lower
        self.axes = np.asarray(axes, dtype=float)
        self.sign = 1.0 if inside else -1.0
        self.dim = len(self.lower)
        self.faces = faces
        # Points nearer to a face than this are on it; round-off grows with the coordinates.
        greatest = float(np.abs(self.lower).max() + self.size.max())
        self._round_off = 16.0 * float(np.finfo(float).eps) * greatest

    def _outward(self, x: Floats) -> tuple[Floats, Floats]:
        """Returns the distance from the box (n,), < 0 inside, and its gradient (n, dim)."""
        local = (x - self.lower) @ self.axes.T - 0.5 * self.size
        excess = np.abs(local) - 0.5 * self.size
        side = np.where(local < 0.0, -1.0, 1.0)
        depth = excess.max(axis=1)
        outside = np.maximum(excess, 0.0)
        length = np.linalg.norm(outside, axis=1)
        out = length > self._round_off
        nearest_face = np.eye(self.dim)[excess.argmax(axis=1)] * side
        from_box = outside * side / np.where(out, length, 1.0)[:, None]
        direction = np.where(out[:, None], from_box, nearest_face)
        return np.where(out, length, depth), direction @ self.axes

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        return np.asarray(-self.sign * self._outward(x)[0])

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; on edges and corners that of one face."""
        return np.asarray(-self.sign * self._outward(x)[1])

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`."""
        parts = []
        for k, name in enumerate("xyz"[: self.dim]):
            for end, mark in ((0.0, "-"), (1.0, "+")):
                if self.faces is not None and name + mark not in self.faces:
                    continue
                corner = self.lower + end * self.size[k] * self.axes[k]
                edges = [self.size[j] * self.axes[j] for j in range(self.dim) if j != k]
                if self.dim == 2:
                    piece, _ = split_segments(corner[None], (corner + edges[0])[None], size)
                else:
                    piece = split_rectangle(corner, edges[0], edges[1], size)
                outward = (2.0 * end - 1.0) * self.axes[k]
                normal = np.tile(-self.sign * outward, (len(piece), 1))
                parts.append(Facets(piece, normal, np.arange(len(piece))))
        return join(parts)
