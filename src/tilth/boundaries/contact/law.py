# SPDX-License-Identifier: BSD-3-Clause
"""The contact law: normal and shear traction of each multiplier by its gap and slip.

With the trial tractions s_n = lambda_n + e_n g and s_t = lambda_t + e_t w_t, tension positive:

    normal   sigma = s_n while s_n <= T, otherwise 0 (bilateral: always s_n),      p = -sigma
    stick    tau = s_t while |s_t| <= r,      r = min(c + mu p, limit)
    slip     tau = r s_t / |s_t|

Without contact both are zero (docs/theory/contact.md; Coulomb friction as in Wriggers,
Computational Contact Mechanics, 2006). Of p, friction has the part that the soil's skeleton bears:
without the excess pore pressure pi beside the surface, so that c - mu pi stands in place of c.
Newton's iteration is semi-smooth: an active-set method (Hueber & Wohlmuth 2005). Where slip would
turn round from one linearisation to the next the multiplier sticks first: with stiff tractions the
iteration would otherwise alternate between both directions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tilth.arrays import Flags, Floats, Integers

LARGEST_SLOPE = 10.0
"""Greatest ratio of shear strength to pressure where the soil can separate.

An adhesion, or a bond, acts there only on soil that is pressed against the surface: it increases to
its full value at a tenth of it as pressure. A law with a jump has no equilibrium where soil begins
to separate.
"""

STRENGTH_TOLERANCE = 1e-9
"""Relative difference of a shear traction from the shear strength that is round-off."""


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

    def columns(self) -> tuple[Floats, Floats, Floats, Floats, Flags]:
        """Returns the parameters in the order of the arguments."""
        return self.cohesion, self.friction, self.limit, self.tension, self.bilateral

    def of(self, chosen: Integers | Flags) -> ContactLaw:
        """Returns the parameters of the chosen ones."""
        return ContactLaw(
            self.cohesion[chosen],
            self.friction[chosen],
            self.limit[chosen],
            self.tension[chosen],
            self.bilateral[chosen],
        )

    def holds(self, normal: Floats) -> Flags:
        """Returns which are in contact at trial normal tractions [stress], shape (m,)."""
        return self.bilateral | (normal <= self.tension)

    def under(self, pore_pressure: Floats) -> ContactLaw:
        """Returns the law beside soil with these excess pore pressures pi [stress], shape (m,)."""
        return replace(self, cohesion=self.cohesion - self.friction * pore_pressure)

    def strength(self, pressure: Floats) -> tuple[Floats, Floats]:
        """Returns the shear strength r [stress] and its derivative by the pressure [-], (m,) each.

        pressure: p [stress], shape (m,); not negative except with a tensile strength.
        """
        strength, slope = self.cohesion + self.friction * pressure, self.friction
        limited = strength > self.limit
        strength, slope = np.where(limited, self.limit, strength), np.where(limited, 0.0, slope)
        largest = LARGEST_SLOPE * np.maximum(pressure, 0.0)
        reduced = ~self.bilateral & (strength > largest)
        strength = np.where(reduced, largest, strength)
        slope = np.where(reduced & (pressure > 0.0), LARGEST_SLOPE, slope)
        positive = strength > 0.0
        return np.where(positive, strength, 0.0), np.where(positive, slope, 0.0)


@dataclass(frozen=True)
class ContactResponse:
    """Tractions of m multipliers and their derivatives.

    Attributes:
        traction: sigma and tau, as internal forces of the soil [stress], shape (m, dim).
        derivative: by the mean gap and slips [stress/length], shape (m, dim, dim).
        by_pore_pressure: derivative of the traction by the excess pore pressure [-], (m, dim).
        closed: whether there is contact, shape (m,).
        slip: direction of the shear traction where the shear strength is reached, unit vectors,
            shape (m, dim - 1); zero elsewhere.
        turned: whether it sticks beyond the shear strength, because the shear traction points
            against the slip at the last linearisation, shape (m,). No equilibrium may have that.
    """

    traction: Floats
    derivative: Floats
    by_pore_pressure: Floats
    closed: Flags
    slip: Floats
    turned: Flags

    @property
    def sliding(self) -> Flags:
        """Whether the shear strength is reached, shape (m,)."""
        return np.asarray(self.slip.any(axis=1))


def first_slip(law: ContactLaw, carried: Floats) -> Floats:
    """Returns the directions in which multipliers slide already at the start of a step.

    carried: tractions of the last step [stress], shape (m, dim). As `ContactResponse.slip`.
    """
    strength, _ = law.strength(-carried[:, 0])
    size = np.linalg.norm(carried[:, 1:], axis=1)
    sliding = (size >= (1.0 - STRENGTH_TOLERANCE) * strength) & (size > 0.0)
    return np.where(sliding, 1.0 / np.where(sliding, size, 1.0), 0.0)[:, None] * carried[:, 1:]


def respond(
    law: ContactLaw,
    trial: Floats,
    stiffness: Floats,
    slip: Floats,
    given: Floats | None = None,
    held: Flags | None = None,
    fixed: Flags | None = None,
) -> ContactResponse:
    """Returns the response to trial tractions.

    Args:
        law: parameters of the m multipliers.
        trial: s_n and s_t [stress], shape (m, dim).
        stiffness: e_n and e_t [stress/length], shape (m, 2).
        slip: of the response at the last linearisation, shape (m, dim - 1).
        given: shear strength [stress], shape (m,), in place of that of the pressure.
        held: which multipliers are not to open now, shape (m,); none if not given.
        fixed: which are closed, whatever their traction, shape (m,); by the law if not given.
    """
    count, dim = trial.shape
    stiff_n, stiff_t = stiffness.T
    closed = law.holds(trial[:, 0]) if fixed is None else fixed
    if held is not None:
        closed = closed | held
    strength, slope = law.strength(-trial[:, 0])
    if given is not None:
        strength, slope = given, np.zeros(count)
    shear = trial[:, 1:]
    size = np.linalg.norm(shear, axis=1)
    turns_round = (strength > 0.0) & (np.einsum("mi,mi->m", shear, slip) < 0.0)
    beyond = closed & (size > strength)
    sliding, turned = beyond & ~turns_round, beyond & turns_round
    direction = np.where(sliding, 1.0 / np.where(sliding, size, 1.0), 0.0)[:, None] * shear
    factor = np.where(sliding, strength, size) / np.where(size > 0.0, size, 1.0)
    factor = np.where(size > 0.0, factor, 1.0)
    traction = np.concatenate([trial[:, :1], factor[:, None] * shear], axis=1)
    traction[~closed] = 0.0

    derivative = np.zeros((count, dim, dim))
    derivative[:, 0, 0] = stiff_n
    tangent = np.eye(dim - 1) - direction[:, :, None] * direction[:, None, :]
    derivative[:, 1:, 1:] = (factor * stiff_t)[:, None, None] * tangent
    derivative[:, 1:, 0] = -(slope * stiff_n)[:, None] * direction
    derivative[~closed] = 0.0
    by_pore_pressure = np.zeros((count, dim))
    by_friction = np.where(slope == law.friction, slope, 0.0)  # not by a limit
    by_pore_pressure[:, 1:] = -by_friction[:, None] * direction
    return ContactResponse(traction, derivative, by_pore_pressure, closed, direction, turned)
