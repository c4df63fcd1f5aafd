# SPDX-License-Identifier: BSD-3-Clause
"""What of flowing water does not fit to the other entries of a model."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.boundaries import AffineBoundary
from tilth.model.flow import PlaneFlowBoundary, SurfaceFlowBoundary
from tilth.model.loads import BodyForce
from tilth.model.problems import dotted, unknown_name
from tilth.model.staging import loading_stages

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

SAME = 1e-9
"""Relative difference of two unit weights that are the same."""


def flow_problems(model: Declaration) -> Iterator[Problem]:
    """Yields what does not fit together where water flows, or does not."""
    used = {name for body in model.bodies for name in body.materials}
    used |= {name for _, stage in loading_stages(model) for name in stage.materials.values()}
    conducting = [name for name, each in model.materials.items() if each.conducts_water]
    if model.flow is None:
        for name in conducting:
            what = "has no meaning without a section [flow]: no water flows"
            remedy = "add [flow] with the unit_weight of the water, or leave it out"
            yield Problem(dotted(("materials", name, "hydraulic_conductivity")), what, remedy)
        for i, stage in loading_stages(model):
            if not stage.flow:
                remedy = "leave it out, or add a section [flow]"
                yield Problem(f"stages[{i}].flow", "has no meaning without [flow]", remedy, False)
        return
    if not used.intersection(conducting):
        what = "water flows through no material"
        remedy = "give a material of a body its `hydraulic_conductivity` and `porosity`"
        yield Problem("flow", what, remedy)
    yield from _weights(model)
    yield from _time(model)
    yield from _heads(model)
    yield from _ratios(model)
    yield from _axis(model)
    yield from _surfaces(model)
    yield from _not_yet(model)
    yield from _given_volume(model)


def _weights(model: Declaration) -> Iterator[Problem]:
    assert model.flow is not None
    declared = [("water", model.water)]
    declared += [(f"stages[{i}].water", stage.water) for i, stage in loading_stages(model)]
    weight = model.flow.unit_weight
    for key, water in declared:
        if water is not None and abs(water.unit_weight - weight) > SAME * weight:
            what = f"is not {key}.unit_weight, {water.unit_weight:g}"
            remedy = "give the same: it is the same water"
            yield Problem("flow.unit_weight", what, remedy, weight)
    heavy = any(isinstance(load, BodyForce) for load in model.loads)
    if heavy and not model.has_water:
        what = "missing: a body force acts, under which the water has a pressure at rest"
        remedy = "give its level and unit_weight; water then flows by its excess over that pressure"
        yield Problem("water", what, remedy)


def _time(model: Declaration) -> Iterator[Problem]:
    """Water takes its time: it has a unit, and the schedule an end in it."""
    if not model.units.time:
        remedy = 'give the unit of the schedule\'s time that fits to the others, such as "day"'
        yield Problem("units.time", "missing: where water flows time has a unit", remedy)
    schedules = [("schedule", model.schedule)]
    if model.stages:
        flowing = [(i, each) for i, each in loading_stages(model) if each.flow]
        schedules = [(f"stages[{i}].schedule", each.schedule) for i, each in flowing]
    for key, schedule in schedules:
        if "end" not in schedule.model_fields_set:
            remedy = "give the time until which the flow is computed"
            yield Problem(f"{key}.end", "missing: where water flows it is a time", remedy)


def _ratios(model: Declaration) -> Iterator[Problem]:
    """Ratios of conductivities have a number for each direction."""
    for name, each in model.materials.items():
        ratios, dim = each.conductivity_ratios, model.dimension
        if ratios is not None and len(ratios) != dim:
            what = f"is for {len(ratios)} directions, but the analysis has {dim}"
            remedy = f"give a list of {dim} numbers, or {dim} rows of {dim}"
            key = dotted(("materials", name, "conductivity_ratios"))
            yield Problem(key, what, remedy, ratios)


def _heads(model: Declaration) -> Iterator[Problem]:
    """A head is over the datum of the water at rest."""
    assert model.flow is not None
    for i, each in enumerate(model.flow.boundaries):
        if each.condition == "head" and not model.has_water:
            what = "needs the water at rest, over which the excess pressure is"
            remedy = 'add [water] with its level, or choose condition = "pressure"'
            yield Problem(f"flow.boundaries[{i}].condition", what, remedy, "head")


def _axis(model: Declaration) -> Iterator[Problem]:
    """The axis of symmetry has no area."""
    for key, plane in flow_planes(model):
        on_axis = model.analysis.kind == "axisymmetric" and plane.axis == "x" and plane.at == 0.0
        if on_axis and plane.condition == "flux":
            what = "is the axis of symmetry, which has no area: no water flows through it"
            yield Problem(f"{key}.at", what, "give a line at a radius > 0", plane.at)


def _surfaces(model: Declaration) -> Iterator[Problem]:
    assert model.flow is not None
    bodies = {body.name: number for number, body in enumerate(model.bodies)}
    for i, each in enumerate(model.flow.boundaries):
        if not isinstance(each, SurfaceFlowBoundary):
            continue
        key = f"flow.boundaries[{i}]"
        if each.body not in bodies:
            yield Problem(f"{key}.body", *unknown_name("body", each.body, bodies), each.body)
        elif model.bodies[bodies[each.body]].surface is None:
            what = f"the body {each.body!r} has no tracked surface"
            remedy = f"add `surface = {{}}` to bodies[{bodies[each.body]}]"
            yield Problem(f"{key}.body", what, remedy, each.body)
        two = [k for k in ("start", "end") if getattr(each, k) is not None]
        three = [k for k in ("part", "within") if getattr(each, k) is not None]
        wrong, of = (three, "3D") if model.dimension == 2 else (two, "2D")
        for name in wrong:
            remedy = (
                "give `start` and `end`" if of == "3D" else "name a `part` or a region `within`"
            )
            yield Problem(f"{key}.{name}", f"is for surfaces in {of}", remedy)


def _not_yet(model: Declaration) -> Iterator[Problem]:
    """What cannot be computed together with flowing water."""
    assert model.flow is not None
    if model.analysis.beyond_limit == "relax":
        what = "cannot be computed together with [flow]"
        yield Problem("analysis.beyond_limit", what, "leave out one of the two", "relax")
    moves, density = model.analysis.inertia is not None, model.flow.density
    if moves and density is None:
        remedy = "give the density of the water [mass / length^3], which its own inertia needs"
        yield Problem("flow.density", "missing: the analysis has inertia", remedy)
    if not moves and density is not None:
        what, remedy = "has no meaning without inertia", "leave it out"
        yield Problem("flow.density", what, remedy, density)
    for i, pair in enumerate(model.contact_pairs):
        if pair.contact.tangential in ("friction", "rough"):
            key, law = f"contact_pairs[{i}].contact.tangential", pair.contact.tangential
            what = "between two bodies it cannot be computed together with [flow]"
            yield Problem(key, what, 'choose "smooth", "adhesion" or "bonded"', law)


def _given_volume(model: Declaration) -> Iterator[Problem]:
    """Soil whose volume is given, with water that can neither leave it nor be compressed."""
    assert model.flow is not None
    moved = any(
        isinstance(each, AffineBoundary) and each.nodes == "all" for each in model.boundaries
    )
    leaves = any(each.condition != "flux" for each in model.flow.boundaries)
    leaves = leaves and all(stage.flow for _, stage in loading_stages(model))
    if moved and not leaves and model.flow.bulk_modulus is None:
        what = "missing: an affine motion gives the volume of all soil, which no water can leave"
        remedy = "give the bulk modulus of the water, or a flow boundary where it is drained"
        yield Problem("flow.bulk_modulus", what, remedy)


def flow_planes(model: Declaration) -> Iterator[tuple[str, PlaneFlowBoundary]]:
    """Yields the flow boundaries on grid lines or planes, with their keys."""
    for i, each in enumerate(() if model.flow is None else model.flow.boundaries):
        if isinstance(each, PlaneFlowBoundary):
            yield f"flow.boundaries[{i}]", each


def flow_axes(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields the entries of flow boundaries that name axes."""
    for key, plane in flow_planes(model):
        yield f"{key}.axis", plane.axis
        yield f"{key}.range", plane.range or {}


def flow_vectors(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields the entries of flow boundaries with a component per direction."""
    for i, each in enumerate(() if model.flow is None else model.flow.boundaries):
        if isinstance(each, SurfaceFlowBoundary) and model.dimension == 2:
            yield f"flow.boundaries[{i}].start", each.start
            yield f"flow.boundaries[{i}].end", each.end
