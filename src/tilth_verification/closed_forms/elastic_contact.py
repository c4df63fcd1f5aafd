# SPDX-License-Identifier: BSD-3-Clause
"""Rigid sphere, cylinder and flat punch on an elastic half-space, small strain.

K.L. Johnson, Contact Mechanics, Cambridge University Press 1985, chapters 3, 4 and 7. Pressures,
forces and depths are positive in compression. E* = E / (1 - nu^2) where the indenter is rigid.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.model import HenckyElastic

LOST_DEPTH = {0.3: 0.4123, 0.49: 0.5231}
"""Poisson's ratio -> E L u / P in a cylinder of soil of radius and height L, see `sphere_depth`."""


def contact_modulus(material: HenckyElastic) -> float:
    """Returns E* = E / (1 - nu^2) [stress]."""
    return material.young_modulus / (1.0 - material.poisson_ratio**2)


def _ellipse(distance: npt.ArrayLike, half_width: float) -> Floats:
    """sqrt(1 - (x / a)^2), 0 outside and for a = 0."""
    if half_width == 0.0:
        return np.zeros_like(np.asarray(distance, dtype=float))
    share = np.asarray(distance, dtype=float) / half_width
    return np.sqrt(np.maximum(1.0 - share**2, 0.0))


@dataclass(frozen=True)
class HertzSphere:
    """Sphere of radius R pressed into a half-space (Johnson, section 4.2).

    P = 4/3 E* sqrt(R) d^1.5, a^2 = R d, p = p0 sqrt(1 - (r / a)^2), p0 = 3 P / (2 pi a^2).

    Attributes:
        radius: R [length].
        modulus: E* [stress].
    """

    radius: float
    modulus: float

    def force(self, depth: float) -> float:
        """Returns the force P [force] at an approach d [length]."""
        return 4.0 / 3.0 * self.modulus * math.sqrt(self.radius) * math.pow(depth, 1.5)

    def depth(self, force: float) -> float:
        """Returns the approach d [length]."""
        return math.pow(0.75 * force / (self.modulus * math.sqrt(self.radius)), 2.0 / 3.0)

    def half_width(self, force: float) -> float:
        """Returns the radius a of the contact [length]."""
        return math.cbrt(0.75 * force * self.radius / self.modulus)

    def peak_pressure(self, force: float) -> float:
        """Returns p0 [stress]."""
        return 1.5 * force / (math.pi * self.half_width(force) ** 2)

    def pressure(self, distance: npt.ArrayLike, force: float) -> Floats:
        """Returns the pressure [stress] at distances from the axis [length]."""
        return self.peak_pressure(force) * _ellipse(distance, self.half_width(force))


@dataclass(frozen=True)
class HertzCylinder:
    """Cylinder of radius R along a line (Johnson, section 4.2(c)); forces per length.

    a^2 = 4 P R / (pi E*), p = p0 sqrt(1 - (x / a)^2), p0 = 2 P / (pi a). The depth depends on the
    size of the soil.

    Attributes:
        radius: R [length].
        modulus: E* [stress].
    """

    radius: float
    modulus: float

    def force(self, half_width: float) -> float:
        """Returns the force P [force/length] at a half-width a [length]."""
        return 0.25 * math.pi * self.modulus * half_width**2 / self.radius

    def half_width(self, force: float) -> float:
        """Returns the half-width a of the contact [length]."""
        return math.sqrt(4.0 * force * self.radius / (math.pi * self.modulus))

    def peak_pressure(self, force: float) -> float:
        """Returns p0 [stress]."""
        return 2.0 * force / (math.pi * self.half_width(force))

    def pressure(self, distance: npt.ArrayLike, force: float) -> Floats:
        """Returns the pressure [stress] at distances from the middle [length]."""
        return self.peak_pressure(force) * _ellipse(distance, self.half_width(force))


@dataclass(frozen=True)
class Cattaneo:
    """Shear under a tangential force Q < mu P that follows the normal one (Johnson, section 7.2).

    The rim slides, the middle |x| <= c sticks: the shear is mu times the pressure less mu times
    that of the same bodies under P - Q / mu, whose half-width is c. So c / a = (1 - Q / (mu P))^n,
    n = 1/2 for the cylinder and 1/3 for the sphere. It holds where the normal load alone makes no
    slip: nu = 0.5 under a rigid body. For the sphere the shear has the direction of Q throughout,
    an approximation in the sliding rim.

    Attributes:
        contact: the normal contact.
        friction: mu [-].
    """

    contact: HertzSphere | HertzCylinder
    friction: float

    def sticking(self, normal_force: float, tangential_force: float) -> float:
        """Returns the half-width c of the sticking part [length]."""
        return self.contact.half_width(self._kept(normal_force, tangential_force))

    def shear(
        self, distance: npt.ArrayLike, normal_force: float, tangential_force: float
    ) -> Floats:
        """Returns the shear stress [stress] at distances from the middle [length]."""
        kept = self._kept(normal_force, tangential_force)
        whole = self.contact.pressure(distance, normal_force)
        return self.friction * (whole - (self.contact.pressure(distance, kept) if kept else 0.0))

    def _kept(self, normal_force: float, tangential_force: float) -> float:
        kept = normal_force - tangential_force / self.friction
        assert kept >= 0.0
        return kept


def sphere_depth(
    sphere: HertzSphere, force: float, material: HenckyElastic, extent: float
) -> float:
    """Returns the approach [length] in a cylinder of soil, radius and height L, rollers around it.

    Far from the contact the half-space has the displacements of a point force, which the base and
    the side reduce: all of the contact sinks by k P / (E L) less. k is from finite elements, by
    `benchmarks/lost_depth.py`.

    Args:
        extent: L [length], much larger than the contact.
    """
    lost = LOST_DEPTH[material.poisson_ratio] * force / (material.young_modulus * extent)
    return sphere.depth(force) - lost


def flat_punch_force(radius: float, depth: float, modulus: float) -> float:
    """Returns the force of a smooth circular punch, 2 a E* d (Johnson, section 3.4)."""
    return 2.0 * radius * modulus * depth
