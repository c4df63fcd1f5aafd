# SPDX-License-Identifier: BSD-3-Clause
"""Names of the state variables of the user's laws: fields of the results and tracked quantities."""

from __future__ import annotations

from typing import Any

from tilth.model.laws import PLASTIC_STRAIN

RESERVED = (
    PLASTIC_STRAIN,
    *("displacement", "cauchy_stress", "volume", "domain", "domain_corners"),
    *("effective_stress", "pore_pressure", "darcy_velocity"),
    *("deformation_gradient", "length", "force", "stress", "mass", "time"),
    *(f"elastic_strain_{number}" for number in (1, 2, 3)),
)
"""Names that results have in any case, and those of the units."""

LONGEST = 100
"""Characters of a name, at most."""


def name_problem(name: Any) -> tuple[str, str] | None:
    """Returns (problem, remedy) of a name that no state variable can have, else None."""
    if not isinstance(name, str) or not name.isidentifier() or not name.isascii():
        return "has not a name of letters, digits and underscores", 'such as "strength"'
    if len(name) > LONGEST:
        return f"has a name of {len(name)} characters", f"use at most {LONGEST}"
    if name in RESERVED:
        return "has a name that the results have already", "choose another name"
    return None
