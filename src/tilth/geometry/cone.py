# SPDX-License-Identifier: BSD-3-Clause
"""A cylindrical shaft with a conical tip (3D), with the soil inside or outside."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from tilth.arrays import Floats
from tilth.geometry.flat import perpendicular, unit
from tilth.geometry.polyline import Polyline
from tilth.geometry.protocol import Facets

FEWEST_SECTORS = 16
"""Facets around the axis, at least."""

AXIAL = 1e-9
"""Radial component of a normal below which it belongs to a flat end."""


def section(radius: float, tip_length: float, length: float) -> Floats:
    """Returns the corners (r, s) of the section, anticlockwise, the tip first, shape (5, 2)."""
    top = tip_length + length
    return np.array(
        [[0.0, 0.0], [radius, tip_length], [radius, top], [-radius, top], [-radius, tip_length]]
    )


class Cone:
    """Solid of revolution: a cone from its tip to the radius of the shaft, then the shaft.

    Args:
        tip: [length], shape (3,).
        axis: from the tip along the shaft, shape (3,), of any length.
        radius: of the shaft [length].
        tip_length: from the tip to the shaft [length]; 0 for a flat end.
        length: of the shaft [length].
        inside: whether the soil is inside.
    """

    dim = 3
    bounded = True
    flat = False

    def __init__(
        self,
        tip: Floats,
        axis: Floats,
        radius: float,
        tip_length: float,
        length: float,
        inside: bool,
    ) -> None:
        self.tip = np.asarray(tip, dtype=float)
        self.axis = unit(np.asarray(axis, dtype=float))
        self._section = section(radius, tip_length, length)
        self._outline = Polyline(self._section, closed=True, left=inside)
        self._sign = 1.0 if inside else -1.0
        first = perpendicular(self.axis)
        self._across = np.stack([first, np.cross(self.axis, first)])

    def _in_section(self, x: Floats) -> tuple[Floats, Floats]:
        """Returns places (r, s) in the section, shape (n, 2), and radial unit vectors (n, 3)."""
        offset = x - self.tip
        along = offset @ self.axis
        radial = offset - along[:, None] * self.axis
        radius = np.linalg.norm(radial, axis=1)
        on_axis = radius <= 1e-12 * self._section[1, 0]
        radial[on_axis] = self._across[0]
        outward = radial / np.where(on_axis, 1.0, radius)[:, None]
        return np.stack([np.where(on_axis, 0.0, radius), along], axis=1), outward

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        return self._outline.distance(self._in_section(x)[0])

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; at edges that of one side, at the tip one of its cone's."""
        place, outward = self._in_section(x)
        direction = self._outline.gradient(place)
        return np.asarray(direction[:, :1] * outward + direction[:, 1:] * self.axis)

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: rings of triangles; a flat end is a polygon in its circle."""
        del lower, upper
        ends = [*self._section[:3], np.array([0.0, self._section[2, 1]])]
        # As many at the tip as around the shaft: the sag of a chord is then of second order there.
        sectors = max(FEWEST_SECTORS, math.ceil(2.0 * math.pi * self._section[1, 0] / size))
        corners = []
        for start, end in pairwise(ends):
            rows = max(1, math.ceil(float(np.linalg.norm(end - start)) / size - 1e-9))
            rings = start + np.linspace(0.0, 1.0, rows + 1)[:, None] * (end - start)
            corners += [self._ring(low, high, sectors) for low, high in pairwise(rings)]
        corner = np.concatenate(corners)
        normal = unit(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]))
        return Facets(corner, -self._sign * normal, np.arange(len(corner)))

    def _ring(self, low: Floats, high: Floats, sectors: int) -> Floats:
        """Returns triangles between two circles (r, s), anticlockwise from outside (n, 3, 3)."""
        angle = 2.0 * np.pi * np.arange(sectors + 1) / sectors
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ self._across
        circle[-1] = circle[0]
        inner, outer = (self.tip + r * circle + s * self.axis for r, s in (low, high))
        a, b, c, d = inner[:-1], inner[1:], outer[1:], outer[:-1]
        triangles = []
        if low[0] > 0.0:
            triangles.append(np.stack([a, b, c], axis=1))
        if high[0] > 0.0:
            triangles.append(np.stack([a, c, d], axis=1))
        return np.concatenate(triangles)

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """As `Geometry.project`: at a right angle to the axis.

        With the angle around the axis and s along it as coordinates, an area on a facet of the
        normal n is r / |n e_r|, one on the cone r_c / |n_c e_r| times the same increments.
        """
        place, outward = self._in_section(x)
        radius, along = place.T
        _, (wide, tip_length) = self._section[:2]
        side = np.abs(normal @ self.axis) < 1.0 - AXIAL
        on_tip = side & (along < tip_length)
        target = np.where(side, wide, radius)
        cosine = np.ones(len(x))
        if tip_length > 0.0:
            target = np.where(on_tip, along * wide / tip_length, target)
            cosine = np.where(on_tip, tip_length / math.hypot(tip_length, wide), cosine)
        facing = np.abs(np.einsum("ni,ni->n", outward, normal))
        scale = target / np.where(radius > 0.0, radius, 1.0)
        ratio = np.where(side, scale * facing / cosine, 1.0)
        return x + (target - radius)[:, None] * outward, ratio
