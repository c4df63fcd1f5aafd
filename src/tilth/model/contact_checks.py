# SPDX-License-Identifier: BSD-3-Clause
"""Checks of contact and of rigid bodies against the rest of the model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.contact import Contact
from tilth.model.fields import AXES
from tilth.model.geometry import PlaneGeometry
from tilth.model.implicit import ImplicitBoundary
from tilth.model.loads import BodyForce
from tilth.model.materials import Material
from tilth.model.problems import dotted, unknown_name
from tilth.model.rigid_bodies import RigidBody
from tilth.model.soils import MohrCoulomb
from tilth.model.staging import loading_stages

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

_STRENGTHS = ("cohesion", "residual_cohesion")


LARGEST_MOMENT = 1.001
"""Greatest principal moment of inertia over the sum of the other two; 1 for a thin plate."""


def contact_problems(model: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the laws of contact and with rigid bodies."""
    for key, entry in _in_contact(model):
        yield from _law_problems(model, key, entry)
    for i, pair in enumerate(model.contact_pairs):
        yield from _strength_problems(
            model, f"contact_pairs[{i}].contact", pair.contact, pair.bodies
        )
    for i, body in enumerate(model.rigid_bodies):
        key = f"rigid_bodies[{i}]"
        problems = [*_component_problems(model, key, body), *_form_problems(model, key, body)]
        yield from problems
        if not problems:
            yield from _free_components(model, key, body)
        for where, shape in model.shapes_of(body):
            if isinstance(shape, PlaneGeometry):
                what = "a plane is infinite: it cannot be a rigid body"
                remedy = "give a box or a plate, or declare an implicit boundary with `contact`"
                yield Problem(f"{where}.type", what, remedy, shape.type)
    for i, boundary in enumerate(model.boundaries):
        if not isinstance(boundary, ImplicitBoundary) or boundary.condition is None:
            continue
        if boundary.geometry.has_two_sides:
            what = "has soil on both sides, which a condition cannot hold apart"
            remedy = "give `contact` instead of `condition`, or name one side"
            yield Problem(f"boundaries[{i}].geometry", what, remedy)


def _in_contact(model: Declaration) -> Iterator[tuple[str, ImplicitBoundary | RigidBody]]:
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, ImplicitBoundary) and boundary.contact is not None:
            yield f"boundaries[{i}]", boundary
    for i, body in enumerate(model.rigid_bodies):
        yield f"rigid_bodies[{i}]", body


def _law_problems(
    model: Declaration, key: str, entry: ImplicitBoundary | RigidBody
) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.bodies}
    own = entry.contact_with or {}
    for name, law in own.items():
        where = dotted((*_parts(key), "contact_with", name))
        if name not in bodies:
            yield Problem(where, *unknown_name("body", name, bodies))
        else:
            yield from _strength_problems(model, where, law, [name])
    if entry.contact is not None:
        others = [name for name in bodies if name not in own]
        yield from _strength_problems(model, f"{key}.contact", entry.contact, others)


def _parts(key: str) -> tuple[str | int, ...]:
    section, _, number = key.rstrip("]").partition("[")
    return section, int(number)


def _strength_problems(
    model: Declaration, key: str, law: Contact, bodies: Sequence[str]
) -> Iterator[Problem]:
    """Laws that take a strength from soil which has none."""
    if not law.needs_strength:
        return
    rough = law.tangential == "rough"
    where = f"{key}.tangential" if rough else f"{key}.adhesion_factor"
    value = law.tangential if rough else law.adhesion_factor
    for name in _materials_of(model, bodies):
        material = model.materials[name]
        if not material.has_shear_strength:
            what = f"the material {name!r} ({material.model}) has no shear strength of its own"
        elif rough and _has_friction_under_excess_pressure(material):
            what = (
                f"the strength of the material {name!r} depends on the effective stress, but the "
                "contact has the total one"
            )
        elif law.adhesion_factor and _has_no_cohesion(material):
            what = f"the material {name!r} has no cohesion, of which this is a share"
        else:
            continue
        remedy = "give `shear_limit` instead"
        if rough:
            remedy = 'choose tangential = "adhesion" with `shear_limit`, or "friction"'
        yield Problem(where, what, remedy, value)
        return


def _has_friction_under_excess_pressure(material: Material) -> bool:
    fluid = getattr(material, "pore_fluid_bulk_modulus", None)
    return fluid is not None and getattr(material, "friction_angle", 0.0) != 0.0


def _has_no_cohesion(material: Material) -> bool:
    keys = _STRENGTHS if isinstance(material, MohrCoulomb) else _STRENGTHS[:1]
    given = [value for key in keys if (value := getattr(material, key, None)) is not None]
    return bool(given) and all(value == 0.0 for value in given)


def _materials_of(model: Declaration, bodies: Sequence[str]) -> list[str]:
    """Returns the materials that soil bodies have in any stage; those that are declared."""
    used = {m for body in model.bodies if body.name in bodies for m in body.materials}
    for _, stage in loading_stages(model):
        used |= {new for old, new in stage.materials.items() if old in used}
    return [name for name in model.materials if name in used]


def _component_problems(model: Declaration, key: str, body: RigidBody) -> Iterator[Problem]:
    """Components of motion or force that this kind of analysis does not have."""
    kind = model.analysis.kind
    components = body.components(model.dimension, kind)
    translations = [each for each in components if each in AXES]
    for name in ("displacement", "force"):
        for axis in getattr(body, name) or {}:
            if axis not in translations:
                yield _absent(f"{key}.{name}.{axis}", axis, kind, getattr(body, name)[axis])
    for component, stiffness in (body.springs or {}).items():
        if component not in components:
            yield _absent(f"{key}.springs.{component}", component, kind, stiffness)
    for name in ("rotation", "moment"):
        entry = getattr(body, name)
        if entry is None:
            continue
        if kind == "axisymmetric":
            yield _absent(f"{key}.{name}", "rotation", kind, entry)
        elif model.dimension == 2 and isinstance(entry, Mapping):
            what = f"{kind} has one rotation, about z"
            yield Problem(f"{key}.{name}", what, "give a number, or rows (time, value)", entry)
        elif model.dimension == 3 and not isinstance(entry, Mapping):
            remedy = f"name the components, such as {name} = {{ x = 0, y = 0, z = 0 }}"
            yield Problem(f"{key}.{name}", "has three components in 3D", remedy, entry)


def _absent(key: str, component: str, kind: str, value: Any) -> Problem:
    if kind == "axisymmetric":
        what = f"{component} is zero by axisymmetry: a body can move along y only"
        return Problem(key, what, "leave it out", value)
    names = ", ".join(RigidBody.components(3 if kind == "3d" else 2, kind))
    return Problem(key, f"{kind} has no component {component}", f"choose from {names}", value)


def _form_problems(model: Declaration, key: str, body: RigidBody) -> Iterator[Problem]:
    inertia, kind = body.moments_of_inertia, model.analysis.kind
    if kind == "axisymmetric":
        if len(body.centre) == 2 and body.centre[0] != 0.0:
            what = f"has r = {body.centre[0]:g}, but the body surrounds the axis of symmetry"
            yield Problem(f"{key}.centre", what, "give x = 0", body.centre)
        if inertia is not None:
            what = "has no meaning in axisymmetry, where the body does not rotate"
            yield Problem(f"{key}.moments_of_inertia", what, "leave it out", inertia)
    elif inertia is not None:
        three = isinstance(inertia, Sequence) and len(inertia) == 3
        if model.dimension == 2 and isinstance(inertia, Sequence):
            yield Problem(f"{key}.moments_of_inertia", "must be one number in 2D", "", inertia)
        elif model.dimension == 3 and not three:
            what = "must be three numbers in 3D"
            yield Problem(f"{key}.moments_of_inertia", what, "give [Ixx, Iyy, Izz]", inertia)
        elif isinstance(inertia, Sequence) and 2.0 * max(inertia) > LARGEST_MOMENT * sum(inertia):
            what = "one is greater than the sum of the other two, which no body has"
            remedy = "give the moments about the principal axes through the centre of mass"
            yield Problem(f"{key}.moments_of_inertia", what, remedy, inertia)


def _inertia_problems(model: Declaration, key: str, body: RigidBody) -> Iterator[Problem]:
    """Free components need inertia, and only they have a velocity of their own."""
    components = body.components(model.dimension, model.analysis.kind)
    free = [each for each in components if not body.is_prescribed(each)]
    moving, turning = [c for c in free if c in AXES], [c for c in free if c not in AXES]
    remedy = "give it, or prescribe them in `displacement` (0 holds them)"
    if moving and body.mass is None:
        what = f"missing: {', '.join(moving)} are free and have inertia"
        yield Problem(f"{key}.mass", what, remedy)
    if turning and body.moments_of_inertia is None:
        what = f"missing: {', '.join(turning)} is free and has inertia"
        yield Problem(f"{key}.moments_of_inertia", what, remedy.replace("displacement", "rotation"))
    dim, spin = model.dimension, body.angular_velocity
    if body.velocity is not None:
        if len(body.velocity) != dim:
            what = f"has {len(body.velocity)} components, expected {dim}"
            yield Problem(f"{key}.velocity", what, "", body.velocity)
        elif held := [a for a, v in zip(AXES, body.velocity, strict=False) if v and a not in free]:
            what = f"is not zero along {', '.join(held)}, which is not free"
            yield Problem(f"{key}.velocity", what, "give 0 there", body.velocity)
    if spin is not None:
        if not turning:
            yield Problem(f"{key}.angular_velocity", "no rotation is free", "leave it out", spin)
        elif isinstance(spin, float) == (dim == 3):
            what = f"must be {'a vector in 3D' if dim == 3 else 'a number in 2D'}"
            yield Problem(f"{key}.angular_velocity", what, "", spin)


def _free_components(model: Declaration, key: str, body: RigidBody) -> Iterator[Problem]:
    """Free components with nothing that holds or loads them."""
    gravity = any(isinstance(load, BodyForce) for load in model.loads)
    if model.analysis.inertia is not None:
        yield from _inertia_problems(model, key, body)
        return
    for name in ("velocity", "angular_velocity"):
        if (value := getattr(body, name)) is not None:
            remedy = "add `inertia` to [analysis], or leave it out"
            yield Problem(f"{key}.{name}", "has no meaning without inertia", remedy, value)
    if body.mass is not None and gravity:
        return
    loose = [
        each
        for each in body.components(model.dimension, model.analysis.kind)
        if not body.is_prescribed(each) and not body.is_loaded(each) and not body.spring(each)
    ]
    if not loose:
        return
    what = f"free body without weight or spring: nothing acts on {', '.join(loose)}"
    if body.mass is not None:
        what += '; its mass has no weight, because there is no load of type = "body_force"'
    remedy = (
        "prescribe these components in `displacement` and `rotation` (0 holds them), or give "
        "`force`, `moment`, `springs` or a `mass` with gravity; a force of 0 leaves them free"
    )
    yield Problem(key, what, remedy)
