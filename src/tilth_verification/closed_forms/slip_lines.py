# SPDX-License-Identifier: BSD-3-Clause
"""Bearing capacity of a strip footing by the method of characteristics (V.V. Sokolovskii).

Plane strain, Mohr-Coulomb, compression positive; x along the surface, z downwards, from the edge of
the footing, which is at x < 0. With the mean s of the stresses in the plane, half of their
difference R = c cos(phi) + s sin(phi), the angle psi of the greater one from z and eps = 45 degrees
- phi / 2, along the lines at psi - eps and psi + eps from z

    ds - 2 R / cos(phi) dpsi = gamma (dz + tan(phi) dx),
    ds + 2 R / cos(phi) dpsi = gamma (dz - tan(phi) dx).

Both are right for level soil in the passive state, psi = 90 degrees, s = s_0 + gamma z / (1 -
sin(phi)), and give Prandtl's and Reissner's capacity of weightless soil. C.M. Martin's program ABC
solves the same equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

from scipy.optimize import brentq, root

State = tuple[float, float, float, float]
"""x, z [length], s [stress] and psi [radians] at a point."""

ROUND_OFF, ITERATIONS = 1e-12, 60
"""Change of a point at which it is found, and how often it is improved at most."""


@dataclass(frozen=True)
class Footing:
    """A rigid strip footing on level soil.

    Attributes:
        width: of the footing [length].
        cohesion: [stress].
        friction_angle: greater than zero [degrees].
        unit_weight: of the soil [stress/length].
        surcharge: pressure beside the footing; with no cohesion greater than zero [stress].
        lines: lines that begin beside the footing, and lines of the fan at its edge; with 24 the
            capacity is exact to 0.1 %.
    """

    width: float
    cohesion: float
    friction_angle: float
    unit_weight: float
    surcharge: float = 0.0
    lines: int = 24

    @property
    def _phi(self) -> float:
        return math.radians(self.friction_angle)

    def _radius(self, s: float) -> float:
        return self.cohesion * math.cos(self._phi) + s * math.sin(self._phi)

    def smooth(self) -> float:
        """Returns the mean pressure at the limit load of a smooth footing [stress].

        The outermost line ends on the axis of symmetry (R. Hill's mechanism).
        """

        def base(length: float) -> list[State]:
            return [line[-1] for line in self._lines(length, 0.0, smooth=True)]

        bounds = 0.1 * self.width, 8.0 * self.width
        end = brentq(lambda x: base(x)[-1][0] + 0.5 * self.width, *bounds, xtol=1e-9 * self.width)
        force = 0.0
        for (x1, _, s1, _), (x2, _, s2, _) in pairwise(base(end)):
            mean = 0.5 * (s1 + s2)
            force += (mean + self._radius(mean)) * (x1 - x2)
        return 2.0 * force / self.width

    def rough(self) -> float:
        """Returns the mean pressure at the limit load of a rough footing [stress].

        A wedge of soil moves with it; the last line of the fan, along the wedge, meets the axis of
        symmetry where the outermost line does, and the greater stress is vertical there.
        """
        half = 0.5 * self.width

        def missed(unknowns: tuple[float, float]) -> tuple[float, float]:
            x, _, _, psi = self._lines(abs(unknowns[0]), unknowns[1])[-1][-1]
            return (x + half) / half, psi

        for guess in ((2.0, -0.1), (2.0, -0.4), (3.0, -0.4), (1.5, -0.7), (4.0, -0.4)):
            found = root(missed, (guess[0] * self.width, guess[1]), tol=1e-10)
            if found.success:
                break
        else:
            raise ValueError(f"no slip lines are found for {self}")
        wedge = [line[-1] for line in self._lines(abs(found.x[0]), found.x[1])]
        force = 0.0
        for (x1, z1, s1, psi1), (x2, z2, s2, psi2) in pairwise(wedge):
            s, psi, wide, deep = 0.5 * (s1 + s2), 0.5 * (psi1 + psi2), x1 - x2, z2 - z1
            radius = self._radius(s)
            vertical, shear = s + radius * math.cos(2.0 * psi), radius * math.sin(2.0 * psi)
            force += vertical * wide + shear * deep - self.unit_weight * 0.5 * (z1 + z2) * wide
        return 2.0 * force / self.width

    def _lines(self, length: float, last_psi: float, *, smooth: bool = False) -> list[list[State]]:
        """Returns the states along the lines at psi + eps from beside the footing.

        Each begins on the first line of the fan, the boundary of the passive state, and ends at
        the last one, or on the base of a smooth footing.

        Args:
            length: of the surface on which they begin, from the edge.
            last_psi: psi of the fan's last line at the edge [radians].
            smooth: whether the lines go on to the base of the footing.
        """
        phi, n = self._phi, self.lines
        shift, steep = self.cohesion / math.tan(phi), math.tan(0.25 * math.pi + 0.5 * phi)
        passive = (self.surcharge + self.cohesion * math.cos(phi)) / (1.0 - math.sin(phi))
        fan = []
        for k in range(n + 1):
            psi = 0.5 * math.pi + (last_psi - 0.5 * math.pi) * k / n
            growth = math.exp(2.0 * math.tan(phi) * (0.5 * math.pi - psi))
            fan.append((0.0, 0.0, (passive + shift) * growth - shift, psi))
        lines = [fan]
        for k in range(1, n + 1):
            x = 0.5 * length * k / n
            s = passive + self.unit_weight * (x / steep) / (1.0 - math.sin(phi))
            line = [(x, x / steep, s, 0.5 * math.pi)]
            for other in lines[-1][1:]:
                line.append(self._crossing(other, line[-1]))
            if smooth:
                line.append(self._on_base(line[-1]))
            lines.append(line)
        return lines

    def _crossing(self, first: State, second: State) -> State:
        """Returns where the line at psi - eps of `first` meets that at psi + eps of `second`."""
        (x1, z1, s1, psi1), (x2, z2, s2, psi2) = first, second
        phi, gamma, tangent = self._phi, self.unit_weight, math.tan(self._phi)
        eps, cosine = 0.25 * math.pi - 0.5 * phi, math.cos(phi)
        s, psi = 0.5 * (s1 + s2), 0.5 * (psi1 + psi2)
        x, z = x2, z2
        for _ in range(ITERATIONS):
            one, other = 0.5 * (psi1 + psi) - eps, 0.5 * (psi2 + psi) + eps
            c1, d1, c2, d2 = math.cos(one), math.sin(one), math.cos(other), math.sin(other)
            a, b, scale = x1 * c1 - z1 * d1, x2 * c2 - z2 * d2, d1 * c2 - c1 * d2
            x, z = (b * d1 - a * d2) / scale, (b * c1 - a * c2) / scale
            k1 = 2.0 * self._radius(0.5 * (s1 + s)) / cosine
            k2 = 2.0 * self._radius(0.5 * (s2 + s)) / cosine
            left = s1 - k1 * psi1 + gamma * (z - z1 + tangent * (x - x1))
            right = s2 + k2 * psi2 + gamma * (z - z2 - tangent * (x - x2))
            before = psi
            psi = (right - left) / (k1 + k2)
            s = left + k1 * psi
            if abs(psi - before) < ROUND_OFF:
                break
        return x, z, s, psi

    def _on_base(self, second: State) -> State:
        """Returns where the line at psi + eps of a state meets a smooth base, psi = 0."""
        x2, z2, s2, psi2 = second
        phi = self._phi
        x = x2 - z2 * math.tan(0.5 * psi2 + 0.25 * math.pi - 0.5 * phi)
        weight = self.unit_weight * (-z2 - math.tan(phi) * (x - x2))
        s = s2
        for _ in range(ITERATIONS):
            before = s
            s = s2 + 2.0 * self._radius(0.5 * (s2 + s)) / math.cos(phi) * psi2 + weight
            if abs(s - before) <= ROUND_OFF * abs(s):
                break
        return x, 0.0, s, 0.0
