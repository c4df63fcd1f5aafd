# SPDX-License-Identifier: BSD-3-Clause
"""Kinds of the numbers of a law: what strength reduction and other units do to each.

Every law says of each of its parameters and state variables which kind it is, in one mapping
beside their declaration. Units, strength reduction and the frozen geometry
(docs/theory/strength_reduction.md) follow from it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal, get_args

import numpy as np

from tilth.arrays import Floats

Values = float | Floats
"""A parameter: one number for all points, or one for each, shape (n,)."""

Kind = Literal[
    "stiffness",
    "strength",
    "hardening",
    "stress",
    "friction angle",
    "friction slope",
    "dilation angle",
    "dilation slope",
    "strain",
    "per strain",
    "dimensionless",
    "length",
    "density",
    "conductivity",
    "preconsolidation",
    "overconsolidation",
]
"""What a parameter or state variable of a law is."""


@dataclass(frozen=True)
class KindRules:
    """What is done to the numbers of a kind.

    Attributes:
        unit: as in the meanings of keys: "stress", "-", "degrees", "length" and others.
        meaning: for the reference.
        strain_power: power of strain in it: 1 for a strain, -1 for what is per strain.
        reduced: what a factor of safety divides, the "value" or its "tangent"; "limited" is kept up
            to the reduced friction; None is kept; "never" makes the law one that cannot be reduced.
    """

    unit: str
    meaning: str
    strain_power: int = 0
    reduced: Literal["value", "tangent", "limited", "never"] | None = None


KINDS: Final[Mapping[Kind, KindRules]] = {
    "stiffness": KindRules("stress", "modulus of elasticity, also that of a pore fluid", -1),
    "strength": KindRules(
        "stress", "cohesion, yield stress, tensile strength or another one", 0, "value"
    ),
    "hardening": KindRules("stress", "change of a strength with plastic strain", -1, "value"),
    "stress": KindRules("stress", "a stress that is no strength, such as a reference pressure"),
    "friction angle": KindRules("degrees", "angle of friction", 0, "tangent"),
    "friction slope": KindRules(
        "-", "shear strength over pressure, such as tan(phi) or the slope of a cone", 0, "value"
    ),
    "dilation angle": KindRules("degrees", "angle of dilation", 0, "limited"),
    "dilation slope": KindRules("-", "change of volume over shear strain in flow", 0, "limited"),
    "strain": KindRules("-", "a strain, or the strain over which something changes", 1),
    "per strain": KindRules("-", "a rate: change of a pure number with strain", -1),
    "dimensionless": KindRules("-", "a pure number, such as Poisson's ratio"),
    "length": KindRules("length", "a length"),
    "density": KindRules("mass / length^3", "mass over volume"),
    "conductivity": KindRules("length / time", "hydraulic conductivity"),
    "preconsolidation": KindRules(
        "stress", "size of a yield surface that follows the pressure", 0, "never"
    ),
    "overconsolidation": KindRules(
        "-", "the same over that through the initial stress", 0, "never"
    ),
}
"""The rules of each kind."""

CHOICES: Final = ", ".join(f'"{kind}"' for kind in get_args(Kind))
"""All kinds, for messages."""

LIMITS: Final[Mapping[Kind, Kind]] = {
    "dilation angle": "friction angle",
    "dilation slope": "friction slope",
}
"""Friction that dilation must not exceed."""


def stiffened(kind: Kind, value: Values, factor: float) -> Values:
    """Returns a number of a law with all moduli multiplied, and all strains divided, by a factor.

    The law has the same stress at strains over the factor [-] as the law itself at these strains.
    """
    power = KINDS[kind].strain_power
    if power == 0:
        return value
    return value / factor if power > 0 else value * factor


def reduced(
    kinds: Mapping[str, Kind], values: Mapping[str, Values], factor: float
) -> dict[str, Values]:
    """Returns the numbers of a law with its strength over a factor.

    Args:
        kinds: of the numbers, by name.
        values: the numbers by name, one number or shape (n,) each.
        factor: of safety [-], > 0.
    """
    found = {name: _divided(kinds[name], value, factor) for name, value in values.items()}
    for name in values:
        for other in values:
            if kinds[other] == LIMITS.get(kinds[name]):
                found[name] = np.minimum(found[name], found[other])
    return found


def _divided(kind: Kind, value: Values, factor: float) -> Values:
    rule = KINDS[kind].reduced
    if rule == "tangent":
        return reduced_angle(value, factor)
    return value / factor if rule == "value" else value


def reduced_angle(degrees: Values, factor: Values) -> Values:
    """Returns the angle whose tangent is that of `degrees` over the factor."""
    return np.degrees(np.arctan(np.tan(np.radians(degrees)) / factor))


def fits_unit(kind: Kind, unit: str) -> bool:
    """Returns whether a state variable of the unit "stress" or "-" can be of a kind."""
    return (KINDS[kind].unit == "stress") == (unit == "stress")


def has_strength(kinds: Mapping[str, Kind]) -> bool:
    """Returns whether one of the numbers is a strength, so that the law can fail."""
    return any(KINDS[kind].reduced in ("value", "tangent") for kind in kinds.values())


def has_friction(kinds: Mapping[str, Kind]) -> bool:
    """Returns whether one of the numbers is a friction."""
    return any(kind in LIMITS.values() for kind in kinds.values())


def is_reducible(kinds: Mapping[str, Kind]) -> bool:
    """Returns whether the kinds of all numbers say what a factor of safety does to them."""
    return all(KINDS[kind].reduced != "never" for kind in kinds.values())
