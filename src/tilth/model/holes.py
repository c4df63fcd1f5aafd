# SPDX-License-Identifier: BSD-3-Clause
"""Holes in shapes in the plane: each inside the outline, apart from it and from the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tilth.arrays import Floats
from tilth.errors import Problem
from tilth.model.crossings import in_polygon, lines_meet
from tilth.model.shape_base import DeclaredShape

NOT_INSIDE = (
    "draw the outline around a hole that touches or leaves it; move it, or make it smaller",
    "make one hole of them, or move one",
)


class Disc(NamedTuple):
    """A circle as an outline."""

    centre: Floats
    radius: float


Ring = Disc | Floats
"""A disc, or the vertices of a polygon, shape (n, 2)."""


class HoledShape(DeclaredShape):
    """A shape that may have holes in the plane."""

    def outline(self) -> Ring:
        """Returns the outline without the holes; in the plane."""
        raise NotImplementedError

    def whole(self) -> float:
        """Returns area or volume [length^dimension] with the holes filled."""
        raise NotImplementedError

    def measure(self) -> float:
        """As `DeclaredShape.measure`: without the holes."""
        return self.whole() - sum(hole.whole() for hole in self.cavities())

    def cavities(self) -> tuple[HoledShape, ...]:
        """As `DeclaredShape.cavities`."""
        return tuple(getattr(self, "holes", ()))


def hole_problems(shape: HoledShape) -> list[Problem]:
    """Returns what is wrong with the holes of a shape, with keys relative to it."""
    holes = shape.cavities()
    if not holes:
        return []
    if shape.dimension != 2:
        remedy = "leave them out, or give the body as an STL file"
        return [Problem("holes", "are for shapes in the plane", remedy)]
    problems = []
    for i, hole in enumerate(holes):
        if hole.cavities():
            remedy = "declare the soil in it as a body of its own"
            problems.append(Problem(f"holes[{i}].holes", "a hole has no holes", remedy))
        for name, value in hole.vectors().items():
            if len(value) != 2:
                what = "must have two coordinates"
                problems.append(Problem(f"holes[{i}].{name}", what, "", value))
    return problems or [*_misplaced(shape.outline(), [hole.outline() for hole in holes])]


def _misplaced(outer: Ring, holes: list[Ring]) -> Iterator[Problem]:
    """Yields holes that are not inside the outline, or not apart from an earlier one."""
    for i, hole in enumerate(holes):
        if _meet(outer, hole) or not _contains(outer, _place_in(hole)):
            what = f"is not wholly inside the shape, but {_reach(hole)}"
            yield Problem(f"holes[{i}]", what, NOT_INSIDE[0])
            continue
        for j, other in enumerate(holes[:i]):
            inside = _contains(other, _place_in(hole)) or _contains(hole, _place_in(other))
            if inside or _meet(other, hole):
                yield Problem(f"holes[{i}]", f"touches or overlaps holes[{j}]", NOT_INSIDE[1])


def _reach(outline: Ring) -> str:
    lower, upper = (
        (outline.centre - outline.radius, outline.centre + outline.radius)
        if isinstance(outline, Disc)
        else (outline.min(axis=0), outline.max(axis=0))
    )
    return f"reaches from ({lower[0]:g}, {lower[1]:g}) to ({upper[0]:g}, {upper[1]:g})"


def _place_in(outline: Ring) -> Floats:
    """Returns a place of the outline, or inside it, shape (2,)."""
    return outline.centre if isinstance(outline, Disc) else outline[0]


def _contains(outline: Ring, place: Floats) -> bool:
    """Whether a place (2,) is inside an outline."""
    if isinstance(outline, Disc):
        return bool(np.linalg.norm(place - outline.centre) < outline.radius)
    return bool(in_polygon(outline, place[None])[0])


def _meet(one: Ring, other: Ring) -> bool:
    """Whether two outlines have a place in common."""
    if isinstance(one, Disc) and isinstance(other, Disc):
        apart = float(np.linalg.norm(one.centre - other.centre))
        return abs(one.radius - other.radius) <= apart <= one.radius + other.radius
    if isinstance(one, Disc):
        return _meet(other, one)
    if isinstance(other, Disc):
        nearest, farthest = _distances(one, other.centre)
        return nearest <= other.radius <= farthest
    return lines_meet(one, other)


def _distances(vertices: Floats, place: Floats) -> tuple[float, float]:
    """Returns the least and the greatest distance of a polygon's outline from a place [length]."""
    edge = np.roll(vertices, -1, axis=0) - vertices
    to = place - vertices
    share = np.clip((to * edge).sum(axis=1) / (edge * edge).sum(axis=1), 0.0, 1.0)
    nearest = np.linalg.norm(to - share[:, None] * edge, axis=1).min()
    return float(nearest), float(np.linalg.norm(to, axis=1).max())
