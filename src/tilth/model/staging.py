# SPDX-License-Identifier: BSD-3-Clause
"""The stages of a model, each as a model of its own: what acts in it, and how it grows.

A stage's model has all bodies of the whole model, so that their numbers stay, and tells which of
them are there (`Model.present`). It has only the boundaries that act. Its loads keep their numbers;
`Model.acting_loads` are those that act. The tables of factors are those of the stage.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel

from tilth.model.boundaries import AffineBoundary, Boundary, NodeBoundary, PlaneBoundary
from tilth.model.flow import (
    UNSCALED,
    FlowBoundary,
    ImplicitFlowBoundary,
    PlaneFlowBoundary,
    SurfaceFlowBoundary,
)
from tilth.model.grading import first_places
from tilth.model.implicit import ImplicitBoundary
from tilth.model.load_curve import LoadCurve
from tilth.model.loads import Load
from tilth.model.rigid_bodies import RigidBody
from tilth.model.staged_bodies import at_start, in_stage
from tilth.model.stages import Stage, StrengthReductionStage

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

M = TypeVar("M", bound="Declaration")

Rows = tuple[tuple[float, float], ...]

FLOW_BOUNDARIES = (PlaneFlowBoundary, ImplicitFlowBoundary, SurfaceFlowBoundary)
"""Types of all flow boundaries."""

BOUNDARIES = (
    PlaneBoundary,
    NodeBoundary,
    ImplicitBoundary,
    AffineBoundary,
    RigidBody,
    *FLOW_BOUNDARIES,
)
"""Types of all boundaries and of rigid bodies, which tell them from loads."""

CHANGES = ("activate", "deactivate", "excavate", "materials", "water", "grid", "reset")
"""Entries of a stage that change something at its start."""


@dataclass(frozen=True)
class StageOfModel:
    """Which stage of a whole model a model is.

    Attributes:
        number: of the stage among those of the type "loading", from 0.
        index: of the stage among all that are declared, from 0.
        declared: the stage; None in a model without stages.
        reductions: strength reductions at its end, with their indices among all stages.
        start: total time at its start [time].
        jumps: names of loads whose tables do not begin with their factors at the end of the last
            stage, with this factor and the first one.
        absent_bodies: names of the bodies that are not there.
        absences: the same of every stage; empty in a model without stages.
        absent_loads: numbers of the loads that do not act.
        boundary_keys: where each boundary stands in the case file, by name.
        rigid_body_keys: the same of rigid bodies.
        flow_boundaries: those of all stages, as declared; None in a model without stages.
        initial: model of the initial state, see `initial_model`; None in itself and without stages.
        follows: whether there is something before that the stage changes: another stage, or an
            initial state that the first stage does not begin with.
        releases: whether forces that its changes leave out of balance are released over it.
    """

    number: int = 0
    index: int = 0
    declared: Stage | None = None
    reductions: tuple[tuple[int, StrengthReductionStage], ...] = ()
    start: float = 0.0
    jumps: tuple[tuple[str, float, float], ...] = ()
    absent_bodies: frozenset[str] = frozenset()
    absences: tuple[frozenset[str], ...] = ()
    absent_loads: frozenset[int] = frozenset()
    boundary_keys: Mapping[str, str] | None = None
    rigid_body_keys: Mapping[str, str] | None = None
    flow_boundaries: Sequence[FlowBoundary] | None = None
    initial: Declaration | None = None
    follows: bool = False
    releases: bool = False

    @property
    def key(self) -> str:
        """Where the stage stands in the case file, such as `stages[0]`."""
        return f"stages[{self.index}]"

    @property
    def name(self) -> str:
        """Name of the stage; empty in a model without stages."""
        return "" if self.declared is None else self.declared.name

    def begins(self, name: str) -> bool:
        """Returns whether a boundary or rigid body that is there was not in the stage before."""
        return not self.follows or self.declared is None or name in self.declared.activate


def loading_stages(model: Declaration) -> list[tuple[int, Stage]]:
    """Returns the stages of the type "loading" with their indices among all stages."""
    return [(i, stage) for i, stage in enumerate(model.stages) if isinstance(stage, Stage)]


def copied(declared: Any, **changes: Any) -> Any:
    """Returns a copy of a declaration with other entries, which are not validated."""
    return BaseModel.model_copy(declared, update=changes)


def moves(boundary: Boundary | RigidBody | FlowBoundary) -> bool:
    """Whether a boundary or a rigid body has a motion, or a number, that a table scales."""
    if isinstance(boundary, FLOW_BOUNDARIES):
        return boundary.condition != "drained"
    if isinstance(boundary, RigidBody):
        return boundary.has_motion_numbers
    if isinstance(boundary, PlaneBoundary | NodeBoundary):
        return boundary.condition == "prescribed"
    return isinstance(boundary, AffineBoundary) or boundary.is_moving


def first_mentions(stages: Iterable[Stage]) -> dict[str, str]:
    """Returns whether each name is first mentioned to "activate" or to "deactivate" it."""
    found: dict[str, str] = {}
    for stage in stages:
        for key in ("activate", "deactivate"):
            for name in getattr(stage, key):
                found.setdefault(name, key)
    return found


def stage_models(model: M) -> tuple[M, ...]:
    """Returns the model of each stage of a model with stages."""
    stages, initial = loading_stages(model), initial_model(model)
    acting = _names(model) - placed_later(model)
    bodies = {body.name for body in model.bodies}
    held: dict[str, float] = {}
    materials: dict[str, str] = {}
    rigid: dict[str, RigidBody] = {}
    water, grid, start, last_end = model.water, model.grid, 0.0, 0.0
    found = []
    for number, (_, stage) in enumerate(stages):
        before, acting = acting, (acting | set(stage.activate)) - set(stage.deactivate)
        end = stage.schedule.end
        tables: dict[str, Rows] = {}
        jumps: list[tuple[str, float, float]] = []
        for name, declared in named_items(model):
            if isinstance(declared, RigidBody):
                continue
            ending = name in stage.deactivate and not isinstance(declared, BOUNDARIES)
            if ending and getattr(declared, "body", None) in bodies - acting:
                ending = False  # the load goes with its body
            if name in acting or (ending and name in before):
                if ending and number == 0:
                    held[name] = _factor_at_start(declared, name, stage)
                last, table = held.get(name), _table(declared, name, stage, held.get(name), ending)
                if (
                    last is not None
                    and table[0][1] != last
                    and not isinstance(declared, BOUNDARIES)
                ):
                    jumps.append((name, last, table[0][1]))
                tables[name], held[name] = table, LoadCurve(table).factor(end)
            elif not isinstance(declared, BOUNDARIES):
                held.pop(name, None)
        there = [body for body in model.rigid_bodies if body.name in acting]
        staged = [(b, in_stage(b, stage, rigid.get(b.name), last_end)) for b in there]
        jumps += [(b.name, *jump) for b, (_, jump) in staged if jump is not None]
        rigid = {b.name: now for b, (now, _) in staged}
        materials = {old: stage.materials.get(new, new) for old, new in materials.items()}
        materials |= {old: new for old, new in stage.materials.items() if old not in materials}
        if stage.water is not None:
            last_level = stage.water.level if water is None else water.level
            if initial.water is not None and number == 0:
                last_level = initial.water.level
            water = copied(stage.water, initial_level=last_level)
        elif water is not None and number > 0:
            held_factor = LoadCurve(water.factor or ((0.0, 1.0),)).factor(last_end)
            water = copied(water, initial_level=None, factor=((0.0, held_factor),))
        last_end = end
        if stage.grid is not None:
            origin = stage.grid.origin
            if origin is None:
                origin = first_places(grid.origin, grid.cell_size, model.dimension)
            grid = copied(grid, cell_size=stage.grid.cell_size, origin=origin)
        found.append(
            _model_of(
                model, number, stage, start, acting, tables, tuple(jumps), initial,
                bodies=_with_materials(model, materials), water=water, grid=grid,
                rigid_bodies=tuple(rigid.values()),
            )
        )  # fmt: skip
        start += end
    absences = tuple(each.stage.absent_bodies for each in found)
    for each in found:
        each.__dict__["stage"] = replace(each.stage, absences=absences)
    return tuple(found)


def initial_model(model: M) -> M:
    """Returns the model of the state in which the soil is before the first stage changes it.

    What no stage activates first is there, as it is at time 0, and stays so: loads and water have
    their factors at that time.
    """
    stage, acting = loading_stages(model)[0][1], _names(model) - placed_later(model)
    tables: dict[str, Rows] = {
        name: ((0.0, _factor_at_start(declared, name, stage)),)
        for name, declared in named_items(model)
        if name in acting and not isinstance(declared, RigidBody)
    }
    water = model.water
    if water is not None:
        level = water.level if water.initial_level is None else water.initial_level
        factor = LoadCurve(water.factor or ((0.0, 1.0),)).factor(0.0)
        water = copied(water, level=level, initial_level=None, factor=((0.0, factor),))
    unchanged: dict[str, Any] = {
        name: Stage.model_fields[name].get_default(call_default_factory=True)
        for name in (*CHANGES, "factors", "force_factors", "release")
    }
    return _model_of(
        model, 0, copied(stage, **unchanged), 0.0, acting, tables, (), None,
        bodies=model.bodies, water=water, grid=model.grid,
        rigid_bodies=tuple(
            at_start(body, stage) for body in model.rigid_bodies if body.name in acting
        ),
    )  # fmt: skip


def placed_later(model: Declaration) -> set[str]:
    """Returns the names of what a stage activates before any removes it: it is not there at first.

    Empty without stages.
    """
    mentions = first_mentions(stage for _, stage in loading_stages(model))
    return {name for name, first in mentions.items() if first == "activate"}


def _factor_at_start(declared: Any, name: str, stage: Stage) -> float:
    """Returns the factor of a load or boundary at time 0, before the first stage."""
    return float(LoadCurve(_table(declared, name, stage, None, False)).factor(0.0))


def changes_initial_state(model: Declaration, first: Stage) -> bool:
    """Whether the state at the start of the first stage is not the initial one.

    Without a stress at the start only an excavated region makes a difference.
    """
    changed = any(getattr(first, name) for name in CHANGES)
    return bool(first.excavate) or (changed and bool(model.initial.stress))


def _load_name(number: int, load: Load) -> str:
    """Returns the name of a load, see `is_nameless`."""
    return load.name if load.name is not None else f"\0{number}"


def is_nameless(name: str) -> bool:
    """Whether a name stands for a load without one: no user can give such a name."""
    return name.startswith("\0")


def named_items(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields all loads, boundaries and rigid bodies with their names; a load without one has that
    of `is_nameless`.
    """
    for number, load in enumerate(model.loads):
        yield _load_name(number, load), load
    for boundary in model.boundaries:
        yield boundary.name, boundary
    for body in model.rigid_bodies:
        yield body.name, body
    if model.flow is not None:
        for each in model.flow.boundaries:
            yield each.name, each


def _names(model: Declaration) -> set[str]:
    return {name for name, _ in named_items(model)} | {body.name for body in model.bodies}


def _table(declared: Any, name: str, stage: Stage, held: float | None, ending: bool) -> Rows:
    """Returns the rows (time, factor) of a load or boundary in a stage.

    held: its factor at the end of the last stage; None if it did not act.
    """
    end = stage.schedule.end
    if name in stage.factors:
        return tuple((row[0], row[1]) for row in stage.factors[name])
    if ending:
        return ((0.0, held or 0.0), (end, 0.0))
    if held is not None:
        return ((0.0, held),)
    ramp = UNSCALED if isinstance(declared, FLOW_BOUNDARIES) else ((0.0, 0.0), (end, 1.0))
    rows = getattr(declared, "factor", None) or ramp
    return tuple((row[0], row[1]) for row in rows)


def _with_materials(model: Declaration, exchanged: Mapping[str, str]) -> tuple[Any, ...]:
    """Returns the bodies with the materials of a stage."""

    def of(entry: Any) -> Any:
        name = entry.material
        return copied(entry, material=None if name is None else exchanged.get(name, name))

    if not any(old != new for old, new in exchanged.items()):
        return tuple(model.bodies)
    return tuple(
        copied(of(body), layers=tuple(of(layer) for layer in body.layers)) for body in model.bodies
    )


def _model_of(
    model: M, number: int, stage: Stage, start: float, acting: set[str],
    tables: Mapping[str, Rows], jumps: tuple[tuple[str, float, float], ...],
    initial: M | None, **changes: Any,
) -> M:  # fmt: skip
    """Returns the model of a stage, or of the initial state without `initial`."""
    kept = [b for b in model.boundaries if b.name in acting]
    boundaries = tuple(copied(b, factor=tables[b.name]) if moves(b) else b for b in kept)
    flow = model.flow
    if flow is not None:
        there = [each for each in flow.boundaries if each.name in acting]
        there = [copied(b, factor=tables[b.name]) if moves(b) else b for b in there]
        flow = copied(flow, boundaries=tuple(there))
    loads = tuple(
        copied(load, factor=tables.get(_load_name(i, load), load.factor))
        for i, load in enumerate(model.loads)
    )
    result: M = copied(
        model, stages=(), schedule=stage.schedule, boundaries=boundaries, loads=loads, flow=flow,
        **changes,
    )  # fmt: skip
    own = loading_stages(model)
    following = [i for i, _ in own[1:]] + [len(model.stages)]
    follows = number > 0 or (initial is not None and changes_initial_state(model, stage))
    result.__dict__["stage"] = StageOfModel(
        number=number,
        index=own[number][0],
        declared=stage,
        reductions=tuple(
            (i, each)
            for i, each in enumerate(model.stages[: following[number]])
            if i > own[number][0]
            and isinstance(each, StrengthReductionStage)
            and initial is not None
        ),
        start=start,
        jumps=jumps,
        absent_bodies=frozenset(b.name for b in model.bodies if b.name not in acting),
        absent_loads=frozenset(
            i for i, load in enumerate(model.loads) if _load_name(i, load) not in tables
        ),
        boundary_keys=model.boundary_keys(),
        rigid_body_keys=model.rigid_body_keys(),
        flow_boundaries=model.all_flow_boundaries(),
        initial=initial,
        follows=follows,
        releases=number > 0 or (follows and bool(model.initial.stress)),
    )
    return result
