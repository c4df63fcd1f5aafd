# SPDX-License-Identifier: BSD-3-Clause
"""Holes in shapes: each inside the shape, and apart from the others.

In the plane they are apart from the outline, too. In space only what boxes around them tell is
checked here, and `bodies/holes_in_space.py` does the rest.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from tilth.arrays import Floats
from tilth.errors import Problem
from tilth.model.crossings import in_polygon, lines_meet
from tilth.model.problems import below
from tilth.model.shape_base import DeclaredShape

CHOICE = {2: "box, polygon and circle", 3: "box, cylinder, sphere and stl"}
"""Holes by the number of directions."""

NOT_IN_SPACE = "let the hole end at the surface of the shape; move it, or make it smaller"

NOTHING_LEFT = (
    "are as large as the shape: nothing is left of it",
    "make them smaller, or leave the body out",
)

ROUND_OFF = 1e-9
"""Share of the extent of a shape by which a hole may reach beyond its surface."""

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
    """A shape with a closed form that may have holes, and may be one."""

    def outline(self) -> Ring:
        """Returns the outline without the holes; in the plane."""
        raise NotImplementedError

    def whole(self) -> float:
        """Returns area or volume [length^dimension] with the holes filled."""
        raise NotImplementedError

    def measure(self) -> float | None:
        """As `DeclaredShape.measure`: without the holes; None with a hole that a file knows."""
        left = self.whole()
        for hole in self.cavities():
            if (size := hole.measure()) is None:
                return None
            left -= size
        return left


def hole_problems(shape: DeclaredShape, dimension: int | None = None) -> list[Problem]:
    """Returns what is wrong with the holes of a shape, with keys relative to it.

    dimension: number of directions; that of the shape if not given.
    """
    holes = shape.cavities()
    if not holes:
        return []
    dimension = dimension or shape.dimension
    if dimension not in CHOICE or any(len(v) != dimension for v in shape.vectors().values()):
        return []  # the shape fits no analysis, which is said of it
    problems = []
    for i, hole in enumerate(holes):
        if dimension not in hole.dimensions:
            what = f"a {hole.type} is no hole in {dimension}D"
            problems.append(Problem(f"holes[{i}].type", what, f"choose from {CHOICE[dimension]}"))
            continue
        if hole.cavities():
            remedy = "declare the soil in it as a body of its own"
            problems.append(Problem(f"holes[{i}].holes", "a hole has no holes", remedy))
        for name, value in hole.vectors().items():
            if len(value) != dimension:
                what = f"must have {'two' if dimension == 2 else 'three'} coordinates"
                problems.append(Problem(f"holes[{i}].{name}", what, "", value))
        problems += below(f"holes[{i}]", hole.size_problems(dimension))
    if problems or dimension == 3:
        return problems or [*_too_large(shape)]
    if not isinstance(shape, HoledShape):
        remedy = "give the section as a polygon with holes"
        return [Problem("holes", f"are for a {shape.type} in 3D", remedy)]
    outlines = [hole.outline() for hole in holes if isinstance(hole, HoledShape)]
    return [*_misplaced(shape.outline(), outlines)]


def _too_large(shape: DeclaredShape) -> Iterator[Problem]:
    """Yields what the boxes around holes in space, and their volumes, tell to be wrong."""
    if not isinstance(shape, HoledShape):
        return
    least, greatest = np.array(shape.bounds())
    slack = ROUND_OFF * float((greatest - least).max())
    for i, hole in enumerate(shape.cavities()):
        if not isinstance(hole, HoledShape):
            continue
        lower, upper = np.array(hole.bounds())
        if (lower < least - slack).any() or (upper > greatest + slack).any():
            what = f"is not inside the shape, but {_reach(lower, upper)}"
            yield Problem(f"holes[{i}]", what, NOT_IN_SPACE)
    left = shape.measure()
    if left is not None and left <= ROUND_OFF * shape.whole():
        yield Problem("holes", NOTHING_LEFT[0], NOTHING_LEFT[1])


def _misplaced(outer: Ring, holes: list[Ring]) -> Iterator[Problem]:
    """Yields holes that are not inside the outline, or not apart from an earlier one."""
    for i, hole in enumerate(holes):
        if _meet(outer, hole) or not _contains(outer, _place_in(hole)):
            what = f"is not wholly inside the shape, but {_reach(*_ends(hole))}"
            yield Problem(f"holes[{i}]", what, NOT_INSIDE[0])
            continue
        for j, other in enumerate(holes[:i]):
            inside = _contains(other, _place_in(hole)) or _contains(hole, _place_in(other))
            if inside or _meet(other, hole):
                yield Problem(f"holes[{i}]", f"touches or overlaps holes[{j}]", NOT_INSIDE[1])


def _ends(outline: Ring) -> tuple[Floats, Floats]:
    """Returns the least and the greatest coordinates of an outline, shape (2,) each."""
    if isinstance(outline, Disc):
        return outline.centre - outline.radius, outline.centre + outline.radius
    return outline.min(axis=0), outline.max(axis=0)


def _reach(lower: Floats, upper: Floats) -> str:
    low, high = (", ".join(f"{x:g}" for x in corner) for corner in (lower, upper))
    return f"reaches from ({low}) to ({high})"


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
