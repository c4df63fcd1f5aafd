# SPDX-License-Identifier: BSD-3-Clause
"""What goes with the commitment of a converged step: checks, tracked surfaces, warnings."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.boundaries.contact.between_bodies import motions_of_bodies, require_short_motion
from tilth.boundaries.contact.checks import require_not_passed
from tilth.comm import together
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import bound_domains
from tilth.terms.balance import Balance

if TYPE_CHECKING:
    from tilth.analysis.simulation import Simulation


def require_acceptable(
    simulation: Simulation,
    step: PreparedStep,
    balance: Balance,
    displacement: Floats,
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
    points, before, after = simulation.points, step.before, step.after
    position = points.position + moved
    motions = motions_of_bodies(simulation.body_contacts, points, moved, simulation.comm)
    with together(simulation.comm):
        simulation.grid.require_inside(position, points.point_id)
        require_short_motion(simulation.body_contacts, motions)
        checked = balance.check(displacement)
    possible = math.inf
    if simulation.dynamics is not None:
        cells = simulation.grid.sizes_at(points.position)
        possible, reason = simulation.dynamics.possible_size(balance, displacement, moved, cells)
        simulation.dynamics.require_accurate(possible, reason)
    if simulation.implicit and not is_least:
        touching, contacts = simulation.contact_surfaces, step.constraints.contacts
        with simulation.services.timers.measure("boundaries"), together(simulation.comm):
            simulation.passage.require_in_front(
                simulation.implicit, points, position, before, after, simulation.grid
            )
            require_not_passed(touching, contacts, points, position, before, after)
    return checked, possible


def warn(
    simulation: Simulation,
    step: PreparedStep,
    balance: Balance,
    equilibrium: Equilibrium,
    moved: Floats,
) -> None:
    """Warns of probable mistakes in a committed step; moved: displacement of the points."""
    warnings, grid = simulation.services.warnings, simulation.grid
    driven = step.driven  # of all processes; below only some may go on
    warnings.bounds(bound_domains(simulation.points, grid))
    if step.active.overlays > 1:
        warnings.unpaired(simulation.model, simulation.points, grid)
    with simulation.services.timers.measure("boundaries"):
        warnings.depths(
            simulation.implicit, simulation.points, simulation.surfaces, step.after, grid
        )
        free = simulation.is_forced or simulation.relaxes
        if not free and np.array_equal(balance.load_before, equilibrium.load):
            predictor = simulation.model.analysis.predictor
            warnings.jump(moved, driven, simulation.points, grid.cell_size, step.after, predictor)


def move_surfaces(
    simulation: Simulation, active: ActiveGrid, displacement: Floats, moved_by: Floats
) -> None:
    """Moves tracked surfaces with the grid; moved_by: of the points in the step, (n, dim)."""
    surfaces = list(simulation.surfaces.values())
    if not surfaces:
        return
    position = simulation.points.position + moved_by
    moved = [
        surface.moved(active, displacement, simulation.points, position) for surface in surfaces
    ]
    for surface, (state, warning) in zip(surfaces, moved, strict=True):
        surface.commit(state)
        if warning:
            simulation.services.warnings.note(warning.partition(" at ")[0], warning)
