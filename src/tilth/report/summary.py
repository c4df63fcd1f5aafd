# SPDX-License-Identifier: BSD-3-Clause
"""Summary of a case that `tilth check` prints."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from tilth.available_memory import AvailableMemory
from tilth.memory_estimate import MemoryEstimate
from tilth.model import (
    AffineBoundary,
    Body,
    BodyForce,
    ImplicitBoundary,
    LineForce,
    Model,
    PlaneBoundary,
    Region,
    SeismicLoad,
    SurfaceLoad,
    TerrainGeometry,
    Track,
    Water,
)
from tilth.model.boundaries import Boundary
from tilth.model.fields import AXES
from tilth.model.geometry import Geometry
from tilth.model.loads import Load
from tilth.model.materials import Material
from tilth.model.parameter_kinds import KINDS
from tilth.model.schedule import Schedule
from tilth.report.amounts import amount, cells_text, elevation, shape_text, vector
from tilth.report.contact_texts import body_text, laws_text, pair_text
from tilth.report.flow_texts import flow_texts
from tilth.report.initial import equilibrium_before, initial_stress
from tilth.report.setup import Setup
from tilth.report.stage_texts import stage_rows


def print_summary(
    model: Model,
    setup: Setup,
    estimate: MemoryEstimate,
    available: AvailableMemory | None,
    console: Console | None = None,
    time: str = "",
    consolidation: Sequence[str] = (),
) -> None:
    """Prints bodies, points, cells, memory, materials, conditions, loads and steps of `model`.

    Args:
        model: the declared problem.
        setup: its material points before the first step.
        estimate: of the memory of its run.
        available: memory on this machine; None if it is not known.
        console: where it is printed; the standard output if None.
        time: what is known of the time of its run; nothing is printed of it if empty.
        consolidation: what is known of the time that the soil takes to consolidate.
    """
    console = console or Console(highlight=False)
    table = Table(show_header=False, box=None, padding=(0, 2, 0, 0), title_justify="left")
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    section = ""
    for heading, text in _rows(model, setup, estimate, available, time, consolidation):
        table.add_row("" if heading == section else heading, Text(text))
        section = heading
    console.print(table)


def _rows(
    model: Model,
    setup: Setup,
    estimate: MemoryEstimate,
    available: AvailableMemory | None,
    time: str,
    consolidation: Sequence[str],
) -> Iterator[tuple[str, str]]:
    unit = model.units
    if model.title:
        yield "title", model.title
    yield "analysis", model.analysis.kind.replace("_", " ")
    limits = "unbounded" if model.grid.limits is None else "limited"
    sizes = zip(model.cell_size, model.largest_cell, strict=True)
    yield "grid", f"{limits}, {cells_text(sizes, unit.length)}"
    for i, body in enumerate(model.bodies):
        yield "bodies", _body(body, int(np.count_nonzero(setup.body_id == i)))
    yield "points", f"{len(setup.position)} in {setup.occupied_cells()} cells"
    yield "unknowns", f"about {estimate.unknowns:,.0f}, linear solver {estimate.solver}"
    yield "memory", str(estimate)
    yield "memory", f"available: {'not known' if available is None else available}"
    if time:
        yield "time", time
    for name, material in model.materials.items():
        yield "materials", _material(name, material, model)
    for entry in model.initial.stress:
        yield "at the start", initial_stress(entry, model)
    if model.initial.stress:
        yield "at the start", equilibrium_before(model)
    if model.water is not None:
        yield "water", _water(model.water, model)
    for text in (*flow_texts(model), *consolidation):
        yield "flow", text
    for boundary in model.boundaries:
        yield "boundaries", _boundary(boundary, model)
    for rigid in model.rigid_bodies:
        shapes = " and ".join(_geometry(shape) for shape in rigid.shapes)
        yield "rigid bodies", body_text(rigid, shapes, model)
    for pair in model.contact_pairs:
        yield "contact", pair_text(pair, model.units.stress)
    for load in model.loads:
        yield "loads", _load(load, model)
    if weights := _unit_weights(model):
        yield "unit weights", weights
    if model.stages:
        yield from stage_rows(model)
    else:
        yield "schedule", _schedule(model.schedule)
    for track in model.track:
        yield "tracked", _track(track)


def _schedule(schedule: Schedule) -> str:
    adaptive = "adaptive" if schedule.adaptive else "of fixed size"
    return (
        f"{schedule.number_of_steps} steps to time {schedule.end:g}, {adaptive}; "
        f"{len(schedule.times_of_output())} outputs"
    )


def _body(body: Body, points: int) -> str:
    update = f", domains by {body.domain_update}" if body.domain_update else ""
    return (
        f"{body.name}: {shape_text(body.shape)} of {', '.join(body.materials)}, {points} points, "
        f"{body.basis} basis{update}"
    )


def _material(name: str, material: Material, model: Model) -> str:
    units = {
        "-": "",
        "degrees": " degrees",
        "length": f" {model.units.length}",
        "length / time": f" {model.units.length}/{model.units.time}",
        "stress": f" {model.units.stress}",
        "mass / length^3": f" {model.units.mass}/{model.units.length}^3",
    }

    def text(key: str, value: Any) -> str:
        name = key.replace("_", " ")
        if key == "state_variables":
            return f"{len(value)} {name}"
        if isinstance(value, dict):
            return ", ".join(f"{each} {number:g}" for each, number in value.items())
        if isinstance(value, tuple):
            return f"{name} {[*value]}"
        if isinstance(value, str):
            return f"{name} {value}"
        if isinstance(value, bool):
            return name
        return f"{name} {amount(value)}{units[KINDS[material.kinds[key]].unit]}"

    fields = type(material).model_fields
    given = material.model_dump(exclude={"model"}, exclude_none=True)
    keys = [key for key, value in given.items() if value is not False]
    parts = [text(fields[key].alias or key, getattr(material, key)) for key in keys]
    return f"{name}: {material.model}, {', '.join(parts)}"


def _unit_weights(model: Model) -> str:
    """Returns the unit weight of each material under gravity, which shows a mass in wrong units.

    Empty unless exactly one body force is declared.
    """
    forces = [load for load in model.loads if isinstance(load, BodyForce)]
    if len(forces) != 1 or not (gravity := math.hypot(*forces[0].acceleration)):
        return ""
    unit = f"{model.units.force}/{model.units.length}^3"
    weights = []
    for name, material in model.materials.items():
        saturated = getattr(material, "saturated_density", None)
        for density, words in ((material.density, ""), (saturated, " saturated")):
            if density:
                weights.append(f"{name} {density * gravity:.4g} {unit}{words}")
    return ", ".join(weights)


def _water(water: Water, model: Model) -> str:
    length, unit = model.units.length, f"{water.unit_weight:g} {model.units.force}"
    start = ""
    if water.initial_level is not None:
        start = f"from {elevation(water.initial_level, length)} to "
    return f"level {start}{elevation(water.level, length)}, unit weight {unit}/{length}^3"


def _boundary(boundary: Boundary, model: Model) -> str:
    if isinstance(boundary, AffineBoundary):
        rows = "; ".join(vector(row) for row in boundary.deformation_gradient)
        moved = f"{boundary.path} path, {boundary.nodes} nodes"
        return f"{boundary.name}: affine motion to F = [{rows}], {moved}"
    if isinstance(boundary, ImplicitBoundary):
        return _implicit(boundary, model)
    if isinstance(boundary, PlaneBoundary):
        where = f"on {boundary.axis} = {boundary.at:g}"
        for axis, (least, greatest) in (boundary.range or {}).items():
            where += f", {least:g} <= {axis} <= {greatest:g}"
        if boundary.solid_side is not None:
            where += f", {boundary.solid_side} side solid"
    else:
        where = f"at the node {vector(boundary.at)}"
    constrained = ", ".join(
        f"u{AXES[i]} = {value:g}" for i, value in boundary.prescribed(model.dimension).items()
    )
    if isinstance(boundary, PlaneBoundary) and boundary.condition in ("base_motion", "absorbing"):
        constrained = _waves(boundary)
    return f"{boundary.name}: {boundary.condition} {where}: {constrained}"


def _waves(boundary: PlaneBoundary | ImplicitBoundary) -> str:
    """Returns the ground beyond an absorbing boundary, and the record that moves it or a base."""
    words = []
    if (record := boundary.acceleration) is not None:
        scale = "" if record.scale == 1.0 else f", times {record.scale:g}"
        words.append(f"acceleration of {Path(record.file).name}{scale}")
    if (ground := boundary.ground) is not None:
        speeds = f"{ground.p_wave_speed:g} and {ground.s_wave_speed:g}"
        words.append(f"ground of density {ground.density:g}, wave speeds {speeds}")
    elif boundary.condition == "absorbing":
        words.append("ground as the soil there")
    return "; ".join(words)


def _implicit(boundary: ImplicitBoundary, model: Model) -> str:
    unit = model.units.length
    constrained: str = boundary.kind
    if boundary.contact is not None:
        laws = laws_text(boundary.contact, boundary.contact_with, model.units.stress)
        constrained = "; ".join(laws)
    if boundary.condition == "absorbing":
        constrained = f"absorbing ({_waves(boundary)})"
    if boundary.direction is not None:
        constrained = f"constrained along {vector(boundary.direction)}"
    parts = [
        f"implicit, {constrained} on a {_geometry(boundary.geometry)}",
        f"{boundary.form} form, delta = {model.delta(boundary):g} {unit}",
    ]
    if boundary.radius_change is not None:
        parts.append(f"radius changes by {boundary.radius_change:g} {unit}")
    if boundary.volume_loss is not None:
        parts.append(f"loses {100.0 * boundary.volume_loss:g} % of its volume")
    if (rotation := boundary.rotation) is not None:
        axis = "" if rotation.axis is None else f"the axis {rotation.axis} through "
        parts.append(f"turns by {rotation.angle:g} degrees about {axis}{vector(rotation.centre)}")
    for axis, value in (boundary.displacement or {}).items():
        parts.append(f"u{axis} = {value:g} {unit}")
    if boundary.motion is not None:
        parts.append(f"moves by {Path(boundary.motion).name}")
    if boundary.is_moving and not model.stages:
        parts.append(f"factor {model.load_curve(boundary).factor(model.schedule.end):g} at the end")
    return f"{boundary.name}: {', '.join(parts)}"


def _geometry(geometry: Geometry) -> str:
    """Returns the geometry's type and its entries, in the order of declaration."""
    words = []
    for key, value in geometry.model_dump(exclude={"type"}, exclude_defaults=True).items():
        if key == "vertices":
            words.append(f"{len(value)} vertices")
        elif isinstance(geometry, TerrainGeometry) and key == "surface":
            words.append(elevation(geometry.surface, ""))
        elif isinstance(value, tuple) and not isinstance(value[0], str):
            words.append(f"{key} {vector(value)}")
        elif isinstance(value, tuple):
            words.append(f"{key} {' '.join(value)}")
        elif isinstance(value, float):
            words.append(f"{key} {value:g}")
        elif value is True:
            words.append(key)
        elif key in ("file", "function"):
            words.append(Path(value).name)
        else:
            words.append(f"{key} {value}")
    return f"{geometry.type} ({', '.join(words)})"


def _load(load: Load, model: Model) -> str:
    name = f"{load.name}: " if load.name else ""
    return name + _declared_load(load, model)


def _declared_load(load: Load, model: Model) -> str:
    end = f"factor {model.load_curve(load).factor(model.schedule.end):g} at the end"
    if model.stages:
        end = "factor by stage"
    if isinstance(load, BodyForce):
        return f"body force, acceleration {vector(load.acceleration)}, {end}"
    if isinstance(load, SurfaceLoad):
        return f"{_surface_load(load, model)}, {end}"
    if isinstance(load, SeismicLoad):
        return f"seismic, coefficients {vector(load.coefficient)} of the body force, {end}"
    force = f"{vector(load.force)} {model.units.force}"
    if isinstance(load, LineForce):
        ends = f"from {vector(load.start)} to {vector(load.end)}"
        per_length = f"{force}/{model.units.length}" if model.units.force else f"{force} per length"
        return f"line force {per_length} on {load.body} {ends}, {end}"
    return f"point force {force} on {load.body} at {vector(load.at)}, {end}"


def _surface_load(load: SurfaceLoad, model: Model) -> str:
    stress, parts = model.units.stress, []
    for key in ("pressure", "shear"):
        if value := getattr(load, key):
            parts.append(f"{key} {value:g} {stress}")
    if load.hydrostatic is not None:
        parts.append(f"water of unit weight {load.hydrostatic.unit_weight:g}")
    if load.pressure_along is not None:
        parts.append("pressure along the arc length")
    if load.traction is not None:
        parts.append(f"traction {vector(load.traction)} {stress}")
    parts = parts or [f"pressure 0 {stress}"]
    where = f" from {vector(load.start)} to {vector(load.end or ())}" if load.start else ""
    where = f" ({load.part})" if load.part else where
    if load.within is not None:
        where += f" within {_region(load.within)}"
    how = "" if load.follower else ", dead"
    return f"{', '.join(parts)} on the surface of {load.body}{where}{how}"


def _region(region: Region) -> str:
    if region.vertices is not None:
        return f"a polygon of {len(region.vertices)} vertices"
    if region.centre is not None:
        return f"the circle of radius {region.radius:g} around {vector(region.centre)}"
    return f"the rectangle from {vector(region.lower or ())} to {vector(region.upper or ())}"


def _track(track: Track) -> str:
    what = " ".join(filter(None, (track.kind, track.quantity, track.component, track.axis)))
    where = f" of {track.boundary or track.of}" if track.boundary or track.of else ""
    if track.share is not None:
        where += f", {100.0 * track.share:g} % of the volume"
    position = f" at {vector(track.at)}" if track.at else ""
    if track.from_:
        position = f" below the {track.from_} surface"
    if track.about:
        position = f" about {vector(track.about)}"
    return f"{track.name}: {what.replace('_', ' ')}{where}{position}"
