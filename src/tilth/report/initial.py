# SPDX-License-Identifier: BSD-3-Clause
"""The declared stress at the start in words."""

from __future__ import annotations

from pathlib import Path

from tilth.model import Model
from tilth.model.fields import AXES
from tilth.model.initial import AtRest, GivenStress, GravityStress, InitialStress, TableStress
from tilth.model.initial_checks import at_rest_of
from tilth.report.amounts import amount, elevation, vector


def initial_stress(entry: InitialStress, model: Model) -> str:
    """Returns what gives the stress of a body."""
    stress = model.units.stress
    if isinstance(entry, GivenStress):
        return f"{entry.body}: stress {vector(entry.stress)} {stress}"
    if isinstance(entry, AtRest):
        return _at_rest(entry, model)
    if isinstance(entry, GravityStress):
        return f"{entry.body}: gravity loading in {entry.steps} parts"
    if isinstance(entry, TableStress):
        vertical = f"vertical pressure {amount(entry.vertical_pressure)} {stress}"
        if entry.K0 is not None:
            return f"{entry.body}: {vertical}, K0 {amount(entry.K0)}"
        lateral = amount(entry.horizontal_pressure or 0.0)
        return f"{entry.body}: {vertical}, horizontal pressure {lateral} {stress}"
    source = "" if entry.source is None else f" of {entry.source}"
    time = "at the end" if entry.time is None else f"at time {entry.time:g}"
    return f"{entry.body}: stress{source} in the run {Path(entry.folder).name} {time}"


def _at_rest(entry: AtRest, model: Model) -> str:
    body = next(body for body in model.bodies if body.name == entry.body)
    below = ""
    if entry.ground is not None:
        axis = AXES[model.dimension - 1]
        below = f" below {axis} = {elevation(entry.ground, model.units.length)}"
    coefficients = []
    for name in dict.fromkeys(body.materials):
        rest = at_rest_of(entry, name)
        key, value = ("K0", rest.K0) if rest.K0 is not None else ("K0_nc", rest.K0_nc)
        text = f"{key} {value}" if isinstance(value, str) else f"{key} {value:g}"
        if rest.overconsolidation_ratio is not None:
            text += f" (OCR {amount(rest.overconsolidation_ratio)})"
        elif rest.pre_overburden_pressure is not None:
            text += f" (POP {amount(rest.pre_overburden_pressure)} {model.units.stress})".rstrip()
        coefficients.append((text, name))
    words = ", ".join(f"{text} of {name}" for text, name in coefficients)
    if len({text for text, _ in coefficients}) == 1:
        words = coefficients[0][0]
    above = f", surcharge {entry.surcharge:g} {model.units.stress}" if entry.surcharge else ""
    return f"{entry.body}: weight of the soil{below}, {words}{above}"


def equilibrium_before(model: Model) -> str:
    """Returns what happens to the declared stress before the first step."""
    if not model.initial.equilibrium:
        return "no equilibrium is found before the first step"
    text = "equilibrium with the loads and boundaries at time 0 is found before the first step"
    if model.initial.reset_plastic_strain:
        text += ", then the plastic strain is set to zero"
    return text
