# SPDX-License-Identifier: BSD-3-Clause
"""Checks that positions can be told apart on the grid: their size relative to that of a cell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.boundaries import NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.model.flow_checks import flow_planes
from tilth.model.geometry_base import DeclaredGeometry
from tilth.model.grading import along_axes
from tilth.model.implicit import ImplicitBoundary
from tilth.model.surface import SurfaceLoad

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

MOST_CELLS = 500_000
"""Cells from the grid's origin to soil or a node with a condition, at most: the indices of nodes
have 20 bits per direction, and a body may move."""

LARGEST_COORDINATE = 1e9
"""Coordinates, at most, as a multiple of the cell size: their round-off is 1e-7 of a cell."""


SMALLEST_SPACING = 0.01
"""Distance of boundary points on a surface, at least, as a multiple of the cell size."""

SMALLEST_LENGTH = 1e-6
"""Sizes of bodies and boundaries, at least, as a multiple of the cell size."""


MOST_ELONGATED = 1e4
"""Ratio of the longest edge of a cell to the shortest, at most; of all cells of a graded grid."""


def magnitude_problems(model: Declaration) -> Iterator[Problem]:
    """Yields positions too far from the grid's origin or from zero, and sizes too small for it.

    Only that where the cells are too elongated: nothing else can be told then.
    """
    ratio = max(model.largest_cell) / min(model.cell_size)
    if ratio > MOST_ELONGATED:
        what = f"the edges of a cell have the ratio {ratio:.3g}, more than {MOST_ELONGATED:g}"
        yield Problem("grid.cell_size", what, "give edges of similar length", model.grid.cell_size)
        return
    yield from _beyond_resolution(model)
    yield from _too_small(model)
    yield from _too_large(model)
    for i, body in enumerate(model.bodies):
        for bound in body.shape.bounds() or ():
            if too_far := _too_far(model, bound):
                yield Problem(f"bodies[{i}].shape", *too_far)
                break
    for key, boundary in [*_nodal(model), *flow_planes(model)]:
        if isinstance(boundary, NodeBoundary):
            at = tuple(boundary.at)
        else:
            at = (*model.origin[: AXES.index(boundary.axis)], boundary.at)
        if too_far := _too_far(model, at):
            yield Problem(f"{key}.at", *too_far, boundary.at)


def _nodal(model: Declaration) -> Iterator[tuple[str, PlaneBoundary | NodeBoundary]]:
    """Yields the boundaries on nodes with their keys."""
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, PlaneBoundary | NodeBoundary):
            yield f"boundaries[{i}]", boundary


def _too_far(model: Declaration, position: Sequence[float]) -> tuple[str, str] | None:
    """Returns (problem, remedy) for a position too many cells from the grid's origin, or None."""
    for k, x in enumerate(position):
        if (cells := abs(model.grid_axis(k).in_cells(x))) > MOST_CELLS:
            what = f"{AXES[k]} = {x:g} is {cells:.3g} cells from the origin of the grid"
            return what, f"at most {MOST_CELLS:,} are possible: use larger cells, or `grid.origin`"
    return None


def _beyond_resolution(model: Declaration) -> Iterator[Problem]:
    greatest = LARGEST_COORDINATE * min(model.cell_size)
    for key, value in _lengths(model):
        if value is not None and any(abs(each) > greatest for each in _numbers(value)):
            what = (
                f"is more than {LARGEST_COORDINATE:g} times the cell size, so that round-off would "
                "be more than 1e-7 of a cell"
            )
            yield Problem(key, what, "use larger cells, or coordinates nearer to 0", value)


def _too_small(model: Declaration) -> Iterator[Problem]:
    least = SMALLEST_LENGTH * min(model.cell_size)
    for i, body in enumerate(model.bodies):
        spacing = body.surface.spacing if body.surface is not None else None
        if spacing is not None and spacing < SMALLEST_SPACING * min(model.cell_size):
            what = f"is smaller than {SMALLEST_SPACING:g} of a cell"
            remedy = "use smaller cells, or a larger spacing"
            yield Problem(f"bodies[{i}].surface.spacing", what, remedy, spacing)
    for key, value in _sizes(model):
        if value is not None and any(each < least for each in _numbers(value)):
            what = f"is smaller than {SMALLEST_LENGTH:g} of a cell ({least:g})"
            yield Problem(key, what, "use smaller cells, or a larger size", value)


def _too_large(model: Declaration) -> Iterator[Problem]:
    for key, geometry in model.geometries():
        cells = _cells_passed(model, geometry)
        if cells > geometry.most_cells:
            what = f"passes through about {cells:.3g} cells, more than {geometry.most_cells:,}"
            remedy = "use larger cells, or give only the part near the soil"
            yield Problem(key, what, remedy)


def _cells_passed(model: Declaration, geometry: DeclaredGeometry) -> float:
    """Returns the number of cells through which a geometry passes, about.

    On a graded grid that of a line by its vertices, of others as if all cells were the smallest.
    """
    vertices = getattr(geometry, "vertices", None)
    if vertices is None or not any(len(line) for line in model.lines):
        return geometry.cells_passed(min(model.cell_size), _soil_length(model))
    axes = [model.grid_axis(k) for k in range(model.dimension)]
    cells = [[axis.in_cells(x) for axis, x in zip(axes, v, strict=True)] for v in vertices]
    return sum(math.dist(one, other) for one, other in pairwise(cells))


def _soil_length(model: Declaration) -> float:
    """Returns the diagonal of the bodies whose bounds are declared [length]."""
    bounds = [found for body in model.bodies if (found := body.shape.bounds()) is not None]
    if not bounds:
        return 0.0
    lower = [min(values) for values in zip(*(low for low, _ in bounds), strict=True)]
    upper = [max(values) for values in zip(*(high for _, high in bounds), strict=True)]
    return math.dist(lower, upper)


def _sizes(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields the sizes of bodies, of implicit boundaries and of rigid bodies."""
    for i, body in enumerate(model.bodies):
        if bounds := body.shape.bounds():
            extent = tuple(high - low for low, high in zip(*bounds, strict=True))
            yield f"bodies[{i}].shape", extent
    for key, geometry in model.geometries():
        for name, size in geometry.sizes().items():
            yield ".".join(filter(None, (key, name))), size


def _numbers(value: Any) -> Iterator[float]:
    """Yields the numbers of a number, a vector or a list of vectors."""
    if isinstance(value, Sequence):
        for each in value:
            yield from _numbers(each)
    else:
        yield value


_POSITIONS = (
    "point", "centre", "tip", "lower", "upper", "vertices", "radius", "width", "length",
)  # fmt: skip
"""Entries of geometries that are positions or sizes."""


def _lengths(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields every position that is compared with positions of the soil, and every radius."""
    yield "grid.origin", model.grid.origin
    for axis, size in zip(AXES, along_axes(model.grid.cell_size, model.dimension), strict=False):
        if isinstance(size, tuple):
            yield f"grid.cell_size.{axis}", [place for place, _ in size]
    if model.grid.follow is not None:
        yield "grid.follow.place", model.grid.follow.place
    for i, body in enumerate(model.bodies):
        if body.surface is not None:
            yield f"bodies[{i}].surface.vertices", body.surface.vertices
    for i, load in enumerate(model.loads):
        region = load.within if isinstance(load, SurfaceLoad) else None
        for name in ("lower", "upper", "centre", "radius", "vertices"):
            yield f"loads[{i}].within.{name}", getattr(region, name, None)
    for key, geometry in model.geometries():
        for name in _POSITIONS:
            yield f"{key}.{name}", getattr(geometry, name, None)
    for i, rigid in enumerate(model.rigid_bodies):
        yield f"rigid_bodies[{i}].centre", rigid.centre
        for axis, value in (rigid.displacement or {}).items():
            values = [row[1] for row in value] if isinstance(value, Sequence) else value
            yield f"rigid_bodies[{i}].displacement.{axis}", values
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, ImplicitBoundary):
            if boundary.rotation is not None:
                yield f"boundaries[{i}].rotation.centre", boundary.rotation.centre
            yield f"boundaries[{i}].displacement", list((boundary.displacement or {}).values())
            yield f"boundaries[{i}].radius_change", boundary.radius_change
