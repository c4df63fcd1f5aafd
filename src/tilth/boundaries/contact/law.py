# SPDX-License-Identifier: BSD-3-Clause
"""The contact law: normal and shear traction of each multiplier by its gap and slip.

With the trial tractions s_n = lambda_n + e_n g and s_t = lambda_t + e_t w_t, tension positive:

    normal   sigma = s_n while s_n <= T, otherwise T (bilateral: always s_n),      p = -sigma
    shear    tau = s_t while |s_t| <= r, otherwise r s_t / |s_t|,      r = min(c + mu p, limit)

Without contact (s_n > T = 0) both are zero (docs/theory/contact.md; Coulomb friction as in
Wriggers, Computational Contact Mechanics, 2006, chapter 5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers

SLOPE_OF_ADHESION = 100.0
"""Ratio of shear strength to pressure below which an adhesion is reduced.

Where the soil can separate, an adhesion acts only on soil that is pressed against the surface. It
increases linearly to its full value at a pressure of a hundredth of it: a law with a jump has no
equilibrium where soil begins to separate.
"""


@dataclass(frozen=True)
class ContactLaw:
    """Parameters of the law of m multipliers or points; every array has the shape (m,).

    Attributes:
        cohesion: c, shear strength without pressure [stress]; infinite if bonded.
        friction: mu, increase of the shear strength by the pressure [-].
        limit: greatest shear strength [stress]; infinite without limit.
        tension: T, tensile strength [stress].
        bilateral: whether the soil cannot separate.
    """

    cohesion: Floats
    friction: Floats
    limit: Floats
    tension: Floats
    bilateral: Flags

    def of(self, chosen: Integers | Flags) -> ContactLaw:
        """Returns the parameters of the chosen ones."""
        return ContactLaw(
            self.cohesion[chosen],
            self.friction[chosen],
            self.limit[chosen],
            self.tension[chosen],
            self.bilateral[chosen],
        )

    def strength(self, pressure: Floats) -> tuple[Floats, Floats]:
        """Returns the shear strength r [stress] and its derivative by the pressure [-], (m,) each.

        pressure: p [stress], shape (m,); not negative except with a tensile strength.
        """
        strength, slope = self.cohesion + self.friction * pressure, self.friction
        limited = strength > self.limit
        strength, slope = np.where(limited, self.limit, strength), np.where(limited, 0.0, slope)
        by_adhesion = SLOPE_OF_ADHESION * np.maximum(pressure, 0.0)
        reduced = ~self.bilateral & np.isfinite(self.cohesion) & (strength > by_adhesion)
        strength = np.where(reduced, by_adhesion, strength)
        slope = np.where(reduced & (pressure > 0.0), SLOPE_OF_ADHESION, slope)
        positive = strength > 0.0
        return np.where(positive, strength, 0.0), np.where(positive, slope, 0.0)


@dataclass(frozen=True)
class ContactResponse:
    """Tractions of m multipliers and their derivatives.

    Attributes:
        traction: sigma and tau, as internal forces of the soil [stress], shape (m, dim).
        derivative: by the mean gap and slips [stress/length], shape (m, dim, dim).
        closed: whether there is contact, shape (m,).
        sliding: whether the shear strength is reached, shape (m,).
    """

    traction: Floats
    derivative: Floats
    closed: Flags
    sliding: Flags


def respond(law: ContactLaw, trial: Floats, stiffness: Floats) -> ContactResponse:
    """Returns the response to trial tractions.

    Args:
        law: parameters of the m multipliers.
        trial: s_n and s_t [stress], shape (m, dim).
        stiffness: e_n and e_t [stress/length], shape (m, 2).
    """
    count, dim = trial.shape
    stiff_n, stiff_t = stiffness.T
    held = law.bilateral | (trial[:, 0] <= law.tension)
    closed = held | (law.tension > 0.0)
    normal = np.where(held, trial[:, 0], law.tension)
    pressure = np.where(closed, -normal, 0.0)
    strength, slope = law.strength(pressure)
    strength = np.where(closed, strength, 0.0)
    shear = trial[:, 1:]
    size = np.linalg.norm(shear, axis=1)
    sliding = closed & (size > strength)
    direction = shear / np.where(size > 0.0, size, 1.0)[:, None]
    factor = np.where(sliding, strength / np.where(size > 0.0, size, 1.0), 1.0)
    traction = np.zeros_like(trial)
    traction[:, 0] = np.where(closed, normal, 0.0)
    traction[:, 1:] = np.where(closed[:, None], factor[:, None] * shear, 0.0)

    derivative = np.zeros((count, dim, dim))
    derivative[:, 0, 0] = np.where(held, stiff_n, 0.0)
    dyad = direction[:, :, None] * direction[:, None, :]
    tangent = np.eye(dim - 1) - np.where(sliding, 1.0, 0.0)[:, None, None] * dyad
    tangent = np.where(closed, factor * stiff_t, 0.0)[:, None, None] * tangent
    derivative[:, 1:, 1:] = tangent
    coupling = np.where(sliding & held, -slope * stiff_n, 0.0)
    derivative[:, 1:, 0] = coupling[:, None] * direction
    return ContactResponse(traction, derivative, closed, sliding)
