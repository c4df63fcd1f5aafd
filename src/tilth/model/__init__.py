# SPDX-License-Identifier: BSD-3-Clause
"""The model of a problem as the user declares it: validated and immutable."""

from tilth.model.bodies import Body
from tilth.model.boundaries import AffineBoundary, Boundary, NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES, Axis, per_direction
from tilth.model.geometry import (
    BoxGeometry,
    CircleGeometry,
    CylinderGeometry,
    FootingGeometry,
    FunctionGeometry,
    Geometry,
    PlaneGeometry,
    PolylineGeometry,
    SphereGeometry,
    SplineGeometry,
    StlGeometry,
)
from tilth.model.implicit import ImplicitBoundary, Rotation
from tilth.model.load_curve import LoadCurve
from tilth.model.loads import BodyForce, Load, PointForce
from tilth.model.materials import HenckyElastic, Material, VonMises
from tilth.model.model import FORMAT, Model
from tilth.model.schedule import Schedule
from tilth.model.settings import Analysis, Follow, Grid, Kind, Limits, Output, Units
from tilth.model.shapes import Box, Circle, Cylinder, Mesh, Polygon, Shape, Sphere
from tilth.model.surface import Hydrostatic, Surface, SurfaceLoad
from tilth.model.track import Track

__all__ = [
    "AXES",
    "FORMAT",
    "AffineBoundary",
    "Analysis",
    "Axis",
    "Body",
    "BodyForce",
    "Boundary",
    "Box",
    "BoxGeometry",
    "Circle",
    "CircleGeometry",
    "Cylinder",
    "CylinderGeometry",
    "Follow",
    "FootingGeometry",
    "FunctionGeometry",
    "Geometry",
    "Grid",
    "HenckyElastic",
    "Hydrostatic",
    "ImplicitBoundary",
    "Kind",
    "Limits",
    "Load",
    "LoadCurve",
    "Material",
    "Mesh",
    "Model",
    "NodeBoundary",
    "Output",
    "PlaneBoundary",
    "PlaneGeometry",
    "PointForce",
    "Polygon",
    "PolylineGeometry",
    "Rotation",
    "Schedule",
    "Shape",
    "Sphere",
    "SphereGeometry",
    "SplineGeometry",
    "StlGeometry",
    "Surface",
    "SurfaceLoad",
    "Track",
    "Units",
    "VonMises",
    "per_direction",
]
