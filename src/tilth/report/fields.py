# SPDX-License-Identifier: BSD-3-Clause
"""Names, units and scalar values of the fields that colour a figure."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from tilth.arrays import Floats
from tilth.errors import BadInput
from tilth.model.laws import state_units
from tilth.model.parameters import parameter_unit
from tilth.model.settings import DARCY_VELOCITY
from tilth.output.snapshot import Snapshot

TENSOR = ("xx", "yy", "zz", "xy", "yz", "xz")
AXES = ("x", "y", "z")


def field_values(snapshot: Snapshot, name: str, units: Mapping[str, str]) -> tuple[Floats, str]:
    """Returns the values of a point field, shape (n,), and its full name with the unit.

    ``name`` is a field, or a field and a component: ``displacement`` (its magnitude),
    ``displacement_y``, ``cauchy_stress_yy``, ``cauchy_stress_mean`` (a third of the trace),
    ``cauchy_stress_von_mises``, ``plastic_strain`` or another state variable, ``volume``. Raises
    ``BadInput`` with the available names for any other.
    """
    fields = snapshot.point_fields
    parents = (key for key in fields if name.startswith(f"{key}_"))
    field = name if name in fields else next(parents, None)
    component = name[len(field) + 1 :] if field is not None else ""
    if field is not None:
        values = np.asarray(fields[field], dtype=np.float64)
        scalar = _component(values, component)
        if scalar is not None:
            title = "equivalent plastic strain" if field == "plastic_strain" else field
            if values.ndim == 2 and values.shape[1] == snapshot.dim:
                component = component or "magnitude"
            words = [title.replace("_", " "), component.replace("_", " ")]
            text = " ".join(word for word in words if word).capitalize()
            text = text.replace("von mises", "von Mises")
            return scalar, f"{text} [{field_unit(field, units)}]"
    known = ", ".join(sorted(fields.keys() - {"domain_corners"}))
    raise BadInput(
        "is not a field of the results",
        f"choose from {known}, or components of them (_x, _y, _xx, _xy, _mean, _von_mises)",
        key="output.colour_by",
        value=name,
    )


def parameter_fields(snapshot: Snapshot) -> list[str]:
    """Returns the names of the fields of the set-up: parameters that vary, and the layers."""
    return [
        name
        for name in snapshot.point_fields
        if name == "layer" or parameter_unit(name) is not None
    ]


def with_unit(name: str, unit: str) -> str:
    """Returns ``name [unit]``, or the name alone if there is no unit."""
    return f"{name} [{unit}]" if unit else name


def _component(values: Floats, component: str) -> Floats | None:
    """Returns one value per point, shape (n,); None if the field has no such component."""
    if values.ndim == 1:
        return values if component == "" else None
    if values.ndim == 2 and values.shape[1] == 6:
        if component == "mean":
            return np.asarray(values[:, :3].mean(axis=1))
        if component == "von_mises":
            deviator = values.copy()
            deviator[:, :3] -= values[:, :3].mean(axis=1, keepdims=True)
            square = (deviator[:, :3] ** 2).sum(axis=1) + 2.0 * (deviator[:, 3:] ** 2).sum(axis=1)
            return np.asarray(np.sqrt(1.5 * square))
        return values[:, TENSOR.index(component)] if component in TENSOR else None
    if values.ndim == 2:
        if component in ("", "magnitude"):
            return np.asarray(np.linalg.norm(values, axis=1))
        names = AXES[: values.shape[1]]
        return values[:, names.index(component)] if component in names else None
    names9 = [a + b for a in AXES for b in AXES]
    flat = values.reshape(len(values), 9)
    return flat[:, names9.index(component)] if component in names9 else None


def _labelled(unit: str, units: Mapping[str, str]) -> str:
    """Returns a unit such as "length / time" with the labels in it, if all of them are known."""
    if unit in units:
        return units[unit] or "-"
    words = re.findall("[a-z]+", unit)
    if not words or not all(units.get(word) for word in words):
        return unit
    return re.sub("[a-z]+", lambda word: units[word[0]], unit).replace(" ", "")


def field_unit(field: str, units: Mapping[str, str]) -> str:
    """Returns the label of the unit of a point field, without component; "-" if it has none."""
    if field in ("displacement", "domain"):
        return units.get("length", "") or "-"
    if field in ("cauchy_stress", "effective_stress", "pore_pressure"):
        return units.get("stress", "") or "-"
    of_time = field in ("velocity", "acceleration", DARCY_VELOCITY)
    if of_time and units.get("length") and units.get("time"):
        power = "\N{SUPERSCRIPT TWO}" if field == "acceleration" else ""
        return f"{units['length']}/{units['time']}{power}"
    if state_units().get(field) == "stress":
        return units.get("stress", "") or "-"
    if (unit := parameter_unit(field)) is not None:
        return _labelled(unit, units)
    return units.get(field) or "-"  # the volume, and the state variables of the user's laws
