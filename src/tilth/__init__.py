# SPDX-License-Identifier: BSD-3-Clause
"""tilth: implicit material point method for geotechnics.

The public names are loaded when they are first used, so that `tilth --version` is instant.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from tilth.analysis.run import resume, run
    from tilth.case import load_case
    from tilth.errors import AnalysisFailed, BadInput, Interrupted, TilthError
    from tilth.model import (
        AffineBoundary,
        Analysis,
        Body,
        BodyForce,
        Box,
        BoxGeometry,
        Circle,
        CircleGeometry,
        Cylinder,
        CylinderGeometry,
        Follow,
        FootingGeometry,
        FunctionGeometry,
        Grid,
        HenckyElastic,
        Hydrostatic,
        ImplicitBoundary,
        Limits,
        Mesh,
        Model,
        NodeBoundary,
        Output,
        PlaneBoundary,
        PlaneGeometry,
        PointForce,
        Polygon,
        PolylineGeometry,
        Rotation,
        Schedule,
        Sphere,
        SphereGeometry,
        SplineGeometry,
        StlGeometry,
        Surface,
        SurfaceLoad,
        Track,
        Units,
        VonMises,
    )

_MODULES = {
    "tilth.analysis.run": ("resume", "run"),
    "tilth.case": ("load_case",),
    "tilth.errors": ("AnalysisFailed", "BadInput", "Interrupted", "TilthError"),
    "tilth.model": (
        "AffineBoundary",
        "Analysis",
        "Body",
        "BodyForce",
        "Box",
        "BoxGeometry",
        "Circle",
        "CircleGeometry",
        "Cylinder",
        "CylinderGeometry",
        "Follow",
        "FootingGeometry",
        "FunctionGeometry",
        "Grid",
        "HenckyElastic",
        "Hydrostatic",
        "ImplicitBoundary",
        "Limits",
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
        "Sphere",
        "SphereGeometry",
        "SplineGeometry",
        "StlGeometry",
        "Surface",
        "SurfaceLoad",
        "Track",
        "Units",
        "VonMises",
    ),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}

__all__ = [
    "AffineBoundary",
    "Analysis",
    "AnalysisFailed",
    "BadInput",
    "Body",
    "BodyForce",
    "Box",
    "BoxGeometry",
    "Circle",
    "CircleGeometry",
    "Cylinder",
    "CylinderGeometry",
    "Follow",
    "FootingGeometry",
    "FunctionGeometry",
    "Grid",
    "HenckyElastic",
    "Hydrostatic",
    "ImplicitBoundary",
    "Interrupted",
    "Limits",
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
    "Sphere",
    "SphereGeometry",
    "SplineGeometry",
    "StlGeometry",
    "Surface",
    "SurfaceLoad",
    "TilthError",
    "Track",
    "Units",
    "VonMises",
    "load_case",
    "resume",
    "run",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'tilth' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
