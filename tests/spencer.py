# SPDX-License-Identifier: BSD-3-Clause
"""Spencer's method of slices, and the circle with its least factor of safety, for tests.

For slopes that descend to the right. With the interslice forces at the angle theta to the
horizontal the resultant on a slice of width b and weight W, with the base at the angle a, is
(Spencer 1967)

    Q = [c b / cos(a) / F + tan(phi) / F (W cos(a) - u b / cos(a)) - W sin(a)]
        / [cos(a - theta) (1 + tan(phi) tan(a - theta) / F)],

and F and theta follow from the balance of forces, sum Q = 0, and of moments about the centre,
sum Q cos(a - theta) = 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq, minimize

from tilth.arrays import Floats

SLICES = 60


@dataclass(frozen=True)
class SpencerSlope:
    """Uniform soil under a polyline; angles in degrees.

    Attributes:
        ground: points of its surface, x increasing, shape (n, 2).
        weight: unit weight, with and without water.
        cohesion, friction_angle: of the soil.
        base: height below which nothing moves.
        water: points of the phreatic surface, in the soil; None if dry.
        water_weight: unit weight of water.
    """

    ground: Sequence[tuple[float, float]]
    weight: float
    cohesion: float
    friction_angle: float
    base: float
    water: Sequence[tuple[float, float]] | None = None
    water_weight: float = 10.0

    def _circle(self, start: float, end: float, depth: float) -> tuple[Floats, ...] | None:
        """Returns inclination, width, weight and pore pressure of the slices; None if none."""
        x0, x1 = np.array([start, end])
        y0, y1 = np.interp([x0, x1], *np.transpose(self.ground))
        chord = np.array([x1 - x0, y1 - y0])
        length = float(np.hypot(*chord))
        radius = length * (0.25 + depth**2) / (2.0 * depth)
        middle = 0.5 * np.array([x0 + x1, y0 + y1])
        centre = middle + np.array([-chord[1], chord[0]]) / length * (radius - depth * length)
        edge = np.linspace(x0, x1, SLICES + 1)
        x, b = 0.5 * (edge[1:] + edge[:-1]), np.diff(edge)
        below = radius**2 - (x - centre[0]) ** 2
        if not below.min() > 0.0:
            return None
        y = centre[1] - np.sqrt(below)
        top = np.interp(x, *np.transpose(self.ground))
        if y.min() < self.base or (y > top + 1e-9).any() or centre[0] < x0:
            return None
        alpha = np.arcsin((centre[0] - x) / radius)  # positive where the base descends
        pressure = np.zeros_like(x)
        if self.water is not None:
            level = np.interp(x, *np.transpose(self.water))
            pressure = self.water_weight * np.maximum(level - y, 0.0)
        return alpha, b, self.weight * (top - y) * b, pressure

    def factor(self, start: float, end: float, depth: float) -> float:
        """Returns Spencer's factor of a circle: it enters at x = start and leaves at x = end.

        depth: sagitta over chord. Infinite if there is no such circle or no solution.
        """
        slices = self._circle(start, end, depth)
        if slices is None:
            return math.inf
        alpha, b, weight, pressure = slices
        tangent = math.tan(math.radians(self.friction_angle))
        base = b / np.cos(alpha)
        resisting = self.cohesion * base + tangent * (weight * np.cos(alpha) - pressure * base)

        def sums(factor: float, theta: float) -> tuple[float, float]:
            lean = alpha - theta
            q = (resisting / factor - weight * np.sin(alpha)) / (
                np.cos(lean) + tangent * np.sin(lean) / factor
            )
            return float(q.sum()), float((q * np.cos(lean)).sum())

        def of_moments(theta: float) -> float:
            return float(brentq(lambda f: sums(f, theta)[1], 0.3, 10.0, xtol=1e-10))

        try:
            steepest = float(brentq(lambda t: sums(of_moments(t), t)[0], 0.0, 0.6, xtol=1e-8))
            return of_moments(steepest)
        except ValueError:
            return math.inf

    def thickness(self, start: float, end: float, depth: float) -> float:
        """Returns the greatest height of soil over a circle; 0 if there is no such circle."""
        slices = self._circle(start, end, depth)
        return 0.0 if slices is None else float((slices[2] / slices[1]).max() / self.weight)

    def least_factor(
        self, entries: tuple[float, float], exits: tuple[float, float], thickness: float = 0.0
    ) -> float:
        """Returns the least factor of all circles with x of entry and exit in these ranges.

        thickness: height of soil over the circle, at least.
        """

        def factor(start: float, end: float, depth: float) -> float:
            if thickness > 0.0 and self.thickness(start, end, depth) < thickness:
                return math.inf
            return self.factor(start, end, depth)

        found = [
            (factor(start, end, depth), (start, end, depth))
            for start in np.linspace(*entries, 8)
            for end in np.linspace(*exits, 6)
            for depth in (0.02, 0.05, 0.1, 0.15, 0.2, 0.3)
        ]

        def at(circle: Floats) -> float:
            start, end, depth = circle
            inside = entries[0] <= start <= entries[1] and exits[0] <= end <= exits[1]
            return factor(start, end, depth) if inside and 0.005 < depth < 0.5 else math.inf

        best = sorted(found)[:3]
        options = {"xatol": 1e-4, "fatol": 1e-5, "maxiter": 150}
        return min(
            float(minimize(at, circle, method="Nelder-Mead", options=options).fun)
            for _, circle in best
        )

    def with_davis(self, dilation_angle: float, factor: float) -> SpencerSlope:
        """Returns the slope with Davis' strength, form C: of a friction angle reduced by a factor.

        c and tan(phi) times cos(psi) cos(phi) / (1 - sin(psi) sin(phi)), with the reduced friction
        angle phi and the dilation angle psi, at most phi.
        """
        phi = math.atan(math.tan(math.radians(self.friction_angle)) / factor)
        psi = min(math.radians(dilation_angle), phi)
        share = math.cos(psi) * math.cos(phi) / (1.0 - math.sin(psi) * math.sin(phi))
        tangent = share * math.tan(math.radians(self.friction_angle))
        return replace(
            self,
            cohesion=share * self.cohesion,
            friction_angle=math.degrees(math.atan(tangent)),
        )
