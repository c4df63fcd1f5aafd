# SPDX-License-Identifier: BSD-3-Clause
"""Likely causes of a load step that fails again and again, from the state of the soil."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tilth.analysis.clock import Clock
from tilth.analysis.contact_warnings import contact_laws
from tilth.analysis.model_warnings import NEARLY_INCOMPRESSIBLE, acts, at
from tilth.analysis.prepare import prepare
from tilth.analysis.services import Services
from tilth.analysis.setup import Setup
from tilth.analysis.state import State
from tilth.arrays import Flags
from tilth.boundaries.implicit.passage import points_behind
from tilth.boundaries.step.conditions import require_no_rigid_motion
from tilth.errors import BadInput, StepFailed
from tilth.grid.background import LEFT_LIMITS, Grid
from tilth.model import Model
from tilth.mpm.domains import LARGEST_HALF_LENGTH
from tilth.mpm.points import MaterialPoints
from tilth.mpm.shear_strength import shear_strength
from tilth.mpm.torn_off import TORN_OFF, torn_off

STEADY_FLOW = 0.5
"""Elastic share of the last step's strain below which a point flows."""

FLOWING_SHARE = 0.05
"""Share of the points in plastic flow from which on a mechanism is likely."""

WIDE_DOMAIN = 2.0
"""Width of a domain, in cells, from which on it averages the deformation over too many of them."""


def likely_causes(
    setup: Setup, state: State, services: Services, clock: Clock, failure: StepFailed
) -> list[str]:
    """Returns likely causes of a failed step, one sentence each, those with most evidence first.

    state: before the step, to which it has been undone, of all processes. clock: at that time.
    """
    model, points = setup.model, state.points
    return [
        *_left_limits(model, points, failure),
        *_behind(state, clock),
        *_not_constrained(setup, state, services, clock),
        *_held_by_contact(setup, state, services, clock),
        *_limit_load(model, points, clock),
        *_without_strength(model, points, failure),
        *_domains(points, state.grid),
        *_locking(model, points),
        *_f_bar_in_dilating_soil(model, points),
        *_torn_off(points),
        *_first_step(model, clock),
    ]


def _left_limits(model: Model, points: MaterialPoints, failure: StepFailed) -> Iterator[str]:
    limits = model.grid.limits
    if failure.reason != LEFT_LIMITS or limits is None or failure.point is None:
        return
    position = points.position[points.index_of(np.array([failure.point]))[0]]
    yield (
        f"soil moves out of the grid's limits, first point {failure.point} from {at(position)}: "
        "smaller steps only delay it; widen grid.limits, or add a boundary that holds the soil"
    )


def _behind(state: State, clock: Clock) -> Iterator[str]:
    for boundary in state.implicit:
        if boundary.quadrature is None:
            continue
        behind, depth = points_behind(boundary, state.points, clock.time, state.grid)
        if len(behind):
            stays = ", and nothing pushes them out: begin with all soil in front of it; near it"
            yield (
                f"{len(behind)} material points are behind the boundary {boundary.name!r} "
                f"({boundary.key}), up to {depth.max():.3g} deep"
                f"{': near it' if boundary.declared.kind == 'contact' else stays} "
                "choose smaller cells or steps"
            )


def _not_constrained(setup: Setup, state: State, services: Services, clock: Clock) -> Iterator[str]:
    """A rigid-body motion that the conditions at this time leave free."""
    try:
        step = prepare(setup, state, services, clock.time, clock.next_time())
        require_no_rigid_motion(
            step.active, setup.kind, step.conditions.constrained, step.constraints
        )
    except StepFailed:
        return
    except BadInput as error:
        free = error.problem.removesuffix(": the system of equations is singular")
        yield (
            f"{free}, since it has lost the boundaries that held it: add a boundary that acts on "
            "it throughout, or end the schedule before"
        )


def _held_by_contact(setup: Setup, state: State, services: Services, clock: Clock) -> Iterator[str]:
    """Soil and rigid bodies that slide or come off where contact alone holds them."""
    beyond = "what friction and soil cannot resist has no equilibrium"
    for body in state.bodies:
        loose = body.free & (body.springs == 0.0)
        names = ", ".join(name for name, free in zip(body.components, loose, strict=True) if free)
        if names:
            yield (
                f"only contact holds the rigid body {body.name!r} in {names}: {beyond}; prescribe "
                "these components instead of the forces on them, or give springs"
            )
    try:
        step = prepare(setup, state, services, clock.time, clock.next_time())
    except (StepFailed, BadInput):
        return
    if not step.constraints.contacts:
        return
    try:
        require_no_rigid_motion(
            step.active,
            setup.kind,
            step.conditions.constrained,
            replace(step.constraints, contacts=()),
        )
    except BadInput:
        laws = [law for _, law in contact_laws(setup.model)]
        slides = any(law.tangential in ("smooth", "friction", "adhesion") for law in laws)
        yield (
            f"only contact holds some of the soil: {beyond}, and it slides or comes off; add a "
            f"boundary that stops it{', or more friction' * slides}"
        )


def _limit_load(model: Model, points: MaterialPoints, clock: Clock) -> Iterator[str]:
    """A load that changes while much of the soil flows plastically."""
    before, after = clock.time, clock.next_time()
    factors = {
        f"loads[{i}] {curve.factor(before):.4g}": curve.factor(after) != curve.factor(before)
        for i, load in model.acting_loads()
        if acts(load, model) and (curve := model.load_curve(load))
    }
    if not any(factors.values()):
        return
    flowing = float(np.mean(points.elastic_share < STEADY_FLOW))
    if flowing < FLOWING_SHARE:
        return
    yield (
        f"the limit load is probably reached: {100.0 * flowing:.0f} % of the material points flow "
        f"plastically while the load changes (last equilibrium at the factors {', '.join(factors)})"
        ", and no smaller step has an equilibrium beyond it; prescribe a displacement instead of "
        "the load to go on, or end the load there"
    )


def _without_strength(model: Model, points: MaterialPoints, failure: StepFailed) -> Iterator[str]:
    """Soil that has friction but neither cohesion nor pressure, as fill just placed."""
    if failure.point is None:
        return
    cohesion, tangent = shear_strength(points, model)
    weak = (cohesion == 0.0) & (tangent > 0.0) & ~points.stress.any(axis=1)
    if weak[points.index_of(np.array([failure.point]))[0]]:
        body = points.body_id[points.index_of(np.array([failure.point]))[0]]
        yield (
            f"{int(weak.sum())} points have neither pressure nor cohesion and so no strength at "
            f"all, such as this one in the body {model.bodies[body].name!r}: give its material a "
            "small cohesion, a twentieth of the pressure under the new soil is enough"
        )


def _domains(points: MaterialPoints, grid: Grid) -> Iterator[str]:
    """Domains of the points that have grown over the cells."""
    for body, own in points.whole_bodies():
        i, cell = body.body, grid.sizes_at(points.position[own])
        width = 2.0 * (points.half_length[own] / cell).max(axis=1)
        if body.has_corners:
            wide, rule = width > WIDE_DOMAIN, f'basis = "{body.basis}"'
            size, remedy = f"wider than {WIDE_DOMAIN:g} cells", 'basis = "gimp"'
        elif body.domain_update is not None:
            first = 2.0 * (points.initial_half_length[own] / cell).max(axis=1)
            most = 2.0 * LARGEST_HALF_LENGTH * (1.0 - 1e-9)
            wide, rule = (width >= most) & (first < most), f'domain_update = "{body.domain_update}"'
            size, remedy = "grown to the size of a cell", "another domain_update"
        else:
            continue
        if wide.any():
            yield (
                f"the domains of {int(wide.sum())} of {len(wide)} points of the body "
                f"{body.name!r} are {size} with {rule} (bodies[{i}]): choose {remedy}, or more "
                "points per cell"
            )


def _locking(model: Model, points: MaterialPoints) -> Iterator[str]:
    """Bodies that keep their volume, by elasticity or by plastic flow, without F-bar."""
    poisson = points.elastic_moduli().poisson
    dilates = _dilates(model, points)
    flows = (points.elastic_share < STEADY_FLOW) & ~dilates
    for body, own in points.whole_bodies():
        i = body.body
        if body.anti_locking != "none":
            continue
        ratio = float(poisson[own].max())
        if ratio >= NEARLY_INCOMPRESSIBLE:
            why = f"is nearly incompressible (Poisson's ratio {ratio:.3g})"
        elif float(np.mean(flows[own])) >= FLOWING_SHARE:
            why = "flows plastically, at constant volume or nearly so,"
        else:
            continue
        others = _layers(model, points, i, dilates)
        apart = ""
        if 0 < len(others) < len(model.bodies[i].materials):
            apart = f", with {' and '.join(others)} as a body of its own without it"
        yield (
            f"the body {body.name!r} {why} without a remedy against locking, so that its pressures "
            f'oscillate: give bodies[{i}].anti_locking = "f_bar"{apart}'
        )


def _f_bar_in_dilating_soil(model: Model, points: MaterialPoints) -> Iterator[str]:
    """Bodies with F-bar whose soil changes its volume as it flows, and so does not lock."""
    flows = (points.elastic_share < STEADY_FLOW) & _dilates(model, points)
    for body, own in points.whole_bodies():
        i, declared = body.body, model.bodies[body.body]
        if body.anti_locking == "none" or float(np.mean(flows[own])) < FLOWING_SHARE:
            continue
        names = _layers(model, points, i, flows)
        apart = ""
        if len(names) < len(declared.materials):
            apart = ", with the other layers, which may need it, as a body of their own"
        yield (
            f"the body {body.name!r} flows with a change of volume in {' and '.join(names)}, which "
            "does not lock, but F-bar gives it the mean change of each cell: compare a run "
            f'with bodies[{i}].anti_locking = "none"{apart}'
        )


def _torn_off(points: MaterialPoints) -> Iterator[str]:
    """Soil at an edge that has come apart, and falls or crumbles."""
    torn = torn_off(points)
    if not torn.any():
        return
    worst = int((points.volume / points.initial_volume).argmax())
    yield (
        f"{int(torn.sum())} points have more than {TORN_OFF:g} times their volume, most of all "
        f"{points.point_id[worst]} at ({at(points.position[worst])}): they are torn off at an edge "
        "of the soil, where little holds them; let no soil fall over the top of a rigid body (make "
        "it higher than its way down), or give the soil a cohesion of a tenth of its unit weight "
        "times the cell's size"
    )


def _layers(model: Model, points: MaterialPoints, body: int, chosen: Flags) -> list[str]:
    """Returns the materials of a body of which at least one of the points (n,) is chosen."""
    names = model.bodies[body].materials
    return [
        names[each.layer]
        for each in points.ranges
        if each.body == body and chosen[each.points].any()
    ]


def _dilates(model: Model, points: MaterialPoints) -> Flags:
    """Returns which points have a law that changes its volume in plastic flow, shape (n,)."""
    found = np.zeros(len(points), dtype=bool)
    for range_ in points.ranges:
        material = model.materials[model.bodies[range_.body].materials[range_.layer]]
        found[range_.points] = material.dilates
    return found


def _first_step(model: Model, clock: Clock) -> Iterator[str]:
    """A first step without an equilibrium."""
    if clock.time > 0.0:
        return
    schedule, stage = model.schedule, model.stage.name
    of_stage = f" of the stage {stage!r}" if stage else ""
    yield (
        f"already the first step{of_stage} ({schedule.first_step:.4g} in the schedule, tried "
        f"down to {min(clock.size, schedule.first_step):.4g}) has no equilibrium: its load or "
        "motion is too large for the soil; check the units of loads, stiffness and strength, or "
        "give more steps"
    )
