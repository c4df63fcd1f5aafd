# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the first load step that need points, grid and boundaries together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tilth.analysis.model_warnings import warnings_of
from tilth.boundaries.contact.checks import require_outside, require_soil_in_reach
from tilth.boundaries.contact.thin import require_thin_shapes_held
from tilth.boundaries.step.axis_consistency import require_no_radial_motion
from tilth.boundaries.step.conditions import require_no_rigid_motion
from tilth.boundaries.step.consistency import require_consistency, table_times
from tilth.errors import BadInput, StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.wet_mass import require_wet_densities
from tilth.surface.make import require_near_soil

if TYPE_CHECKING:
    from tilth.analysis.simulation import Simulation


def check_first_step(simulation: Simulation, in_advance: bool = False) -> ActiveGrid:
    """Checks the conditions of the first step, and notes warnings of the model; returns its grid.

    in_advance: whether it is that of a later stage, with soil that has not moved yet. Where rigid
        bodies are in the soil is then left to the check at the start of the stage.

    Raises:
        BadInput: contradicting conditions, a rigid-body motion that none of them prevents, a
            boundary or a surface without soil, a thin shape in soil that is to part from it.
    """
    model = simulation.model
    require_wet_densities(model, simulation.points)
    if not in_advance:
        _require_outside(simulation)
    first = model.schedule.regular_time(1)
    try:
        step = simulation.prepare(0.0, first)
    except StepFailed as failure:
        raise BadInput(
            f"{failure.reason} before the first step (point {failure.point})",
            "move the body, or widen grid.limits",
            key="bodies",
        ) from failure
    if not in_advance:
        contacts = step.constraints.contacts
        require_soil_in_reach(simulation.bodies, contacts, first, model.rigid_body_keys())
    begins = model.stage.begins
    require_thin_shapes_held(
        simulation.contact_surfaces, begins, simulation.points, simulation.grid
    )
    for boundary in simulation.implicit:
        boundary.require_soil(simulation.points.position)
    times = [*table_times(model), *simulation.waves.peak_times(model.schedule.end)]
    require_consistency(simulation.boundaries, step.constraints, times, model.boundary_keys())
    require_no_radial_motion(
        simulation.axis, simulation.boundaries, simulation.implicit, step.active, times
    )
    if simulation.dynamics is None:
        require_no_rigid_motion(
            step.active, simulation.kind, step.conditions.constrained, step.constraints
        )
    require_near_soil(model, simulation.surfaces, step.active)
    for key, text in warnings_of(simulation, in_advance):
        simulation.services.warnings.note(key, text)
    return step.active


def _require_outside(simulation: Simulation) -> None:
    """Checks that no soil is inside a rigid body that begins with this stage."""
    stage = simulation.model.stage
    surfaces = [
        surface
        for surface in simulation.contact_surfaces
        if surface.body is not None and stage.begins(surface.body.name)
    ]
    require_outside(surfaces, simulation.points, has_moved=stage.number > 0)
