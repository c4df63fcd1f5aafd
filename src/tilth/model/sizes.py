# SPDX-License-Identifier: BSD-3-Clause
"""Checks that vectors, shapes and axes fit the dimension of the analysis."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from tilth.errors import Problem
from tilth.model.boundaries import AffineBoundary, NodeBoundary, PlaneBoundary
from tilth.model.fields import AXES
from tilth.model.flow import PlaneFlowBoundary
from tilth.model.flow_checks import flow_axes, flow_vectors
from tilth.model.geometry import GEOMETRIES, DeclaredGeometry, TerrainGeometry
from tilth.model.implicit import ImplicitBoundary
from tilth.model.initial import AtRest
from tilth.model.loads import BodyForce, LineForce, PointForce, SeismicLoad
from tilth.model.problems import below, dotted
from tilth.model.shapes import SHAPES, DeclaredShape, Terrain
from tilth.model.staging import loading_stages
from tilth.model.surface import SurfaceLoad
from tilth.model.track import Track
from tilth.model.variation import (
    AlongAxis,
    ByDepth,
    Random,
    Variation,
    at_survey_points,
    variations,
)

if TYPE_CHECKING:
    from tilth.model.declaration import Declaration


def size_problems(model: Declaration) -> list[Problem]:
    """Returns every entry that does not fit the dimension of the analysis."""
    kind, dimension = model.analysis.kind, model.dimension
    problems = [p for key, value in _vectors(model) for p in _length(key, value, dimension, kind)]
    problems += [p for key, axes in _axes(model) for p in _axis(key, axes, dimension, kind)]
    problems += _grids(model)
    for i, body in enumerate(model.bodies):
        problems += _variant(f"bodies[{i}].shape", body.shape, SHAPES, dimension, kind)
    for i, boundary in enumerate(model.boundaries):
        key = f"boundaries[{i}]"
        if isinstance(boundary, AffineBoundary):
            problems += _affine(f"{key}.deformation_gradient", boundary, dimension, kind)
        problems += _range(key, boundary)
        if isinstance(boundary, ImplicitBoundary):
            problems += _rotation(f"{key}.rotation", boundary, dimension, kind)
            if kind == "axisymmetric" and boundary.volume_loss is not None:
                what = "in axisymmetry a circle is the section of a sphere or a ring"
                remedy = "give `radius_change`"
                problems.append(Problem(f"{key}.volume_loss", what, remedy, boundary.volume_loss))
    for i, each in enumerate(() if model.flow is None else model.flow.boundaries):
        problems += _range(f"flow.boundaries[{i}]", each)
    for key, geometry in model.geometries():
        problems += _variant(key, geometry, GEOMETRIES, dimension, kind)
    problems += [*_surfaces(model), *_forces(model)]
    problems += _levels(model)
    for i, track in enumerate(model.track):
        if track.quantity in _ABOUT_AXES:
            problems += _moment(f"track[{i}]", track, dimension, kind)
    return problems


def _range(key: str, boundary: Any) -> Iterator[Problem]:
    """The axis normal to a plane is not one along which the plane has a range."""
    plane = isinstance(boundary, PlaneBoundary | PlaneFlowBoundary)
    if plane and boundary.axis in (boundary.range or {}):
        what = f"is the axis normal to the plane, along which `at` = {boundary.at:g} is given"
        yield Problem(f"{key}.range.{boundary.axis}", what, "leave it out")


def _grids(model: Declaration) -> Iterator[Problem]:
    """Axes without a cell size or a direction, and origins that are not the first place."""
    grids = [
        ("grid", model.grid),
        *((f"stages[{i}].grid", s.grid) for i, s in loading_stages(model)),
    ]
    followed = model.grid.follow.axes if model.grid.follow is not None else ()
    for key, grid in grids:
        if grid is None or not isinstance(grid.cell_size, Mapping):
            continue
        kind, axes = model.analysis.kind, AXES[: model.dimension]
        for axis in axes:
            if axis not in grid.cell_size:
                remedy = "give a number, or rows (place, size)"
                yield Problem(f"{key}.cell_size.{axis}", "missing", remedy)
        yield from _axis(f"{key}.cell_size", grid.cell_size, model.dimension, kind)
        for k, axis in enumerate(axes):
            rows = grid.cell_size.get(axis)
            if not isinstance(rows, tuple):
                continue
            first = rows[0][0]
            if grid.origin is not None and k < len(grid.origin) and grid.origin[k] != first:
                what = f"along {axis} the origin is the first place of {key}.cell_size, {first:g}"
                yield Problem(f"{key}.origin", what, "give this, or leave it out", grid.origin)
            if axis in followed and all(place != 0.0 for place, _ in rows):
                what = (
                    "places are relative to the point that the grid follows, and no line is there"
                )
                yield Problem(f"{key}.cell_size.{axis}", what, "give a row with place 0", rows)


def _surfaces(model: Declaration) -> Iterator[Problem]:
    """Entries of surfaces and their loads that are only for curves, or only for triangles."""
    if model.dimension == 2:
        for i, load in enumerate(model.loads):
            for key in ("part", "within"):
                if isinstance(load, SurfaceLoad) and getattr(load, key) is not None:
                    what, remedy = "is for surfaces in 3D", "give `start` and `end`"
                    yield Problem(f"loads[{i}].{key}", what, remedy)
        return
    remedy = 'leave it out: in an analysis of kind "3d" the outline of a body has triangles'
    for i, body in enumerate(model.bodies):
        surface = body.surface
        if surface is not None and surface.vertices is not None:
            yield Problem(f"bodies[{i}].surface.vertices", "are for curves in 2D", remedy)
        if surface is not None and surface.points == "outer_layer":
            what = "is for curves in 2D"
            yield Problem(f"bodies[{i}].surface.points", what, remedy, surface.points)
    remedy = "name a `part` or a region `within` in 3D, and give `traction` for shear"
    for i, load in enumerate(model.loads):
        for key in ("start", "pressure_along", "shear"):
            if isinstance(load, SurfaceLoad) and getattr(load, key):
                yield Problem(f"loads[{i}].{key}", "is for curves in 2D", remedy)


def _forces(model: Declaration) -> Iterator[Problem]:
    """Forces that the kind of the analysis does not have."""
    for i, load in enumerate(model.loads):
        if isinstance(load, LineForce) and model.dimension == 2:
            remedy = 'give a load of type = "point_force": it is a line load in plane strain, '
            remedy += "a ring load in axisymmetry"
            yield Problem(f"loads[{i}].type", "is for 3D", remedy, load.type)
        if model.analysis.kind != "axisymmetric":
            continue
        if isinstance(load, PointForce) and load.at[0] < 0.0:
            what, remedy = "lies at a radius below 0", "give r >= 0"
            yield Problem(f"loads[{i}].at", what, remedy, load.at)
        elif isinstance(load, PointForce) and load.at[0] == 0.0 and load.force[0] != 0.0:
            what = "has a radial component on the axis of symmetry, where it has no direction"
            yield Problem(f"loads[{i}].force", what, "give 0 for it, or r > 0", load.force)
        elif isinstance(load, SeismicLoad) and load.coefficient[0] != 0.0:
            what = "a horizontal force in one direction would break the axisymmetry"
            remedy = "give 0 for it, or choose another kind of analysis"
            yield Problem(f"loads[{i}].coefficient", what, remedy, load.coefficient)


def _levels(model: Declaration) -> Iterator[Problem]:
    """Polylines in 3D, where a surface is a number or a file; survey points where none may be."""
    for key, level in levels(model):
        if model.dimension == 3 and isinstance(level, tuple):
            remedy = 'give a number, or { file = "surface.csv" } with the columns x,y,value'
            yield Problem(key, "a polyline of rows (x, elevation) is for 2D", remedy, level)
        if at_survey_points(level):
            if model.dimension == 2:
                remedy = "leave it out: in 2D the rows x,z of a file need no order"
                yield Problem(f"{key}.places", "is for 3D", remedy, level.places)
            elif key.endswith("level"):
                remedy = "give a number, or a grid: a level of water goes on beyond its ends"
                what = "survey points give no level of water"
                yield Problem(f"{key}.places", what, remedy, level.places)


def levels(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields every declared elevation of a surface or a horizon, with its key."""
    for key, variation in _variations(model):
        if isinstance(variation, ByDepth):
            yield f"{key}.surface", variation.surface
        elif isinstance(variation, Random) and variation.random.surface is not None:
            yield f"{key}.random.surface", variation.random.surface
    for i, body in enumerate(model.bodies):
        if isinstance(body.shape, Terrain):
            for name, level in body.shape.levels().items():
                yield f"bodies[{i}].shape.{name}", level
        for j, layer in enumerate(body.layers):
            if layer.bottom is not None:
                yield f"bodies[{i}].layers[{j}].bottom", layer.bottom
    for key, geometry in model.geometries():
        if isinstance(geometry, TerrainGeometry):
            yield f"{key}.surface", geometry.surface
    for i, entry in enumerate(model.initial.stress):
        if isinstance(entry, AtRest) and entry.ground is not None:
            yield f"initial.stress[{i}].ground", entry.ground
    declared = [("water", model.water)]
    declared += [(f"stages[{i}].water", stage.water) for i, stage in loading_stages(model)]
    for key, water in declared:
        if water is not None:
            yield f"{key}.level", water.level
            yield f"{key}.initial_level", water.initial_level


def _variations(model: Declaration) -> Iterator[tuple[str, Variation]]:
    """Yields every material parameter and initial stress that varies, with its key."""
    for name, material in model.materials.items():
        for key, variation in variations(material).items():
            yield dotted(("materials", name, key)), variation
    for place, entry in model.initial.entries():
        for key, variation in variations(entry).items():
            yield f"{place}.{key}", variation


def _vectors(model: Declaration) -> Iterator[tuple[str, Any]]:
    """Yields every entry that may be a vector with one component per direction."""
    yield "grid.origin", model.grid.origin
    yield "grid.cell_size", model.grid.cell_size
    for i, stage in loading_stages(model):
        if stage.grid is not None:
            yield f"stages[{i}].grid.origin", stage.grid.origin
            yield f"stages[{i}].grid.cell_size", stage.grid.cell_size
    if model.grid.limits is not None:
        yield "grid.limits.lower", model.grid.limits.lower
        yield "grid.limits.upper", model.grid.limits.upper
    if model.grid.follow is not None:
        yield "grid.follow.place", model.grid.follow.place
    for i, body in enumerate(model.bodies):
        for way in ("points_per_cell", "points", "spacing"):
            yield f"bodies[{i}].{way}", getattr(body, way)
        if model.dimension in body.shape.dimensions:
            for name, value in body.shape.vectors().items():
                yield f"bodies[{i}].shape.{name}", value
    for i, boundary in enumerate(model.boundaries):
        if isinstance(boundary, NodeBoundary):
            yield f"boundaries[{i}].at", boundary.at
        elif isinstance(boundary, ImplicitBoundary):
            yield f"boundaries[{i}].direction", boundary.direction
            if boundary.rotation is not None:
                yield f"boundaries[{i}].rotation.centre", boundary.rotation.centre
    for i, rigid in enumerate(model.rigid_bodies):
        yield f"rigid_bodies[{i}].centre", rigid.centre
    for key, geometry in model.geometries():
        if model.dimension in geometry.dimensions:
            for name, value in geometry.vectors(model.dimension).items():
                yield f"{key}.{name}", value
    for i, load in enumerate(model.loads):
        if isinstance(load, BodyForce):
            yield f"loads[{i}].acceleration", load.acceleration
        elif isinstance(load, SeismicLoad):
            yield f"loads[{i}].coefficient", load.coefficient
        elif isinstance(load, LineForce):
            if model.dimension == 3:
                for key in ("start", "end", "force"):
                    yield f"loads[{i}].{key}", getattr(load, key)
        elif isinstance(load, SurfaceLoad):
            yield f"loads[{i}].traction", load.traction
            if model.dimension == 2:
                yield f"loads[{i}].start", load.start
                yield f"loads[{i}].end", load.end
        else:
            yield f"loads[{i}].at", load.at
            yield f"loads[{i}].force", load.force
    for key, variation in _variations(model):
        if isinstance(variation, Random):
            yield f"{key}.random.correlation_lengths", variation.random.correlation_lengths
    yield from flow_vectors(model)
    for i, track in enumerate(model.track):
        yield f"track[{i}].at", track.at
        yield f"track[{i}].about", track.about


def _axes(model: Declaration) -> Iterator[tuple[str, Iterable[str]]]:
    """Yields every entry that names axes or components."""
    for key, variation in _variations(model):
        if isinstance(variation, AlongAxis):
            yield f"{key}.axis", variation.axis
    yield "grid.follow.axes", model.grid.follow.axes if model.grid.follow is not None else ()
    for i, boundary in enumerate(model.boundaries):
        key = f"boundaries[{i}]"
        if isinstance(boundary, AffineBoundary):
            continue
        yield f"{key}.displacement", boundary.displacement or {}
        if isinstance(boundary, ImplicitBoundary):
            continue
        yield f"{key}.components", boundary.components or ()
        if isinstance(boundary, PlaneBoundary):
            yield f"{key}.axis", boundary.axis
            yield f"{key}.range", boundary.range or {}
    yield from flow_axes(model)
    for key, geometry in model.geometries():
        for name, axes in geometry.axes_named().items():
            yield f"{key}.{name}", axes
    for i, track in enumerate(model.track):
        yield f"track[{i}].axis", track.axis or ()
        if track.quantity in _ABOUT_AXES:
            continue
        if track.component in AXES or track.component in ("yz", "xz"):
            yield f"track[{i}].component", track.component or ""


def _length(key: str, value: Any, dimension: int, kind: str) -> Iterator[Problem]:
    if isinstance(value, Sequence) and len(value) != dimension:
        what = f"must have {dimension} components, not {len(value)}"
        yield Problem(key, what, f"{kind} has the directions {', '.join(AXES[:dimension])}", value)


def _axis(key: str, axes: Iterable[str], dimension: int, kind: str) -> Iterator[Problem]:
    if dimension == 2 and any("z" in axis for axis in axes):
        value = axes if isinstance(axes, str | dict) else list(axes)
        what = "names the z direction"
        yield Problem(key, what, f"{kind} has the directions x, y", value)


def _variant(
    key: str,
    declared: DeclaredShape | DeclaredGeometry,
    known: Sequence[type[DeclaredShape] | type[DeclaredGeometry]],
    dimension: int,
    kind: str,
) -> Iterator[Problem]:
    """What of a shape or geometry does not fit; `known` are all of its sort."""
    if dimension in declared.dimensions:
        yield from below(key, declared.size_problems(dimension))
        return
    fitting = [cls for cls in known if dimension in cls.dimensions]
    choices = ", ".join(f'"{cls.model_fields["type"].default}"' for cls in fitting)
    what = f'does not exist with analysis.kind = "{kind}"'
    yield Problem(f"{key}.type", what, f"choose from {choices}", declared.type)


def _rotation(key: str, boundary: ImplicitBoundary, dimension: int, kind: str) -> Iterator[Problem]:
    rotation = boundary.rotation
    if rotation is None:
        return
    if kind == "axisymmetric":
        what = "a rotation would break the axisymmetry"
        yield Problem(key, what, "leave it out", rotation.model_dump(exclude_none=True))
    elif dimension == 2 and rotation.axis is not None:
        remedy = "leave it out: the boundary rotates in the plane"
        yield Problem(f"{key}.axis", "is for 3D only", remedy, rotation.axis)
    elif dimension == 3 and rotation.axis is None:
        yield Problem(f"{key}.axis", "missing", "give the axis of the rotation by `angle`")


_ABOUT_AXES = ("moment", "rigid_rotation")
"""Quantities whose components are about axes."""


def _moment(key: str, track: Track, dimension: int, kind: str) -> Iterator[Problem]:
    turning = track.quantity == "rigid_rotation"
    if kind == "axisymmetric":
        what = "the reaction has no moment in axisymmetry"
        remedy = 'track the "reaction"'
        if turning:
            what, remedy = "nothing rotates in axisymmetry", 'track the "rigid_displacement"'
        yield Problem(f"{key}.quantity", what, remedy, track.quantity)
    elif dimension == 2 and track.component != "z":
        what = f"{kind} has {'rotations' if turning else 'moments'} about z only"
        yield Problem(f"{key}.component", what, 'give component = "z"', track.component)


def _affine(key: str, boundary: AffineBoundary, dimension: int, kind: str) -> Iterator[Problem]:
    matrix = boundary.deformation_gradient
    if len(matrix) != dimension:
        what = f"is a {len(matrix)} x {len(matrix)} matrix"
        remedy = f'analysis.kind = "{kind}" needs {dimension} x {dimension}'
        yield Problem(key, what, remedy, matrix)
    elif kind == "axisymmetric" and (matrix[0][1] != 0.0 or matrix[1][0] != 0.0):
        what = "couples radius and axis"
        yield Problem(key, what, "give [[F_rr, 0], [0, F_zz]]; the hoop stretch is F_rr", matrix)
    elif kind == "axisymmetric" and matrix[0][0] <= 0.0:
        yield Problem(key, "turns the radius inside out", "give F_rr > 0 and F_zz > 0", matrix)
