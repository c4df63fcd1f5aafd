# SPDX-License-Identifier: BSD-3-Clause
"""Holes in bodies in space: which positions are in them, and whether they are where they may be."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.bodies.forms import Form, WithHoles
from tilth.bodies.holes import remaining
from tilth.bodies.inside import inside_of
from tilth.bodies.polygon import OUTLINE_TOLERANCE
from tilth.bodies.request import BodyPoints, Request
from tilth.bodies.thickness import Crossings, crossings_of
from tilth.model import Box, Cylinder, Sphere
from tilth.model.holes import NOT_IN_SPACE, NOT_INSIDE, NOTHING_LEFT, ROUND_OFF
from tilth.variation.tables import place_text

LINES = 101
"""Vertical lines across a hole along x and along y; odd, so that one is in the middle."""

RIM = 1e-6
"""Distance of the outermost lines from the rim of a hole, over its extent."""


def without_holes_in_space(points: BodyPoints, form: WithHoles, request: Request) -> BodyPoints:
    """Returns the points of a form that are in none of its holes; points on their surfaces stay.

    All volumes are multiplied by one factor so that they sum to the volume of the form.

    Args:
        points: of the whole form.
        form: the form.
        request: its resolution.

    Raises:
        BadInput: a hole is not inside the form, overlaps another one or has no points in it, or
            nothing is left.
    """
    require_holes_inside(form, request)
    if form.measure() <= ROUND_OFF * form.whole.measure():
        raise request.refused(*NOTHING_LEFT, "shape.holes")
    margin = 2.0 * OUTLINE_TOLERANCE * float(points.half_length.min())
    within = [deep_inside(hole, points.position, margin) for hole in form.holes]
    return remaining(points, within, form.measure(), request)


def deep_inside(form: Form, position: Floats, margin: float) -> Flags:
    """Returns which positions (n, 3) are inside a form by a margin along every axis, (n,)."""
    inside, deep = inside_of(form), np.ones(len(position), dtype=bool)
    for shift in margin * np.vstack([np.eye(3), -np.eye(3)]):
        own = np.flatnonzero(deep)
        deep[own] = inside(position[own] + shift)
    return deep


def require_holes_inside(form: WithHoles, request: Request) -> None:
    """Refuses a hole that is not inside its body, or overlaps an earlier one.

    They are compared along vertical lines: where a line is in the hole and not in the body, or in
    both holes. The lines are close to each other at the rim of a hole, and pass by every corner of
    a box, so that what lies between them unseen is some 1e-6 of the hole.
    """
    whole, holes = form.whole, form.holes
    bounds = np.array(form.bounds())
    slack = ROUND_OFF * float(np.ptp(bounds, axis=0).max())
    for i, hole in enumerate(holes):
        own = np.array(hole.bounds())
        place = _lines(own, [hole])
        found = _common(crossings_of(hole, place), crossings_of(whole, place), False, slack)
        if found is not None:
            at = place_text(np.append(place[found[0]], found[1]))
            problem, key = f"is not inside the shape, but reaches beyond it at {at}", f"holes[{i}]"
            raise request.refused(problem, NOT_IN_SPACE, f"shape.{key}")
        for j, other in enumerate(holes[:i]):
            both = np.array(other.bounds())
            both = np.stack([np.maximum(own[0], both[0]), np.minimum(own[1], both[1])])
            if (np.diff(both, axis=0) <= slack).any():
                continue
            place = _lines(both, [hole, other])
            found = _common(crossings_of(hole, place), crossings_of(other, place), True, slack)
            if found is not None:
                at = place_text(np.append(place[found[0]], found[1]))
                problem = f"overlaps holes[{j}] at {at}"
                raise request.refused(problem, NOT_INSIDE[1], f"shape.holes[{i}]")


def _lines(bounds: Floats, forms: list[Form]) -> Floats:
    """Returns places in plan of lines within bounds (2, 3), by corners and round rims, (n, 2)."""
    rim = RIM * np.ptp(bounds, axis=0)
    axes = [np.linspace(bounds[0, k] + rim[k], bounds[1, k] - rim[k], LINES) for k in range(2)]
    found = [np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)]
    share = np.stack(np.meshgrid(*[[RIM, 1.0 - RIM]] * 3), axis=-1).reshape(-1, 3)
    angle = np.radians(np.arange(360.0))
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    rings = np.concatenate([(1.0 - each) * circle for each in np.geomspace(RIM, 0.1, 11)])
    for form in forms:
        if isinstance(form, Box):
            edges = np.array(form.axes) * np.subtract(form.upper, form.lower)[:, None]
            found.append((np.array(form.lower) + share @ edges)[:, :2])
        elif isinstance(form, Sphere) or (isinstance(form, Cylinder) and form.axis == "z"):
            found.append(np.array(form.centre)[:2] + form.radius * rings)
    return np.concatenate(found)


def _common(one: Crossings, other: Crossings, both: bool, slack: float) -> tuple[int, float] | None:
    """Returns a line and a height in one shape and in the other (`both`), or not in the other.

    None if there is no such piece of a line longer than `slack` [length].
    """
    events = [
        (line, height, np.full(len(line), -sign), number)
        for number, crossings in enumerate((one, other))
        for sign, line, height in crossings.found
    ]
    line, height, step = (np.concatenate([each[k] for each in events]) for k in range(3))
    of = np.concatenate([np.full(len(each[0]), each[3]) for each in events])
    order = np.lexsort((height, line))
    line, height, step, of = line[order], height[order], step[order], of[order]
    in_one, in_other = (np.cumsum(np.where(of == k, step, 0.0))[:-1] > 0.5 for k in (0, 1))
    length = np.where(np.diff(line) == 0, np.diff(height), 0.0)
    length = np.where(in_one & (in_other == both), length, 0.0)
    if not len(length) or length.max() <= slack:
        return None
    most = int(length.argmax())
    return int(line[most]), float(height[most] + 0.5 * length[most])
