# SPDX-License-Identifier: BSD-3-Clause
"""A step before its forces, and its result."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tilth.analysis.kept_contact import KeptContact, KeptForce
from tilth.analysis.step import Equilibrium
from tilth.arrays import Floats
from tilth.boundaries import Conditions, ImplicitConstraints
from tilth.boundaries.step.axis import AxisConstraints
from tilth.boundaries.surfaces.near_soil import NearSoil
from tilth.comm import total
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.balance import Balance
from tilth.terms.outcome import ContactState, Outcome
from tilth.terms.protocol import Role


@dataclass(frozen=True)
class Relaxing:
    """What a step does to soil that comes to rest by damped inertia.

    Attributes:
        number: of the relaxation, from 1.
        at_rest: whether the soil is at rest after the step.
        energy: kinetic energy after the step [force length].
        work: of loads and boundaries since the soil moves [force length].
    """

    number: int
    at_rest: bool
    energy: float
    work: float


@dataclass(frozen=True)
class StepResult:
    """The result of a converged step.

    Attributes:
        active: the grid of the step.
        equilibrium: nodal displacement and residuals; reaction of grid-line conditions.
        forces: nodal forces of each boundary on the soil [force], shape (nodes, dim), by name.
        work: work of loads and boundaries in the step [force length]: that of a boundary or rigid
            body in contact is its force times its own motion.
        time: at the end of the step.
        areas: area of each implicit boundary that touches soil, at the end of the step, by name
            [length^(dim - 1), in axisymmetry length^2].
        contacts: the points of each contact surface, by the name of its boundary or rigid body.
        between_bodies: names of the contacts between bodies among them; their force is that on the
            second body.
        friction_work: work that friction dissipates in the step [force length].
        damping_work: the same of Rayleigh damping.
        integration_work: the same of the time integration.
        stabilisation_work: work that ghost stabilisation takes in the step [force length].
        gap_work: the same of contact where gaps close or open, see `SlipWork`.
        radiated_work: energy that leaves through absorbing boundaries less what comes in.
        outflow: water that leaves through flow boundaries in the step, of all processes
            [length^dim], in axisymmetry of the full circle, by name of the boundary.
        size: of the step [time]; 0 where no water flows.
        seepage_work: work that flowing water dissipates in the step [force length].
        possible_size: greatest size of a step relative to this one that keeps the declared limits
            of error and motion; infinite without limits.
        relaxing: of a step in which soil comes to rest; None in all others.
    """

    active: ActiveGrid
    equilibrium: Equilibrium
    forces: dict[str, Floats]
    work: float
    time: float
    areas: dict[str, float] = field(default_factory=dict)
    contacts: dict[str, ContactState] = field(default_factory=dict)
    between_bodies: frozenset[str] = frozenset()
    friction_work: float = 0.0
    damping_work: float = 0.0
    integration_work: float = 0.0
    stabilisation_work: float = 0.0
    gap_work: float = 0.0
    radiated_work: float = 0.0
    outflow: dict[str, float] = field(default_factory=dict)
    size: float = 0.0
    seepage_work: float = 0.0
    possible_size: float = math.inf
    relaxing: Relaxing | None = None

    @property
    def reaction(self) -> Floats:
        """Nodal forces of all boundaries on the soil [force], shape (nodes, dim)."""
        of_boundaries = [f for name, f in self.forces.items() if name not in self.between_bodies]
        return np.asarray(np.sum([np.zeros_like(self.equilibrium.load), *of_boundaries], axis=0))

    def discharge(self, name: str) -> float:
        """Returns the water per time that leaves through a flow boundary; 0 if it does not act."""
        return self.outflow[name] / self.size if self.size > 0.0 and name in self.outflow else 0.0

    def resultant(self, name: str) -> Floats:
        """Returns the force of a boundary on the soil [force], (dim,); all processes call it."""
        own = self.forces[name][self.active.owned]
        return total(self.active.comm, np.asarray(own.sum(axis=0)))

    def moment(self, name: str, about: Floats) -> Floats:
        """Returns the moment of that force about a point [force length], shape (3,), likewise."""
        arm, own = self.active.position + self.equilibrium.displacement - about, self.active.owned
        three = ((0, 0), (0, 3 - arm.shape[1]))
        moment = np.cross(np.pad(arm[own], three), np.pad(self.forces[name][own], three))
        return total(self.active.comm, np.asarray(moment.sum(axis=0)))


@dataclass(frozen=True)
class PreparedStep:
    """A step before its forces: where the soil is on the grid, and what conditions act.

    Attributes:
        before, after: times at its start and end.
        active: the grid with the soil on it.
        on_axis: all conditions on nodes, and what else acts on the axis of symmetry.
        constraints: of the implicit boundaries.
        absorbing: points of the absorbing boundaries near soil, in a step with inertia.
    """

    before: float
    after: float
    active: ActiveGrid
    on_axis: AxisConstraints
    constraints: ImplicitConstraints
    absorbing: Sequence[NearSoil] = ()

    @property
    def size(self) -> float:
        """Its size [time]."""
        return self.after - self.before

    @property
    def conditions(self) -> Conditions:
        """All conditions on nodes."""
        return self.on_axis.conditions

    @property
    def driven(self) -> float:
        """How far boundaries and rigid bodies whose motion is prescribed move in it [length].

        All processes ask for it together.
        """
        prescribed = float(np.abs(self.conditions.increment).max(initial=0.0))
        return self.active.comm.max(max(prescribed, self.constraints.largest_increment()))


def result_of(
    step: PreparedStep,
    balance: Balance,
    equilibrium: Equilibrium,
    kept: KeptContact,
    kept_ghost: KeptForce,
) -> StepResult:
    """Returns the result of a converged step; call it before the step is committed.

    kept, kept_ghost: the forces of contact and of ghost stabilisation at the end of the last step;
    are renewed.
    """
    conditions, constraints = step.conditions, step.constraints
    carried = constraints.after(equilibrium.displacement)
    forces = conditions.forces(equilibrium.reaction) | constraints.forces(carried)
    outcomes = balance.outcomes(equilibrium.x)
    contacts = [(of, of.contact) for of in outcomes if of.contact is not None]
    for of, _ in contacts:
        forces |= of.forces
    touching = balance.carried_force(Role.CONTACT)
    if len(kept.key) > 0:  # else there was none, or another stage
        touching = -kept.at(balance.active)
    loading = [forces[each.name] for _, each in contacts if not each.is_between_bodies]
    acting = sum(loading, np.zeros_like(touching))
    kept.keep(balance.active, acting)
    kept.normal = {each.name: each.normal for _, each in contacts}
    reaction_before = constraints.reaction_before(
        equilibrium.initial_reaction,
        conditions.constrained,
        balance.constant_force(),
        touching,
        balance.carried_force(Role.BETWEEN_BODIES),
    )
    states = {each.name: each.state for _, each in contacts}
    works = [of.work for of in outcomes]
    result = StepResult(
        balance.active,
        equilibrium,
        forces,
        0.0,
        step.after,
        areas=constraints.areas | {name: each.area for name, each in states.items()},
        contacts=states,
        between_bodies=frozenset(each.name for _, each in contacts if each.is_between_bodies),
        friction_work=sum(each.friction for each in works),
        damping_work=sum(each.damping for each in works),
        integration_work=sum(each.integration for each in works),
        stabilisation_work=_stabilisation_work(balance, equilibrium, outcomes, kept_ghost),
        gap_work=sum(each.gaps for each in works),
        radiated_work=sum(each.radiated for each in works),
        seepage_work=sum(each.seepage for each in works),
    )
    outflow = {name: nodal for of in outcomes for name, nodal in of.outflow.items()}
    twice = balance.load_before + equilibrium.load + reaction_before + result.reaction
    work = 0.5 * balance.active.work(twice, equilibrium.displacement)
    work += sum(of.work.surface for of, each in contacts if not each.is_between_bodies)
    for of in outcomes:  # those of inertia, which are no part of this work, after it
        forces |= of.forces
    flows = {name: outflow_of(balance.active, nodal) for name, nodal in outflow.items()}
    return replace(result, forces=forces, work=work, outflow=flows)


def outflow_of(active: ActiveGrid, nodal: Floats) -> float:
    """Returns the sum of a volume of water over the nodes of all processes, (nodes, 1)."""
    return float(total(active.comm, np.asarray(nodal[active.owned].sum(axis=0)))[0])


def _stabilisation_work(
    balance: Balance, equilibrium: Equilibrium, outcomes: Sequence[Outcome], kept: KeptForce
) -> float:
    """Returns the work that ghost stabilisation takes in a step [force length], with its mass.

    By the trapezoidal rule. The points carry neither the ghost mass's acceleration nor its kinetic
    energy to the next step: in place of the work of its force at the end stands that energy.

    outcomes: of the terms. kept: the internal force at the end of the last step; is renewed.
    """
    displacement = equilibrium.displacement
    before = balance.stabilisation(np.zeros_like(displacement))
    if len(kept.key) > 0:  # else there was none, or another stage
        before = kept.at(balance.active)
    after = balance.stabilisation(displacement)
    work = 0.5 * balance.active.work(before + after, displacement)
    for of in outcomes:
        if of.ghost_force is not None:
            work += of.work.stabilisation
            after = after + of.ghost_force
    kept.keep(balance.active, after)
    return work
