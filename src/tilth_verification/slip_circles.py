# SPDX-License-Identifier: BSD-3-Clause
"""Bishop's simplified method of slices, and the circle with the least factor of safety.

A second computation for slopes that descend to the right. Each slice has the vertical load V: its
weight and that of the water above it; the water pressure on the ground also pushes horizontally, H.
Moments about the centre of the circle of radius R (Bishop 1955), alpha the inclination of the base:

    F = sum [c b + (V - u b) tan phi] / m_alpha  R / sum [V (x_c - x) + H (y_c - y_ground)],
    m_alpha = cos alpha + sin alpha tan phi / F.

Without friction it is the exact balance of moments, whatever the forces between slices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from tilth.arrays import Floats

COARSE, FINE = 24, 120
"""Slices in the search over all circles, and for those that are best in it."""

ITERATIONS = 40
Of = Callable[[Floats, Floats], Floats]
"""A quantity of the soil at points x, y, of their shape."""


@dataclass(frozen=True)
class Slope:
    """A slope that descends to the right.

    Attributes:
        ground: points of its surface, x increasing, shape (n, 2) [length].
        unit_weight: of the soil, with its water [force / length^3].
        cohesion: c or s_u at points [stress].
        tangent: tan(phi) at points [-].
        base: height below which nothing moves [length].
        pore_pressure: at points [stress].
        water_level: of the water above the ground; none if below it [length].
        water_weight: unit weight of the water [force / length^3].
    """

    ground: Sequence[tuple[float, float]]
    unit_weight: float
    cohesion: Of
    tangent: Of
    base: float = 0.0
    pore_pressure: Of = lambda x, y: np.zeros_like(x)
    water_level: float = -np.inf
    water_weight: float = 0.0

    def height(self, x: Floats) -> Floats:
        """Returns the height of the ground at x."""
        return np.asarray(np.interp(x, *np.transpose(self.ground)))

    def factors(self, start: Floats, end: Floats, depth: Floats, slices: int = FINE) -> Floats:
        """Returns the factors of safety of circles, infinite for those that are none; shape (k,).

        Args:
            start, end: x where they enter behind the crest and leave below it, shape (k,).
            depth: sagitta over the chord, shape (k,).
            slices: of each circle.
        """
        left = np.stack([start, self.height(start)])
        right = np.stack([end, self.height(end)])
        chord = right - left
        length = np.hypot(*chord)
        with np.errstate(all="ignore"):
            radius = length * (0.25 + depth**2) / (2.0 * depth)
            up = np.stack([-chord[1], chord[0]]) / length
            centre = 0.5 * (left + right) + up * (radius - depth * length)
            share = (np.arange(slices) + 0.5) / slices
            x = start[:, None] + (end - start)[:, None] * share
            width = (end - start)[:, None] / slices
            arm, radius = centre[0][:, None] - x, radius[:, None]
            below = np.sqrt(radius**2 - arm**2)
            y, ground = centre[1][:, None] - below, self.height(x)
            sine, cosine = arm / radius, below / radius
            water = self.water_weight * np.maximum(self.water_level - ground, 0.0)
            fall = (self.height(x - 0.5 * width) - self.height(x + 0.5 * width)) / width
            vertical = (self.unit_weight * (ground - y) + water) * width
            horizontal = -water * fall * width
            moment = (vertical * arm + horizontal * (centre[1][:, None] - ground)).sum(axis=1)
            c, tangent = self.cohesion(x, y), self.tangent(x, y)
            resisting = c * width + (vertical - self.pore_pressure(x, y) * width) * tangent
            factor = np.ones(len(start))
            for _ in range(ITERATIONS):
                projected = cosine + sine * tangent / factor[:, None]
                before = factor
                factor = (resisting / projected).sum(axis=1) * radius[:, 0] / moment
                if not (np.abs(factor - before) > 1e-9 * np.abs(factor)).any():
                    break
            lowest = np.where(centre[0] < end, centre[1] - radius[:, 0], right[1])
            none = (
                (centre[0] < start)
                | (lowest < self.base - 1e-9)
                | (projected < 0.1).any(axis=1)
                | (ground < y).any(axis=1)
                | ~(moment > 0.0)
                | ~np.isfinite(factor)
            )
        return np.where(none, np.inf, factor)

    def least_factor(self, entries: tuple[float, float], exits: tuple[float, float]) -> float:
        """Returns the least factor of safety of all circles.

        entries, exits: range of x where they begin and end.
        """
        grids = np.meshgrid(
            np.linspace(*entries, 25), np.linspace(*exits, 25), np.linspace(0.04, 0.48, 12)
        )
        tried = np.stack([each.ravel() for each in grids])
        start, end, depth = tried
        factor = self.factors(start, end, depth, COARSE)
        best = [tried[:, number] for number in np.argsort(factor)[:4]]

        def at(circle: Floats) -> float:
            if not (entries[0] <= circle[0] <= entries[1] and exits[0] <= circle[1] <= exits[1]):
                return np.inf
            return float(self.factors(*np.array(circle)[:, None])[0])

        return min(
            float(minimize(at, each, method="Nelder-Mead", options={"xatol": 1e-6}).fun)
            for each in best
        )


def uniform(value: float) -> Of:
    """Returns a quantity that is the same everywhere."""
    return lambda x, y: np.full_like(x, value)
