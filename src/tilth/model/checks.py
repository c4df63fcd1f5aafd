# SPDX-License-Identifier: BSD-3-Clause
"""Consistency checks between the entries of a model: references by name, and required entries."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.boundaries import AffineBoundary
from tilth.model.contact_checks import contact_problems
from tilth.model.contact_pairs import contact_pair_problems
from tilth.model.fields import AXES
from tilth.model.flow_checks import flow_problems
from tilth.model.implicit import ImplicitBoundary
from tilth.model.initial_checks import initial_problems
from tilth.model.laws import PLASTIC_STRAIN
from tilth.model.loads import BodyForce, LineForce, PointForce, SeismicLoad
from tilth.model.magnitudes import magnitude_problems
from tilth.model.placement import geometry_problems
from tilth.model.problems import dotted, suggestion, unknown_name
from tilth.model.settings import (
    COLOURS,
    COLOURS_OF_FLOW,
    COLOURS_OF_INERTIA,
    COLOURS_OF_WATER,
)
from tilth.model.sizes import size_problems
from tilth.model.stage_checks import problems_in_stages, stage_problems
from tilth.model.staging import loading_stages
from tilth.model.surface import SurfaceLoad
from tilth.model.track import OF_FLOW, OF_FLOW_BOUNDARIES
from tilth.model.track_checks import track_problems
from tilth.model.turns import turns_in_steps

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration


def problems_between_entries(model: Declaration) -> list[Problem]:
    """Returns the problems between the entries of a model; geometry only if all sizes are right."""
    declared = {name: each.declared_variables() for name, each in model.materials.items()}
    problems = [
        *_repeated_names(model),
        *_unknown_references(model),
        *state_variable_problems(model, declared),
        *initial_problems(model),
        *_needs_implicit(model),
        *track_problems(model),
        *_needs_water(model),
        *_needs_inertia(model),
        *_densities(model),
        *_needs_gravity(model),
        *_needs_time(model),
        *flow_problems(model),
        *size_problems(model),
        *contact_problems(model),
        *contact_pair_problems(model),
    ]
    if model.stages:
        problems += [*_without_schedule(model), *stage_problems(model)]
    if not problems:
        problems = [*magnitude_problems(model)] or geometry_problems(model)
        of_stages = problems_in_stages(model) if model.stages else problems_of_stage(model)
        problems = [*of_stages, *problems]
    return problems


def problems_of_stage(model: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the boundaries and loads that act together."""
    yield from _needs_gravity(model)
    yield from _affine_stands_alone(model)
    yield from _constrained_directions(model)
    yield from turns_in_steps(model)


def _without_schedule(model: Declaration) -> Iterator[Problem]:
    if "schedule" in model.model_fields_set:
        what = "is given together with `stages`, each of which has its own"
        yield Problem("schedule", what, "leave it out")


def _repeated_names(model: Declaration) -> Iterator[Problem]:
    for sections in (
        ("bodies",),
        ("boundaries", "rigid_bodies", "contact_pairs", "flow.boundaries"),
        ("loads",),
        ("track",),
        ("stages",),
    ):
        keys: dict[str, str] = {}
        entries = [(f"{s}[{i}]", e) for s in sections for i, e in enumerate(_entries(model, s))]
        for key, entry in entries:
            name = entry.name
            if name is not None and (first := keys.setdefault(name, key)) != key:
                what = f"is already the name of {first}"
                yield Problem(f"{key}.name", what, "give each entry a different name", name)


def _entries(model: Declaration, section: str) -> Sequence[Any]:
    if section == "flow.boundaries":
        return () if model.flow is None else model.flow.boundaries
    entries: Sequence[Any] = getattr(model, section)
    return entries


def _unknown_references(model: Declaration) -> Iterator[Problem]:
    bodies = {body.name: number for number, body in enumerate(model.bodies)}
    boundaries = dict.fromkeys(
        each.name for each in (*model.boundaries, *model.rigid_bodies, *model.contact_pairs)
    )
    for i, body in enumerate(model.bodies):
        for key, material in zip(body.material_keys(), body.materials, strict=True):
            if material not in model.materials:
                words = unknown_name("material", material, model.materials)
                yield Problem(f"bodies[{i}].{key}", *words, material)
    for i, load in enumerate(model.loads):
        if isinstance(load, PointForce | LineForce | SurfaceLoad) and load.body not in bodies:
            yield Problem(f"loads[{i}].body", *unknown_name("body", load.body, bodies), load.body)
        elif isinstance(load, SurfaceLoad):
            number = bodies[load.body]
            if model.bodies[number].surface is None:
                what = f"the body {load.body!r} has no tracked surface that could carry a load"
                remedy = f"add `surface = {{}}` to bodies[{number}]"
                yield Problem(f"loads[{i}].body", what, remedy, load.body)
    for i, track in enumerate(model.track):
        if track.body is not None and track.body not in bodies:
            words = unknown_name("body", track.body, bodies)
            yield Problem(f"track[{i}].body", *words, track.body)
        elif track.quantity == "enclosed" and track.body is not None:
            number = bodies[track.body]
            if model.bodies[number].surface is None:
                what = f"the body {track.body!r} has no tracked surface that could enclose anything"
                remedy = f"add `surface = {{}}` to bodies[{number}]"
                yield Problem(f"track[{i}].body", what, remedy, track.body)
        known, kind = boundaries, "boundary"
        if track.quantity in OF_FLOW_BOUNDARIES:
            known, kind = dict.fromkeys(model.flow_boundary_keys()), "flow boundary"
        if track.boundary is not None and track.boundary not in known:
            words = unknown_name(kind, track.boundary, known)
            yield Problem(f"track[{i}].boundary", *words, track.boundary)


def state_variable_problems(
    model: Declaration, variables: Mapping[str, Mapping[str, str] | None]
) -> Iterator[Problem]:
    """Yields names of state variables, in `[[track]]` and `colour_by`, that no law has.

    variables: units of the state variables of each material; None for those not yet known, of which
        nothing is refused.
    """
    for i, track in enumerate(model.track):
        known = _known(model, variables, track.body)
        if track.variable is not None and known is not None and track.variable not in known:
            words = unknown_name("state variable", track.variable, known)
            yield Problem(f"track[{i}].variable", *words, track.variable)
    colour, known = model.output.colour_by, _known(model, variables, None)
    fixed = COLOURS
    if model.has_water or model.flow is not None:
        fixed = (*fixed, *COLOURS_OF_WATER)
    if model.flow is not None:
        fixed = (*fixed, *COLOURS_OF_FLOW)
    if model.analysis.inertia is not None:
        fixed = (*fixed, *COLOURS_OF_INERTIA)
    if known is not None and colour not in (choices := [*dict.fromkeys((*fixed, *known))]):
        likely = suggestion(colour, choices)
        remedy = f'did you mean "{likely}"? ' if likely else ""
        remedy += f"choose from {', '.join(choices)}"
        yield Problem("output.colour_by", "no field of this name", remedy, colour)


def _known(
    model: Declaration, variables: Mapping[str, Mapping[str, str] | None], body: str | None
) -> list[str] | None:
    """Returns the state variables of one body's material, or of those of all bodies.

    None if they are not known of all of them.
    """
    names = {PLASTIC_STRAIN: ""}
    for each in model.bodies:
        known = [m for m in each.materials if m in model.materials and body in (None, each.name)]
        for material in known:
            own = variables[material]
            if own is None:
                return None
            names |= own
    return list(names)


def _needs_implicit(model: Declaration) -> Iterator[Problem]:
    """Only an implicit boundary can be followed by the grid."""
    kinds = {boundary.name: boundary.type for boundary in model.boundaries}
    implicit = ", ".join(f"`{name}`" for name, kind in kinds.items() if kind == "implicit")
    remedy = f"choose from {implicit}" if implicit else "this model has no implicit boundary"
    if (follow := model.grid.follow) is not None:
        key, followed = "grid.follow.boundary", kinds.get(follow.boundary)
        if followed is None and any(b.name == follow.boundary for b in model.rigid_bodies):
            what = "the grid can follow implicit boundaries only, but this is a rigid body"
            how = "declare it as an implicit boundary with `contact` and a motion"
            yield Problem(key, what, how, follow.boundary)
        elif followed is None:
            yield Problem(key, *unknown_name("boundary", follow.boundary, kinds), follow.boundary)
        elif followed != "implicit":
            what = f'the grid can follow implicit boundaries only, but this one is "{followed}"'
            yield Problem(key, what, remedy, follow.boundary)


def _needs_water(model: Declaration) -> Iterator[Problem]:
    """Only water has a pore pressure."""
    if model.flow is not None:
        return
    for i, track in enumerate(model.track):
        key = f"track[{i}].quantity"
        if track.quantity == "pore_pressure" and not model.has_water:
            remedy = "add a section [water]; an undrained law has a state variable instead"
            yield Problem(key, "there is no water", remedy, track.quantity)
        if track.quantity in OF_FLOW:
            remedy = "add a section [flow]"
            yield Problem(key, "no water flows", remedy, track.quantity)
        if track.quantity == "excess_pore_pressure":
            remedy = 'add a section [flow]; an undrained law has it as a "state"'
            yield Problem(key, "no water flows", remedy, track.quantity)


def _densities(model: Declaration) -> Iterator[Problem]:
    """A body force and inertia act on mass, so every material of a body needs a density."""
    moves = model.analysis.has_mass
    if not moves and not any(isinstance(load, BodyForce) for load in model.loads):
        return
    why = "it has inertia" if moves else "a body force acts on this material"
    if model.analysis.beyond_limit == "relax":
        why = 'beyond the limit load it has inertia (analysis.beyond_limit = "relax")'
    used = {material for body in model.bodies for material in body.materials}
    for name, material in model.materials.items():
        if name in used and not (material.density if moves else material.density is not None):
            yield Problem(
                dotted(("materials", name, "density")),
                "missing" if material.density is None else "is zero",
                f"give the density [mass / length^3]: {why}",
            )


def _needs_time(model: Declaration) -> Iterator[Problem]:
    """With inertia time is a quantity like length and force."""
    if model.analysis.inertia is not None and not model.units.time:
        remedy = 'give the unit of the schedule\'s time that fits to the others, such as "s"'
        yield Problem("units.time", "missing: with inertia time has a unit", remedy)
    if model.analysis.inertia is None:
        return
    schedules = [("schedule", model.schedule)]
    if model.stages:
        moving = [(i, each) for i, each in loading_stages(model) if each.inertia]
        schedules = [(f"stages[{i}].schedule", each.schedule) for i, each in moving]
    for key, schedule in schedules:
        if "end" not in schedule.model_fields_set:
            remedy = "give the time until which the motion is computed"
            yield Problem(f"{key}.end", "missing: with inertia it is a time like others", remedy)


def _needs_inertia(model: Declaration) -> Iterator[Problem]:
    """A base that moves by its acceleration and waves that leave are of dynamic analyses."""
    for i, boundary in enumerate(model.boundaries):
        condition = getattr(boundary, "condition", None)
        if condition in ("base_motion", "absorbing") and model.analysis.inertia is None:
            remedy = 'add `inertia` to [analysis], such as inertia = { scheme = "newmark" }'
            key = f"boundaries[{i}].condition"
            yield Problem(key, "has no meaning without inertia", remedy, condition)


def _needs_gravity(model: Declaration) -> Iterator[Problem]:
    """A seismic load is a part of gravity."""
    if any(isinstance(load, BodyForce) for _, load in model.acting_loads()):
        return
    for i, load in model.acting_loads():
        if isinstance(load, SeismicLoad):
            yield Problem(
                f"loads[{i}].type",
                "a seismic load is a part of gravity, but no body force is given",
                'add a load of type = "body_force"',
                load.type,
            )


def _affine_stands_alone(model: Declaration) -> Iterator[Problem]:
    affine = [i for i, b in enumerate(model.boundaries) if isinstance(b, AffineBoundary)]
    others = (*model.boundaries, *model.rigid_bodies, *model.contact_pairs)
    if affine and len(others) > 1:
        yield Problem(
            f"boundaries[{affine[0]}].type",
            "an affine motion moves nodes everywhere and cannot be combined with other boundaries, "
            "rigid bodies or contact pairs",
            "keep either the affine motion or the others",
            "affine",
        )


def _constrained_directions(model: Declaration) -> Iterator[Problem]:
    """A direction without any condition makes the system singular: the soil moves freely along it.

    What an implicit boundary or a rigid body constrains depends on its contact with soil: the
    simulation checks it.
    """
    if model.rigid_bodies or model.analysis.inertia is not None:
        return
    if not model.boundaries:
        yield Problem(
            "boundaries",
            "there is no boundary condition at all, so the system would be singular: "
            "the soil can move as a rigid body",
            "add at least one [[boundaries]], such as a roller on the base",
        )
        return
    constrained: set[int] = set()
    for boundary in model.boundaries:
        if isinstance(boundary, AffineBoundary | ImplicitBoundary):
            return
        constrained.update(boundary.prescribed(model.dimension))
    free = [AXES[i] for i in range(model.dimension) if i not in constrained]
    if model.analysis.kind == "axisymmetric" and "x" in free:
        free.remove("x")  # the hoop strain resists a uniform radial motion
    for axis in free:
        yield Problem(
            "boundaries",
            f"no condition constrains the {axis} direction, so the system would be singular: "
            f"the soil can move freely along {axis}",
            f"constrain {axis} on at least one plane or node, such as by a roller normal to {axis}",
        )
