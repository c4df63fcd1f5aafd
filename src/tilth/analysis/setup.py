# SPDX-License-Identifier: BSD-3-Clause
"""The data for the picture of the set-up, and the report of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tilth.analysis.recorder import snapshot, units_of
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats, Integers
from tilth.boundaries import Boundary
from tilth.boundaries.implicit.boundary import Implicit
from tilth.model import AffineBoundary, BodyForce, ImplicitBoundary, Model, PointForce, SeismicLoad
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.water import PhreaticSurface
from tilth.output.folder import SETUP, load_model
from tilth.report.fields import parameter_fields
from tilth.report.setup_data import Condition, Load, Setup, Surface
from tilth.surface.loads import SurfaceLoads, declared_loads

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def write_report(folder: Path) -> Path:
    """Writes report.html into the folder of a run, finished or not; returns its path.

    No function of the user is run. For a folder of a version of tilth that did not store the
    set-up, its picture is computed from the model, and left out if that would run such a function.

    Raises:
        BadInput: `folder` is not that of a run.
    """
    from tilth.report.html import write_report as write

    model = load_model(folder)
    stored = (folder / SETUP).exists()
    return write(
        folder, model.to_dict(), setup=None if stored or model.functions else setup_of(model)
    )


def setup_of(model: Model) -> Setup:
    """Returns the data for the picture of a model's set-up; runs the functions that it names.

    Raises:
        BadInput: the model cannot be computed (see `Simulation.check`).
    """
    simulation = Simulation(model)
    return initial_setup(simulation, simulation.check(), model.of_stages)


def setup_figures(model: Model) -> tuple[Setup, dict[str, Figure]]:
    """Returns the set-up of a model and its figures by name.

    They are "" for the picture of the set-up, and the name of each parameter that varies from place
    to place and of the layers. Runs the functions that the model names.

    Raises:
        BadInput: the model cannot be computed (see `Simulation.check`).
    """
    from tilth.report.field_plots import draw_frames
    from tilth.report.setup import draw_setup

    simulation = Simulation(model)
    active = simulation.check()
    setup = initial_setup(simulation, active, model.of_stages)
    start = snapshot(simulation, active, None, 0, 0.0)
    units = units_of(model)
    axisymmetric = model.analysis.kind == "axisymmetric"
    return setup, {"": draw_setup(setup)} | {
        name: draw_frames([start], name, units, axisymmetric=axisymmetric)
        for name in parameter_fields(start)
    }


def initial_setup(
    simulation: Simulation, active: ActiveGrid, models: Sequence[Model] = ()
) -> Setup:
    """Returns the data for the picture of the set-up of a simulation before its first step.

    `active` is the grid of that step, `models` are those of all stages if there are several.
    """
    model, points = simulation.model, simulation.points
    water = _water(simulation, models or [model])
    return Setup(
        title=model.title,
        dim=model.dimension,
        length_unit=model.units.length,
        position=points.position,
        half_lengths=points.half_length,
        corners=points.all_corners(),
        body_id=points.body_id,
        body_names=[body.name for body in model.bodies],
        cell_size=simulation.grid.cell_size,
        origin=simulation.grid.origin,
        conditions=[_condition(simulation, boundary, active) for boundary in simulation.boundaries],
        surfaces=[_surface(simulation, boundary) for boundary in simulation.implicit],
        tracked=simulation.surface_shapes(),
        loads=[*_loads(simulation), *_surface_loads(simulation, active)],
        body_force=_body_force(model),
        force_unit=model.units.force,
        kind=model.analysis.kind,
        warnings=tuple(simulation.warnings),
        water_times=water[0],
        water=water[1],
    )


def _water(simulation: Simulation, models: Sequence[Model]) -> tuple[Floats, Floats]:
    """The surface of the water in the plane: times, (m,), and vertices beyond all soil, (m, k, 2).

    At the start and the end of each stage; not a number in stages without water.
    """
    position = simulation.points.position
    surfaces = [(model, PhreaticSurface.of(model)) for model in models]
    if position.shape[1] == 3 or not any(surface for _, surface in surfaces):
        return np.zeros(0), np.zeros((0, 0, 2))
    wide = 10.0 * float(np.ptp(position, axis=0).max())
    vertices = {float(position[:, 0].min()) - wide, float(position[:, 0].max()) + wide}
    vertices |= {x for _, surface in surfaces if surface for x in surface.vertices}
    places = np.column_stack([sorted(vertices), np.zeros(len(vertices))])
    times, lines = [], []
    for model, surface in surfaces:
        for time in (0.0, model.schedule.end):
            times.append(model.stage.start + time)
            height = np.full(len(places), np.nan)
            if surface is not None:
                height = surface.level(places, time)
            lines.append(np.column_stack([places[:, 0], height]))
    return np.array(times), np.stack(lines)


FLAT_FACETS = 12
"""Facets of a plane over the longest side of the soil, about."""


def _surface(simulation: Simulation, boundary: Implicit) -> Surface:
    points, cell = simulation.points, simulation.grid.cell_size
    lower, upper = points.position.min(axis=0) - 2 * cell, points.position.max(axis=0) + 2 * cell
    size = float(cell.max())
    if boundary.geometry.flat:
        size = max(size, float((upper - lower).max()) / FLAT_FACETS)
    facets = boundary.geometry.facets(lower, upper, size)
    centre = facets.corner.mean(axis=1)
    end = boundary.motion.position(centre, boundary.factor(simulation.model.schedule.end)) - centre
    return Surface(
        name=boundary.name,
        kind=boundary.declared.condition,
        corner=facets.corner,
        normal=facets.normal,
        displacement=end if boundary.declared.is_moving else None,
        bounded=boundary.geometry.bounded,
    )


def _condition(simulation: Simulation, boundary: Boundary, active: ActiveGrid) -> Condition:
    declared = next(b for b in simulation.model.boundaries if b.name == boundary.name)
    assert not isinstance(declared, ImplicitBoundary)
    prescribed = boundary.prescribe(active, 0.0, simulation.model.schedule.end)
    nodes = prescribed.constrained.any(axis=1)
    moving = bool(prescribed.increment.any())
    return Condition(
        name=boundary.name,
        kind="affine" if isinstance(declared, AffineBoundary) else declared.condition,
        position=active.position[nodes],
        constrained=prescribed.constrained[nodes],
        displacement=prescribed.increment[nodes] if moving else None,
    )


ARROWS = 40
"""Arrows of a load on a surface, about."""


def _surface_loads(simulation: Simulation, active: ActiveGrid) -> list[Load]:
    """The loads on surfaces at the end of the schedule, on the initial surface."""
    model = simulation.model
    end = model.schedule.end
    loads = SurfaceLoads(
        declared_loads(model), model.analysis.kind, simulation.surfaces, active, end, end
    )
    found = []
    for declared, place, force in loads.at_points(np.zeros((active.nodes, model.dimension))):
        group = _groups(np.linalg.norm(force, axis=1))
        count = np.bincount(group)[:, None]
        position, total = (
            np.stack([np.bincount(group, column) for column in of_points.T], axis=1, dtype=float)
            for of_points in (place, force)
        )
        found.append(
            Load(
                name=declared.name or f"load on the surface of {declared.body}",
                position=position / count,
                force=total,
            )
        )
    return found


def _groups(size: Floats) -> Integers:
    """Returns the arrow of each point of a load, (n,): groups of neighbours of about equal forces.

    size: magnitudes of the points' forces [force], shape (n,).
    """
    if not size.any():
        size = np.ones_like(size)
    share = (np.cumsum(size) - 0.5 * size) / size.sum()
    group = np.floor(share * min(ARROWS, len(size))).astype(np.int64)
    return np.asarray(np.unique(group, return_inverse=True)[1])


def _loads(simulation: Simulation) -> list[Load]:
    """Point forces and line forces at the end of the schedule, where they act at the start."""
    loads = []
    for each in simulation.loads.on_points:
        declared, end = each.load, simulation.model.schedule.end
        what = "point force" if isinstance(declared, PointForce) else "line force"
        force = np.array(declared.force) * each.curve.factor(end)
        group = _groups(each.weight)
        first = np.unique(group, return_index=True)[1]
        weight = np.bincount(group, each.weight)
        loads.append(
            Load(
                name=declared.name or f"{what} on {declared.body}",
                position=each.place[first],
                force=np.outer(weight, force),
            )
        )
    return loads


def _body_force(model: Model) -> Floats | None:
    """Returns all forces per mass at factor 1 [acceleration], shape (dim,); None without any."""
    acting = [load for _, load in model.acting_loads()]
    gravity = [np.array(load.acceleration) for load in acting if isinstance(load, BodyForce)]
    if not gravity:
        return None
    total = np.sum(gravity, axis=0)
    magnitude = np.linalg.norm(total)
    seismic = [
        magnitude * np.array(load.coefficient) for load in acting if isinstance(load, SeismicLoad)
    ]
    return np.asarray(np.sum([total, *seismic], axis=0))
