# SPDX-License-Identifier: BSD-3-Clause
"""Water that flows through the pores: its properties, and where its pressure or flux is given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared, chosen_by
from tilth.model.boundaries import Ranges
from tilth.model.fields import AsTuple, Axis, CellName, Entries, Name, Positive, Real, Table, Vector
from tilth.model.geometry import Geometry
from tilth.model.problems import rejection
from tilth.model.region import Region

_VALUES = {"pressure": "excess_pressure", "head": "head", "flux": "flux"}
"""Condition -> the key that it needs."""


UNSCALED = ((0.0, 1.0),)
"""Table of a flow boundary without one."""


class _FlowBoundary(Declared):
    name: CellName
    """Name of the flow boundary, different from those of boundaries and rigid bodies."""
    condition: Literal["drained", "pressure", "head", "flux"]
    """One of "drained" (no excess pore pressure: water leaves and enters freely), "pressure" (the
    excess pore pressure is given), "head" (the total head is given) and "flux" (what flows through
    it is given). Where nothing is declared no water passes.
    """
    excess_pressure: Real | None = None
    """With condition "pressure": excess over the water at rest at factor 1 [stress], compression
    positive.
    """
    head: Real | None = None
    """With condition "head": total head at factor 1, the elevation to which the water would rise
    in a pipe there [length], on the same axis as the level of `[water]`, which it needs.
    """
    flux: Real | None = None
    """With condition "flux": volume of water per time and area that enters the soil at factor 1
    [length / time]; negative if it leaves the soil.
    """
    factor: Table | None = None
    """Rows (time, factor) of the given pressure, head or flux, shape (n, 2); 1 if not given: unlike
    a load, it is there from the start.
    """

    @classmethod
    def required_keys(cls, given: Mapping[str, Any]) -> set[str]:
        """As `Declared.required_keys`: the number that the condition needs."""
        needed = _VALUES.get(str(given.get("condition")))
        return super().required_keys(given) | ({needed} if needed else set())

    @model_validator(mode="after")
    def _entries_fit_the_condition(self) -> Any:
        problems = []
        for condition, key in _VALUES.items():
            value = getattr(self, key)
            if value is not None and self.condition != condition:
                what = f'has no meaning with condition = "{self.condition}"'
                remedy = f'choose condition = "{condition}", or leave it out'
                problems.append(Problem(key, what, remedy, value))
        if self.condition == "drained" and self.factor is not None:
            what = 'there is nothing to scale with condition = "drained"'
            problems.append(Problem("factor", what, "leave it out", self.factor))
        if problems:
            raise rejection(problems)
        return self

    @property
    def value(self) -> float:
        """The excess pore pressure, the head, or the flux into the soil, at factor 1."""
        key = _VALUES.get(self.condition)
        return 0.0 if key is None else float(getattr(self, key))


class PlaneFlowBoundary(_FlowBoundary):
    """Pressure on the nodes of a grid line (2D) or grid plane (3D), which does not move, or flux.

    A flux enters the soil on each side of it, through the faces of the cells there in which points
    of soil with flowing water are.
    """

    type: Literal["plane"] = "plane"
    axis: Axis
    """Axis normal to the line or plane."""
    at: Real
    """Coordinate of the line or plane along `axis` [length]; must be that of a grid line."""
    range: Ranges | None = None
    """Part with the condition, axis -> [least, greatest] coordinate [length]; all if not given."""


class ImplicitFlowBoundary(_FlowBoundary):
    """Pressure or flux on a geometry at any position in the grid, which does not move."""

    type: Literal["implicit"] = "implicit"
    geometry: Geometry
    """Its position, and the side of the soil."""


class SurfaceFlowBoundary(_FlowBoundary):
    """Pressure or flux on a body's surface or a part of it; the body needs a `surface`."""

    type: Literal["surface"] = "surface"
    body: Name
    """Name of the body."""
    start: Vector | None = None
    """Start of the part [length], shape (2,), in 2D; the whole surface if not given."""
    end: Vector | None = None
    """End of the part [length], shape (2,); from `start` to `end`, soil is on the left."""
    part: Name | None = None
    """Named part of the surface in 3D, such as "z+" of a box; the whole surface if not given."""
    within: Region | None = None
    """Region in plan of the undeformed body (3D), as that of a load on a surface."""

    @model_validator(mode="after")
    def _part_is_whole(self) -> Any:
        problems = []
        if (self.start is None) != (self.end is None):
            missing = "start" if self.start is None else "end"
            problems.append(Problem(missing, "missing", "give both or none"))
        if self.start is not None and self.part is not None:
            problems.append(Problem("part", "is given with `start`", "give one of the two"))
        if problems:
            raise rejection(problems)
        return self


FlowBoundary = Annotated[
    PlaneFlowBoundary | ImplicitFlowBoundary | SurfaceFlowBoundary,
    Field(discriminator="type"),
    chosen_by("type", PlaneFlowBoundary, ImplicitFlowBoundary, SurfaceFlowBoundary),
]

FlowBoundaryList = Annotated[Sequence[FlowBoundary], Entries, AsTuple]


class Flow(Declared):
    """Water that flows through the pores of saturated soil, and consolidates it.

    It flows through the materials with a `hydraulic_conductivity`; others let no water in. The
    unknown is the excess pore pressure, over that of the water at rest of `[water]`, or over none
    without it ([theory](../theory/consolidation.md)). Time then has a unit, and the laws' stress
    is the effective one.
    """

    unit_weight: Positive
    """Unit weight of the water [force / length^3], > 0; that of `[water]` if that is given."""
    bulk_modulus: Positive | None = None
    """Bulk modulus of the water with the gas in it [stress], > 0; it cannot be compressed if not
    given.
    """
    density: Positive | None = None
    """Density of the water [mass / length^3], > 0; with `inertia`, which needs it: its own inertia
    holds the water back.
    """
    scheme: Literal["backward_euler", "bdf2"] = "backward_euler"
    """How the balance of water is integrated over time: "backward_euler" (of order 1, and monotone)
    or "bdf2" (the backward difference formula of order 2, with steps of any size; backward Euler in
    the first step of a stage, and in a step more than twice as long as the last one).
    """
    largest_error: Positive | None = None
    """Largest local error of the pore pressure in a step, by that of backward Euler [stress]; a
    step with more is shortened, and shortened steps grow again up to those of the schedule. The run
    fails if `minimum_step` of the schedule is still too long. 0.01 of the load is a common value;
    no limit if not given.
    """
    boundaries: FlowBoundaryList = ()
    """Where the pressure or the flux is given, an entry [[flow.boundaries]] for each."""
