# SPDX-License-Identifier: BSD-3-Clause
"""The change from one stage of an analysis to the next: soil, materials, grid, boundaries."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import partial

import numpy as np

from tilth.analysis.kept_contact import KeptContact
from tilth.analysis.placement import placed_on_ground, settlement
from tilth.analysis.simulation import Simulation
from tilth.analysis.state import State
from tilth.arrays import Flags, Floats
from tilth.bodies.forms import form_of
from tilth.bodies.inside import inside_of
from tilth.bodies.request import Request
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.errors import BadInput, StepFailed
from tilth.grid.background import background_grid
from tilth.model import Model
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.model.stages import Stage
from tilth.model.staging import copied
from tilth.mpm.exchanged_water import exchanged_water
from tilth.mpm.initial_points import initial_points, present_points
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.mpm.pore_water import PRESSURE
from tilth.mpm.wet_mass import total_mass
from tilth.terms.balance import Balance
from tilth.terms.protocol import Role
from tilth.variation.tables import place_text


def next_stage(last: Simulation, model: Model, initial: MaterialPoints) -> Simulation:
    """Returns the simulation at the start of a stage, from the state at the end of the last one.

    Args:
        last: the simulation of the last stage at its end; it must not be used afterwards.
        model: of the stage.
        initial: undeformed points of all bodies of all stages, with the materials of the stage.

    Raises:
        BadInput: no soil is left, new soil would overlap with soil, a stress that an exchanged
            material cannot have, or conditions that cannot be met.
    """
    stage = model.stage.declared
    assert stage is not None
    key = model.stage.key
    points = last.state.points.selected(_remaining(last.state.points, model, stage))
    if len(points) == 0:
        raise BadInput(f"no soil is left in the stage {stage.name!r}", "keep some", key=key)
    bulk_modulus = np.inf if model.flow is None else model.flow.bulk_modulus or np.inf
    points = _with_materials(points, initial, bulk_modulus, key)
    points, grounds = _with_new_bodies(points, last.setup.model, model, initial, key)
    _reset(points, stage)
    end = last.setup.model.schedule.end
    moving = points.kinetic_energy(total_mass(points, last.setup.water, end))
    if not stage.inertia:
        points.motion[:] = 0.0
    simulation = Simulation(model, points, initial, last.setup.terms, last.setup.fields)
    state, warnings = simulation.state, simulation.services.warnings
    simulation.services.go_on_from(last.services)
    _carry(last.state, state, simulation.setup.model, grounds)
    if not stage.inertia:
        bodies = [body.inertia for body in state.bodies if body.inertia is not None]
        energies = moving, sum(each.energy() for each in bodies), points.stored_energy()
        warnings.stopped(stage.name, *energies)
        for each in bodies:
            each.rest()
    if stage.grid is not None:
        warnings.few_points(points, state.grid, f"{key}.grid.cell_size")
    return simulation


def _remaining(points: MaterialPoints, model: Model, stage: Stage) -> Flags:
    """Returns which points are still there at the start of the stage, shape (n,)."""
    kept = present_points(model, points)
    for i, region in enumerate(stage.excavate):
        entry = f"{model.stage.key}.excavate[{i}]"
        axisymmetric = model.analysis.kind == "axisymmetric"
        request = Request(region.body, axisymmetric, background_grid(model), entry=entry)
        inside = inside_of(form_of(region.shape, request))
        own = points.of_body(region.body)
        removed = inside(points.position[own])
        if not removed.any():
            raise BadInput(
                f"no soil of {region.body!r} is in this region at the start of {stage.name!r}",
                "correct its shape, which lies in the deformed ground",
                key=f"{entry}.shape",
            )
        kept[own] &= ~removed
    return kept


def _with_materials(
    points: MaterialPoints, initial: MaterialPoints, bulk_modulus: float, key: str
) -> MaterialPoints:
    """Returns the points with the laws that `initial` has, their effective stress as it was.

    bulk_modulus: of the water, see `PoreWater`.
    """
    new = {(range_.body, range_.layer): range_ for range_ in initial.ranges}
    ranges = [
        replace(new[range_.body, range_.layer], start=range_.start, stop=range_.stop)
        for range_ in points.ranges
    ]
    columns = initial.state.shape[1]
    state = np.zeros((len(points), columns))
    shared = min(columns, points.state.shape[1])
    state[:, :shared] = points.state[:, :shared]
    changed = MaterialPoints(
        **{
            **points.arrays(),
            "state": state,
            "parameters": initial.parameters[points.point_id],
            "water": exchanged_water(points, initial, bulk_modulus),
        },  # type: ignore[arg-type]
        ranges=ranges,
        varying=initial.varying,
    )
    for before, after in zip(points.ranges, ranges, strict=True):
        if not _same_law(points, before, changed, after):
            _exchange(points.part(before), changed.part(after), key)
    return changed


def _same_law(
    points: MaterialPoints, before: PointRange, changed: MaterialPoints, after: PointRange
) -> bool:
    one, other = points.parameters_of(before), changed.parameters_of(after)
    same = before.law.name == after.law.name and before.law.core is after.law.core
    if isinstance(before.law.core, str):
        same = before.law.core == after.law.core
    return same and one.shape == other.shape and bool((one == other).all())


def _exchange(before: MaterialPoints, part: MaterialPoints, key: str) -> None:
    """Gives the points of one range, which have a new law, the state that belongs to their stress.

    The elastic strain is that of the effective stress with the new law. An excess pore pressure,
    of Kirchhoff's kind, stays if the new law has one too, or water flows in one of the two.
    """
    jacobian = before.stress_jacobian
    kirchhoff = before.stress * jacobian[:, None]
    pore_pressure = np.zeros(len(before))
    variables = list(part.ranges[0].law.state_variables)
    if EXCESS_PORE_PRESSURE in before.ranges[0].law.state_variables:
        pore_pressure = before.state_variable(EXCESS_PORE_PRESSURE)
    kirchhoff[:, :3] += pore_pressure[:, None]
    if EXCESS_PORE_PRESSURE in variables and before.water.shape[1]:
        pore_pressure = pore_pressure + before.water[:, PRESSURE] * jacobian
    part.state[:] = 0.0
    failed = part.start_with(kirchhoff)
    if EXCESS_PORE_PRESSURE in variables:
        part.state[:, variables.index(EXCESS_PORE_PRESSURE)] = pore_pressure
        kirchhoff[:, :3] -= pore_pressure[:, None]
    part.stress[:] = kirchhoff / jacobian[:, None]
    if failed >= 0:
        raise BadInput(
            f"the material {part.ranges[0].law.name!r} cannot have the stress of the soil at "
            f"{place_text(part.position[failed])}",
            "exchange it in a stage in which the soil has another stress",
            key=f"{key}.materials",
        )


def _with_new_bodies(
    points: MaterialPoints, last: Model, model: Model, initial: MaterialPoints, key: str
) -> tuple[MaterialPoints, dict[str, Floats]]:
    """Returns the points with those of bodies that are new, and the ground below each (see
    `placed_on_ground`).
    """
    new = initial.selected(present_points(model, initial) & ~present_points(last, initial))
    if len(new) == 0:
        return points, {}
    grounds = placed_on_ground(new, points, initial, key)
    return points.joined(new), grounds


def _reset(points: MaterialPoints, stage: Stage) -> None:
    if "displacement" in stage.reset:
        points.displacement[:] = 0.0
    if "plastic_strain" in stage.reset:
        points.plastic[:, 0] = 0.0


def _carry(last: State, state: State, model: Model, grounds: dict[str, Floats]) -> None:
    """Hands on what persists: tractions of boundaries, tracked surfaces, stabilisation."""
    same_grid = state.grid.has_lines_of(last.grid)
    before = {boundary.name: boundary for boundary in [*last.implicit, *last.waves.surfaces()]}
    for boundary in [*state.implicit, *state.waves.surfaces()]:
        if (earlier := before.get(boundary.name)) is not None:
            _carry_tractions(earlier, boundary, same_grid)
    bodies = {body.name: body for body in last.bodies}
    moved = last.declared_dynamics is not None
    for body in state.bodies:
        if body.name in bodies:
            body.go_on_from(bodies[body.name])
        if state.declared_dynamics is not None and not (moved and body.name in bodies):
            body.begin_stage(model.schedule.first_step)
    for name, surface in state.surfaces.items():
        if name in last.surfaces:
            surface.restore(last.surfaces[name].state())
        elif name in grounds:
            surface.move_vertically(partial(settlement, grounds[name]))
    pairs = {pair.name: pair for pair in last.body_contacts}
    for pair in state.body_contacts:
        if pair.name in pairs:
            pair.carry_from(pairs[pair.name])
    if not same_grid:
        for contact in [*state.contact_surfaces, *state.body_contacts]:
            contact.close_gaps()
    stage = model.stage.declared
    exchanges = stage is not None and bool(stage.materials)
    state.go_on_from(last, same_grid, exchanges)


def _carry_tractions(before: Implicit, after: Implicit, same_grid: bool) -> None:
    """Hands on the tractions of a boundary; with another grid, those of the nearest points."""
    if same_grid:
        after.restore(before.state())
    elif before.quadrature is not None:
        after.carry_from(before)


def release_out_of_balance(simulation: Simulation, kept: KeptContact | None = None) -> Floats:
    """Lets the forces that are out of balance at the start of a stage act as released forces.

    With inertia these are what the motion at the end of the last stage is out of balance with.

    kept: the force of contact at the end of the last stage, if it had inertia and this grid.

    Returns their resultant on the free nodes [force], shape (dim,).

    Raises:
        StepFailed: the forces cannot be computed.
    """
    state, dynamics = simulation.state, simulation.state.declared_dynamics
    first = simulation.setup.model.schedule.first_step
    with nullcontext() if dynamics is None else dynamics.at_start(first):
        step = simulation.prepare(0.0, 0.0)
        soil = simulation.soil_on(step.active)
        balance = simulation.balance(step, soil)
        still = balance.at(np.zeros(step.active.position.shape))
        if dynamics is not None:  # finds where bodies that move with inertia touch the soil
            balance.begin(still)
        residual = balance.evaluate(still).u
        residual += _contact_so_far(balance, kept)
    if dynamics is not None:
        residual += dynamics.force_at_start(balance)
    force = np.where(step.conditions.constrained, 0.0, residual)
    state.waves.hold(step, soil, balance, force)
    force[state.waves.nodes(soil, 0.0)] = 0.0
    state.released.set(balance.active, force)
    return np.asarray(force.sum(axis=0))


def _contact_so_far(balance: Balance, kept: KeptContact | None) -> Floats:
    """Returns what to add to the residual so that contact acts as at the end of the last stage.

    The law of contact has no force of its own without motion: a gap or penetration within its
    accuracy, times its stiffness, would act as a released force, on another grid many times the
    contact's own.
    """
    change = np.zeros((balance.active.nodes, balance.active.grid.dim))
    for term in balance.terms:
        if term.role not in (Role.CONTACT, Role.BETWEEN_BODIES):
            continue
        without_motion, carried = term.constant_force(), term.carried_force()
        if without_motion is not None:
            change -= without_motion
        if carried is not None and (kept is None or term.role is Role.BETWEEN_BODIES):
            change += carried
    return change if kept is None else change - kept.at(balance.active)


def checked_next_stage(
    last: Simulation, model: Model, initial: MaterialPoints, in_advance: bool = False
) -> Simulation:
    """As `next_stage`, with the first step's conditions checked and out-of-balance forces found.

    last: the initial state may stand for the last stage of the first one.

    in_advance: whether the stage is only looked at, with soil that has not moved yet. No forces are
        found then, see `check_first_step` for the conditions.

    Raises:
        BadInput: as `next_stage` and `Simulation.check`.
    """
    stage = model.stage.declared
    assert stage is not None
    is_first = last.setup.model.initial_model is None
    kept = last.state.kept_contact if stage.grid is None and not is_first else None
    if not (stage.inertia or last.state.declared_dynamics is not None):
        kept = None
    simulation = next_stage(last, model, initial)
    try:
        simulation.check(in_advance)
        if model.stage.releases and not in_advance:
            release_out_of_balance(simulation, kept)
    except StepFailed as failure:
        raise BadInput(
            f"the stage cannot begin: {failure.reason}",
            "change what the stage removes, exchanges or places",
            key=model.stage.key,
        ) from failure
    except BadInput as error:
        when = f"at the start of the stage {model.stage.name!r}"
        if _has_empty_cells(stage, simulation.state):
            when += ", whose grid has cells smaller than the distance of the points"
        raise error.during(when) from error
    return simulation


def _has_empty_cells(stage: Stage, state: State) -> bool:
    """Whether the stage has a grid with cells smaller than the points' mean distance."""
    points, grid = state.points, state.grid
    apart = 2.0 * (points.half_length / grid.sizes_at(points.position)).mean(axis=0)
    return stage.grid is not None and bool((apart > 1.0).any())


def points_of_stages(models: Sequence[Model]) -> list[MaterialPoints]:
    """Returns the undeformed points of all bodies for each stage, with the stage's materials.

    Stages with the same materials share them; they must not be changed.
    """
    found: list[MaterialPoints] = []
    for number, model in enumerate(models):
        same = number > 0 and model.bodies == models[number - 1].bodies
        initial = model.initial_model
        assert initial is not None, "a model with stages"
        of_first = copied(model, grid=initial.grid)  # points per cell are those of [grid]
        found.append(found[-1] if same else initial_points(of_first))
    return found
