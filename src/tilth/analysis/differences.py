# SPDX-License-Identifier: BSD-3-Clause
"""What differs in two models up to a moment, from which a run of the second one goes on."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from tilth.model import Model, SurfaceLoad
from tilth.model.flow import UNSCALED
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.model.load_curve import LoadCurve
from tilth.model.problems import dotted
from tilth.model.rigid_bodies import RigidBody
from tilth.model.staging import moves
from tilth.model.surface import Hydrostatic

_ROUND_OFF = 1e-12
"""Part of the largest value within which two tables are the same."""

END = "schedule.end"
"""Key of the end of a schedule, up to which water moves to its level."""

_TABLES_OF_BODIES = ("displacement", "rotation", "force", "moment")


def differences(
    earlier: Model, model: Model, number: int, time: float | None = None
) -> Iterator[tuple[str, str]]:
    """Yields (key, text) of what differs in two models with stages up to a moment of one of them.

    Args:
        earlier: of the run that is gone on with.
        model: of the run that goes on.
        number: of the stage among those of the type "loading".
        time: of the stage, up to which the run is done; its schedule may then go on in another
            way, and `differing_tables` compares its tables. None for the end of the stage.
    """
    for key in ("analysis", "units", "track", "initial"):
        if getattr(earlier, key) != getattr(model, key):
            yield key, f"`{key}`"
    has_fluid = any(EXCESS_PORE_PRESSURE in law.state_variables for law in earlier.laws.values())
    if has_fluid and model.has_water and not earlier.has_water:
        yield "water", "that there is water at all, with effective stresses in all outputs,"
    if earlier.output.deformation_gradient != model.output.deformation_gradient:
        yield "output.deformation_gradient", "`output.deformation_gradient`"
    stages = earlier.of_stages[: number + 1], model.of_stages[: number + 1]
    for i, (one, other) in enumerate(zip(*stages, strict=True)):
        for key in _of_stage(one, other, time if i == number else None):
            what = f"`{key}` of this stage, or what is carried on from earlier ones,"
            yield other.stage.key, what
    first, initial = earlier.of_stages[0].initial_model, model.of_stages[0].initial_model
    if first is not None and initial is not None and list(_of_stage(first, initial, None)):
        yield "stages[0]", "what the declared materials and bodies are before this stage"
    there = [
        i
        for i, body in enumerate(earlier.bodies)
        if any(each.present(body.name) for each in earlier.of_stages[: number + 1])
    ]
    last = max(there) + 1
    if earlier.bodies[:last] != model.bodies[:last]:
        yield "bodies", "a body"
    for i in there:
        if earlier.bodies[i].surface is not None and (
            _stretches(earlier, i) != _stretches(model, i)
        ):
            yield "loads", f"a stretch of the surface of {earlier.bodies[i].name!r} that is loaded"


def _of_stage(one: Model, other: Model, time: float | None) -> Iterator[str]:
    """Yields the keys of a stage whose entries differ; time: see `differences`."""
    before, after = _declared(one), _declared(other)
    if time is None:
        yield from (key for key in before if before[key] != after[key])
        return
    for key in before:
        if key not in ("schedule", "release"):
            found = first_difference(without_tables(before[key]), without_tables(after[key]), key)
            if found is not None:
                yield found


def _declared(model: Model) -> dict[str, Any]:
    """Returns all that acts in a stage, by its key."""
    stage = model.stage.declared
    assert stage is not None
    used = {name for body in model.present_bodies for name in body.materials}
    return {
        "bodies": model.present_bodies,
        "materials": {name: each for name, each in model.materials.items() if name in used},
        "boundaries": model.boundaries,
        "rigid_bodies": model.rigid_bodies,
        "contact_pairs": (
            model.acting_pairs,
            {body.name: model.overlays()[body.name] for body in model.present_bodies},
        ),
        "loads": [load for _, load in model.acting_loads()],
        "water": model.water,
        "flow": model.flow,
        "flow = false": not stage.flow,
        "grid": model.grid,
        "schedule": model.schedule,
        "excavate": stage.excavate,
        "release": stage.release,
        "reset": stage.reset,
        "inertia": stage.inertia,
    }


def _stretches(model: Model, number: int) -> list[Any]:
    name = model.bodies[number].name
    return [
        (i, load.start, load.end, load.part)
        for i, load in enumerate(model.loads)
        if isinstance(load, SurfaceLoad) and load.body == name
    ]


def without_tables(entry: Any) -> Any:
    """Returns plain entries of a declaration, or of several, without those of `tables_of`."""
    if isinstance(entry, BaseModel):
        plain = {name: without_tables(getattr(entry, name)) for name in type(entry).model_fields}
        for key in ("factor", "force_factor"):
            plain.pop(key, None)
        if isinstance(entry, RigidBody):
            plain |= {key: _numbers(getattr(entry, key)) for key in _TABLES_OF_BODIES}
        if isinstance(entry, Hydrostatic):
            plain["level"] = _numbers(entry.level)
        return plain
    if isinstance(entry, Mapping):
        return {key: without_tables(value) for key, value in entry.items()}
    if isinstance(entry, list | tuple):
        return [without_tables(value) for value in entry]
    return entry


def _numbers(entry: Any) -> Any:
    """Returns numbers as they are, and in place of each table over time that it is one."""
    if isinstance(entry, Mapping):
        return {axis: _numbers(value) for axis, value in entry.items()}
    return "table" if isinstance(entry, Sequence) else entry


def tables_of(model: Model) -> dict[str, LoadCurve]:
    """Returns what varies over the time of a stage's model, by its key.

    These are all tables, and what grows over the whole schedule where there is none.
    """
    end = model.schedule.end
    ramp = ((0.0, 0.0), (end, 1.0))
    found = {}
    for i, load in model.acting_loads():
        found[f"loads[{i}].factor"] = model.load_curve(load)
        if isinstance(load, SurfaceLoad) and load.hydrostatic is not None:
            level = load.hydrostatic.level
            if isinstance(level, Sequence):
                found[f"loads[{i}].hydrostatic.level"] = LoadCurve(level)
    keys = model.boundary_keys()
    for boundary in model.boundaries:
        if moves(boundary):
            found[f"{keys[boundary.name]}.factor"] = model.load_curve(boundary)
    keys = model.rigid_body_keys()
    for body in model.rigid_bodies:
        key = keys[body.name]
        if body.has_motion_numbers:
            found[f"{key}.factor"] = LoadCurve(body.factor or ramp)
        if body.has_force_numbers:
            found[f"{key}.force_factor"] = LoadCurve(body.force_factor or ramp)
        for name in _TABLES_OF_BODIES:
            found |= _tables_in(f"{key}.{name}", getattr(body, name))
    if model.flow is not None:
        keys = model.flow_boundary_keys()
        for each in model.flow.boundaries:
            if moves(each):
                table = each.factor or UNSCALED
                found[f"{keys[each.name]}.factor"] = LoadCurve(table)
    if model.water is not None:
        found["water.factor"] = LoadCurve(model.water.factor or ((0.0, 1.0),))
        if model.water.initial_level is not None:
            stage = f"{model.stage.key}." if model.stage.declared is not None else ""
            found[f"{stage}{END}"] = LoadCurve(ramp)  # the level moves up to there
    if model.stage.declared is not None and model.stage.number > 0:
        key = f"{model.stage.key}.release"
        found[key] = LoadCurve(model.stage.declared.release or ramp)
    return found


def _tables_in(key: str, entry: Any) -> dict[str, LoadCurve]:
    if isinstance(entry, Mapping):
        return {f"{key}.{axis}": LoadCurve(v) for axis, v in entry.items() if _is_table(v)}
    return {key: LoadCurve(entry)} if _is_table(entry) else {}


def _is_table(entry: Any) -> bool:
    return isinstance(entry, Sequence)


def differing_tables(one: Model, other: Model, time: float) -> Iterator[tuple[str, LoadCurve]]:
    """Yields the keys of tables that differ up to a time of a stage, with those of `one`."""
    before, after = tables_of(one), tables_of(other)
    for key, curve in before.items():
        if key in after and not _same_up_to(curve, after[key], time):
            yield key, curve


def _same_up_to(one: LoadCurve, other: LoadCurve, time: float) -> bool:
    rows = [row for curve in (one, other) for row in curve.table if row[0] < time]
    values = [(one.factor(at), other.factor(at)) for at in [*(row[0] for row in rows), time]]
    largest = max(abs(value) for pair in values for value in pair)
    return all(abs(a - b) <= _ROUND_OFF * largest for a, b in values)


def first_difference(before: Any, after: Any, key: str = "") -> str | None:
    """Returns the key of the first plain entry that differs, such as `loads[0].pressure`."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        for name in [*before, *(name for name in after if name not in before)]:
            path = f"{key}.{dotted((name,))}" if key else dotted((name,))
            if name not in before or name not in after:
                return path
            if found := first_difference(before[name], after[name], path):
                return found
        return None
    lists = isinstance(before, list) and isinstance(after, list) and len(before) == len(after)
    if lists and any(isinstance(each, Mapping) for each in before):
        for i, pair in enumerate(zip(before, after, strict=True)):
            if found := first_difference(*pair, f"{key}[{i}]"):
                return found
        return None
    return None if before == after else key
