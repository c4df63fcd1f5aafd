# SPDX-License-Identifier: BSD-3-Clause
"""Contact and rigid bodies that can be computed, but are probably not meant."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, permutations

import numpy as np

from tilth.arrays import Floats
from tilth.boundaries.contact.make import extents
from tilth.geometry.make import Geometry, make_shape, make_shapes
from tilth.grid.background import background_grid
from tilth.model import (
    Contact,
    FootingGeometry,
    ImplicitBoundary,
    MeshGeometry,
    Model,
    PolylineGeometry,
    RigidBody,
    StlGeometry,
    TerrainGeometry,
)
from tilth.model.geometry_base import DeclaredGeometry
from tilth.mpm.points import MaterialPoints
from tilth.variation.tables import place_text

STEEPEST = 2.0
"""Coefficient of friction above which it is probably an angle: the tangent of 63 degrees."""

THINNEST = 0.1
"""Thickness of a solid shape, in cells, below which the soil hardly feels its edge."""

FACET = 0.25
"""Size of the facets of rigid bodies that are compared with others, in cells."""

WITHIN = 1e-3
"""Distance below the surface of a rigid body, in cells, at which it counts as inside."""


def contact_warnings(model: Model) -> Iterator[tuple[str, str]]:
    """Yields coefficients that look like angles, and rigid surfaces with soil on one side only."""
    for key, law in contact_laws(model):
        if law.friction is not None and law.friction > STEEPEST:
            angle = math.degrees(math.atan(law.friction))
            tangent = math.tan(math.radians(min(law.friction, 89.0)))
            yield (
                f"friction of {key}",
                f"{key}.friction = {law.friction:g} is the tangent of {angle:.0f} degrees; an "
                f"angle of {law.friction:g} degrees would be friction = {tangent:.3g}",
            )
    for body in model.rigid_bodies:
        yield from _thin(model, body)
        for key, shape in model.shapes_of(body):
            if solid := _thickness(model, key, shape):
                yield (
                    f"thickness of {key}",
                    f"{key}: this shape is only {solid:.3g} thick, "
                    f"{solid / min(model.cell_size):.2g} of a cell: soil hardly feels its edge, "
                    "and its sides act on the same nodes; give one of two cells or more, or with "
                    'normal = "bilateral" a thin shape (a plate, or a line with soil = "both")',
                )
            line = isinstance(shape, PolylineGeometry) and not shape.closed
            line |= isinstance(shape, TerrainGeometry)
            open_sides = ("left", "right", "front", "back")
            line |= isinstance(shape, MeshGeometry | StlGeometry) and shape.soil in open_sides
            if (line and not shape.has_two_sides) or isinstance(shape, FootingGeometry):
                yield (
                    f"one side of {key}",
                    f"{key}: the rigid body {body.name!r} has soil on one side of this "
                    f"{shape.type} only, and passes through soil on the other; give the whole "
                    'outline, two cells thick or more, or with normal = "bilateral" a plate or '
                    'soil = "both", unless this is meant',
                )


def rigid_overlaps(model: Model, points: MaterialPoints) -> Iterator[tuple[str, str]]:
    """Yields pairs of rigid bodies that come together and have a place in common.

    points: the undeformed soil; of unbounded shapes only the part near it is looked at.
    """
    grid, keys = background_grid(model), model.rigid_body_keys()
    lower, upper = points.position.min(axis=0), points.position.max(axis=0)
    lower, upper = lower - 2.0 * grid.sizes_at(lower), upper + 2.0 * grid.sizes_at(upper)
    within, new = WITHIN * min(model.cell_size), model.rigid_bodies
    inside: dict[str, tuple[list[Geometry], Floats]] = {}
    for body in new if len(new) > 1 else ():
        if model.stage.begins(body.name):
            shapes = make_shapes(body, model)
            facets = [each.facets(lower, upper, FACET * min(model.cell_size)) for each in shapes]
            centre = [each.corner.mean(axis=1) - within * each.normal for each in facets]
            inside[body.name] = shapes, np.concatenate(centre)
    for one, other in combinations(inside, 2):
        for (_, places), (shapes, _) in permutations((inside[one], inside[other])):
            deepest = np.min([shape.distance(places) for shape in shapes], axis=0)
            if deepest.min(initial=0.0) > -0.5 * within:
                continue
            yield (
                f"overlap of rigid bodies {one} and {other}",
                f"{keys[other]}: the rigid bodies {one!r} and {other!r} have a place in common at "
                f"the start, such as at {place_text(places[int(deepest.argmin())])}: they do not "
                "feel each other, and soil there feels the contact of both; move one of them, or "
                "give one body with several shapes in `geometries`",
            )
            break


def _thickness(model: Model, key: str, shape: DeclaredGeometry) -> float:
    """Returns the thickness of a solid shape if it is thin against the cells [length], or 0."""
    if shape.has_two_sides:
        return 0.0
    cell = np.array(model.cell_size)
    thickness = extents(make_shape(shape, model, key), cell)[1]
    return thickness if thickness < THINNEST * float(cell.min()) else 0.0


def _thin(model: Model, body: RigidBody) -> Iterator[tuple[str, str]]:
    """Yields thin shapes whose sides feel no pressure that would let friction or adhesion act."""
    laws = [body.contact, *(body.contact_with or {}).values()]
    if not any(law.normal == "unilateral" and law.tangential != "smooth" for law in laws):
        return
    thin = [key for key, shape in model.shapes_of(body) if shape.has_two_sides]
    if thin:
        yield (
            f"thin sides of {body.name}",
            f"{thin[0]}: soil on both sides of a thin shape moves as one, and where it presses "
            f"alike on them does not press on the rigid body {body.name!r}: with normal = "
            '"unilateral" nearly no shear stress acts on these sides, and soil never parts from '
            'one of them alone; give normal = "bilateral" with adhesion, a shape at least two '
            "cells thick, or ignore this where soil comes to one side only",
        )


def contact_laws(model: Model) -> Iterator[tuple[str, Contact]]:
    """Yields every law of contact with its place in the case file."""
    keys = model.boundary_keys() | model.rigid_body_keys()
    entries: list[ImplicitBoundary | RigidBody] = [*model.rigid_bodies]
    entries += [each for each in model.boundaries if isinstance(each, ImplicitBoundary)]
    for entry in entries:
        if entry.contact is not None:
            yield f"{keys[entry.name]}.contact", entry.contact
        for name, law in (entry.contact_with or {}).items():
            yield f"{keys[entry.name]}.contact_with.{name}", law
    for i, pair in enumerate(model.contact_pairs):
        yield f"contact_pairs[{i}].contact", pair.contact
