# SPDX-License-Identifier: BSD-3-Clause
"""A load step from the preparation to the commitment, and the accelerations before the first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from tilth.analysis.acceptance import move_surfaces, require_acceptable, warn
from tilth.analysis.attempts import solve
from tilth.analysis.prepare import prepare, soil_on
from tilth.analysis.services import Services
from tilth.analysis.setup import InStep, Setup
from tilth.analysis.state import State
from tilth.analysis.step_result import StepResult, result_of
from tilth.analysis.step_terms import balance_of, terms_of
from tilth.errors import StepFailed
from tilth.mpm.interval import Interval
from tilth.terms.drag import Drag


def advance(
    setup: Setup,
    state: State,
    services: Services,
    before: float,
    after: float,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
    is_least: bool = False,
    is_short: bool = False,
) -> StepResult:
    """Takes the step from time `before` to `after`; changes the state only if it converges.

    is_least: whether the step cannot be shortened. Soil that passes through a boundary then
        only gives a warning.
    is_short: whether it was shortened so much that its failure is not put down to its size.
        Where Newton's method finds no equilibrium the soil then creeps to it, if there is one;
        soil with friction that boundaries or bodies drive creeps in steps of any size.

    Raises:
        StepFailed: no equilibrium, an inverted point, a point that left the grid, soil that
            passes through an implicit boundary.
    """
    timers = services.timers
    begin_motion(setup, state, services, before, after - before)
    step = prepare(setup, state, services, before, after)
    interval = Interval(before, setup.model.stage.start + before, after - before)
    soil = soil_on(step.active, setup, state, services, interval)
    of = InStep(setup, state, step, soil)
    terms, drag = terms_of(of, timers), None
    creeps = is_short or (setup.has_friction and step.driven > 0.0)
    if creeps and state.dynamics is None and state.relaxation is None:
        drag = Drag.of(soil)
        terms.insert(-1, drag)
    with timers.measure("basis"):  # for this includes the matrix's pattern
        balance = balance_of(of, terms)
    services.observer.prepared(soil, balance)
    equilibrium = solve(setup, state, services, step, soil, balance, on_iteration, drag)
    displacement = equilibrium.displacement
    moved = soil.interpolate(displacement)
    try:
        checked, possible = require_acceptable(
            state, timers, step, balance, equilibrium.x, moved, is_least
        )
    except StepFailed as failure:
        failure.residuals = equilibrium.residuals
        raise
    move_surfaces(state, services.warnings, balance.active, displacement, moved)
    with timers.measure("boundaries"):
        result = result_of(step, balance, equilibrium, state.kept_contact, state.kept_ghost)
    if state.pore_pressure is not None:
        result = state.pore_pressure.with_discharge(result, step.size)
    balance.commit(equilibrium.x, checked)
    state.waves.commit(before, after)
    for pair in state.body_contacts:
        pair.begin()
    state.predictor.commit(balance.active, displacement, after - before)
    warn(setup.model, state, services, step, balance, equilibrium, moved)
    return replace(result, possible_size=possible)


def begin_motion(setup: Setup, state: State, services: Services, time: float, size: float) -> None:
    """Finds the accelerations at the start of inertia, if there is any and they are unknown.

    They are those after a very short step from rest, under the forces at its start. A stage
    after another one begins in balance: what is not is held and released.

    size: of the first step [time].

    Raises:
        StepFailed: they are not found.
    """
    dynamics = state.declared_dynamics
    if dynamics is None or dynamics.begun or state.relaxes:
        return
    with dynamics.at_start(size):
        step = prepare(setup, state, services, time, time)
        soil = soil_on(step.active, setup, state, services)
        of = InStep(setup, state, step, soil)
        balance = balance_of(of, terms_of(of, services.timers), holds_others=True)
        taken, unbalanced = state.waves.take_over(step, soil, balance)
        if taken:
            services.warnings.not_at_rest(unbalanced)
            balance = balance_of(of, terms_of(of, services.timers), holds_others=True)
        if setup.model.stage.releases:
            dynamics.begun = True
            return
        found = solve(setup, state, services, step, soil, balance)
    dynamics.start(found, balance, soil, size)
