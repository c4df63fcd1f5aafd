# SPDX-License-Identifier: BSD-3-Clause
"""Checks of the first load step that need points, grid and boundaries together."""

from __future__ import annotations

from tilth.analysis.model_warnings import warnings_of
from tilth.analysis.prepare import prepare
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.boundaries.contact.checks import require_outside, require_soil_in_reach
from tilth.boundaries.contact.thin import require_thin_shapes_held
from tilth.boundaries.step.axis_consistency import require_no_radial_motion
from tilth.boundaries.step.conditions import require_no_rigid_motion
from tilth.boundaries.step.consistency import require_consistency, table_times
from tilth.errors import BadInput, StepFailed
from tilth.model.staging import StageOfModel
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.wet_mass import require_wet_densities
from tilth.surface.make import require_near_soil


def check_first_step(
    setup: Setup, state: State, services: Services, in_advance: bool = False
) -> ActiveGrid:
    """Checks the conditions of the first step, and notes warnings of the model; returns its grid.

    in_advance: whether it is that of a later stage, with soil that has not moved yet. Where rigid
        bodies are in the soil is then left to the check at the start of the stage.

    Raises:
        BadInput: contradicting conditions, a rigid-body motion that none of them prevents, a
            boundary or a surface without soil, a thin shape in soil that is to part from it.
    """
    model = setup.model
    require_wet_densities(model, state.points)
    if not in_advance:
        _require_outside(model.stage, state)
    first = model.schedule.regular_time(1)
    try:
        step = prepare(setup, state, services, 0.0, first)
    except StepFailed as failure:
        raise BadInput(
            f"{failure.reason} before the first step (point {failure.point})",
            "move the body, or widen grid.limits",
            key="bodies",
        ) from failure
    if not in_advance:
        contacts = step.constraints.contacts
        require_soil_in_reach(state.bodies, contacts, first, model.rigid_body_keys())
    begins = model.stage.begins
    require_thin_shapes_held(state.contact_surfaces, begins, state.points, state.grid)
    for boundary in state.implicit:
        boundary.require_soil(state.points.position)
    if state.pore_pressure is not None and not in_advance:
        state.pore_pressure.require_soil(state.points, step.active)
    times = [*table_times(model), *state.waves.peak_times(model.schedule.end)]
    require_consistency(state.boundaries, step.constraints, times, model.boundary_keys())
    require_no_radial_motion(state.axis, state.boundaries, state.implicit, step.active, times)
    if state.dynamics is None:
        require_no_rigid_motion(
            step.active, setup.kind, step.conditions.constrained, step.constraints
        )
    require_near_soil(model, state.surfaces, step.active)
    for key, text in warnings_of(setup, state, services, in_advance):
        services.warnings.note(key, text)
    return step.active


def _require_outside(stage: StageOfModel, state: State) -> None:
    """Checks that no soil is inside a rigid body that begins with this stage."""
    surfaces = [
        surface
        for surface in state.contact_surfaces
        if surface.body is not None and stage.begins(surface.body.name)
    ]
    require_outside(surfaces, state.points, has_moved=stage.number > 0)
