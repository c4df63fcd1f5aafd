# SPDX-License-Identifier: BSD-3-Clause
"""Checks of positions: conditions on grid lines, bodies inside the limits, r >= 0, bands."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from tilth.errors import Problem
from tilth.model.boundaries import NodeBoundary, PlaneBoundary
from tilth.model.contact_pairs import overlay_problems
from tilth.model.fields import AXES
from tilth.model.flow_checks import flow_planes
from tilth.model.implicit import ImplicitBoundary
from tilth.model.problems import below

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration

ON_GRID_LINE = 1e-9
"""Distance from a grid line, as a fraction of a cell, below which a position is on it."""


LEAST_BAND = 1e-8
"""Width of the band of an implicit boundary, at least, as a fraction of the smallest edge."""


def geometry_problems(model: Declaration) -> list[Problem]:
    """Returns the problems of boundaries off the grid lines or too wide, and of bodies outside."""
    return [
        *_lines_that_move(model),
        *_off_grid_lines(model),
        *_implicit(model),
        *_out_of_bounds(model),
        *overlay_problems(model),
    ]


def _lines_that_move(model: Declaration) -> Iterator[Problem]:
    """Conditions on lines that move because the grid follows a boundary."""
    follow = model.grid.follow
    for i, boundary in enumerate(model.boundaries if follow is not None else ()):
        assert follow is not None
        if isinstance(boundary, PlaneBoundary):
            lost = boundary.axis in follow.axes
        else:
            lost = isinstance(boundary, NodeBoundary)
        if lost:
            what = (
                f"the grid follows {follow.boundary!r} along {', '.join(follow.axes)}, so its "
                "lines move away from this condition"
            )
            yield Problem(f"boundaries[{i}]", what, 'make it one of type = "implicit"')
    for key, plane in flow_planes(model):
        if follow is not None and plane.axis in follow.axes:
            what = (
                f"the grid follows {follow.boundary!r} along {plane.axis}, so its lines move away "
                "from where the pressure or flux is given"
            )
            yield Problem(key, what, 'make it one of type = "implicit"')


def _off_grid_lines(model: Declaration) -> Iterator[Problem]:
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, PlaneBoundary):
            wrong = _nearest_lines(model, AXES.index(boundary.axis), boundary.at)
            if wrong:
                yield Problem(f"boundaries[{i}].at", "is not on a grid line", wrong, boundary.at)
        elif isinstance(boundary, NodeBoundary):
            lines = [_nearest_lines(model, j, at) for j, at in enumerate(boundary.at)]
            if any(lines):
                remedy = "; ".join(line for line in lines if line)
                yield Problem(f"boundaries[{i}].at", "is not a grid node", remedy, boundary.at)
    for key, plane in flow_planes(model):
        if wrong := _nearest_lines(model, AXES.index(plane.axis), plane.at):
            remedy = f'{wrong}; type = "implicit" may lie anywhere'
            yield Problem(f"{key}.at", "is not on a grid line", remedy, plane.at)


def _implicit(model: Declaration) -> Iterator[Problem]:
    edge = min(model.cell_size)
    for i, boundary in enumerate(model.boundaries):
        if not isinstance(boundary, ImplicitBoundary):
            continue
        if not LEAST_BAND * edge <= model.delta(boundary) <= 0.5 * edge:
            what = (
                f"must be greater than 0 and at most {0.5 * edge:g}, half the smallest edge of a "
                "cell"
            )
            if 0.0 < model.delta(boundary) < LEAST_BAND * edge:
                what = f"must be at least {LEAST_BAND * edge:g}, {LEAST_BAND:g} of a cell"
            remedy = f"leave it out for a thousandth of that edge, {1e-3 * edge:g}"
            yield Problem(f"boundaries[{i}].delta", what, remedy, boundary.delta)
    if model.analysis.kind == "axisymmetric":
        for key, geometry in model.geometries():
            yield from below(key, geometry.axisymmetry_problems())


def _nearest_lines(model: Declaration, direction: int, at: float) -> str:
    """Returns a remedy with the two nearest grid lines, or "" for a position on a grid line."""
    axis = model.grid_axis(direction)
    number = axis.in_cells(at)
    if abs(number - round(number)) <= ON_GRID_LINE:
        return ""
    below, above = (axis.coordinate(math.floor(number) + n) for n in (0, 1))
    return f"the nearest grid lines are {AXES[direction]} = {below:.9g} and {above:.9g}"


def _out_of_bounds(model: Declaration) -> Iterator[Problem]:
    limits = model.grid.limits
    slack = [ON_GRID_LINE * size for size in model.cell_size]
    for i, body in enumerate(model.bodies):
        bounds = body.shape.bounds()
        if bounds is None:
            continue
        lower, upper = bounds
        beyond = lower[0] < -slack[0] and not body.shape.may_cross_axis()
        if model.analysis.kind == "axisymmetric" and beyond:
            what = f"the body extends to x = {lower[0]:g}, but x is the radius in axisymmetry"
            yield Problem(f"bodies[{i}].shape", what, "keep the body at x >= 0")
        for j, hole in enumerate(body.shape.cavities()):
            bounds = hole.bounds()
            if model.analysis.kind == "axisymmetric" and bounds and bounds[0][0] < -slack[0]:
                what = f"the hole extends to x = {bounds[0][0]:g}, beyond the axis of symmetry"
                yield Problem(f"bodies[{i}].shape.holes[{j}]", what, "keep the hole at x >= 0")
        if limits is None:
            continue
        for j, axis in enumerate(AXES[: model.dimension]):
            least, greatest = limits.lower[j], limits.upper[j]
            if lower[j] < least - slack[j] or upper[j] > greatest + slack[j]:
                what = (
                    f'the body "{body.name}" is outside the grid limits: it reaches from {axis} = '
                    f"{lower[j]:g} to {upper[j]:g}, the grid from {least:g} to {greatest:g}"
                )
                remedy = "move or shrink the body, or widen `grid.limits`"
                yield Problem(f"bodies[{i}].shape", what, remedy)
