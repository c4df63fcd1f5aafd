# SPDX-License-Identifier: BSD-3-Clause
"""The data for the picture of the set-up, and the report of a run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tilth.analysis.recorder import snapshot, units_of
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries import Boundary
from tilth.boundaries.implicit.boundary import Implicit
from tilth.model import AffineBoundary, BodyForce, ImplicitBoundary, Model, PointForce
from tilth.mpm.grid import ActiveGrid
from tilth.output.folder import SETUP, load_model
from tilth.report.fields import parameter_fields
from tilth.report.setup_data import Condition, Load, Setup, Surface
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.terms.loads import Loads

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
    return initial_setup(simulation, simulation.check())


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
    setup = initial_setup(simulation, active)
    start = snapshot(simulation, active, None, 0, 0.0)
    units = units_of(model)
    axisymmetric = model.analysis.kind == "axisymmetric"
    return setup, {"": draw_setup(setup)} | {
        name: draw_frames([start], name, units, axisymmetric=axisymmetric)
        for name in parameter_fields(start)
    }


def initial_setup(simulation: Simulation, active: ActiveGrid) -> Setup:
    """Returns the data for the picture of the set-up of a simulation before its first step.

    `active` is the grid of that step.
    """
    model, points = simulation.model, simulation.points
    gravity = [
        np.array(load.acceleration)
        for _, load in model.acting_loads()
        if isinstance(load, BodyForce)
    ]
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
        loads=[*_loads(model, simulation), *_surface_loads(simulation, active)],
        body_force=sum(gravity) if gravity else None,  # type: ignore[arg-type]
        force_unit=model.units.force,
        kind=model.analysis.kind,
        warnings=tuple(simulation.warnings),
        water=_water(simulation),
        end=model.schedule.end,
    )


def _water(simulation: Simulation) -> Floats | None:
    """The surface of the water in the plane at the start and at the end, beyond all soil."""
    water, x = simulation.water, simulation.points.position[:, 0]
    if water is None or simulation.model.dimension != 2:
        return None
    wide = 10.0 * float(np.ptp(simulation.points.position, axis=0).max())
    times = (0.0, simulation.model.schedule.end)
    return np.stack([water.line(time, x.min() - wide, x.max() + wide) for time in times])


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
        group = np.arange(len(place)) * min(ARROWS, len(place)) // len(place)
        count = np.bincount(group)[:, None]
        position, total = (
            np.stack([np.bincount(group, column) for column in of_points.T], axis=1, dtype=float)
            for of_points in (place, force)
        )
        found.append(
            Load(
                name=f"load on the surface of {declared.body}",
                position=position / count,
                force=total,
            )
        )
    return found


def _loads(model: Model, simulation: Simulation) -> list[Load]:
    points = simulation.points
    loads = []
    for declared, ids, curve in Loads(model, points).on_points:
        assert isinstance(declared, PointForce)
        position = points.position[points.index_of(ids)]
        force = np.array(declared.force) * curve.factor(model.schedule.end)
        loads.append(
            Load(
                name=f"point force on {declared.body}",
                position=position,
                force=np.tile(force / len(ids), (len(ids), 1)),
            )
        )
    return loads
