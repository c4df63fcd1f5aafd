# SPDX-License-Identifier: BSD-3-Clause
"""Elastic ball with a fixed surface under its weight, and hollow sphere under pressure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats
from tilth.model import HenckyElastic
from tilth_verification.closed_forms.moduli import Moduli


@dataclass(frozen=True)
class ConstrainedBall:
    """Ball whose surface does not move, under a uniform body force; small strain.

    With w constant and r the distance from the centre, u = (a^2 - r^2) w vanishes at r = a, its
    Laplacian is -6 w and grad div u is -2 w. So Navier's equation
    mu Laplacian u + (lambda + mu) grad div u + b = 0 holds with w = b / (2 (lambda + 4 mu)).

    Attributes:
        centre: shape (3,) [length].
        radius: a [length].
        body_force: b [force/length^3], shape (3,).
        material: its density is not used.
    """

    centre: Sequence[float]
    radius: float
    body_force: Sequence[float]
    material: HenckyElastic

    def displacement(self, position: npt.ArrayLike) -> Floats:
        """Returns the displacement at positions in the ball, (n, 3) [length], shape (n, 3)."""
        moduli = Moduli.of(self.material)
        arm = np.asarray(position, dtype=float) - np.asarray(self.centre)
        height = self.radius**2 - (arm**2).sum(axis=1)
        force = np.asarray(self.body_force) / (2.0 * (moduli.lame + 4.0 * moduli.shear))
        return np.asarray(height[:, None] * force)


@dataclass(frozen=True)
class PressurisedShell:
    """Hollow sphere under pressure from inside, free outside; small strain (Lame).

    The displacement is radial, u = A r + B / r^2, with A = p a^3 / ((b^3 - a^3) 3 K) and
    B = p a^3 b^3 / ((b^3 - a^3) 4 mu), so that the radial stress 3 K A - 4 mu B / r^3 is -p at the
    inner radius a and 0 at the outer radius b.

    Attributes:
        inner, outer: radii a and b [length].
        pressure: p [stress].
        material: its density is not used.
    """

    inner: float
    outer: float
    pressure: float
    material: HenckyElastic

    def displacement(self, radius: npt.ArrayLike) -> Floats:
        """Returns the radial displacement at distances from the centre [length]."""
        moduli, r = Moduli.of(self.material), np.asarray(radius, dtype=float)
        bulk = moduli.lame + 2.0 / 3.0 * moduli.shear
        factor = self.pressure * self.inner**3 / (self.outer**3 - self.inner**3)
        return np.asarray(factor * (r / (3.0 * bulk) + self.outer**3 / (4.0 * moduli.shear * r**2)))
