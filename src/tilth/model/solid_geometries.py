# SPDX-License-Identifier: BSD-3-Clause
"""Geometries of what is pressed into soil: footings, plates, cones and piles."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import PlainValidator, model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import (
    AXES,
    AxisOrDirection,
    Direction,
    NotNegative,
    Positive,
    PositivePerDirection,
    Vector,
    real,
)
from tilth.model.geometry_base import DeclaredGeometry, unit
from tilth.model.problems import reject, rejection

_PARALLEL = 1e-9
"""Sine of an angle below which two directions count as parallel."""


class _Rectangle(Declared):
    """What a segment (2D) and a rectangle (3D) have in common."""

    centre: Vector
    """Its centre [length], shape (dimension,)."""
    normal: Direction
    """Normal, shape (dimension,), of any length; into the soil where that is on one side."""
    width: PositivePerDirection
    """Width [length], > 0; in 3D two widths, parallel and perpendicular to `along`."""
    along: Direction | None = None
    """Direction of the first width, in 3D only, shape (3,); it is projected onto the rectangle."""

    @model_validator(mode="after")
    def _along_lies_in_it(self) -> Any:
        if self.along is None or len(self.along) != 3 or len(self.normal) != 3:
            return self
        (a, b, c), (d, e, f) = unit(self.normal), unit(self.along)
        if math.hypot(b * f - c * e, c * d - a * f, a * e - b * d) <= _PARALLEL:
            remedy = "give a direction that lies in the rectangle"
            raise rejection([Problem("along", "is parallel to `normal`", remedy, self.along)])
        return self

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        widths = self.width if isinstance(self.width, Sequence) else [self.width]
        return math.prod(width / cell for width in widths)

    def sizes(self) -> dict[str, Any]:
        """As `DeclaredGeometry.sizes`."""
        return {"width": self.width}

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`; `along` is for 3D only."""
        along = {"along": self.along} if dimension == 3 else {}
        return {"centre": self.centre, "normal": self.normal, **along}

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """As `DeclaredGeometry.size_problems`."""
        widths = self.width if isinstance(self.width, Sequence) else None
        if dimension == 2 and widths is not None:
            yield Problem("width", "must be one number in 2D", "such as width = 2", widths)
        if dimension == 3 and (widths is None or len(widths) != 2):
            remedy = "give the widths parallel and perpendicular to `along`, such as width = [2, 1]"
            yield Problem("width", "must be two numbers in 3D", remedy, self.width)
        if dimension == 2 and self.along is not None:
            remedy = "leave it out: the normal is sufficient"
            yield Problem("along", "is for 3D only", remedy, self.along)
        if dimension == 3 and self.along is None:
            yield Problem("along", "missing", "give the direction of the first width")


class FootingGeometry(_Rectangle, DeclaredGeometry):
    """Straight segment (2D) or flat rectangle (3D), such as the base of a footing."""

    dimensions = (2, 3)

    type: Literal["footing"] = "footing"


class PlateGeometry(_Rectangle, DeclaredGeometry):
    """Plate with soil around it, in any direction: a blade, an anchor, a box with edges.

    Without a thickness it is a segment (2D) or rectangle (3D) with soil on both sides.
    """

    dimensions = (2, 3)

    type: Literal["plate"] = "plate"
    thickness: NotNegative = 0.0
    """Thickness along `normal`, half on each side of `centre` [length], >= 0."""

    @property
    def has_two_sides(self) -> bool:
        """As `DeclaredGeometry.has_two_sides`."""
        return self.thickness == 0.0

    def sizes(self) -> dict[str, Any]:
        """As `DeclaredGeometry.sizes`."""
        return super().sizes() | ({} if self.has_two_sides else {"thickness": self.thickness})


def _apex_angle(value: Any) -> float:
    if _LEAST_APEX <= (number := real(value)) <= 180.0:
        return number
    remedy = "60 is usual for a penetrometer, 180 is a flat end"
    raise reject(f"must be between {_LEAST_APEX:g} and 180 degrees", remedy)


_LEAST_APEX = 1.0

ApexAngle = Annotated[float, PlainValidator(_apex_angle)]


class ConeGeometry(DeclaredGeometry):
    """Cylindrical shaft with a conical tip (3D, axisymmetry), such as a penetrometer or a pile.

    In plane strain the same section is a wedge.
    """

    dimensions = (2, 3)

    type: Literal["cone"] = "cone"
    tip: Vector
    """Its tip [length], shape (dimension,); in axisymmetry at r = 0."""
    angle: ApexAngle
    """Apex angle between opposite sides of the tip [degrees], 1 to 180; 180 is a flat end."""
    radius: Positive
    """Radius of the shaft [length], > 0."""
    length: Positive
    """Length of the shaft above the conical tip [length], > 0; its end is closed."""
    axis: AxisOrDirection | None = None
    """Direction from the tip along the shaft, an axis or shape (dimension,); upwards if not given.
    """
    soil: Literal["inside", "outside"]
    """Whether the soil is inside or outside."""

    @property
    def direction(self) -> tuple[float, ...]:
        """The unit vector from the tip along the shaft, shape (dimension,)."""
        dimension = len(self.tip)
        axis = self.axis or AXES[dimension - 1]
        if isinstance(axis, str):
            return tuple(float(axis == each) for each in AXES[:dimension])
        return unit(axis)

    @property
    def tip_length(self) -> float:
        """Length of the conical tip [length], 0 with a flat end."""
        if self.angle == 180.0:
            return 0.0
        return self.radius / math.tan(math.radians(0.5 * self.angle))

    def cells_passed(self, cell: float, soil: float) -> float:
        """As `DeclaredGeometry.cells_passed`."""
        del soil
        side = math.hypot(self.tip_length, self.radius) + self.length + self.radius
        if len(self.tip) == 2:
            return 2.0 * side / cell
        return 2.0 * math.pi * self.radius * side / cell**2

    def sizes(self) -> dict[str, Any]:
        """As `DeclaredGeometry.sizes`."""
        return {"radius": self.radius, "length": self.length}

    def vectors(self, dimension: int) -> dict[str, Any]:
        """As `DeclaredGeometry.vectors`."""
        by_name = self.axis is None or isinstance(self.axis, str)
        return {"tip": self.tip} | ({} if by_name else {"axis": self.axis})

    def axes_named(self) -> dict[str, Sequence[str]]:
        """As `DeclaredGeometry.axes_named`."""
        return {"axis": self.axis} if isinstance(self.axis, str) else {}

    def axisymmetry_problems(self) -> Iterator[Problem]:
        """As `DeclaredGeometry.axisymmetry_problems`."""
        if self.tip[0] != 0.0:
            what = f"has r = {self.tip[0]:g}, but in axisymmetry the axis of a cone is r = 0"
            yield Problem("tip", what, "give x = 0", self.tip)
        if self.direction[0] != 0.0:
            what = "is not along the axis of symmetry"
            yield Problem("axis", what, 'give "y" or [0, -1], or leave it out', self.axis)
