# SPDX-License-Identifier: BSD-3-Clause
"""Creates the geometry of an implicit boundary or a rigid body from its declaration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from tilth import model as declared
from tilth.curves.chain import BadSurface, Chain
from tilth.curves.crossing import require_no_crossing
from tilth.curves.spline import LocalCubicSpline
from tilth.errors import BadInput
from tilth.geometry.both_sides import BothSides
from tilth.geometry.box import Box
from tilth.geometry.cone import Cone, section
from tilth.geometry.footing import Footing
from tilth.geometry.level_set import LevelSet
from tilth.geometry.mesh_group import group_line, group_surface
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.geometry.protocol import Geometry
from tilth.geometry.round import Circle, Cylinder, Sphere
from tilth.geometry.spline import SplineGeometry
from tilth.geometry.terrain import terrain_surface
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.model import ImplicitBoundary, Model, RigidBody
from tilth.model.fields import per_direction
from tilth.model.geometry import DeclaredGeometry
from tilth.model.user_function import UserFunction

__all__ = ["GEOMETRIES", "Geometry", "make_geometry", "make_shape", "make_shapes"]


def make_geometry(boundary: ImplicitBoundary, model: Model) -> Geometry:
    """Returns the geometry that a boundary of a model declares.

    Raises:
        BadInput: a file or function named there cannot be used, or a curve is not valid.
    """
    key = model.boundary_keys()[boundary.name]
    return make_shape(boundary.geometry, model, f"{key}.geometry")


def make_shape(geometry: DeclaredGeometry, model: Model, key: str) -> Geometry:
    """Returns a declared geometry; `key` is its place in the case file, for messages.

    Raises:
        BadInput: as `make_geometry`.
    """
    return GEOMETRIES[type(geometry)](geometry, model, key)


def make_shapes(body: RigidBody, model: Model) -> list[Geometry]:
    """Returns the shapes of a rigid body of a model; raises as `make_geometry`."""
    return [make_shape(shape, model, key) for key, shape in model.shapes_of(body)]


def _plane(plane: declared.PlaneGeometry, model: Model, key: str) -> Geometry:
    return Plane(np.array(plane.point), np.array(plane.normal))


def _circle(circle: declared.CircleGeometry, model: Model, key: str) -> Geometry:
    return Circle(np.array(circle.centre), circle.radius, circle.soil == "inside")


def _cylinder(cylinder: declared.CylinderGeometry, model: Model, key: str) -> Geometry:
    centre, axis = np.array(cylinder.centre), np.array(cylinder.direction)
    return Cylinder(centre, axis, cylinder.radius, cylinder.soil == "inside")


def _sphere(sphere: declared.SphereGeometry, model: Model, key: str) -> Geometry:
    return Sphere(np.array(sphere.centre), sphere.radius, sphere.soil == "inside")


def _polyline(line: declared.PolylineGeometry, model: Model, key: str) -> Geometry:
    made = Polyline(np.array(line.vertices), line.closed, line.soil != "right")
    return BothSides(made) if line.has_two_sides else made


def _spline(spline: declared.SplineGeometry, model: Model, key: str) -> Geometry:
    points = np.array(spline.vertices)
    corner = np.zeros(len(points), dtype=bool)
    corner[list(spline.corners or ())] = True
    if spline.soil == "right":  # the soil of a chain is on its left
        points, corner = points[::-1], corner[::-1]
    try:
        chain = Chain(points, spline.closed, corner)
    except BadSurface as error:
        raise BadInput(error.problem, error.remedy, key=f"{key}.vertices") from error
    require_no_crossing(chain, f"{key}.vertices")
    return SplineGeometry(LocalCubicSpline(chain))


def _box(box: declared.BoxGeometry, model: Model, key: str) -> Geometry:
    corners = np.array(box.lower), np.array(box.upper)
    return Box(*corners, np.array(box.axes), box.soil == "inside", box.faces)


def _footing(
    footing: declared.FootingGeometry | declared.PlateGeometry, model: Model, key: str
) -> Footing:
    widths = np.array(per_direction(footing.width, model.dimension - 1))
    along = None if footing.along is None else np.array(footing.along)
    return Footing(np.array(footing.centre), np.array(footing.normal), widths, along)


def _plate(plate: declared.PlateGeometry, model: Model, key: str) -> Geometry:
    middle = _footing(plate, model, key)
    if plate.has_two_sides:
        return BothSides(middle)
    axes = np.vstack([middle.axes, middle.normal])
    half = np.append(middle.half, 0.5 * plate.thickness)
    lower = middle.centre - half @ axes
    return Box(lower, lower + 2.0 * half, axes, inside=False)


def _cone(cone: declared.ConeGeometry, model: Model, key: str) -> Geometry:
    tip, axis, inside = np.array(cone.tip), np.array(cone.direction), cone.soil == "inside"
    if model.dimension == 3:
        return Cone(tip, axis, cone.radius, cone.tip_length, cone.length, inside)
    corners = section(cone.radius, cone.tip_length, cone.length)
    across = np.array([axis[1], -axis[0]])
    vertices = tip + corners[:, :1] * across + corners[:, 1:] * axis
    return Polyline(vertices, closed=True, left=inside)


def _function(declaration: declared.FunctionGeometry, model: Model, key: str) -> Geometry:
    function = UserFunction(declaration.function, key=f"{key}.function")
    return LevelSet(function, model.dimension, np.array(model.cell_size))


def _stl(stl: declared.StlGeometry, model: Model, key: str) -> Geometry:
    kind = OpenSurface if stl.is_open else TriangleMesh
    return kind.from_file(stl.file, stl.soil, key=f"{key}.file")


def _terrain(terrain: declared.TerrainGeometry, model: Model, key: str) -> Geometry:
    return terrain_surface(terrain, key)


def _mesh(mesh: declared.MeshGeometry, model: Model, key: str) -> Geometry:
    if model.dimension == 3:
        return group_surface(mesh.file, mesh.group, mesh.soil, key)
    line, closed = group_line(mesh.file, mesh.group, key)
    sides = ("inside", "outside", "both") if closed else ("left", "right", "both")
    if mesh.soil not in sides:
        what = f"is no side of the {'closed' if closed else 'open'} line of {mesh.group!r}"
        remedy = f"give {', '.join(repr(side) for side in sides)}".replace("'", '"')
        raise BadInput(what, remedy, key=f"{key}.soil", value=mesh.soil)
    made = Polyline(line, closed, mesh.soil not in ("right", "outside"))
    return BothSides(made) if mesh.has_two_sides else made


GEOMETRIES: dict[type[DeclaredGeometry], Callable[[Any, Model, str], Geometry]] = {
    declared.PlaneGeometry: _plane,
    declared.CircleGeometry: _circle,
    declared.CylinderGeometry: _cylinder,
    declared.SphereGeometry: _sphere,
    declared.PolylineGeometry: _polyline,
    declared.SplineGeometry: _spline,
    declared.BoxGeometry: _box,
    declared.FunctionGeometry: _function,
    declared.StlGeometry: _stl,
    declared.TerrainGeometry: _terrain,
    declared.MeshGeometry: _mesh,
    declared.FootingGeometry: _footing,
    declared.PlateGeometry: _plate,
    declared.ConeGeometry: _cone,
}
"""One line per geometry: the function that creates it from declaration, model and key."""
