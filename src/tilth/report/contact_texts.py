# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies, contact pairs and laws of contact in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from tilth.model import Contact, ContactPair, Model, RigidBody
from tilth.report.amounts import vector


def law_text(law: Contact, stress: str) -> str:
    """Returns a law of contact in words; ``stress`` is the label of its unit."""
    normal = "never opens"
    if law.normal == "unilateral":
        strength = law.tensile_strength
        normal = "opens under tension" if strength is None else f"opens at {strength:g} {stress}"
    limit = ""
    if law.adhesion_factor is not None:
        limit = f"{law.adhesion_factor:g} of the soil's cohesion"
    elif law.shear_limit is not None:
        limit = f"{law.shear_limit:g} {stress}".rstrip()
    tangential = {
        "smooth": "smooth",
        "friction": f"friction {law.friction or 0.0:g}"
        + (f", shear at most {limit}" * bool(limit)),
        "adhesion": f"shear resistance {limit}",
        "rough": "shear resistance that of the soil",
        "bonded": "no sliding",
    }[law.tangential]
    return f"{normal}, {tangential}"


def laws_text(law: Contact, others: Mapping[str, Contact] | None, stress: str) -> Iterator[str]:
    """Yields a law of contact and those with other soil bodies in words."""
    yield f"contact: {law_text(law, stress)}"
    for name, other in (others or {}).items():
        yield f"with {name}: {law_text(other, stress)}"


def motion_texts(body: RigidBody, model: Model) -> Iterator[str]:
    """Yields the motion of a rigid body, its free components, and what acts on these."""
    units = model.units
    components = RigidBody.components(model.dimension, model.analysis.kind)
    prescribed = [c for c in components if body.is_prescribed(c)]
    for component in prescribed:
        yield _moved(body, component, units.length)
    free = [c.replace("_", " about ") for c in components if c not in prescribed]
    if free:
        yield f"free: {', '.join(free)}"
    for key, unit in (("force", units.force), ("moment", f"{units.force} {units.length}")):
        for name, value in _entries(key, getattr(body, key)):
            yield f"{name} {_amount(value, unit)}"
    if body.mass is not None:
        yield f"weight of a mass of {body.mass:g} {units.mass}".rstrip()
    for component, stiffness in (body.springs or {}).items():
        turning = component.startswith("rotation")
        unit = f"{units.force} {units.length}/rad" if turning else f"{units.force}/{units.length}"
        name = component.replace("_", " about ")
        yield f"spring {name} {stiffness:g} {unit if units.force else ''}".rstrip()


def body_text(body: RigidBody, shapes: str, model: Model) -> str:
    """Returns a rigid body in words; ``shapes`` are its geometries."""
    laws = laws_text(body.contact, body.contact_with, model.units.stress)
    parts = [
        f"rigid body, {shapes}",
        f"centre {vector(body.centre)}",
        *motion_texts(body, model),
        *laws,
    ]
    return f"{body.name}: {'; '.join(parts)}"


def pair_text(pair: ContactPair, stress: str) -> str:
    """Returns a contact pair in words; ``stress`` is the label of its unit."""
    parts = [f"between {pair.bodies[0]} and {pair.bodies[1]}", law_text(pair.contact, stress)]
    if pair.wished_in_place:
        parts.append("wished in place")
    return f"{pair.name}: {'; '.join(parts)}"


def _moved(body: RigidBody, component: Any, length: str) -> str:
    if component.startswith("rotation"):
        value = body.rotation
        name = component.replace("_", " about ")
        if isinstance(value, Mapping):
            value = value.get(component.removeprefix("rotation_"))
        return f"{name} {_amount(value, 'degrees')}"
    return f"u{component} = {_amount((body.displacement or {}).get(component), length)}"


def _entries(key: str, entry: Any) -> Iterator[tuple[str, Any]]:
    if isinstance(entry, Mapping):
        for axis, value in entry.items():
            yield f"{key} {axis}", value
    elif entry is not None:
        yield key, entry


def _amount(value: Any, unit: str) -> str:
    """Returns a number, or the last value of a table, with its unit."""
    if isinstance(value, int | float):
        return f"{value:g} {unit}".rstrip()
    return f"by a table, {value[-1][1]:g} {unit}".rstrip() + " at its end"
