# SPDX-License-Identifier: BSD-3-Clause
"""Circle, infinite circular cylinder and sphere, with the soil inside or outside."""

from __future__ import annotations

import math

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.geometry.flat import box_corners, pack, perpendicular, unit
from tilth.geometry.protocol import Facets


class _Round:
    """Base class: the distance follows from the vectors from the centre or axis."""

    flat = False
    dim: int
    radius: float
    power: int  # directions in which the surface is curved

    def __init__(self, centre: Floats, radius: float, inside: bool) -> None:
        self.centre = np.asarray(centre, dtype=float)
        self.radius = float(radius)
        self.sign = 1.0 if inside else -1.0

    def radial(self, x: Floats) -> Floats:
        """As `RoundGeometry.radial`."""
        return np.asarray(x - self.centre)

    def distance(self, x: Floats) -> Floats:
        """As `Geometry.distance`."""
        return np.asarray(self.sign * (self.radius - np.linalg.norm(self.radial(x), axis=1)))

    def gradient(self, x: Floats) -> Floats:
        """As `Geometry.gradient`; at the centre an arbitrary radial direction."""
        return np.asarray(-self.sign * self._outward(x))

    def _outward(self, x: Floats) -> Floats:
        radial = self.radial(x)
        length = np.linalg.norm(radial, axis=1)
        at_centre = length < 1e-12 * self.radius
        radial[at_centre] = self._any_direction()
        return unit(radial)

    def _any_direction(self) -> Floats:
        return np.asarray(np.eye(self.dim)[0])

    def project(self, x: Floats, normal: Floats) -> tuple[Floats, Floats]:
        """As `Geometry.project`: along the radius."""
        radial = self.radial(x)
        length = np.linalg.norm(radial, axis=1)
        outward = radial / length[:, None]
        ratio = (self.radius / length) ** self.power
        ratio = ratio * np.abs(np.einsum("ni,ni->n", outward, normal))
        return x + (self.radius - length)[:, None] * outward, ratio

    def _facets(self, corner: Floats, group: Integers) -> Facets:
        middle = corner.mean(axis=1)
        if self.dim == 2:
            edge = corner[:, 1] - corner[:, 0]
            normal = np.stack([-edge[:, 1], edge[:, 0]], axis=1)
        else:
            normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        normal = unit(normal)
        side = np.sign(np.einsum("ni,ni->n", normal, self.gradient(middle)))
        return Facets(corner, side[:, None] * normal, group)


def _sectors(radius: float, size: float) -> int:
    """Returns the number of chords of a circle: even, at least 32, each at most `size` long."""
    return 2 * max(16, math.ceil(math.pi * radius / size))


class Circle(_Round):
    """Circle in the plane (2D)."""

    dim = 2
    bounded = True
    power = 1

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: chords."""
        n = _sectors(self.radius, size)
        angle = 2.0 * np.pi * np.arange(n + 1) / n
        vertex = self.centre + self.radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        vertex[-1] = vertex[0]
        return self._facets(np.stack([vertex[:-1], vertex[1:]], axis=1), np.arange(n))


class Cylinder(_Round):
    """Infinite circular cylinder (3D) along the vector `axis` through `centre`."""

    dim = 3
    bounded = False
    power = 1

    def __init__(self, centre: Floats, axis: Floats, radius: float, inside: bool) -> None:
        super().__init__(centre, radius, inside)
        self.axis = unit(np.asarray(axis, dtype=float))
        first = perpendicular(self.axis)
        self._across = np.stack([first, np.cross(self.axis, first)])

    def radial(self, x: Floats) -> Floats:
        """As `RoundGeometry.radial`."""
        offset = x - self.centre
        return np.asarray(offset - (offset @ self.axis)[:, None] * self.axis)

    def _any_direction(self) -> Floats:
        return np.asarray(self._across[0])

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: one group per sector and step along the axis."""
        n = _sectors(self.radius, size)
        along = (box_corners(lower, upper) - self.centre) @ self.axis / size
        rows = np.arange(math.floor(along.min()) - 1, math.ceil(along.max()) + 1)
        row, sector = (i.ravel() for i in np.meshgrid(rows, np.arange(n), indexing="ij"))

        def at(row: Integers, sector: Integers) -> Floats:
            angle = 2.0 * np.pi * (sector % n) / n
            ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) @ self._across
            return np.asarray(self.centre + self.radius * ring + size * row[:, None] * self.axis)

        a, b = at(row, sector), at(row, sector + 1)
        c, d = at(row + 1, sector + 1), at(row + 1, sector)
        halves = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
        corner = np.stack(halves, axis=1).reshape(-1, 3, 3)
        return self._facets(corner, np.repeat(pack(row, sector), 2))


class Sphere(_Round):
    """Sphere (3D)."""

    dim = 3
    bounded = True
    power = 2

    def facets(self, lower: Floats, upper: Floats, size: float) -> Facets:
        """As `Geometry.facets`: a subdivided octahedron, projected onto the sphere."""
        n = max(8, math.ceil(0.5 * math.pi * self.radius / size))
        i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
        up = i + j < n
        down = i + j < n - 1

        def weights(i: Integers, j: Integers) -> Floats:
            return np.stack([n - i - j, i, j], axis=1) / n

        upward = np.stack(
            [weights(i[up], j[up]), weights(i[up] + 1, j[up]), weights(i[up], j[up] + 1)], axis=1
        )
        downward = np.stack(
            [
                weights(i[down] + 1, j[down]),
                weights(i[down] + 1, j[down] + 1),
                weights(i[down], j[down] + 1),
            ],
            axis=1,
        )
        barycentric = np.concatenate([upward, downward])
        octants = [
            barycentric @ np.diag([x, y, z])
            for x in (1.0, -1.0)
            for y in (1.0, -1.0)
            for z in (1.0, -1.0)
        ]
        corner = self.centre + self.radius * unit(np.concatenate(octants))
        return self._facets(corner, np.arange(len(corner)))
