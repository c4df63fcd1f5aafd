# SPDX-License-Identifier: BSD-3-Clause
"""A step before its forces: the points on the grid, and what conditions act."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import PreparedStep
from tilth.boundaries import Conditions, ImplicitConstraints
from tilth.boundaries.contact.gather import TouchingSoil
from tilth.boundaries.step.constraints import FoundSoil
from tilth.comm import together
from tilth.mpm import active_grid
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import bound_domains
from tilth.mpm.interval import INSTANT, Interval
from tilth.mpm.shear_strength import shear_strength
from tilth.mpm.soil import Soil


def locate(setup: Setup, state: State, services: Services, time: float) -> ActiveGrid:
    """Locates the points on the grid of the step that begins at `time`; returns it.

    Raises:
        StepFailed: a point is outside the grid, or its domain extends over too many cells.
    """
    state.grid = setup.grid_motion.at(time)
    if state.grid.graded and setup.grid_motion.follows:  # smaller cells come to the points
        services.warnings.bounds(bound_domains(state.points, state.grid))
    state.points = state.distribution.arranged(state.points, state.grid)
    with together(state.comm):
        overlays = state.distribution.overlays
        active = active_grid.locate(state.points, state.grid, services.buffers, overlays)
    return state.distribution.located(active)


def soil_on(
    active: ActiveGrid,
    setup: Setup,
    state: State,
    services: Services,
    interval: Interval = INSTANT,
) -> Soil:
    """Returns the soil on the grid of a step that takes this time."""
    own = state.distribution.own
    return Soil(state.points, active, setup.kind, services.timers, own, interval)


def prepare(
    setup: Setup, state: State, services: Services, before: float, after: float
) -> PreparedStep:
    """Locates the points and finds the conditions of the step from `before` to `after`.

    Raises:
        StepFailed: a point is outside the grid, or its domain extends over too many cells.
        BadInput: a boundary prescribes a radial displacement on the axis of symmetry.
    """
    model, timers = setup.model, services.timers
    with timers.measure("basis"):
        active = locate(setup, state, services, before)
    time_step = state.time_step(before, after)
    for body in state.bodies:
        body.begin(after, time_step)
    implicit = state.implicit + (state.waves.surfaces() if time_step is None else [])
    touching = TouchingSoil(state.surfaces, partial(shear_strength, model=model))
    with timers.measure("boundaries"):
        near = FoundSoil.find(implicit, state.points, active, before, touching, state.body_contacts)
        absorbing = state.waves.near(state.points, active, before) if time_step else []
        active = active.with_nodes(near.nodes(active, absorbing))
    with together(state.comm):
        declared = Conditions.gather(state.boundaries, active, before, after)
    on_axis = state.axis.constrain(active, declared, state.implicit, before)
    on_axis = replace(on_axis, conditions=on_axis.conditions.of_owners(active))
    with timers.measure("boundaries"):
        constraints = ImplicitConstraints.gather(
            implicit, state.points, active, setup.kind, before, after,
            on_axis.conditions.constrained, near,
        )  # fmt: skip
    services.warnings.places(
        state.boundaries, on_axis.conditions, constraints, model.boundary_keys(), before
    )
    return PreparedStep(before, after, active, on_axis, constraints, absorbing)
