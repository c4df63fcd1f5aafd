# SPDX-License-Identifier: BSD-3-Clause
"""Regions in plan, where a load acts on a surface in 3D."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.crossings import crosses_itself
from tilth.model.fields import Matrix, Positive, Vector
from tilth.model.problems import rejection

CIRCLE_SIDES = 180
"""Sides of the regular polygon of equal area that takes the place of a circle."""

_WAYS = (("lower", "upper"), ("centre", "radius"), ("vertices",))


class Region(Declared):
    """Region in plan (3D): a rectangle, a circle or a polygon, each by its own keys below."""

    lower: Vector | None = None
    """Corner of a rectangle with the least x and y [length], shape (2,); with `upper`."""
    upper: Vector | None = None
    """Corner of the rectangle with the greatest x and y [length], shape (2,)."""
    centre: Vector | None = None
    """Centre of a circle [length], shape (2,); with `radius`."""
    radius: Positive | None = None
    """Radius of the circle [length]."""
    vertices: Matrix | None = None
    """Corners of a polygon in order [length], shape (n, 2), n >= 3."""

    @property
    def area(self) -> float:
        """Area of the region [length^2]."""
        corners = self.corners()
        pairs = zip(corners, corners[1:] + corners[:1], strict=True)
        return 0.5 * abs(sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in pairs))

    def corners(self) -> list[tuple[float, float]]:
        """Returns the corners of the region, or of the polygon of a circle's area [length]."""
        if self.vertices is not None:
            return [(x, y) for x, y in self.vertices]
        if self.centre is not None and self.radius is not None:
            turn = 2.0 * math.pi / CIRCLE_SIDES
            radius = self.radius * math.sqrt(turn / math.sin(turn))
            (x, y), angles = self.centre, [turn * (i + 0.5) for i in range(CIRCLE_SIDES)]
            return [(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles]
        assert self.lower is not None
        assert self.upper is not None
        (x0, y0), (x1, y1) = self.lower, self.upper
        return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]

    @model_validator(mode="after")
    def _is_one_region(self) -> Any:
        if problems := [*self._incomplete()] or [*self._empty()]:
            raise rejection(problems)
        return self

    def _incomplete(self) -> Iterator[Problem]:
        ways = [keys for keys in _WAYS if any(getattr(self, key) is not None for key in keys)]
        remedy = "give `lower` and `upper`, or `centre` and `radius`, or `vertices`"
        if not ways:
            yield Problem("", "says nothing of the region", remedy)
        for keys in ways[1:]:
            yield Problem(keys[0], f"is given with `{ways[0][0]}`", remedy)
        for key in ways[0] if ways else ():
            if getattr(self, key) is None:
                yield Problem(key, "missing", remedy)
        for key in ("lower", "upper", "centre"):
            if len(getattr(self, key) or (0.0, 0.0)) != 2:
                what = "must have the two components x and y of the plan"
                yield Problem(key, what, "leave out z", getattr(self, key))
        if self.vertices is not None and any(len(row) != 2 for row in self.vertices):
            what = "each vertex must have the two components x and y of the plan"
            yield Problem("vertices", what, "leave out z", self.vertices)

    def _empty(self) -> Iterator[Problem]:
        if self.lower is not None and self.upper is not None:
            for axis, low, high in zip("xy", self.lower, self.upper, strict=True):
                if not low < high:
                    what = f"{axis} is not greater than that of `lower`"
                    yield Problem("upper", what, "exchange the numbers", self.upper)
        elif self.vertices is not None:
            problem = ""
            if len(self.vertices) < 3:
                problem = "needs at least three vertices"
            elif self.area == 0.0:
                problem = "encloses no area"
            elif crosses_itself(self.vertices):
                problem = "the edges intersect each other"
            if problem:
                remedy = "give the corners in order around the region, each once"
                yield Problem("vertices", problem, remedy, self.vertices)
