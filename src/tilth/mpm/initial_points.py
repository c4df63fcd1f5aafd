# SPDX-License-Identifier: BSD-3-Clause
"""Initial material points of a model."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.bodies import BodyPoints, discretise
from tilth.grid.background import Grid, background_grid
from tilth.model import Model
from tilth.model.isotropic import ParametersAt
from tilth.model.parameter_kinds import Values
from tilth.model.problems import dotted
from tilth.mpm.apart import require_apart
from tilth.mpm.domains import keep_off_axis
from tilth.mpm.initial_motion import initial_motion
from tilth.mpm.initial_stress import Start, declared_start, start_with_stress
from tilth.mpm.initial_water import initial_water
from tilth.mpm.layers import by_layer
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.mpm.pore_water import Permeability, normalised
from tilth.mpm.user_moduli import require_declared_moduli
from tilth.variation.evaluate import parameter_values


def initial_points(model: Model) -> MaterialPoints:
    """Returns the undeformed material points of all bodies of a model, with their initial stress.

    The initial stress is that of the materials before any stage exchanges them. Points of a stage
    with other materials have the parameters that belong to it, but not the stress itself.

    Raises:
        BadInput: a body or a layer without points, a parameter that has no admissible value at a
            point, bodies that would pass through each other, a stress that its law cannot have, or
            a law of the user that cannot be loaded or has other moduli than the declared ones.
    """
    ranges: list[PointRange] = []
    parts: list[BodyPoints] = []
    parameters: dict[int, Floats] = {}
    starts: dict[int, Start] = {}
    declared: list[dict[str, Floats]] = []
    start, overlays, grid = 0, model.overlays(), background_grid(model)
    first = model if model.initial_model is None else model.initial_model
    for number, body in enumerate(model.bodies):
        part = discretise(body, model.analysis.kind, grid)
        part, counts = by_layer(body, part, f"bodies[{number}]")
        declared_starts = None
        if first.present(body.name):  # a body that is placed later begins without stress
            declared_starts = declared_start(first, number, part.position, counts, body.materials)
        begin = 0
        for layer, (name, count) in enumerate(zip(body.materials, counts, strict=True)):
            own = slice(begin, begin + count)
            start_of_layer = None if declared_starts is None else declared_starts[layer]
            values, found = _parameters(model, name, part.position[own], start_of_layer, grid)
            if values.ndim == 2:
                parameters[len(ranges)] = values
            if start_of_layer is not None:
                starts[len(ranges)] = start_of_layer
            declared.append(found)
            material, law = model.materials[name], model.laws[name]
            require_declared_moduli(law, values, dotted(("materials", name)))
            ranges.append(
                PointRange(
                    name=body.name,
                    start=start + begin,
                    stop=start + begin + count,
                    basis=body.basis,
                    domain_update=body.domain_update,
                    law=law,
                    parameters=values if values.ndim == 1 else None,
                    density=material.density or 0.0,
                    wet_density=(
                        material.density if material.watertight else material.saturated_density
                    ),
                    keeps_water=material.keeps_water or material.saturated_density is None,
                    anti_locking=body.anti_locking,
                    body=number,
                    layer=layer,
                    overlay=overlays[body.name],
                    permeability=Permeability(
                        material.permeability or "constant",
                        material.permeability_parameter,
                        normalised(material.conductivity_ratios),
                    ),
                )
            )
            begin += count
        parts.append(part)
        start += begin
    corners = any(range_.has_corners for range_ in ranges)
    points = MaterialPoints.undeformed(
        ranges,
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.volume for part in parts]),
        np.concatenate([part.half_length for part in parts]),
        np.concatenate([part.corners() for part in parts]) if corners else None,
        parameters,
        _at_all_points(ranges, declared, start),
    )
    points.water = initial_water(model, points)
    require_apart(model, points, grid)
    if model.bodies == first.bodies:
        start_with_stress(points, model, starts)
    if model.analysis.has_mass:
        points.motion = initial_motion(points, model)
    if model.analysis.kind == "axisymmetric":
        for point_range in ranges:
            if point_range.convected_by_gradient:
                keep_off_axis(points.part(point_range))
        points.update_bounding_boxes()
    return points


def present_points(model: Model, points: MaterialPoints) -> Flags:
    """Returns which points belong to bodies that are there in the stage of a model, shape (n,)."""
    there = np.array([model.present(body.name) for body in model.bodies])
    return np.asarray(there[points.body_id])


def _parameters(
    model: Model, name: str, position: Floats, start: Start | None, grid: Grid
) -> tuple[Floats, dict[str, Floats]]:
    """Returns the parameters of a material's law at points, and the entries that vary, by key.

    Shape (m,) or (n, m) of the former, (n,) of the latter.
    """
    material = model.materials[name]
    stress = None if start is None else start.stress
    varying = parameter_values(material, position, dotted(("materials", name)), stress)
    entries = {key: getattr(material, key) for key in type(material).model_fields} | varying
    if start is not None:
        entries |= start.parameters
    at = ParametersAt(entries.__getitem__, _cell_length(grid, position))
    return material.parameter_array(at, len(position)), varying


def _cell_length(grid: Grid, position: Floats) -> Values:
    """Returns the cell length of `ParametersAt`; shape (n,) where cells are of different sizes."""
    if grid.graded:
        return np.asarray(grid.sizes_at(position).prod(axis=1) ** (1.0 / grid.dim))
    return float(float(np.prod(grid.cell_size)) ** (1.0 / grid.dim))


def _at_all_points(
    ranges: list[PointRange], declared: list[dict[str, Floats]], points: int
) -> Mapping[str, Floats]:
    """Returns the entries of all ranges that vary, by key, shape (points,)."""
    keys = dict.fromkeys(key for found in declared for key in found)
    arrays = {key: np.full(points, np.nan) for key in keys}
    for range_, found in zip(ranges, declared, strict=True):
        for key, values in found.items():
            arrays[key][range_.start : range_.stop] = values
    return arrays
