# SPDX-License-Identifier: BSD-3-Clause
"""What goes with the commitment of a converged step: checks, tracked surfaces, warnings."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tilth.algebra.unknowns import Unknowns
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.services import Services
from tilth.analysis.state import State
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.boundaries.contact.between_bodies import motions_of_bodies, require_short_motion
from tilth.boundaries.contact.checks import require_not_passed
from tilth.comm import together
from tilth.model import Model
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import bound_domains
from tilth.terms.balance import Balance
from tilth.timers import Timers


def require_acceptable(
    state: State,
    timers: Timers,
    step: PreparedStep,
    balance: Balance,
    x: Unknowns,
    moved: Floats,
    is_least: bool,
) -> tuple[list[Any], float]:
    """Checks a converged step.

    Returns:
        What `Balance.commit` needs of `Balance.check`, and how large the step may be, see
        `StepResult.possible_size`.

    Raises:
        StepFailed: it cannot be committed.
    """
    points, before, after = state.points, step.before, step.after
    position = points.position + moved
    motions = motions_of_bodies(state.body_contacts, points, moved, state.comm)
    with together(state.comm):
        state.grid.require_inside(position, points.point_id)
        require_short_motion(state.body_contacts, motions)
        checked = balance.check(x)
    possible = math.inf
    if state.dynamics is not None:
        cells = state.grid.sizes_at(points.position)
        possible, reason = state.dynamics.possible_size(balance, x.u, moved, cells)
        state.dynamics.require_accurate(possible, reason)
    if state.pore_pressure is not None:
        possible = min(possible, state.pore_pressure.possible_size(balance, x))
    if state.implicit and not is_least:
        touching, contacts = state.contact_surfaces, step.constraints.contacts
        with timers.measure("boundaries"), together(state.comm):
            state.passage.require_in_front(
                state.implicit, points, position, before, after, state.grid
            )
            require_not_passed(touching, contacts, points, position, before, after)
    return checked, possible


def warn(
    model: Model,
    state: State,
    services: Services,
    step: PreparedStep,
    balance: Balance,
    equilibrium: Equilibrium,
    moved: Floats,
) -> None:
    """Warns of probable mistakes in a committed step; moved: displacement of the points."""
    warnings, grid = services.warnings, state.grid
    driven = step.driven  # of all processes; below only some may go on
    warnings.bounds(bound_domains(state.points, grid))
    if step.active.overlays > 1:
        warnings.unpaired(model, state.points, grid)
    with services.timers.measure("boundaries"):
        warnings.depths(state.implicit, state.points, state.surfaces, step.after, grid)
        free = state.is_forced or state.relaxes
        if not free and np.array_equal(balance.load_before, equilibrium.load):
            predictor = model.analysis.predictor
            warnings.jump(moved, driven, state.points, grid.cell_size, step.after, predictor)


def move_surfaces(
    state: State,
    warnings: RunWarnings,
    active: ActiveGrid,
    displacement: Floats,
    moved_by: Floats,
) -> None:
    """Moves tracked surfaces with the grid; moved_by: of the points in the step, (n, dim)."""
    surfaces = list(state.surfaces.values())
    if not surfaces:
        return
    position = state.points.position + moved_by
    moved = [surface.moved(active, displacement, state.points, position) for surface in surfaces]
    for surface, (new, warning) in zip(surfaces, moved, strict=True):
        surface.commit(new)
        if warning:
            warnings.note(warning.partition(" at ")[0], warning)
