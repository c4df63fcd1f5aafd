# SPDX-License-Identifier: BSD-3-Clause
"""Shapes of bodies: coordinates [length] in the undeformed state, angles in degrees."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union

import numpy as np
from pydantic import Field, model_validator

from tilth.errors import Problem
from tilth.model.base import chosen_by
from tilth.model.crossings import crosses_itself
from tilth.model.fields import (
    AXES,
    Angle,
    AsTuple,
    Axis,
    Entries,
    Face,
    Faces,
    FileName,
    Matrix,
    Positive,
    Vector,
    extent_problems,
)
from tilth.model.file_shapes import FileShape
from tilth.model.file_shapes import Mesh as Mesh
from tilth.model.file_shapes import Outline as Outline
from tilth.model.holes import Disc, HoledShape, Ring, hole_problems
from tilth.model.problems import rejection
from tilth.model.shape_base import Bounds as Bounds
from tilth.model.shape_base import DeclaredShape as DeclaredShape
from tilth.model.variation import Level


class Box(HoledShape):
    """Rectangle (2D) or cuboid (3D), optionally rotated about its `lower` corner."""

    dimensions = (2, 3)
    has_own_axes = True

    type: Literal["box"] = "box"
    lower: Vector
    """Corner of least coordinates before the rotation [length], shape (dimension,)."""
    upper: Vector
    """Opposite corner before the rotation [length], shape (dimension,)."""
    angle: Angle = 0.0
    """Rotation about `lower` [degrees], anticlockwise; in 3D right-handed about `axis`."""
    axis: Axis | None = None
    """Axis of the rotation; only in 3D, required for a rotated box."""
    holes: Holes = ()
    """Holes in it: in 2D boxes, polygons or circles inside the outline, apart from each other; in
    3D boxes, cylinders, spheres or bodies in STL files inside it, which may touch its surface and
    each other; none if not given.
    """

    @model_validator(mode="after")
    def _has_extent(self) -> Any:
        problems = list(extent_problems(self.lower, self.upper)) or hole_problems(self)
        if problems:
            raise rejection(problems)
        return self

    @property
    def dimension(self) -> int:
        """Number of directions."""
        return len(self.lower)

    def outline(self) -> Ring:
        """As `HoledShape.outline`."""
        edges = np.array(self.axes) * np.subtract(self.upper, self.lower)[:, None]
        shares = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
        return np.asarray(self.lower + shares @ edges)

    @property
    def axes(self) -> tuple[tuple[float, ...], ...]:
        """Unit vectors of the box's own axes as rows, shape (dimension, dimension)."""
        return box_axes(self.dimension, self.angle, self.axis)

    def bounds(self) -> Bounds:
        """Returns the bounding box of the rotated box."""
        edges = [high - low for low, high in zip(self.lower, self.upper, strict=True)]
        corners = []
        for corner in product(*((0.0, edge) for edge in edges)):
            offset = [
                sum(c * e[i] for c, e in zip(corner, self.axes, strict=True))
                for i in range(self.dimension)
            ]
            corners.append([low + o for low, o in zip(self.lower, offset, strict=True)])
        return _bounds_of(corners)

    def whole(self) -> float:
        """As `HoledShape.whole`."""
        return math.prod(high - low for low, high in zip(self.lower, self.upper, strict=True))

    def vectors(self) -> dict[str, Any]:
        """As `DeclaredShape.vectors`."""
        return {"lower": self.lower, "upper": self.upper}

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredShape.size_problems`."""
        yield from turned_box_problems(self.angle, self.axis, dimension)


class Polygon(HoledShape):
    """Simple polygon (2D) with its vertices in clockwise or anticlockwise order."""

    dimensions = (2,)

    type: Literal["polygon"] = "polygon"
    vertices: Matrix
    """Corners in order [length], shape (n, 2), n >= 3; the last is joined to the first."""
    holes: Holes = ()
    """Holes in it: boxes, polygons or circles inside the outline, apart from each other; none if
    not given.
    """

    @model_validator(mode="after")
    def _is_simple(self) -> Any:
        corners = self.vertices
        problem = ""
        if any(len(corner) != 2 for corner in corners):
            problem = "each vertex must have two coordinates"
        elif len(corners) < 3:
            problem = "needs at least three vertices"
        elif self.area == 0.0:
            problem = "encloses no area"
        elif crosses_itself(corners):
            problem = "the edges intersect each other"
        if problem:
            remedy = "give the corners in order around the body, each once"
            raise rejection([Problem("vertices", problem, remedy, corners)])
        if problems := hole_problems(self):
            raise rejection(problems)
        return self

    def outline(self) -> Ring:
        """As `HoledShape.outline`."""
        return np.array(self.vertices, dtype=float)

    @property
    def area(self) -> float:
        """Area [length^2] that the vertices enclose, in either order (Gauss's area formula)."""
        x0, y0 = self.vertices[0]
        moved = [(x - x0, y - y0) for x, y in self.vertices]
        pairs = zip(moved, moved[1:] + moved[:1], strict=True)
        return 0.5 * abs(sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in pairs))

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        return _bounds_of(self.vertices)

    def whole(self) -> float:
        """As `HoledShape.whole`."""
        return self.area


class Circle(HoledShape):
    """Disc (2D); in axisymmetry a torus, or a sphere if its centre is on the axis."""

    dimensions = (2,)

    type: Literal["circle"] = "circle"
    centre: Vector
    """Centre [length], shape (2,)."""
    radius: Positive
    """Radius [length], > 0."""
    holes: Holes = ()
    """Holes in it: boxes, polygons or circles inside the outline, apart from each other; none if
    not given.
    """

    @model_validator(mode="after")
    def _has_holes_inside(self) -> Any:
        if self.holes and (problems := hole_problems(self)):
            raise rejection(problems)
        return self

    def outline(self) -> Ring:
        """As `HoledShape.outline`."""
        return Disc(np.array(self.centre, dtype=float), self.radius)

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        return _around(self.centre, [self.radius] * 2)

    def whole(self) -> float:
        """As `HoledShape.whole`; that of the whole circle also where the axis halves it."""
        return math.pi * self.radius**2

    def vectors(self) -> dict[str, Any]:
        """As `DeclaredShape.vectors`."""
        return {"centre": self.centre}

    def may_cross_axis(self) -> bool:
        """Whether its centre is on the axis of symmetry: it is a ball."""
        return self.centre[0] == 0.0


class Cylinder(HoledShape):
    """Solid or hollow cylinder along a coordinate axis (3D), or a half or quarter of it."""

    dimensions = (3,)

    type: Literal["cylinder"] = "cylinder"
    centre: Vector
    """Centre of the lower end face [length], shape (3,)."""
    radius: Positive
    """Radius [length], > 0."""
    axis: Axis
    """Axis along which the cylinder extends from its lower end face."""
    height: Positive
    """Length along the axis [length], > 0."""
    inner_radius: Positive | None = None
    """Inner radius of a hollow cylinder [length], below `radius`; solid if not given."""
    sides: Faces | None = None
    """Sides of its axis with material, such as ["x+", "y+"] for a quarter between planes of
    symmetry; all if not given.
    """
    holes: Holes = ()
    """Holes in it: boxes, cylinders, spheres or bodies in STL files inside it, which may
    touch its surface and each other; none if not given.
    """

    @model_validator(mode="after")
    def _is_a_tube_or_a_part(self) -> Any:
        problems = _round_problems(self.radius, self.inner_radius, self.sides)
        if along := [side for side in self.sides or () if side[0] == self.axis]:
            remedy = "leave it out: `centre` and `height` give the ends of the cylinder"
            problems.append(Problem("sides", f"{along[0]} is along the axis", remedy, self.sides))
        if problems := problems or hole_problems(self):
            raise rejection(problems)
        return self

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        along = AXES.index(self.axis)
        reach = [0.0 if i == along else self.radius for i in range(3)]
        lower, upper = _around(self.centre, reach, self.sides)
        rise = [self.height if i == along else 0.0 for i in range(3)]
        return lower, tuple(high + r for high, r in zip(upper, rise, strict=True))

    def whole(self) -> float:
        """As `HoledShape.whole`."""
        ring = math.pi * (self.radius**2 - (self.inner_radius or 0.0) ** 2)
        return 0.5 ** len(self.sides or ()) * ring * self.height

    def vectors(self) -> dict[str, Any]:
        """As `DeclaredShape.vectors`."""
        return {"centre": self.centre}


class Sphere(HoledShape):
    """Solid or hollow sphere (3D), or a half, quarter or octant of it."""

    dimensions = (3,)

    type: Literal["sphere"] = "sphere"
    centre: Vector
    """Centre [length], shape (3,)."""
    radius: Positive
    """Radius [length], > 0."""
    inner_radius: Positive | None = None
    """Inner radius of a hollow sphere [length], below `radius`; solid if not given."""
    sides: Faces | None = None
    """Sides of its centre with material, such as ["x+", "y+", "z+"] for an octant between planes of
    symmetry; all if not given.
    """
    holes: Holes = ()
    """Holes in it: boxes, cylinders, spheres or bodies in STL files inside it, which may
    touch its surface and each other; none if not given.
    """

    @model_validator(mode="after")
    def _is_a_shell_or_a_part(self) -> Any:
        problems = _round_problems(self.radius, self.inner_radius, self.sides)
        if problems := problems or hole_problems(self):
            raise rejection(problems)
        return self

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        return _around(self.centre, [self.radius] * 3, self.sides)

    def whole(self) -> float:
        """As `HoledShape.whole`."""
        cubes = self.radius**3 - (self.inner_radius or 0.0) ** 3
        return 0.5 ** len(self.sides or ()) * 4.0 / 3.0 * math.pi * cubes

    def vectors(self) -> dict[str, Any]:
        """As `DeclaredShape.vectors`."""
        return {"centre": self.centre}


class Terrain(FileShape):
    """Ground between a base and the surface of the terrain, within vertical sides (2D and 3D).

    In 2D the surface is the polyline through its heights. In 3D it is linear between the lines of
    a grid along each of them (bilinear), or on the triangles between survey points. All heights are
    lengths of the case.
    """

    dimensions = (2, 3)

    type: Literal["terrain"] = "terrain"
    surface: Level
    """Elevation of the surface [length]: a number, in 2D also rows (x, elevation), or
    { file = "heights.csv" } with a grid over the horizontal axes, also an ESRI ASCII grid (.asc),
    or in 3D survey points at any places, { file = "survey.csv", places = "scattered" }.
    """
    base: Level
    """Elevation of the lower side [length], below the surface everywhere; as the surface."""
    lower: Vector
    """Least horizontal coordinates [length], shape (dimension - 1,): [x], in 3D [x, y]."""
    upper: Vector
    """Greatest horizontal coordinates [length]; surface and base must reach as far."""
    holes: Holes = ()
    """Holes in it, in 3D: boxes, cylinders, spheres or bodies in STL files inside it, which may
    touch its surface and each other; none if not given.
    """

    @model_validator(mode="after")
    def _has_holes_inside(self) -> Any:
        if problems := hole_problems(self, len(self.lower) + 1):
            raise rejection(problems)
        return self

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredShape.size_problems`."""
        yield from plan_problems(self.lower, self.upper, dimension)

    def levels(self) -> dict[str, Any]:
        """Returns its elevations by key."""
        return {"surface": self.surface, "base": self.base}


class Stl(FileShape):
    """Body within a closed triangulated surface in an STL file (3D), also with cavities.

    Its points are the centres of the grid's sub-cells inside it. The surface must not pass through
    itself.
    """

    dimensions = (3,)

    type: Literal["stl"] = "stl"
    file: FileName
    """Path of the .stl file, text or binary, relative to the case file."""
    scale: Positive
    """Length in the case for one unit of the file: 1 for the same unit, 0.001 for a file in mm and
    a case in m.
    """
    holes: Holes = ()
    """Holes in it, beside cavities in the file: boxes, cylinders, spheres or bodies in STL files
    inside it, which may touch its surface and each other; none if not given.
    """

    @model_validator(mode="after")
    def _has_holes_inside(self) -> Any:
        if problems := hole_problems(self):
            raise rejection(problems)
        return self


if TYPE_CHECKING:
    Hole = DeclaredShape
else:
    Hole = Annotated[
        Box | Polygon | Circle | Cylinder | Sphere | Stl,
        Field(discriminator="type"),
        chosen_by("type", Box, Polygon, Circle, Cylinder, Sphere, Stl),
    ]
Holes = Annotated[Sequence[Hole], Entries, AsTuple]


SHAPES: tuple[type[DeclaredShape], ...] = (
    Box,
    Polygon,
    Circle,
    Cylinder,
    Sphere,
    *FileShape.__subclasses__(),
)
"""All shapes: those of this file, then those that a file knows."""

if TYPE_CHECKING:
    Shape = DeclaredShape
else:
    Shape = Annotated[Union[SHAPES], Field(discriminator="type"), chosen_by("type", *SHAPES)]  # noqa: UP007 - of a tuple


def plan_problems(
    lower: Sequence[float], upper: Sequence[float], dimension: int
) -> Iterator[Problem]:
    """Yields what is wrong with the corners of a rectangle in plan, or of a stretch of x in 2D."""
    for key, corner in (("lower", lower), ("upper", upper)):
        if len(corner) != dimension - 1:
            what = f"has {len(corner)} components, not one for each horizontal axis"
            yield Problem(key, what, "give [x] in 2D, [x, y] in 3D", corner)
            return
    if any(high <= low for low, high in zip(lower, upper, strict=True)):
        yield Problem("upper", "must exceed `lower` in every direction", "", upper)


def turned_box_problems(angle: float, axis: Axis | None, dimension: int) -> Iterator[Problem]:
    """Yields what is wrong with the rotation of a box in an analysis of this dimension."""
    if dimension == 2 and axis is not None:
        remedy = "leave it out: `angle` rotates the box in the plane"
        yield Problem("axis", "is for 3D only", remedy, axis)
    if dimension == 3 and angle and axis is None:
        yield Problem("axis", "missing", "give the axis of the rotation by `angle`")


def box_axes(dimension: int, angle: float, axis: Axis | None) -> tuple[tuple[float, ...], ...]:
    """Returns unit vectors along the axes of a box rotated by `angle` [degrees], as rows."""
    axes = [[float(i == j) for j in range(dimension)] for i in range(dimension)]
    if angle:
        cosine, sine = _cos_sin(angle)
        turned = 2 if dimension == 2 or axis is None else AXES.index(axis)
        first, second = (turned + 1) % 3, (turned + 2) % 3
        axes[first][first], axes[first][second] = cosine, sine
        axes[second][first], axes[second][second] = -sine, cosine
    return tuple(tuple(axis) for axis in axes)


def _cos_sin(degrees: float) -> tuple[float, float]:
    """Returns cosine and sine, exact at multiples of a right angle."""
    quarter, rest = divmod(degrees, 90.0)
    cosine, sine = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    for _ in range(int(quarter) % 4):
        cosine, sine = -sine, cosine
    return cosine, sine


def _bounds_of(corners: Sequence[Sequence[float]]) -> Bounds:
    columns = list(zip(*corners, strict=True))
    return tuple(min(c) for c in columns), tuple(max(c) for c in columns)


def _around(
    centre: Sequence[float], reach: Sequence[float], sides: Sequence[Face] | None = None
) -> Bounds:
    kept = list(zip(centre, reach, side_signs(sides), strict=False))
    lower = tuple(c if sign > 0 else c - r for c, r, sign in kept)
    return lower, tuple(c if sign < 0 else c + r for c, r, sign in kept)


def side_signs(sides: Sequence[Face] | None) -> tuple[int, ...]:
    """Returns 1 or -1 for directions with one side named, 0 for the others, shape (3,)."""
    named = {side[0]: 1 if side[1] == "+" else -1 for side in sides or ()}
    return tuple(named.get(axis, 0) for axis in AXES)


def _round_problems(
    radius: float, inner_radius: float | None, sides: Sequence[Face] | None
) -> list[Problem]:
    problems = []
    if inner_radius is not None and inner_radius >= radius:
        remedy = "give less, or leave it out for a solid body"
        what = f"is not below `radius` = {radius:g}"
        problems.append(Problem("inner_radius", what, remedy, inner_radius))
    if sides and len({side[0] for side in sides}) < len(sides):
        remedy = "name one side, or none for both"
        problems.append(Problem("sides", "names both sides of an axis", remedy, sides))
    return problems
