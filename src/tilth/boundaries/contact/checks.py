# SPDX-License-Identifier: BSD-3-Clause
"""Checks of surfaces in contact before the first step and after each step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.constraint import ContactConstraint
from tilth.boundaries.contact.gather import REACH
from tilth.boundaries.contact.overlap import soil_inside
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.boundaries.contact.surface import ContactSurface
from tilth.errors import BadInput, StepFailed
from tilth.mpm.points import MaterialPoints
from tilth.mpm.torn_off import torn_off

INSIDE = 0.1
"""Depth in cells from which a material point counts as inside a rigid body at the start."""

LARGEST_DEPTH = 0.5
"""Depth in cells that no material point may newly have behind a surface after a step."""

UNSEEN = 0.1
"""Depth in cells by which no material point may get behind a part of a surface in a step at whose
start this part had no soil within `REACH`, so that nothing held the point."""

_IN_SOIL = "cut its shape out of the soil body and give `wished_in_place = true`"

_IN_MOVED_SOIL = (
    "`excavate` its shape in this stage; its place is that in the soil as the results show it at "
    "the end of the stage before, from which `tilth run CASE.toml --from DIR:STAGE` goes on"
)


def require_outside(
    surfaces: Sequence[ContactSurface], points: MaterialPoints, has_moved: bool = False
) -> None:
    """Checks that no soil begins inside a rigid body.

    has_moved: whether it is the soil at the end of a stage.

    Raises:
        BadInput: material points are inside one.
    """
    for surface in surfaces:
        if surface.body is None:
            continue
        inside, depth = soil_inside(
            lambda x, own=surface: own.distance(x, own.body.time),  # type: ignore[misc]
            points,
            INSIDE * surface.cell,
        )
        if len(inside) == 0:
            continue
        name = surface.body.name
        first = ", ".join(f"{x:g}" for x in points.position[inside[0]])
        raise BadInput(
            f"{len(inside)} material points begin inside the rigid body {name!r}, up to "
            f"{depth:.3g} deep, such as number {points.point_id[inside[0]]} at ({first})",
            f"lift the body by {depth:.3g} or more, so that it comes down on the soil, or "
            + (_IN_MOVED_SOIL if has_moved else _IN_SOIL),
            key=surface.key,
        )


def require_soil_in_reach(
    bodies: Sequence[RigidBody],
    contacts: Sequence[ContactConstraint],
    after: float,
    keys: Mapping[str, str],
) -> None:
    """Checks that free bodies that fall in the first step, to time `after`, can come down on soil.

    keys: where each body stands in the case file, by name.

    Raises:
        BadInput: no soil is within reach of one.
    """
    for body in bodies:
        direction = body.falls_along(after)
        own = [part for part in contacts if part.boundary.body is body]
        if direction is None or any((part.pose.normal @ direction > 0.0).any() for part in own):
            continue
        raise BadInput(
            f"no soil is within {REACH:g} cell of the rigid body {body.name!r} in the direction of "
            "the force on it, and nothing else holds it there",
            "place it closer to the soil, prescribe its motion, or give springs",
            key=keys[body.name],
        )


def require_not_passed(
    surfaces: Sequence[ContactSurface],
    contacts: Sequence[ContactConstraint],
    points: MaterialPoints,
    moved: Floats,
    before: float,
    after: float,
) -> None:
    """Checks that a step takes no material point through a surface.

    Contact holds soil that is within a cell of a surface at the start of a step. Points that are
    torn off may pass by less than a cell: they bear nothing, and fall however short the step is.
    contacts: those of the step. moved: positions at the end [length], shape (n, dim).

    Raises:
        StepFailed: a point is behind the surface that was not before.
    """
    way = np.linalg.norm(moved - points.position, axis=1)
    torn = torn_off(points)
    for surface in surfaces:
        if surface.quadrature is None:
            continue
        near = _near(surface, moved, after)
        near = near[~torn[near] | (way[near] >= surface.cell)]
        now = surface.distance(moved[near], after) / surface.cell
        behind = np.flatnonzero(now < -UNSEEN)
        if len(behind) == 0:
            continue
        was = surface.distance(points.position[near[behind]], before) / surface.cell
        now = now[behind]
        through = (now < -LARGEST_DEPTH) & (was >= -LARGEST_DEPTH)
        entered = np.flatnonzero((was - now > UNSEEN) & ~through)
        if len(entered):
            place = moved[near[behind[entered]]]
            through[entered] = _is_unseen(surface, contacts, place, after)
        if through.any():
            raise StepFailed(
                f"soil passes through the surface of {surface.name!r} in one step",
                point=int(points.point_id[near[behind[through]][0]]),
                share=0.5,
            )


def _is_unseen(
    surface: ContactSurface, contacts: Sequence[ContactConstraint], place: Floats, time: float
) -> Flags:
    """Returns which places (k, dim) are nearest to a part of the surface without contact, (k,)."""
    from scipy.spatial import cKDTree

    position = surface.surface_points(time)[0]
    seen = np.zeros(len(position), dtype=bool)
    for part in contacts:
        if part.boundary is surface:
            seen[part.chosen] = True
    return np.asarray(~seen[cKDTree(position).query(place)[1]])


def _near(surface: ContactSurface, position: Floats, time: float) -> Integers:
    place, _, _ = surface.surface_points(time)
    if len(place) == 0:
        return np.zeros(0, dtype=np.int64)
    low, high = place.min(axis=0) - surface.cell, place.max(axis=0) + surface.cell
    return np.flatnonzero(((position >= low) & (position <= high)).all(axis=1))
