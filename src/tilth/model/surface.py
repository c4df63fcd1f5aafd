# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of bodies: boundary points that move with the soil, and loads distributed over them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import (
    Flag,
    Matrix,
    Name,
    Positive,
    Profile,
    Real,
    Table,
    Vector,
    WholeNumbers,
)
from tilth.model.problems import rejection


class Surface(Declared):
    """Boundary points on a body's surface: a spline goes through them, in 3D triangles."""

    points: Literal["extra", "outer_layer"] = "extra"
    """"extra": points without volume on the edge itself; "outer_layer" (2D): the body's outermost
    material points, half their spacing inside."""
    spacing: Positive | None = None
    """Largest distance of the boundary points [length]; half a cell if not given."""
    vertices: Matrix | None = None
    """Boundary points in place of those on the body's outline [length], shape (n, 2), with the
    soil on the left of the way along them (2D)."""
    closed: Flag = True
    """Whether the last of `vertices` is joined to the first."""
    corners: WholeNumbers | None = None
    """Which of `vertices` are corners, counted from 0; those that turn by more than `corner_angle`
    if not given."""
    corner_angle: Positive = 20.0
    """Turning angle [degrees] above which a vertex of a polygon, a mesh or `vertices` is a corner;
    the spline is smooth at the others."""

    @model_validator(mode="after")
    def _chain(self) -> Any:
        problems = []
        if self.vertices is None:
            for key, given in (("corners", self.corners is not None), ("closed", not self.closed)):
                if given:
                    remedy = "leave it out: the outline of the body knows"
                    problems.append(Problem(key, "is for `vertices` only", remedy))
        else:
            if any(len(row) != 2 for row in self.vertices):
                remedy = "give [x, y] for each boundary point"
                problems.append(Problem("vertices", "are places in 2D", remedy))
            if self.points == "outer_layer":
                remedy = 'leave out `vertices`, or choose points = "extra"'
                what = "the outer layer consists of material points"
                problems.append(Problem("vertices", what, remedy))
            wrong = [i for i in self.corners or () if i >= len(self.vertices)]
            if wrong:
                remedy = f"the vertices are numbered from 0 to {len(self.vertices) - 1}"
                problems.append(Problem("corners", "names no vertex", remedy, wrong[0]))
        if problems:
            raise rejection(problems)
        return self


class Hydrostatic(Declared):
    """Pressure of water at rest: unit_weight (level - height) below the level, none above."""

    level: Real | Table
    """Height of the water's surface [length], along y in 2D and z in 3D: a number, or rows (time,
    level)."""
    unit_weight: Positive
    """Weight of the water per volume [force / length^3]."""


class SurfaceLoad(Declared):
    """Load distributed over a body's surface, or part of it; the body needs a `surface`."""

    type: Literal["surface"] = "surface"
    body: Name
    """Name of the body."""
    start: Vector | None = None
    """Where the loaded part begins [length], shape (2,), in 2D; the whole surface if not given."""
    end: Vector | None = None
    """Where it ends; the soil is on the left of the way from `start` to `end`."""
    part: Name | None = None
    """Named part of the surface in 3D, such as "z+" of a box; the whole surface if not given."""
    pressure: Real = 0.0
    """Pressure on the soil at factor 1 [stress], > 0 compresses."""
    hydrostatic: Hydrostatic | None = None
    """Pressure of water, added to `pressure`."""
    pressure_along: Profile | None = None
    """Rows (arc length from `start`, pressure) at factor 1, added to `pressure` (2D)."""
    shear: Real = 0.0
    """Shear traction at factor 1 [stress], > 0 from `start` towards `end` (2D)."""
    traction: Vector | None = None
    """Force per initial area at factor 1 [stress], shape (dimension,): its direction stays."""
    follower: Flag = True
    """Whether pressure and shear follow the surface: its direction and its area. If not, they act
    on the initial surface for ever; `traction` always does."""
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); from 0 to 1 over the schedule where not given."""

    @model_validator(mode="after")
    def _some_load(self) -> Any:
        problems = []
        loads = (self.pressure, self.hydrostatic, self.pressure_along, self.shear, self.traction)
        if not any(loads):
            remedy = "give `pressure`, `hydrostatic`, `pressure_along`, `shear` or `traction`"
            problems.append(Problem("pressure", "missing", remedy))
        if (self.start is None) != (self.end is None):
            missing = "start" if self.start is None else "end"
            problems.append(Problem(missing, "missing", "give both or none"))
        if self.start is not None and self.part is not None:
            problems.append(Problem("part", "is given with `start`", "give one of the two"))
        if self.hydrostatic is not None and not self.follower:
            remedy = "leave out `follower`: water follows the surface"
            problems.append(Problem("follower", "does not go with `hydrostatic`", remedy, False))
        if problems:
            raise rejection(problems)
        return self
