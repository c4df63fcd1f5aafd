# SPDX-License-Identifier: BSD-3-Clause
"""The state of the bodies at the start: their stress."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal

from pydantic import Field

from tilth.model.base import Declared, chosen_by
from tilth.model.fields import AsTuple, Entries, Name, NotNegative, Positive, Real, Vector


class GivenStress(Declared):
    """The same stress at all points of a body."""

    type: Literal["given"] = "given"
    body: Name
    """Name of the body."""
    stress: Vector
    """Effective Cauchy stress [stress], tension positive: xx, yy, zz, xy in 2D (in axisymmetry xx
    is radial, yy axial, zz hoop), xx, yy, zz, xy, yz, xz in 3D."""


class AtRest(Declared):
    """Stress under level ground: the weight above acts vertically, K0 times this stress sideways.

    The weight is that of the body's density under the body force that acts at time 0, which must be
    vertical. The normal stresses are -sigma_v along the vertical axis and -K0 sigma_v across it.
    """

    type: Literal["k0"] = "k0"
    body: Name
    """Name of the body."""
    K0: Positive
    """Coefficient of earth pressure at rest [-], > 0: horizontal over vertical effective stress."""
    surface_level: Real
    """Height of the level ground above the origin [length]: y in 2D, z in 3D."""
    surcharge: NotNegative = 0.0
    """Vertical pressure on the ground [stress], >= 0; a load of the same size must act on it."""


InitialStress = Annotated[
    GivenStress | AtRest,
    Field(discriminator="type"),
    chosen_by("type", GivenStress, AtRest),
]


class Initial(Declared):
    """State at time 0; bodies that are not named start without stress."""

    stress: Annotated[Sequence[InitialStress], Entries, AsTuple] = ()
    """Stress of bodies, an entry [[initial.stress]] for each."""
