# SPDX-License-Identifier: BSD-3-Clause
"""What is wrong with the stages of a model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from tilth.errors import Problem
from tilth.model.cam_clay import ModifiedCamClay
from tilth.model.initial import AtRest
from tilth.model.initial_checks import at_rest_of
from tilth.model.loads import BodyForce
from tilth.model.problems import unknown_name
from tilth.model.rigid_bodies import RigidBody
from tilth.model.stages import MOST_STAGES, Stage, StrengthReductionStage
from tilth.model.staging import (
    BOUNDARIES,
    FLOW_BOUNDARIES,
    changes_initial_state,
    first_mentions,
    is_nameless,
    loading_stages,
    moves,
    named_items,
    stage_models,
)

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration


def stage_problems(model: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the entries of the stages of a model."""
    if len(model.stages) > MOST_STAGES:
        yield Problem("stages", f"has {len(model.stages):,} entries", f"at most {MOST_STAGES:,}")
        return
    kinds: dict[str, list[str]] = {}
    for name, declared in named_items(model):
        kind = "boundary" if isinstance(declared, BOUNDARIES) else "load"
        kind = "rigid body" if isinstance(declared, RigidBody) else kind
        kind = "flow boundary" if isinstance(declared, FLOW_BOUNDARIES) else kind
        kinds.setdefault(name, []).append(kind)
    for body in model.bodies:
        kinds.setdefault(body.name, []).append("body")
    if isinstance(model.stages[0], StrengthReductionStage):
        what = "cannot be the first stage: it needs soil in equilibrium"
        remedy = "put it after a stage in which gravity acts"
        yield Problem("stages[0].type", what, remedy, model.stages[0].type)
        return
    known = [name for name in kinds if not is_nameless(name)]
    stages = loading_stages(model)
    mentions = first_mentions(stage for _, stage in stages)
    later = {name for name, first in mentions.items() if first == "activate"}
    acting = set(kinds) - later
    gone: set[str] = set()
    used = {name for body in model.bodies for name in body.materials}
    for index, stage in stages:
        key = f"stages[{index}]"
        for which in ("activate", "deactivate"):
            for name in getattr(stage, which):
                if any(name == pair.name for pair in model.contact_pairs) and name not in kinds:
                    what = "is a contact pair, which acts while both its bodies are there"
                    yield Problem(f"{key}.{which}", what, "leave it out", name)
                elif name not in kinds:
                    yield Problem(
                        f"{key}.{which}",
                        *unknown_name(
                            "body, boundary, rigid body, flow boundary or load", name, known
                        ),
                        name,
                    )
                elif len(kinds[name]) > 1:
                    what = f"{' and '.join(kinds[name])} have this name"
                    yield Problem(f"{key}.{which}", what, "give them different names", name)
                elif (name in acting) == (which == "activate"):
                    state = "acts already" if which == "activate" else "does not act before"
                    if kinds[name] == ["body"]:
                        state = "is already there" if which == "activate" else "is not there before"
                    yield Problem(f"{key}.{which}", f"{name!r} {state}", "leave it out", name)
        for name in gone & set(stage.activate):
            what = f"the rigid body {name!r} was removed and cannot come back"
            remedy = "declare another one at its new place"
            yield Problem(f"{key}.activate", what, remedy, name)
        gone |= {name for name in stage.deactivate if kinds.get(name) == ["rigid body"]}
        before, acting = acting, (acting | set(stage.activate)) - set(stage.deactivate)
        yield from _force_factor_problems(model, key, stage, acting)
        yield from _factor_problems(model, key, stage, before | acting, kinds)
        for old, new in stage.materials.items():
            for name in (old, new):
                if name not in model.materials:
                    words = unknown_name("material", name, model.materials)
                    yield Problem(f"{key}.materials", *words, name)
            if old in model.materials and old not in used:
                what = f"no body consists of {old!r} before this stage"
                remedy = "name the material that is to be exchanged, or leave it out"
                yield Problem(f"{key}.materials", what, remedy, old)
        used = {stage.materials.get(name, name) for name in used}
        yield from _excavation_problems(model, key, stage, before)
        if (
            index == 0
            and stage.release is not None
            and not (model.initial.stress and changes_initial_state(model, stage))
        ):
            what = "has no meaning in the first stage, which changes no soil that is stressed"
            yield Problem(f"{key}.release", what, "leave it out")
        if stage.release is not None and stage.release[-1][0] > stage.schedule.end:
            what = f"ends after the stage, which ends at {stage.schedule.end:g}"
            yield Problem(f"{key}.release", what, "end it with the stage", stage.release)


def _factor_problems(
    model: Declaration, key: str, stage: Stage, acting: set[str], kinds: Mapping[str, list[str]]
) -> Iterator[Problem]:
    items = dict(named_items(model))
    scaled = [n for n, d in items.items() if not isinstance(d, BOUNDARIES) or moves(d)]
    for name, table in stage.factors.items():
        where = f"{key}.factors"
        if name not in items:
            choices = [each for each in scaled if not is_nameless(each)]
            words = unknown_name("load, moving boundary or rigid body", name, choices)
            yield Problem(where, *words, name)
        elif name not in scaled and isinstance(items[name], RigidBody):
            what = f"the rigid body {name!r} has no number in `displacement` or `rotation` to scale"
            remedy = "its forces are scaled in `force_factors`; tables are taken as they are"
            yield Problem(where, what, remedy, name)
        elif name not in scaled:
            what = f"the boundary {name!r} does not move: there is nothing to scale"
            if isinstance(items[name], FLOW_BOUNDARIES):
                what = f"the flow boundary {name!r} is drained: there is nothing to scale"
            yield Problem(where, what, "leave it out", name)
        elif name not in acting:
            what = f"{name!r} does not act in this stage"
            yield Problem(where, what, f"add it to `{key}.activate`", name)
        elif table[-1][0] > stage.schedule.end:
            what = f"the table of {name!r} ends after the stage, at {table[-1][0]:g}"
            yield Problem(where, what, f"the stage ends at {stage.schedule.end:g}", table)


def _force_factor_problems(
    model: Declaration, key: str, stage: Stage, acting: set[str]
) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.rigid_bodies}
    where = f"{key}.force_factors"
    for name, table in stage.force_factors.items():
        if name not in bodies:
            yield Problem(where, *unknown_name("rigid body", name, bodies), name)
        elif not bodies[name].has_force_numbers:
            what = f"the rigid body {name!r} has no number in `force` or `moment` to scale"
            yield Problem(where, what, "leave it out; tables are taken as they are", name)
        elif name not in acting:
            what = f"{name!r} does not act in this stage"
            yield Problem(where, what, f"add it to `{key}.activate`", name)
        elif table[-1][0] > stage.schedule.end:
            what = f"the table of {name!r} ends after the stage, at {table[-1][0]:g}"
            yield Problem(where, what, f"the stage ends at {stage.schedule.end:g}", table)


def _excavation_problems(
    model: Declaration, key: str, stage: Stage, present: set[str]
) -> Iterator[Problem]:
    bodies = {body.name: body for body in model.bodies}
    for i, region in enumerate(stage.excavate):
        where = f"{key}.excavate[{i}].body"
        if region.body not in bodies:
            yield Problem(where, *unknown_name("body", region.body, bodies), region.body)
        elif region.body not in present:
            yield Problem(where, f"{region.body!r} is not there before", "leave it out")
        elif bodies[region.body].surface is not None:
            what = f"the body {region.body!r} has a tracked surface, which cannot be cut"
            remedy = "declare the part to be excavated as a body of its own and deactivate it"
            yield Problem(where, what, remedy, region.body)


def _lost_velocities(of_stage: Declaration, stage: Stage, begun: set[str]) -> Iterator[Problem]:
    """Yields velocities of bodies that come in a stage without inertia, which ends at rest.

    begun: bodies that were there in an earlier stage; these are added.
    """
    given = [
        (f"initial.velocity[{i}]", each.body)
        for i, each in enumerate(of_stage.initial.velocity)
        if of_stage.present(each.body)
    ]
    keys = of_stage.rigid_body_keys()
    given += [
        (f"{keys[body.name]}.{name}", body.name)
        for body in of_stage.rigid_bodies
        for name in ("velocity", "angular_velocity")
        if np.any(getattr(body, name) or 0.0)
    ]
    for key, name in given:
        if name not in begun and not stage.inertia:
            what = f"{name!r} is there from the stage {stage.name!r} on, which has no inertia"
            remedy = "activate it in a stage with inertia, which it begins with this velocity"
            yield Problem(key, what, remedy)
    begun |= {name for _, name in given}


def problems_in_stages(model: Declaration) -> Iterator[Problem]:
    """Yields what does not fit together in the model of a stage; its own entries are right."""
    held: dict[str, float] = {}
    complained: list[int] = []
    begun: set[str] = set()
    models = stage_models(model)
    before = models[0].stage.initial
    if models[0].stage.follows and before is not None:
        yield from _initial_problems(model, before)
        yield from _state_problems(before, complained)
    yield from _exchange_problems(model, models)
    for of_stage in models:
        key, stage = of_stage.stage.key, of_stage.stage.declared
        assert stage is not None
        yield from _lost_velocities(of_stage, stage, begun)
        for boundary in [*of_stage.boundaries, *of_stage.rigid_bodies]:
            if not moves(boundary):
                continue
            table = of_stage.load_curve(boundary).table
            first, expected = table[0][1], held.get(boundary.name, 0.0)
            if first != expected:
                what = (
                    f"the motion of {boundary.name!r} begins with the factor {first:g}, "
                    f"but the last stage ended with {expected:g}"
                )
                remedy = f"begin the table with [0, {expected:g}]: the boundary cannot jump"
                yield Problem(f"{key}.factors", what, remedy, boundary.name)
            held[boundary.name] = of_stage.load_curve(boundary).factor(stage.schedule.end)
        yield from _state_problems(of_stage, complained)


def _state_problems(of_stage: Declaration, complained: list[int]) -> Iterator[Problem]:
    """Yields what does not fit together in a stage, or in the initial state.

    complained: numbers of the loads that were complained of; those of now are added.
    """
    from tilth.model.checks import problems_of_stage

    key = of_stage.stage.key
    when = "in this stage" if of_stage.stage.initial else "in the initial state, before this stage"
    for i, load in of_stage.acting_loads():
        body = getattr(load, "body", None)
        if body is None or of_stage.present(body) or i in complained:
            continue
        complained.append(i)
        if load.name is None:
            what = f"a load acts on the body {body!r}, which is not there {when}"
            remedy = f"give `loads[{i}]` a name, to activate and deactivate it with its body"
        else:
            what = f"the load {load.name!r} acts on the body {body!r}, which is not there {when}"
            remedy = "activate and deactivate it together with this body"
        yield Problem(key, what, remedy, body)
    follow = of_stage.grid.follow
    if follow is not None and all(b.name != follow.boundary for b in of_stage.boundaries):
        what = f"the grid follows the boundary {follow.boundary!r}, which does not act"
        yield Problem(key, what, "keep this boundary, or let the grid rest", follow.boundary)
        return
    if not of_stage.present_bodies:
        yield Problem(key, "no body is left", "keep at least one body")
        return
    for problem in problems_of_stage(of_stage):
        where = f" (in {problem.key})" if problem.key != "boundaries" else ""
        what = f"{problem.problem}{where}, {when}"
        yield Problem(key, what, problem.remedy, problem.value)


def _initial_problems(model: Declaration, initial: Declaration) -> Iterator[Problem]:
    """Yields what is wrong with the initial state that the first stage changes.

    initial: its model.
    """
    stage, key = loading_stages(model)[0][1], initial.stage.key
    if not model.initial.stress:
        return
    acting = [load for _, load in initial.acting_loads()]
    heavy = any(isinstance(load, BodyForce) for load in acting)
    for load in model.loads:
        if isinstance(load, BodyForce) and load.name in stage.activate and not heavy:
            what = f"{load.name!r} does not act yet in the initial state, whose stress it causes"
            remedy = "leave it out: what no stage activates is there from the start"
            yield Problem(f"{key}.activate", what, remedy, load.name)
    for load in acting:
        if load.name in stage.deactivate and not initial.load_curve(load).factor(0.0):
            what = (
                f"the load {load.name!r} is removed before it has acted: its factor at time 0 is 0"
            )
            remedy = "give it its whole factor from the start, factor = [[0, 1], [1, 1]]"
            yield Problem(f"{key}.deactivate", what, remedy, load.name)
    bodies = [each.body for each in model.initial.velocity]
    bodies += [
        body.name
        for body in initial.rigid_bodies
        if np.any(body.velocity or 0.0) or np.any(body.angular_velocity or 0.0)
    ]
    if stage.inertia and model.analysis.inertia is not None and bodies:
        what = (
            f"{bodies[0]!r} begins to move in this stage, which changes the soil at its start too"
        )
        remedy = "put a stage before it, in which it begins to move"
        yield Problem(key, what, remedy)


def _exchange_problems(model: Declaration, models: Sequence[Declaration]) -> Iterator[Problem]:
    """Yields exchanged materials of Cam Clay that nothing gives a preconsolidation."""
    seen: set[str] = set()
    for of_stage in models:
        for before, after in zip(model.bodies, of_stage.bodies, strict=True):
            found = model.initial.of(before.name)
            for old, new in zip(before.materials, after.materials, strict=True):
                law, past = model.materials[new], None
                if found is not None and isinstance(found[1], AtRest):
                    past = at_rest_of(found[1], old).past
                if old == new or new in seen or not isinstance(law, ModifiedCamClay):
                    continue
                if law.has_preconsolidation or past is not None:
                    continue
                seen.add(new)
                what = (
                    f"the material {new!r}, which stands for {old!r} here, has no preconsolidation"
                )
                remedy = (
                    f"give materials.{new} exactly one of `overconsolidation_ratio` and "
                    "`preconsolidation_pressure`"
                )
                yield Problem(f"{of_stage.stage.key}.materials", what, remedy, new)
