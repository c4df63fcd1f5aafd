# SPDX-License-Identifier: BSD-3-Clause
"""Initial material points of a declared body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.bodies.box import box_points
from tilth.bodies.filling import require_filled
from tilth.bodies.forms import WithHoles, form_of
from tilth.bodies.holes import without_holes
from tilth.bodies.holes_in_space import without_holes_in_space
from tilth.bodies.inside import Inside, inside_of
from tilth.bodies.mesh import Elements, mesh_points
from tilth.bodies.polygon import polygon_points
from tilth.bodies.polyhedron import Polyhedron, polyhedron_points
from tilth.bodies.request import BodyPoints, Request, per_direction
from tilth.bodies.round import circle_points, cylinder_points, sphere_points
from tilth.bodies.terrain import HeightField, height_field_points
from tilth.model import Body, Box, Circle, Cylinder, Polygon, Sphere
from tilth.model.shapes import SHAPES, DeclaredShape

if TYPE_CHECKING:
    from tilth.grid.background import Grid

FORMS: dict[type, Callable[[Any, Request], BodyPoints]] = {
    Box: box_points,
    Polygon: polygon_points,
    Circle: circle_points,
    Cylinder: cylinder_points,
    Sphere: sphere_points,
    Elements: mesh_points,
    HeightField: height_field_points,
    Polyhedron: polyhedron_points,
}
"""One line per form: the function that divides it into material points."""


def discretise(body: Body, kind: str, grid: Grid) -> BodyPoints:
    """Returns the initial material points of a body; their volumes sum to its volume to round-off.

    kind: plane_strain, axisymmetric or 3d.
    Points are ordered x fastest, then y, then z (a mesh: in the order of its elements). In
    axisymmetry the domains' half lengths along r are limited to r, so that none extends across the
    axis; rotated domains and those of a mesh (CPDI) fill the body and need no limit.
    Raises BadInput, naming the body, for a body without points, a shape of another dimension, or
    points so close that it can only be an error, or so far apart that cells in the body are empty.
    """
    request = requested(body, kind, grid)
    if grid.dim not in body.shape.dimensions:
        raise request.refused(
            f"a {body.shape.type} is not a shape of {grid.dim} dimensions",
            "choose " + ", ".join(s.__name__.lower() for s in SHAPES if grid.dim in s.dimensions),
            "shape.type",
        )
    if request.points is None:
        request.check_spacing(request.cell_size / request.requested_spacing())
    form = form_of(body.shape, request)
    if isinstance(form, WithHoles):
        points = without_holes_in_space(FORMS[type(form.whole)](form.whole, request), form, request)
    else:
        points = FORMS[type(form)](form, request)
    if isinstance(form, DeclaredShape) and form.cavities():
        points = without_holes(points, form, request)
    request.check_distance(points)
    require_filled(points, request)
    rotated = points.frame is not None and request.has_corners
    if not request.axisymmetric or rotated or points.corner is not None:
        return points
    half_length = points.half_length.copy()
    half_length[:, 0] = np.minimum(half_length[:, 0], points.position[:, 0])
    return replace(points, half_length=half_length)


def inside_body(body: Body, kind: str, grid: Grid) -> Inside:
    """Returns the test of which positions [length], (n, dimension), are inside a body's shape.

    Arguments as those of `discretise`. Raises BadInput for a file that cannot be read.
    """
    return inside_of(form_of(body.shape, requested(body, kind, grid)))


def requested(body: Body, kind: str, grid: Grid) -> Request:
    """Returns the resolution that a body declares; arguments as in `discretise`."""
    return Request(
        name=body.name,
        axisymmetric=kind == "axisymmetric",
        grid=grid,
        points_per_cell=per_direction(body.points_per_cell, grid.dim),
        points=per_direction(body.points, grid.dim),
        spacing=per_direction(body.spacing, grid.dim),
        basis=body.basis,
    )
