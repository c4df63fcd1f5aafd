# SPDX-License-Identifier: BSD-3-Clause
"""Constitutive laws: what each of those in the compiled core declares of itself."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from typing import Any

from tilth import _core

PLASTIC_STRAIN = "plastic_strain"
"""Equivalent plastic strain [-]: known of the points of every law."""

EXCESS_PORE_PRESSURE = "excess_pore_pressure"
"""State variable of the laws whose stress is the total one [stress], compression positive; it
belongs to the Kirchhoff stress."""


@dataclass(frozen=True)
class Law:
    """A constitutive law (cpp/tilth/material/law.hpp), of the core or of the user.

    Attributes:
        name: that in a case file.
        parameters: names of its parameters, in the order in which the core takes them.
        state_variables: units ("stress" or "-") of what it stores at each point, by name.
        symmetric_tangent: whether the stress of a step has a potential (associated flow).
        source: None for a law of the core; else the law of the user that the core evaluates
            (`PythonLaw`, `CompiledLaw`, `Umat`).
    """

    name: str
    parameters: tuple[str, ...]
    state_variables: dict[str, str]
    symmetric_tangent: bool
    source: Any = field(default=None, compare=False)

    @property
    def core(self) -> Any:
        """What the functions of the core take as material."""
        return self.name if self.source is None else self.source

    @property
    def failure(self) -> str:
        """What it means that the law fails at a material point."""
        if self.source is None:
            return "the return mapping of a material point did not converge"
        return f"{self.source.title} found no stress for a material point (a failure, or NaN)"


@cache
def laws() -> dict[str, Law]:
    """Returns all laws of the core by name."""
    return {
        name: Law(name, tuple(parameters), dict(variables), symmetric)
        for name, (parameters, variables, symmetric) in _core.materials().items()
    }


def state_units() -> dict[str, str]:
    """Returns the units ("stress" or "-") of the state variables of the core's laws, by name."""
    units = {PLASTIC_STRAIN: "-"}
    for law in laws().values():
        units |= law.state_variables
    return units
