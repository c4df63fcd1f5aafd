# SPDX-License-Identifier: BSD-3-Clause
"""Stages of an analysis: what changes at the start of each, and how long it takes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import AsTuple, Entries, Flag, Table, Vector
from tilth.model.grading import CellSize
from tilth.model.problems import reject, rejection
from tilth.model.schedule import Schedule
from tilth.model.shapes import Shape
from tilth.model.strength_reduction import StrengthReduction
from tilth.model.texts import Name
from tilth.model.water import Water

MOST_STAGES = 1000
"""Stages of an analysis, at most."""

LONGEST_STAGE_NAME = 60
"""Characters of a stage's name, at most: it is part of the name of a file."""


def _stage_name(value: str) -> str:
    if len(value) > LONGEST_STAGE_NAME:
        raise reject(f"is longer than {LONGEST_STAGE_NAME} characters")
    if not re.fullmatch(r"\w([\w .+-]*[\w+])?", value):
        what = "has a character that a stage's name cannot have"
        raise reject(what, "use letters, digits, spaces, '_', '-', '.' and '+', such as \"dig 2\"")
    return value


def _list_of_names(value: Any) -> Any:
    if isinstance(value, str):
        raise reject("must be a list of names", f'such as ["{value}"]')
    return value


def _distinct(value: tuple[str, ...]) -> tuple[str, ...]:
    if len(set(value)) != len(value):
        raise reject("names an entry twice", "name each once")
    return value


StageName = Annotated[Name, AfterValidator(_stage_name)]
EntryNames = Annotated[
    Sequence[Name],
    BeforeValidator(_list_of_names),
    Entries,
    AsTuple,
    AfterValidator(_distinct),
]
Factors = Mapping[Name, Table]
ExchangedMaterials = Mapping[Name, Name]
Resets = Annotated[
    Sequence[Literal["displacement", "plastic_strain"]],
    BeforeValidator(_list_of_names),
    AsTuple,
    AfterValidator(_distinct),
]


class ExcavatedRegion(Declared):
    """A region whose soil is removed: every material point inside it at the start of the stage."""

    body: Name
    """Name of the body from which it is removed; without a tracked surface."""
    shape: Shape
    """The region, in the deformed ground."""


Regions = Annotated[Sequence[ExcavatedRegion], Entries, AsTuple]


class StageGrid(Declared):
    """The background grid from this stage on."""

    cell_size: CellSize
    """Edge length of its cells [length], > 0, in any of the forms of [grid]."""
    origin: Vector | None = None
    """Coordinates of a node [length], shape (dimension,); that of [grid] if not given. Along an
    axis with rows (place, size) it is the first place."""


class Stage(Declared):
    """A stage: changes at its start, and its own schedule, in whose time its tables run.

    What a stage does not name goes on as it was: loads and motions keep the factor that they had at
    the end of the last stage. What any stage activates is not there before.

    Forces that are out of balance after the changes, such as those of removed soil on what remains
    and the weight of new soil, are held at first and released over the stage, as `release` says.

    The first stage changes the initial state: with a stress at the start, its equilibrium is found
    before these changes, with the materials, soil, boundaries and water that are there without
    them.
    """

    type: Literal["loading"] = "loading"
    name: StageName
    """Name of the stage, unique."""
    schedule: Schedule
    """Its load steps; time begins at 0 in each stage."""
    activate: EntryNames = ()
    """Names of bodies, boundaries, those of the flow, rigid bodies and loads that act from this
    stage on. A body is
    placed without stress on the deformed ground: its points move vertically with the ground below
    them.
    """
    deactivate: EntryNames = ()
    """Names of bodies, boundaries, those of the flow and rigid bodies that are removed at the start
    of the stage, and of loads: a load decreases to 0 over the stage, unless `factors` has a table
    for it.
    """
    excavate: Regions = ()
    """Regions whose soil is removed, in sections [[stages.excavate]] below the stage."""
    factors: Factors = Field(default_factory=dict)
    """Rows (time, factor) for loads, moving boundaries, given pressures and fluxes of water, and
    prescribed motions of rigid bodies in this stage, by their names. A load
    that a stage activates increases from 0 to 1 over the stage if it has no table.
    """
    force_factors: Factors = Field(default_factory=dict)
    """Rows (time, factor) for the forces and moments on rigid bodies in this stage, by the names of
    the bodies; `factors` are those of their motions.
    """
    release: Table | None = None
    """Rows (time, share) of the out-of-balance forces that have been released; 0 to 1 over the
    stage if not given. The last share must be 1.
    """
    materials: ExchangedMaterials = Field(default_factory=dict)
    """Exchanged materials: the name of the new one for each old one. The effective stress stays."""
    water: Water | None = None
    """The water from this stage on: it moves linearly to this level over the stage."""
    inertia: Flag = True
    """Whether inertia acts in this stage, if [analysis] has it. A stage without, such as one in
    which gravity is applied, is quasi-static and ends at rest."""
    flow: Flag = True
    """Whether water flows in this stage, if the model has [flow]; without it the soil is undrained,
    and its water keeps its volume."""
    grid: StageGrid | None = None
    """Another background grid from this stage on."""
    reset: Resets = ()
    """What begins at 0 again at the start of the stage: "displacement", "plastic_strain"."""

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = []
        if both := set(self.activate) & set(self.deactivate):
            what, name = "is in `activate` and in `deactivate`", min(both)
            problems.append(Problem("deactivate", what, "name it in one of the two", name))
        if self.release is not None and self.release[-1][1] != 1.0:
            what = f"ends with the share {self.release[-1][1]:g}"
            remedy = "end with 1: no force may remain out of balance after the stage"
            problems.append(Problem("release", what, remedy, self.release))
        if self.water is not None and self.water.initial_level is not None:
            what = "has no meaning in a stage"
            remedy = "leave it out: the level begins where it was at the end of the last stage"
            problems.append(Problem("water.initial_level", what, remedy))
        if problems:
            raise rejection(problems)
        return self


class StrengthReductionStage(StrengthReduction):
    """The factor of safety at the end of the stage before, by strength reduction.

    It takes no time and changes nothing: the next stage goes on from the end of the one before. Its
    files are `safety_stage_02.csv` and so on, numbered as the stages are listed.
    """

    name: StageName
    """Name of the stage, unique."""


def _with_type(entries: Any) -> Any:
    """Adds the type of a stage that does not give it."""
    if isinstance(entries, dict) and "type" not in entries:
        return {"type": "loading", **entries}
    return entries


AnyStage = Annotated[
    Stage | StrengthReductionStage,
    Field(discriminator="type"),
    BeforeValidator(_with_type),
]
Stages = Annotated[Sequence[AnyStage], Entries, AsTuple]
