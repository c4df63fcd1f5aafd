# SPDX-License-Identifier: BSD-3-Clause
"""From the declared geometry of an implicit boundary to one that can be computed with."""

from __future__ import annotations

import numpy as np

from tilth.curves.chain import BadSurface, Chain
from tilth.curves.crossing import require_no_crossing
from tilth.curves.spline import LocalCubicSpline
from tilth.errors import BadInput
from tilth.geometry.box import Box
from tilth.geometry.footing import Footing
from tilth.geometry.level_set import LevelSet
from tilth.geometry.plane import Plane
from tilth.geometry.polyline import Polyline
from tilth.geometry.protocol import Geometry
from tilth.geometry.round import Circle, Cylinder, Sphere
from tilth.geometry.spline import SplineGeometry
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.model import ImplicitBoundary, Model
from tilth.model.fields import per_direction
from tilth.model.geometry import (
    BoxGeometry,
    CircleGeometry,
    CylinderGeometry,
    FootingGeometry,
    FunctionGeometry,
    PlaneGeometry,
    PolylineGeometry,
    SphereGeometry,
)
from tilth.model.geometry import SplineGeometry as Splined
from tilth.model.user_function import UserFunction

__all__ = ["Geometry", "make_geometry"]


def make_geometry(boundary: ImplicitBoundary, model: Model) -> Geometry:
    """Returns the geometry that a boundary of a model declares.

    Raises:
        BadInput: a file or function that it names cannot be used.
    """
    declared = boundary.geometry
    number = [b.name for b in model.boundaries].index(boundary.name)
    key = f"boundaries[{number}].geometry"
    inside = getattr(declared, "soil", None) == "inside"
    if isinstance(declared, PlaneGeometry):
        return Plane(np.array(declared.point), np.array(declared.normal))
    if isinstance(declared, CircleGeometry):
        return Circle(np.array(declared.centre), declared.radius, inside)
    if isinstance(declared, CylinderGeometry):
        axis = np.array(declared.direction)
        return Cylinder(np.array(declared.centre), axis, declared.radius, inside)
    if isinstance(declared, SphereGeometry):
        return Sphere(np.array(declared.centre), declared.radius, inside)
    if isinstance(declared, PolylineGeometry):
        return Polyline(np.array(declared.vertices), declared.closed, declared.soil == "left")
    if isinstance(declared, Splined):
        return _spline(declared, f"{key}.vertices")
    if isinstance(declared, BoxGeometry):
        corners = np.array(declared.lower), np.array(declared.upper)
        return Box(*corners, np.array(declared.axes), inside, declared.faces)
    if isinstance(declared, FootingGeometry):
        widths = np.array(per_direction(declared.width, model.dimension - 1))
        along = None if declared.along is None else np.array(declared.along)
        return Footing(np.array(declared.centre), np.array(declared.normal), widths, along)
    if isinstance(declared, FunctionGeometry):
        function = UserFunction(declared.function, key=f"{key}.function")
        return LevelSet(function, model.dimension, np.array(model.cell_size))
    return TriangleMesh.from_file(declared.file, declared.soil, key=f"{key}.file")


def _spline(declared: Splined, key: str) -> SplineGeometry:
    points = np.array(declared.vertices)
    corner = np.zeros(len(points), dtype=bool)
    corner[list(declared.corners or ())] = True
    if declared.soil == "right":  # along the chain it is on the left
        points, corner = points[::-1], corner[::-1]
    try:
        chain = Chain(points, declared.closed, corner)
    except BadSurface as error:
        raise BadInput(error.problem, error.remedy, key=key) from error
    require_no_crossing(chain, key)
    return SplineGeometry(LocalCubicSpline(chain))
