# SPDX-License-Identifier: BSD-3-Clause
"""The analysis in memory: points, grid, boundaries and loads, advanced step by step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.acceptance import move_surfaces, require_acceptable, warn
from tilth.analysis.attempts import solve
from tilth.analysis.checks import check_first_step
from tilth.analysis.dynamics import Dynamics
from tilth.analysis.grid_motion import GridMotion
from tilth.analysis.kept_contact import KeptContact, KeptForce
from tilth.analysis.owners import (
    DECLARED_POSITION,
    Arrays,
    Stateful,
    WrongState,
    restore_all,
    restored_points,
    state_of,
)
from tilth.analysis.predictor import Predictor, load_curves
from tilth.analysis.relaxation import Relaxation
from tilth.analysis.residual import newton_attempts
from tilth.analysis.services import Services
from tilth.analysis.step_result import PreparedStep, StepResult, result_of
from tilth.analysis.wave_boundaries import WaveBoundaries
from tilth.arrays import Floats
from tilth.boundaries import (
    Conditions,
    ImplicitConstraints,
    make_bodies,
    make_body_contacts,
    make_boundaries,
    make_implicit,
)
from tilth.boundaries.contact.gather import TouchingSoil
from tilth.boundaries.contact.state import RigidBodyState
from tilth.boundaries.contact.surface import ContactSurface
from tilth.boundaries.contact.terms import contact_terms
from tilth.boundaries.implicit.passage import PassageCheck
from tilth.boundaries.step.axis import Axis
from tilth.boundaries.step.constraints import FoundSoil
from tilth.comm import SERIAL, Communicator, together
from tilth.errors import StepFailed
from tilth.grid.background import largest_face
from tilth.model import Model
from tilth.model.load_curve import LoadCurve
from tilth.mpi import return_memory
from tilth.mpm.active_grid import ActiveGrid, locate
from tilth.mpm.distribution import Distribution, KeyedRows
from tilth.mpm.domains import bound_domains
from tilth.mpm.initial_points import initial_points, present_points
from tilth.mpm.interval import INSTANT, Interval
from tilth.mpm.points import MaterialPoints
from tilth.mpm.shear_strength import shear_strength
from tilth.mpm.soil import Soil
from tilth.mpm.water import PhreaticSurface
from tilth.output.snapshot import SurfaceShape
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.surface.make import make_surfaces
from tilth.terms.balance import Balance
from tilth.terms.drag import Drag
from tilth.terms.edge_support import EdgeSupport
from tilth.terms.ghost import Ghost
from tilth.terms.inertia import TimeStep
from tilth.terms.linear import LinearForces
from tilth.terms.loads import Loads
from tilth.terms.point_loads import PointLoads
from tilth.terms.protocol import Role, Term, union
from tilth.terms.released import Release, ReleasedForces
from tilth.terms.soil_forces import SoilForces
from tilth.terms.unheld_weight import unheld_weight
from tilth.terms.water import WaterForces
from tilth.terms.weak_springs import WeakSprings

ROUND_OFF = 1e-14
"""Residual forces below this share of Young's modulus times a cell's face count as zero."""


class Simulation:
    """The state of an analysis in memory.

    Args:
        model: the declared problem.
        points: the present points; those of the undeformed bodies if None.
        initial: the undeformed points of all bodies of all stages, in the order of their numbers;
            computed if None.

    Attributes:
        points: the material points, changed by `advance`.
        surfaces: tracked surfaces, by the bodies' names.
        water: the phreatic surface; None without water.
        bodies: rigid bodies.
        contact_surfaces: surfaces of boundaries and bodies that soil can separate from.
        body_contacts: surfaces of soil bodies in contact with other soil bodies.
        declared_dynamics: the inertia of the analysis; None if it is quasi-static.
        relaxation: of soil beyond a limit load; None if the analysis ends there.
        passage: remembers where soil was in front of the boundaries.
        is_forced: whether rigid bodies move freely.
        has_friction: whether some soil has friction by a law that says what its strength is.
        distribution: which points this process owns, of those of all processes.
        kept_contact, kept_ghost: forces of contact and ghost stabilisation after the last step.
        services: what steps use and no result depends on.
        round_off: residual that counts as zero [force].

    Raises:
        BadInput: a body without points, conditions that leave a rigid motion or contradict.
    """

    def __init__(
        self,
        model: Model,
        points: MaterialPoints | None = None,
        initial: MaterialPoints | None = None,
    ) -> None:
        self.model = model
        self.kind = model.analysis.kind
        self.declared_dynamics = Dynamics.of(model)
        self.relaxation = Relaxation.of(model)
        self.kept_contact = KeptContact(model.dimension)
        self.kept_ghost = KeptForce(model.dimension)
        self.boundaries = make_boundaries(model, self._time_step)
        self.implicit = make_implicit(model)
        self.bodies, surfaces = make_bodies(model, self._acceleration)
        self.implicit += surfaces
        self._grid_motion = GridMotion(model, self.implicit)
        self.grid = self._grid_motion.at(0.0)
        model.require_state_variables()
        initial = initial_points(model) if initial is None else initial
        self._declared_position = initial.position if model.stage.name else None
        if points is None:
            points = (
                initial.selected(present_points(model, initial)) if model.stage.name else initial
            )
        self.points = points
        self.services = Services.of(model, len(points), SERIAL)
        self.waves = WaveBoundaries(model, self.boundaries, self.points.position)
        self.loads = Loads(model, initial, self.points)
        self.water = PhreaticSurface.of(model)
        self.axis = Axis(model, initial)
        self.surfaces = make_surfaces(model, initial)
        self.body_contacts = make_body_contacts(model, self.surfaces)
        self.distribution = Distribution(SERIAL, self.points, self.grid)
        self._touching = TouchingSoil(
            self.surfaces, lambda points: shear_strength(points, self.model)
        )
        self._surface_loads = declared_loads(model)
        self._ghost = Ghost(model.analysis.ghost_stabilisation, model.dimension)
        self._edge_support = EdgeSupport(model.dimension)
        self.passage = PassageCheck()
        self.predictor = Predictor(model.dimension, load_curves(model))
        stage = model.stage.declared
        release = (None if stage is None else stage.release) or ((0, 0), (model.schedule.end, 1))
        self.released = ReleasedForces(model.dimension, LoadCurve(release))
        self.round_off = (
            ROUND_OFF * float(self.points.elastic_moduli().young.max()) * largest_face(self.grid)
        )
        self.services.warnings.departures(model)
        self.contact_surfaces = [s for s in self.implicit if isinstance(s, ContactSurface)]
        touching = bool(self.contact_surfaces or self.body_contacts)
        self.is_forced = any(body.free.any() for body in self.bodies)
        self.has_friction = bool((shear_strength(self.points, model)[1] > 0.0).any())
        self.attempts = newton_attempts(model.analysis, self.round_off, touching)
        self.services.warnings.bounds(bound_domains(self.points, self.grid))

    @classmethod
    def restored(
        cls, model: Model, arrays: Arrays, initial: MaterialPoints | None = None
    ) -> Simulation:
        """Returns a simulation in the state that `arrays` stored.

        initial: as in the constructor.

        Raises:
            MissingState: they lack something that a step reads.
            WrongState: they are not of this model.
        """
        initial = initial_points(model) if initial is None else initial
        simulation = cls(model, restored_points(initial, arrays, model.stage.name != ""), initial)
        restore_all(simulation.owners(), arrays)
        if unknown := set(arrays) - set(simulation.arrays()):
            raise WrongState(f"{min(unknown)!r} belongs to nothing in it")
        return simulation

    def _acceleration(self, time: float) -> Floats:
        """Returns all body forces per mass [acceleration], shape (dim,)."""
        return self.loads.acceleration(time) + np.zeros(self.model.dimension)

    def _time_step(self, before: float, after: float) -> TimeStep | None:
        """Returns the step of the equations of motion, None if it has no inertia."""
        own = self.declared_dynamics
        return None if own is None else own.step(before, after)

    def distribute(self, comm: Communicator) -> None:
        """Leaves this process its part of the points; all processes have them all before.

        Raises:
            BadInput: there are too many processes, or PETSc is missing.
        """
        if comm.size > 1:
            self.distribution = Distribution(comm, self.points, self.grid, self._keyed)
            self.points = self.distribution.owned(self.points)
            self.services.distribute(self.model, comm)
            return_memory()
            self.distribution.own = self.distribution.own[self.distribution.own]

    def _keyed(self) -> list[KeyedRows]:
        """Returns the owners whose variables belong to nodes or cells."""
        return [each for each in self.owners().values() if isinstance(each, KeyedRows)]

    @property
    def comm(self) -> Communicator:
        """The processes of the run."""
        return self.distribution.comm

    @property
    def owned_points(self) -> MaterialPoints:
        """The points of this process without the copies of other processes' points."""
        return self.distribution.owned(self.points)

    @property
    def relaxes(self) -> bool:
        """Whether soil moves beyond a limit load."""
        return self.relaxation is not None and self.relaxation.active

    @property
    def dynamics(self) -> Dynamics | Relaxation | None:
        """The inertia that acts now; None in equilibrium."""
        return self.relaxation if self.relaxes else self.declared_dynamics

    @property
    def rigid_bodies(self) -> dict[str, RigidBodyState]:
        """Motion of the rigid bodies and forces on them, by their names."""
        return {body.name: body.result() for body in self.bodies}

    def undeformed(self) -> MaterialPoints:
        """Returns the points where they were declared; in a model without stages as they are."""
        if self._declared_position is None:
            return self.points
        changed = {
            "position": self._declared_position[self.points.point_id],
            "half_length": self.points.initial_half_length,
        }
        return MaterialPoints(
            **{**self.points.arrays(), **changed},  # type: ignore[arg-type]
            ranges=self.points.ranges,
            varying=self.points.varying,
        )

    def surface_shapes(self) -> tuple[SurfaceShape, ...]:
        """Returns the tracked surfaces of the bodies as they are now."""
        return tuple(surface.shape() for surface in self.surfaces.values())

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Returns all arrays that a later step reads: points and state variables of the owners."""
        arrays = dict(self.points.arrays())
        if self._declared_position is not None:
            arrays[DECLARED_POSITION] = self._declared_position[self.points.point_id]
        return arrays | state_of(self.owners())

    def owners(self) -> dict[str, Stateful]:
        """Returns the objects with variables that persist from step to step, except the points.

        The names are unique: boundaries and surfaces have numbers, not the names of the user.
        """
        owners: dict[str, Stateful] = {
            "ghost": self._ghost,
            "edge support": self._edge_support,
            "last step": self.predictor,
            "axis": self.axis,
        }
        if self.model.stage.releases:
            owners["released"] = self.released
        moving = self.declared_dynamics, self.relaxation, self.kept_contact, self.kept_ghost
        names = "dynamics", "relaxation", "contact force", "ghost force"
        named = zip(names, moving, strict=True)
        owners |= {name: each for name, each in named if each is not None}
        owners |= {f"boundary {number}": each for number, each in enumerate(self.implicit)}
        owners |= {f"rigid body {i}": each for i, each in enumerate(self.bodies)}
        owners |= {f"contact pair {i}": each for i, each in enumerate(self.body_contacts)}
        owners |= {f"surface {i}": each for i, each in enumerate(self.surfaces.values())}
        return owners | self.waves.owners()

    def go_on_from(self, last: Simulation, same_grid: bool) -> None:
        """Takes over from the last stage what persists besides points, boundaries and surfaces.

        same_grid: whether the background grid is that of the last stage.
        """
        self.services.go_on_from(last.services)
        if last.declared_dynamics is not None:
            self.waves.go_on_from(last.waves)
        if self.relaxation is not None and last.relaxation is not None:
            self.relaxation.number = last.relaxation.number
        if same_grid:
            self._ghost.restore(last._ghost.state())
            self._edge_support.restore(last._edge_support.state())
            if self.model.stage.declared is not None and self.model.stage.declared.materials:
                self._ghost.keep_forces()
            self.axis.restore(last.axis.state())

    def check(self, in_advance: bool = False) -> ActiveGrid:
        """Checks the conditions of the first step as `check_first_step`; returns its grid.

        Raises:
            BadInput: see `check_first_step`.
        """
        return check_first_step(self, in_advance)

    def soil_on(self, active: ActiveGrid, interval: Interval = INSTANT) -> Soil:
        """Returns the soil on the grid of a step that takes this time."""
        timers, own = self.services.timers, self.distribution.own
        return Soil(self.points, active, self.kind, timers, own, interval)

    def locate(self, time: float) -> ActiveGrid:
        """Locates the points on the grid of the step that begins at `time`; returns it.

        Raises:
            StepFailed: a point is outside the grid, or its domain extends over too many cells.
        """
        self.grid = self._grid_motion.at(time)
        if self.grid.graded and self._grid_motion.follows:  # smaller cells come to the points
            self.services.warnings.bounds(bound_domains(self.points, self.grid))
        self.points = self.distribution.arranged(self.points, self.grid)
        with together(self.comm):
            active = locate(
                self.points, self.grid, self.services.buffers, self.distribution.overlays
            )
        return self.distribution.located(active)

    def prepare(self, before: float, after: float) -> PreparedStep:
        """Locates the points and finds the conditions of the step from `before` to `after`.

        Raises:
            StepFailed: a point is outside the grid, or its domain extends over too many cells.
            BadInput: a boundary prescribes a radial displacement on the axis of symmetry.
        """
        with self.services.timers.measure("basis"):
            active = self.locate(before)
        time_step = self._time_step(before, after)
        for body in self.bodies:
            body.begin(after, time_step)
        implicit = self.implicit + (self.waves.surfaces() if time_step is None else [])
        with self.services.timers.measure("boundaries"):
            near = FoundSoil.find(
                implicit, self.points, active, before, self._touching, self.body_contacts
            )
            absorbing = self.waves.near(self.points, active, before) if time_step else []
            active = active.with_nodes(near.nodes(active, absorbing))
        with together(self.comm):
            declared = Conditions.gather(self.boundaries, active, before, after)
        on_axis = self.axis.constrain(active, declared, self.implicit, before)
        on_axis = replace(on_axis, conditions=on_axis.conditions.of_owners(active))
        with self.services.timers.measure("boundaries"):
            constraints = ImplicitConstraints.gather(
                implicit, self.points, active, self.kind, before, after,
                on_axis.conditions.constrained, near,
            )  # fmt: skip
        self.services.warnings.places(
            self.boundaries, on_axis.conditions, constraints, self.model.boundary_keys(), before
        )
        return PreparedStep(before, after, active, on_axis, constraints, absorbing)

    def advance(
        self,
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
        if self.dynamics is not None:
            self.dynamics.begin(self, before, after - before)
        step = self.prepare(before, after)
        interval = Interval(before, self.model.stage.start + before, after - before)
        soil = self.soil_on(step.active, interval)
        terms, drag = self.terms(step, soil), None
        creeps = is_short or (self.has_friction and step.driven > 0.0)
        if creeps and self.dynamics is None and self.relaxation is None:
            drag = Drag.of(soil)
            terms.insert(-1, drag)
        with self.services.timers.measure("basis"):  # for this includes the matrix's pattern
            balance = Balance(step.active, terms)
        self.services.observer.prepared(soil, balance, step.conditions.constrained)
        equilibrium = solve(self, step, soil, balance, on_iteration, drag=drag)
        displacement = equilibrium.displacement
        moved = soil.interpolate(displacement)
        try:
            checked, possible = require_acceptable(
                self, step, balance, displacement, moved, is_least
            )
        except StepFailed as failure:
            failure.residuals = equilibrium.residuals
            raise
        move_surfaces(self, balance.active, displacement, moved)
        with self.services.timers.measure("boundaries"):
            result = result_of(step, balance, equilibrium, self.kept_contact, self.kept_ghost)
        balance.commit(displacement, checked)
        self.waves.commit(before, after)
        for pair in self.body_contacts:
            pair.begin()
        self.predictor.commit(balance.active, displacement, after - before)
        warn(self, step, balance, equilibrium, moved)
        return replace(result, possible_size=possible)

    def terms(self, step: PreparedStep, soil: Soil, stiffening: float = 1.0) -> list[Term]:
        """Returns all terms of the balance of a step. New terms are added here.

        stiffening: factor of the moduli of points on a frozen geometry [-].
        """
        active, constraints = step.active, step.constraints
        before, after, constrained = step.before, step.after, step.conditions.constrained
        with self.services.timers.measure("boundaries"):
            boundaries = LinearForces(
                constraints.couplings(),
                constraints.carried_force,
                constraints.coupled_nodes(),
                lambda u: constraints.commit(constraints.after(u)),
                label="implicit boundaries",
            )
        with self.services.timers.measure("basis"):
            weight = None
            if self.has_friction:
                acceleration = self._acceleration(after)
                weight = unheld_weight(soil.points, self.model, acceleration, self.grid)
            ghost = LinearForces(
                self._ghost.couplings(soil, constrained, constraints.exterior_nodes(), weight),
                held=self._ghost.held_nodes(active, constrained),
                commit=lambda u: self._ghost.commit(active, u),
                role=Role.STABILISATION,
                label="ghost stabilisation",
            )
            axis = LinearForces(
                step.on_axis.couplings(),
                commit=lambda u: self.axis.commit(step.on_axis, active, u),
                label="axis of symmetry",
            )
            on_surfaces = SurfaceLoads(
                self._surface_loads, self.kind, self.surfaces, active, before, after
            )
        on_points = PointLoads(self.loads, soil, before, after)
        terms: list[Term] = [SoilForces(soil), boundaries, ghost, axis, on_points, on_surfaces]
        force = self.round_off / ROUND_OFF
        motion = self._time_step(before, after)
        still = stiffening != 1.0 or (motion is not None and motion.from_rest)
        terms += contact_terms(
            constraints.contacts, self.bodies, after, force, active.nodes,
            self.kept_contact.normal, still,
        )  # fmt: skip
        if self._ghost.of_weight or len(self._edge_support.face):
            terms.append(self._edge_support.term(active, self._ghost.of_weight, stiffening))
        if self.water is not None:
            terms.append(WaterForces(self.water, self.loads, soil, before, after))
        if self.model.stage.releases:
            terms.append(Release(self.released, active, before, after))
        if self.dynamics is not None:
            faces = self._ghost.faces
            terms += self.dynamics.terms(step, soil, self.water, faces, self.waves)
        held = union(active.nodes, (term.held_nodes() for term in terms))
        return [*terms, WeakSprings.of(soil, held)]
