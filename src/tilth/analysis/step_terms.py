# SPDX-License-Identifier: BSD-3-Clause
"""The terms of the balance of a step; the list `TERMS` has a maker for each kind."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace

import numpy as np

from tilth.analysis.setup import ROUND_OFF, InStep, Maker
from tilth.boundaries.contact.terms import contact_terms
from tilth.surface.loads import SurfaceLoads
from tilth.terms.balance import Balance
from tilth.terms.linear import LinearForces
from tilth.terms.point_loads import PointLoads
from tilth.terms.protocol import Role, Term, union
from tilth.terms.released import Release
from tilth.terms.soil_forces import SoilForces
from tilth.terms.space import displacement_of
from tilth.terms.unheld_weight import unheld_weight
from tilth.terms.water import WaterForces
from tilth.terms.weak_springs import WeakSprings
from tilth.timers import Timers


def soil_forces(of: InStep) -> Sequence[Term]:
    """Stresses of the soil."""
    return [SoilForces(of.soil)]


def implicit_boundaries(of: InStep) -> Sequence[Term]:
    """Implicit boundaries that hold the soil."""
    constraints = of.step.constraints
    return [
        LinearForces(
            constraints.couplings(),
            constraints.carried_force,
            constraints.coupled_nodes(),
            lambda u: constraints.commit(constraints.after(u)),
            label="implicit boundaries",
        )
    ]


def ghost_stabilisation(of: InStep) -> Sequence[Term]:
    """Ghost stabilisation of the edge of the soil."""
    ghost, active, weight = of.state.ghost, of.step.active, None
    constrained, exterior = of.step.conditions.constrained, of.step.constraints.exterior_nodes()
    if of.setup.has_friction:
        acceleration = of.setup.loads.acceleration(of.step.after)
        weight = unheld_weight(of.soil.points, of.setup.model, acceleration, of.state.grid)
    return [
        LinearForces(
            ghost.couplings(of.soil, constrained, exterior, weight),
            held=ghost.held_nodes(active, constrained),
            commit=lambda u: ghost.commit(active, u),
            role=Role.STABILISATION,
            label="ghost stabilisation",
        )
    ]


def axis(of: InStep) -> Sequence[Term]:
    """What holds the soil on the axis of symmetry."""
    on_axis, active, owner = of.step.on_axis, of.step.active, of.state.axis
    return [
        LinearForces(
            on_axis.couplings(),
            commit=lambda u: owner.commit(on_axis, active, u),
            label="axis of symmetry",
        )
    ]


def point_loads(of: InStep) -> Sequence[Term]:
    """Body forces and loads on points."""
    return [PointLoads(of.setup.loads, of.soil, of.step.before, of.step.after)]


def surface_loads(of: InStep) -> Sequence[Term]:
    """Loads on surfaces."""
    setup, step = of.setup, of.step
    loads, surfaces = setup.surface_loads, of.state.surfaces
    return [SurfaceLoads(loads, setup.kind, surfaces, step.active, step.before, step.after)]


def contact(of: InStep) -> Sequence[Term]:
    """Contact, and rigid bodies."""
    setup, step, state = of.setup, of.step, of.state
    motion = state.time_step(step.before, step.after)
    still = of.stiffening != 1.0 or (motion is not None and motion.from_rest)
    force = setup.round_off / ROUND_OFF
    return contact_terms(
        step.constraints.contacts, state.bodies, step.after, force, step.active.nodes,
        state.kept_contact.normal, still, setup.model.flow is not None,
    )  # fmt: skip


def edge_support(of: InStep) -> Sequence[Term]:
    """Springs under soil at the edge that nothing else holds."""
    support, of_weight = of.state.edge_support, of.state.ghost.of_weight
    if not of_weight and not len(support.face):
        return []
    return [support.term(of.step.active, of_weight, of.stiffening)]


def water_forces(of: InStep) -> Sequence[Term]:
    """Water at rest."""
    setup, step = of.setup, of.step
    if setup.water is None:
        return []
    return [WaterForces(setup.water, setup.loads, of.soil, step.before, step.after)]


def released_forces(of: InStep) -> Sequence[Term]:
    """Forces that a stage releases."""
    if not of.setup.model.stage.releases:
        return []
    return [Release(of.state.released, of.step.active, of.step.before, of.step.after)]


def inertia_and_flow(of: InStep) -> Sequence[Term]:
    """Inertia, its damping, boundaries that absorb waves, and water that flows in moving soil."""
    state, inertia = of.state, None
    terms: list[Term] = []
    if (dynamics := state.dynamics) is not None:
        inertia = dynamics.inertia(of.step, of.soil, of.setup.water, state.ghost.faces)
        if inertia is not None:
            terms += dynamics.terms(inertia, of.step, of.soil, state.waves)
    if state.pore_pressure is not None:
        terms += state.pore_pressure.terms(of, inertia)
    return terms


TERMS: tuple[Maker, ...] = (
    soil_forces,
    implicit_boundaries,
    ghost_stabilisation,
    axis,
    point_loads,
    surface_loads,
    contact,
    edge_support,
    water_forces,
    released_forces,
    inertia_and_flow,
)
"""Makers of all terms. New terms are added here."""

_TIMED = {
    implicit_boundaries: "boundaries",
    ghost_stabilisation: "basis",
    axis: "basis",
    surface_loads: "basis",
}
"""Part of the time that each of them belongs to; the others measure it themselves, or take none."""


def balance_of(of: InStep, terms: Sequence[Term], holds_others: bool = False) -> Balance:
    """Returns the balance of a step with the displacement and all other fields.

    holds_others: whether only the displacement is looked for; the others stay as they are.
    """
    owners = [*of.setup.fields, *of.state.fields]
    others = [each.in_step(of) for each in owners]
    for owner, each in zip(owners, others, strict=True):
        if owner.name != each.name:
            raise ValueError(f"the owner {owner.name!r} gives a field of the name {each.name!r}")
    if holds_others:
        none = [np.zeros(each.nodes.count, dtype=bool) for each in others]
        pairs = zip(others, none, strict=True)
        others = [replace(each, active=active, prescribed=None) for each, active in pairs]
    fields = [displacement_of(of.step.active, of.step.conditions), *others]
    return Balance(of.step.active, terms, fields)


def terms_of(of: InStep, timers: Timers) -> list[Term]:
    """Returns all terms of the balance of a step: weak springs last, where nothing else holds."""
    terms: list[Term] = []
    for make in of.setup.terms:
        with timers.measure(_TIMED[make]) if make in _TIMED else nullcontext():
            terms += make(of)
    held = union(of.step.active.nodes, (term.held_nodes() for term in terms))
    return [*terms, WeakSprings.of(of.soil, held)]
