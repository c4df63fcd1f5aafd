# SPDX-License-Identifier: BSD-3-Clause
"""Geometries of implicit boundaries: coordinates [length] at time 0; angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

from pydantic import Field, model_validator

from tilth.errors import Problem
from tilth.model.base import chosen_by
from tilth.model.crossings import crosses_itself
from tilth.model.fields import (
    AXES,
    Angle,
    Axis,
    AxisOrDirection,
    Direction,
    Faces,
    FileName,
    Flag,
    Matrix,
    Name,
    Positive,
    PythonFunction,
    Vector,
    WholeNumbers,
    extent_problems,
)
from tilth.model.geometry_base import DeclaredGeometry as DeclaredGeometry
from tilth.model.geometry_base import unit as unit
from tilth.model.problems import rejection
from tilth.model.shapes import box_axes, plan_problems, turned_box_problems
from tilth.model.solid_geometries import ConeGeometry as ConeGeometry
from tilth.model.solid_geometries import FootingGeometry as FootingGeometry
from tilth.model.solid_geometries import PlateGeometry as PlateGeometry
from tilth.model.variation import Level


class PlaneGeometry(DeclaredGeometry):
    """Infinite straight line (2D) or plane (3D)."""

    dimensions = (2, 3)

    type: Literal["plane"] = "plane"
    point: Vector
    """A point on it [length], shape (dimension,)."""
    normal: Direction
    """Normal into the soil, shape (dimension,), of any length."""

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        return {"point": self.point, "normal": self.normal}


class CircleGeometry(DeclaredGeometry):
    """Circle (2D); in axisymmetry its part at r >= 0 is the section of a torus or a sphere."""

    dimensions = (2,)

    type: Literal["circle"] = "circle"
    centre: Vector
    """Centre [length], shape (2,); in axisymmetry at r >= 0."""
    radius: Positive
    """Radius [length], > 0."""
    soil: Literal["inside", "outside"]
    """Whether the soil is inside or outside."""

    @property
    def radius_at_rest(self) -> float:
        """Its radius at time 0 [length]."""
        return self.radius

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        return 2.0 * math.pi * self.radius / cell

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        return {"centre": self.centre}

    def axisymmetry_problems(self) -> Iterator[Problem]:
        """As `DeclaredGeometry.axisymmetry_problems`."""
        if self.centre[0] < 0.0:
            what = f"the centre has r = {self.centre[0]:g}, but x is the radius in axisymmetry"
            yield Problem("centre", what, "keep the centre at x >= 0", self.centre)


class CylinderGeometry(DeclaredGeometry):
    """Infinite circular cylinder (3D)."""

    dimensions = (3,)

    type: Literal["cylinder"] = "cylinder"
    centre: Vector
    """A point on its axis [length], shape (3,)."""
    axis: AxisOrDirection
    """Its axis: a coordinate axis, or a direction of any length, shape (3,)."""
    radius: Positive
    """Radius [length], > 0."""
    soil: Literal["inside", "outside"]
    """Whether the soil is inside or outside."""

    @property
    def direction(self) -> tuple[float, ...]:
        """The unit vector of its axis."""
        if isinstance(self.axis, str):
            return tuple(float(axis == self.axis) for axis in AXES)
        return unit(self.axis)

    @property
    def radius_at_rest(self) -> float:
        """Its radius at time 0 [length]."""
        return self.radius

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        return 2.0 * math.pi * self.radius / cell * (soil / cell + 1.0)

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        by_name = isinstance(self.axis, str)
        return {"centre": self.centre} | ({} if by_name else {"axis": self.axis})


class SphereGeometry(DeclaredGeometry):
    """Sphere (3D)."""

    dimensions = (3,)

    type: Literal["sphere"] = "sphere"
    centre: Vector
    """Centre [length], shape (3,)."""
    radius: Positive
    """Radius [length], > 0."""
    soil: Literal["inside", "outside"]
    """Whether the soil is inside or outside."""

    @property
    def radius_at_rest(self) -> float:
        """Its radius at time 0 [length]."""
        return self.radius

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        return 4.0 * math.pi * (self.radius / cell) ** 2

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        return {"centre": self.centre}


def _length(vertices: Sequence[Sequence[float]]) -> float:
    """Returns the length of the polyline through vertices (n, dim) [length]."""
    return sum(math.dist(a, b) for a, b in pairwise(vertices))


class PolylineGeometry(DeclaredGeometry):
    """Straight segments through given points (2D), open or closed."""

    dimensions = (2,)

    type: Literal["polyline"] = "polyline"
    vertices: Matrix
    """Points in order [length], shape (n, 2), n >= 2; n >= 3 if closed."""
    closed: Flag = False
    """Whether the last vertex is joined to the first."""
    soil: Literal["left", "right", "both"]
    """Side of the soil, looking along the vertices in their order; "both" for a thin plate or skirt
    in contact with soil.
    """

    @model_validator(mode="after")
    def _is_simple(self) -> Any:
        corners = self.vertices
        path = [*corners, corners[0]] if self.closed else corners
        problem, remedy = "", ""
        if any(len(corner) != 2 for corner in corners):
            problem, remedy = "each vertex must have two coordinates", "such as [[0, 0], [1, 2]]"
        elif len(corners) < (3 if self.closed else 2):
            count = "three vertices to be closed" if self.closed else "two vertices"
            problem, remedy = f"needs at least {count}", "add the missing ones"
        elif any(a == b for a, b in pairwise(path)):
            problem = "repeats a vertex right after itself"
            remedy = "keep one of the two"
            if self.closed and corners[0] == corners[-1]:
                remedy = "leave the last vertex out: closed = true joins it to the first"
        elif not self.closed and len(corners) > 3 and corners[0] == corners[-1]:
            problem = "ends where it starts, but is not closed"
            remedy = "leave the last vertex out and set closed = true"
        elif crosses_itself(corners, self.closed):
            problem = "the segments intersect each other"
            remedy = "give the vertices in order along the boundary"
        if problem:
            raise rejection([Problem("vertices", problem, remedy, corners)])
        return self

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        return _length(self.vertices) / cell

    @property
    def has_two_sides(self) -> bool:
        """As `DeclaredGeometry.has_two_sides`."""
        return self.soil == "both"


class SplineGeometry(DeclaredGeometry):
    """Open or closed smooth curve through points, with optional corners (2D)."""

    dimensions = (2,)
    most_cells = 2_000  # the nearest point on a curve is found by iteration

    type: Literal["spline"] = "spline"
    vertices: Matrix
    """Points on the curve in order [length], shape (n, 2)."""
    closed: Flag = False
    """Whether the last point is joined to the first."""
    corners: WholeNumbers | None = None
    """Numbers of the points that are corners, from 0; none if not given."""
    soil: Literal["left", "right"]
    """Side of the soil, looking along the vertices in their order."""

    @model_validator(mode="after")
    def _is_a_curve(self) -> Any:
        if any(len(row) != 2 for row in self.vertices):
            remedy = "give [x, y] for each vertex"
            raise rejection([Problem("vertices", "must be points in 2D", remedy)])
        wrong = [i for i in self.corners or () if i >= len(self.vertices)]
        if wrong:
            remedy = f"the vertices are numbered from 0 to {len(self.vertices) - 1}"
            raise rejection([Problem("corners", "names no vertex", remedy, wrong[0])])
        return self

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        return _length(self.vertices) / cell


class BoxGeometry(DeclaredGeometry):
    """Faces of a rectangle (2D) or cuboid (3D), optionally rotated about its `lower` corner."""

    dimensions = (2, 3)

    type: Literal["box"] = "box"
    lower: Vector
    """Corner of least coordinates before the rotation [length], shape (dimension,)."""
    upper: Vector
    """Opposite corner before the rotation [length], shape (dimension,)."""
    angle: Angle = 0.0
    """Rotation about `lower` [degrees], anticlockwise; in 3D right-handed about `axis`."""
    axis: Axis | None = None
    """Axis of the rotation; only in 3D, required for a rotated box."""
    soil: Literal["inside", "outside"]
    """Whether the soil is inside or outside the box."""
    faces: Faces | None = None
    """Faces with the condition, such as ["x-", "y+"] for those of least x and of greatest y in the
    box's own axes; all if not given.
    """

    @model_validator(mode="after")
    def _has_extent(self) -> Any:
        if problems := extent_problems(self.lower, self.upper):
            raise rejection(problems)
        return self

    @property
    def axes(self) -> tuple[tuple[float, ...], ...]:
        """Unit vectors of the box's own axes as rows, shape (dimension, dimension)."""
        return box_axes(len(self.lower), self.angle, self.axis)

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        edges: list[float] = [edge / cell for edge in self.sizes()[""]]
        return 2.0 * sum(math.prod(edges[:j] + edges[j + 1 :]) for j in range(len(edges)))

    def sizes(self) -> dict[str, Any]:
        """As `DeclaredGeometry.sizes`."""
        return {"": [high - low for low, high in zip(self.lower, self.upper, strict=True)]}

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        return {"lower": self.lower, "upper": self.upper}

    def axes_named(self) -> dict[str, Sequence[str]]:
        """As `DeclaredGeometry.axes_named`."""
        return {"faces": self.faces or ()}

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredGeometry.size_problems`."""
        yield from turned_box_problems(self.angle, self.axis, dimension)


class FunctionGeometry(DeclaredGeometry):
    """Zero level set of a Python function."""

    dimensions = (2, 3)

    type: Literal["function"] = "function"
    function: PythonFunction
    """The function as "file.py:name", the file relative to the case file. Its argument is points,
    shape (n, dimension); it returns their signed distances [length], shape (n,), > 0 in soil. The
    file is run: use only one that you trust.
    """


class StlGeometry(DeclaredGeometry):
    """Surface of triangles in an STL file (3D), closed or open, as that of a terrain.

    An open one needs triangles that are turned to one side. It must reach beyond the soil on all
    sides: beyond its border there is nothing that holds it.
    """

    dimensions = (3,)

    type: Literal["stl"] = "stl"
    file: FileName
    """Path of the .stl file, relative to the case file."""
    soil: Literal["inside", "outside", "front", "back"]
    """Side of the soil: "inside" or "outside" of a closed surface; of an open one "front", the side
    to which the normals of the triangles point, from which their corners follow each other
    anticlockwise, or "back".
    """

    @property
    def is_open(self) -> bool:
        """Whether it is an open surface."""
        return self.soil in ("front", "back")


class TerrainGeometry(DeclaredGeometry):
    """Surface of a terrain over a rectangle in plan (3D), or a stretch of x (2D).

    In 2D it is the polyline through its heights. In 3D it consists of triangles: four for each cell
    of a grid, which meet above its middle at the mean of its corners, or those between survey
    points. It must reach beyond the soil on all sides: beyond its border nothing holds it.
    """

    dimensions = (2, 3)

    type: Literal["terrain"] = "terrain"
    surface: Level
    """Elevation of the surface [length], as that of a body of this type: a number, in 2D also rows
    (x, elevation), or { file = "heights.csv" } with a grid over the horizontal axes, also an ESRI
    ASCII grid (.asc), or in 3D { file = "survey.csv", places = "scattered" }.
    """
    lower: Vector
    """Least horizontal coordinates [length], shape (dimension - 1,): [x], in 3D [x, y]."""
    upper: Vector
    """Greatest horizontal coordinates [length]; the surface must reach as far."""
    soil: Literal["above", "below"]
    """Whether the soil is above or below the surface."""

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredGeometry.size_problems`."""
        yield from plan_problems(self.lower, self.upper, dimension)


class MeshGeometry(DeclaredGeometry):
    """Line (2D) or surface (3D), open or closed, given by a physical group of a Gmsh mesh.

    In 2D the line elements of the group must form one line, in 3D its triangles one surface. Their
    directions in the file do not matter, unless a surface is open: then all are turned to one side.
    """

    dimensions = (2, 3)

    type: Literal["mesh"] = "mesh"
    file: FileName
    """Path of the .msh file, relative to the case file."""
    group: Name
    """Name of the physical group of lines (2D) or triangles (3D); the number of one without."""
    soil: Literal["inside", "outside", "left", "right", "both", "front", "back"]
    """Side of the soil: "inside" or "outside" of a closed line or surface; "left" or "right" of an
    open line, looking along it from its end of least x (of least y if both have the same x), so
    that "left" is above the surface of the ground; in 2D also "both", for a thin plate; in 3D
    "front" or "back" of an open surface, as of an STL file.
    """

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredGeometry.size_problems`."""
        sides = ("inside", "outside", "front", "back")
        if dimension == 3 and self.soil not in sides:
            remedy = 'give "inside" or "outside" of a closed one, "front" or "back" of an open one'
            yield Problem("soil", "is no side of a surface", remedy, self.soil)
        if dimension == 2 and self.soil in ("front", "back"):
            remedy = 'give "left" or "right" of an open line'
            yield Problem("soil", "is a side of a surface, in 3D", remedy, self.soil)

    @property
    def has_two_sides(self) -> bool:
        """As `DeclaredGeometry.has_two_sides`."""
        return self.soil == "both"


GEOMETRIES: tuple[type[DeclaredGeometry], ...] = tuple(
    sorted(DeclaredGeometry.__subclasses__(), key=lambda cls: cls.__module__ != __name__)
)
"""All geometries: those of this file in its order, then those that are pressed into soil."""

if TYPE_CHECKING:
    Geometry = DeclaredGeometry
else:
    Geometry = Annotated[
        Union[GEOMETRIES],  # noqa: UP007 - of a tuple
        Field(discriminator="type"),
        chosen_by("type", *GEOMETRIES),
    ]
