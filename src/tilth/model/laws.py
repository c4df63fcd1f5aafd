# SPDX-License-Identifier: BSD-3-Clause
"""The constitutive laws of the compiled core: what each declares of itself."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from tilth import _core

PLASTIC_STRAIN = "plastic_strain"
"""Equivalent plastic strain [-]: known of the points of every law."""


@dataclass(frozen=True)
class Law:
    """A constitutive law (cpp/tilth/material/law.hpp).

    Attributes:
        name: that in a case file.
        parameters: names of its parameters, in the order in which the core takes them.
        state_variables: units ("stress" or "-") of what it stores at each point, by name.
        symmetric_tangent: whether the stress of a step has a potential (associated flow).
    """

    name: str
    parameters: tuple[str, ...]
    state_variables: dict[str, str]
    symmetric_tangent: bool


@cache
def laws() -> dict[str, Law]:
    """Returns all laws by name."""
    return {
        name: Law(name, tuple(parameters), dict(variables), symmetric)
        for name, (parameters, variables, symmetric) in _core.materials().items()
    }


def state_units() -> dict[str, str]:
    """Returns the units ("stress" or "-") of the state variables of all laws, by name."""
    units = {PLASTIC_STRAIN: "-"}
    for law in laws().values():
        units |= law.state_variables
    return units
