# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of bodies: boundary points that move with the soil, and distributed loads on them."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import (
    CellName,
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
from tilth.model.region import Region


class Surface(Declared):
    """Boundary points on a body's surface, connected by a spline in 2D and by triangles in 3D."""

    points: Literal["extra", "outer_layer"] = "extra"
    """One of "extra" (points without volume on the edge itself) and "outer_layer" (2D: the body's
    outermost material points, half their spacing inside).
    """
    spacing: Positive | None = None
    """Largest distance between boundary points [length]; half a cell if not given."""
    vertices: Matrix | None = None
    """Boundary points instead of those on the body's outline [length], shape (n, 2), in an order
    with the soil on the left (2D).
    """
    closed: Flag = True
    """Whether the last of `vertices` is joined to the first."""
    corners: WholeNumbers | None = None
    """Numbers of the `vertices` that are corners, from 0; if not given, those where the direction
    changes by more than `corner_angle`.
    """
    corner_angle: Positive = 20.0
    """Change of direction [degrees] above which a vertex of a polygon, a mesh or `vertices` is a
    corner; the spline is smooth at the others.
    """

    @model_validator(mode="after")
    def _chain(self) -> Any:
        problems = []
        if self.vertices is None:
            remedy = "leave it out: the outline of the body determines it"
            if self.corners is not None:
                problems.append(Problem("corners", "is for `vertices` only", remedy))
            if not self.closed:
                problems.append(Problem("closed", "is for `vertices` only", remedy, False))
        else:
            if any(len(row) != 2 for row in self.vertices):
                remedy = "give [x, y] for each boundary point"
                problems.append(Problem("vertices", "must be points in 2D", remedy))
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
    """Hydrostatic pressure: unit_weight (level - height) below the level, zero above."""

    level: Real | Table
    """Height of the water's surface [length], along y in 2D and z in 3D: a number, or rows (time,
    level).
    """
    unit_weight: Positive
    """Unit weight of the water [force / length^3]."""


_LOADS = ("pressure", "hydrostatic", "pressure_along", "shear", "traction")


class SurfaceLoad(Declared):
    """Load distributed over a body's surface or a part of it; the body needs a `surface`."""

    type: Literal["surface"] = "surface"
    name: CellName | None = None
    """Name by which stages and messages refer to the load; different from those of other loads."""
    body: Name
    """Name of the body."""
    start: Vector | None = None
    """Start of the loaded part [length], shape (2,), in 2D; the whole surface if not given."""
    end: Vector | None = None
    """End of the loaded part [length], shape (2,); from `start` to `end`, soil is on the left. In
    axisymmetry the part is a ring, or a disc.
    """
    part: Name | None = None
    """Named part of the surface in 3D, such as "z+" of a box; the whole surface if not given."""
    within: Region | None = None
    """Region in plan of the undeformed body (3D): the load acts on what in it faces upwards, of
    `part` if that is given; on all of a part that nowhere faces upwards, such as "z-".
    """
    pressure: Real = 0.0
    """Pressure on the soil at factor 1 [stress], > 0 compresses; 0 is a load, too."""
    hydrostatic: Hydrostatic | None = None
    """Water pressure, added to `pressure`."""
    pressure_along: Profile | None = None
    """Rows (arc length from `start`, pressure) at factor 1, added to `pressure` (2D)."""
    shear: Real = 0.0
    """Shear traction at factor 1 [stress], > 0 in the direction from `start` to `end` (2D)."""
    traction: Vector | None = None
    """Force per initial area at factor 1 [stress], shape (dimension,), of constant direction."""
    follower: Flag = True
    """Whether pressure and shear act on the current direction and area of the surface. If not, they
    act on the initial ones, as `traction` always does.
    """
    factor: Table | None = None
    """Rows (time, factor), shape (n, 2); 0 to 1 over the schedule if not given."""

    @model_validator(mode="after")
    def _some_load(self) -> Any:
        problems = []
        given = [getattr(self, key) for key in self.model_fields_set.intersection(_LOADS)]
        if all(value is None for value in given):  # one of 0 is given, too
            remedy = "give `pressure`, `hydrostatic`, `pressure_along`, `shear` or `traction`"
            problems.append(Problem("pressure", "missing", remedy))
        if (self.start is None) != (self.end is None):
            missing = "start" if self.start is None else "end"
            problems.append(Problem(missing, "missing", "give both or none"))
        if self.start is not None and self.part is not None:
            problems.append(Problem("part", "is given with `start`", "give one of the two"))
        if self.start is not None and self.within is not None:
            problems.append(Problem("within", "is given with `start`", "give one of the two"))
        if self.hydrostatic is not None and not self.follower:
            remedy = "leave out `follower`: water follows the surface"
            problems.append(Problem("follower", "does not go with `hydrostatic`", remedy, False))
        if problems:
            raise rejection(problems)
        return self
