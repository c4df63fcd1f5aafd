# SPDX-License-Identifier: BSD-3-Clause
"""An elastic ball held all around that sags a little under its weight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.model import HenckyElastic
from tilth.verification.closed_forms.moduli import Moduli

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class HeldBall:
    """Ball whose surface does not move, under a uniform body force; small strain.

    With w constant and r the distance from the centre, u = (a^2 - r^2) w vanishes at r = a, its
    Laplacian is -6 w and grad div u is -2 w. So Navier's equation
    mu Laplacian u + (lambda + mu) grad div u + b = 0 holds with w = b / (2 (lambda + 4 mu)).

    Attributes:
        centre: shape (3,) [length].
        radius: a [length].
        body_force: b [force/length^3], shape (3,).
        material: its density does not count.
    """

    centre: Sequence[float]
    radius: float
    body_force: Sequence[float]
    material: HenckyElastic

    def displacement(self, place: npt.ArrayLike) -> FloatArray:
        """Returns the displacement at places in the ball [length], shape (n, 3)."""
        moduli = Moduli.of(self.material)
        arm = np.asarray(place, dtype=float) - np.asarray(self.centre)
        height = self.radius**2 - (arm**2).sum(axis=1)
        force = np.asarray(self.body_force) / (2.0 * (moduli.lame + 4.0 * moduli.shear))
        return np.asarray(height[:, None] * force)
