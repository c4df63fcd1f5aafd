# SPDX-License-Identifier: BSD-3-Clause
"""Checks that positions can be told apart on the grid: their size relative to that of a cell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.boundaries import NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.model.implicit import ImplicitBoundary

if TYPE_CHECKING:
    from tilth.model.model import Model

MOST_CELLS = 500_000
"""Cells from the grid's origin to soil or a node with a condition, at most: the indices of nodes
have 20 bits per direction, and a body may move."""

LARGEST_COORDINATE = 1e9
"""Coordinates, at most, as a multiple of the cell size: their round-off is 1e-7 of a cell."""


def magnitude_problems(model: Model) -> Iterator[Problem]:
    """Yields positions that are too far from the grid's origin or from the zero of coordinates."""
    yield from _beyond_resolution(model)
    for i, body in enumerate(model.bodies):
        for bound in body.shape.bounds() or ():
            if too_far := _too_far(model, bound):
                yield Problem(f"bodies[{i}].shape", *too_far)
                break
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, PlaneBoundary):
            number = AXES.index(boundary.axis)
            at = (*model.origin[:number], boundary.at)
        elif isinstance(boundary, NodeBoundary):
            at = tuple(boundary.at)
        else:
            continue
        if too_far := _too_far(model, at):
            yield Problem(f"boundaries[{i}].at", *too_far, boundary.at)


def _too_far(model: Model, position: Sequence[float]) -> tuple[str, str] | None:
    """Returns (problem, remedy) for a position too many cells from the grid's origin, or None."""
    for axis, x, origin, size in zip(AXES, position, model.origin, model.cell_size, strict=False):
        if abs(x - origin) > MOST_CELLS * size:
            cells = abs(x - origin) / size
            what = f"{axis} = {x:g} is {cells:.3g} cells from the origin of the grid"
            return what, f"at most {MOST_CELLS:,} are possible: use larger cells, or `grid.origin`"
    return None


def _beyond_resolution(model: Model) -> Iterator[Problem]:
    greatest = LARGEST_COORDINATE * min(model.cell_size)
    for key, value in _lengths(model):
        if value is not None and any(abs(each) > greatest for each in _numbers(value)):
            what = (
                f"is more than {LARGEST_COORDINATE:g} times the cell size, so that round-off would "
                "be more than 1e-7 of a cell"
            )
            yield Problem(key, what, "use larger cells, or coordinates nearer to 0", value)


def _numbers(value: Any) -> Iterator[float]:
    """Yields the numbers of a number, a vector or a list of vectors."""
    if isinstance(value, Sequence):
        for each in value:
            yield from _numbers(each)
    else:
        yield value


def _lengths(model: Model) -> Iterator[tuple[str, Any]]:
    """Yields every position that is compared with positions of the soil, and every radius."""
    yield "grid.origin", model.grid.origin
    if model.grid.follow is not None:
        yield "grid.follow.place", model.grid.follow.place
    for i, body in enumerate(model.bodies):
        if body.surface is not None:
            yield f"bodies[{i}].surface.vertices", body.surface.vertices
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, ImplicitBoundary):
            for name in ("point", "centre", "lower", "upper", "vertices", "radius", "width"):
                value = getattr(boundary.geometry, name, None)
                yield f"boundaries[{i}].geometry.{name}", value
            if boundary.rotation is not None:
                yield f"boundaries[{i}].rotation.centre", boundary.rotation.centre
            yield f"boundaries[{i}].displacement", list((boundary.displacement or {}).values())
            yield f"boundaries[{i}].radius_change", boundary.radius_change
