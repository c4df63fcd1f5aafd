# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of a terrain over a rectangle in plan: heights on a grid, or on triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tilth.arrays import Floats
from tilth.variation.survey import Survey


class HeightSurface(Protocol):
    """Heights over a rectangle in plan."""

    def at(self, place: Floats) -> Floats:
        """Returns the heights at places in the rectangle (n, 2) [length], shape (n,)."""

    def volume_above(self, height: float) -> float:
        """Returns the volume [length^3] between the surface and a height, > 0 below the surface."""

    def range(self) -> tuple[float, float]:
        """Returns the least and the greatest height [length]."""

    def vertices(self) -> Floats:
        """Returns the places of its vertices in plan, shape (n, 2)."""


@dataclass(frozen=True)
class Gridded:
    """A surface that is bilinear between the lines of a grid, which end with the rectangle.

    Attributes:
        lines: increasing coordinates along x and y [length].
        height: at the crossings [length], shape (nx, ny).
    """

    lines: tuple[Floats, Floats]
    height: Floats

    def at(self, place: Floats) -> Floats:
        """As `HeightSurface.at`."""
        from scipy.interpolate import RegularGridInterpolator  # takes 0.2 s: only where needed

        return np.asarray(RegularGridInterpolator(self.lines, self.height)(place))

    def volume_above(self, height: float) -> float:
        """As `HeightSurface.volume_above`; a bilinear height has the mean of its corners."""
        z = self.height - height
        mean = 0.25 * (z[1:, 1:] + z[:-1, 1:] + z[1:, :-1] + z[:-1, :-1])
        return float(np.einsum("i,j,ij->", *(np.diff(line) for line in self.lines), mean))

    def range(self) -> tuple[float, float]:
        """As `HeightSurface.range`."""
        return float(self.height.min()), float(self.height.max())

    def vertices(self) -> Floats:
        """As `HeightSurface.vertices`."""
        return np.stack(np.meshgrid(*self.lines, indexing="ij"), axis=-1).reshape(-1, 2)


@dataclass(frozen=True)
class Triangulated:
    """A surface of triangles between survey points, cut off at the sides of the rectangle.

    Attributes:
        survey: the survey points.
        triangle: corners in the rectangle, x and y less the origin of the survey, and height
            [length], shape (n, 3, 3).
        key, file: entry of the case file with the survey, and its file, for messages.
    """

    survey: Survey
    triangle: Floats
    key: str
    file: str

    @classmethod
    def within(
        cls, survey: Survey, lower: Floats, upper: Floats, key: str, file: str
    ) -> Triangulated:
        """Returns the part of a survey in the rectangle between two corners (2,).

        Raises:
            BadInput: a corner is outside the convex hull of the points.
        """
        corners = np.stack(np.meshgrid(*np.stack([lower, upper], axis=1)), axis=-1).reshape(-1, 2)
        survey.at(corners, key, file)
        triangle = survey.triangles()
        for k in range(2):
            for bound, sign in ((lower[k], 1.0), (upper[k], -1.0)):
                triangle = _cut_off(triangle, k, float(bound - survey.origin[k]), sign)
        return cls(survey, triangle, key, file)

    def at(self, place: Floats) -> Floats:
        """As `HeightSurface.at`."""
        return self.survey.at(place, self.key, self.file)

    def volume_above(self, height: float) -> float:
        """As `HeightSurface.volume_above`."""
        first, second = (self.triangle[:, k, :2] - self.triangle[:, 0, :2] for k in (1, 2))
        area = 0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
        return float(area @ (self.triangle[..., 2].mean(axis=1) - height))

    def range(self) -> tuple[float, float]:
        """As `HeightSurface.range`."""
        return float(self.triangle[..., 2].min()), float(self.triangle[..., 2].max())

    def vertices(self) -> Floats:
        """As `HeightSurface.vertices`."""
        return np.asarray(np.unique(self.triangle[..., :2].reshape(-1, 2), axis=0)) + (
            self.survey.origin
        )


def _cut_off(triangle: Floats, axis: int, bound: float, sign: float) -> Floats:
    """Returns the parts of triangles (n, 3, 3) with sign (coordinate - bound) >= 0, as triangles.

    One corner on that side leaves one triangle, two leave two.
    """
    offset = sign * (triangle[..., axis] - bound)
    inside = offset >= 0.0
    count = inside.sum(axis=1)
    parts = [triangle[count == 3]]
    for number in (1, 2):
        some = np.flatnonzero(count == number)
        alone = inside[some] if number == 1 else ~inside[some]  # the one corner on its side
        turn = (alone.argmax(axis=1)[:, None] + np.arange(3)) % 3
        corner = np.take_along_axis(triangle[some], turn[..., None], axis=1)
        away = np.take_along_axis(offset[some], turn, axis=1)
        one, other = corner[:, 1], corner[:, 2]
        ends = []
        for k in (1, 2):
            share = (away[:, 0] / (away[:, 0] - away[:, k]))[:, None]
            end = corner[:, 0] + share * (corner[:, k] - corner[:, 0])
            end[:, axis] = bound
            ends.append(end)
        if number == 1:
            parts.append(np.stack([corner[:, 0], *ends], axis=1))
        else:
            parts.append(np.stack([ends[0], one, other], axis=1))
            parts.append(np.stack([ends[0], other, ends[1]], axis=1))
    return np.concatenate(parts)
