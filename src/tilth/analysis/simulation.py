# SPDX-License-Identifier: BSD-3-Clause
"""A model made ready to compute: points, grid, boundaries and loads, advanced step by step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.analysis.predictor import Predictor
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.state import MissingState, Stateful, restore_all, state_of
from tilth.analysis.step import Equilibrium, Newton, solve_step
from tilth.arrays import Floats
from tilth.boundaries import Conditions, ImplicitConstraints, make_boundaries, make_implicit
from tilth.boundaries.agreement import require_agreement, turning_times
from tilth.boundaries.axis import Axis, OnAxis
from tilth.boundaries.axis_agreement import require_on_axis
from tilth.boundaries.implicit.passage import find_passage
from tilth.boundaries.together import require_no_rigid_motion
from tilth.errors import BadInput, StepFailed
from tilth.model import Model
from tilth.model.fields import AXES
from tilth.mpm.domains import bound_domains
from tilth.mpm.grid import ActiveGrid, Buffers, Grid, locate
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.output.snapshot import SurfaceShape
from tilth.solvers import linear_solver
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.surface.make import make_surfaces, require_near_soil
from tilth.terms.balance import Balance
from tilth.terms.ghost import Ghost
from tilth.terms.linear import LinearForces
from tilth.terms.loads import Loads
from tilth.terms.point_loads import PointLoads
from tilth.terms.protocol import Term, union
from tilth.terms.soil_forces import SoilForces
from tilth.terms.weak_springs import WeakSprings
from tilth.timers import Timers

ROUND_OFF = 1e-14
"""Residual forces below this share of Young's modulus times a cell's face count as zero."""

TRIES, FUTILE = 4, 0.95
"""Where so many shorter steps leave more than this part of the soil's depth behind a boundary, no
step is short enough."""


@dataclass(frozen=True)
class StepResult:
    """What is known after a converged step.

    Attributes:
        active: the grid of the step.
        equilibrium: nodal displacement and residuals; reaction of grid-line conditions.
        forces: nodal forces of each boundary on the soil [force], shape (nodes, dim), by name.
        work: work of loads and boundaries on the soil in the step [force length].
        time: at the end of the step.
    """

    active: ActiveGrid
    equilibrium: Equilibrium
    forces: dict[str, Floats]
    work: float
    time: float

    @property
    def reaction(self) -> Floats:
        """Nodal forces of all boundaries on the soil [force], shape (nodes, dim)."""
        return np.asarray(np.sum(list(self.forces.values()), axis=0))

    def resultant(self, name: str) -> Floats:
        """Returns the force of a boundary on the soil [force], shape (dim,)."""
        return np.asarray(self.forces[name].sum(axis=0))

    def moment(self, name: str, about: Floats) -> Floats:
        """Returns the moment of that force about a place [force length], shape (3,)."""
        arm = self.active.position + self.equilibrium.displacement - about
        three = ((0, 0), (0, 3 - arm.shape[1]))
        return np.asarray(
            np.cross(np.pad(arm, three), np.pad(self.forces[name], three)).sum(axis=0)
        )


class Simulation:
    """The state of an analysis in memory.

    Args:
        model: the declared problem.
        points: points to go on with (from a checkpoint); made from the bodies if None.

    Attributes:
        points: the material points, changed by `advance`.
        surfaces: tracked surfaces, by the bodies' names.
        timers: time spent in basis, stress, assembly, solve and rest.
        run_warnings: what is probably not meant.

    Raises:
        BadInput: a body without points, conditions that leave a rigid motion or contradict.
    """

    def __init__(self, model: Model, points: MaterialPoints | None = None) -> None:
        self.model = model
        self.timers = Timers()
        self.run_warnings = RunWarnings()
        self.kind = model.analysis.kind
        limits = model.grid.limits
        self.grid = Grid(
            origin=np.array(model.origin, dtype=float),
            cell_size=np.array(model.cell_size, dtype=float),
            lower=None if limits is None else np.array(limits.lower, dtype=float),
            upper=None if limits is None else np.array(limits.upper, dtype=float),
        )
        self.boundaries = make_boundaries(model)
        self.implicit = make_implicit(model)
        self.grid = self._grid_at(0.0)
        initial = initial_points(model)
        self._solver = linear_solver(
            model.analysis.solver, model.dimension, len(initial), self.run_warnings.fallback
        )
        self.loads = Loads(model, initial)
        self.axis = Axis(model, initial)
        self.points = initial if points is None else points
        self.soil = Soil(self.points, self.kind, self.timers)
        self.surfaces = make_surfaces(model, initial)
        self._surface_loads = declared_loads(model)
        self._ghost = Ghost(model.analysis.ghost_stabilisation, model.dimension)
        self._passage = (math.nan, math.inf, 0)  # start of the step shortened last, depth, tries
        self._predictor = Predictor(model.dimension)
        self._buffers = Buffers()
        plain = Newton(
            tolerance=model.analysis.tolerance,
            maximum_iterations=model.analysis.maximum_iterations,
            line_search=model.analysis.line_search or False,
            round_off=ROUND_OFF
            * float(self.points.elastic_moduli().young.max())
            * float(np.prod(self.grid.cell_size) / self.grid.cell_size.max()),
        )
        patient = replace(plain, line_search=True, maximum_iterations=2 * plain.maximum_iterations)
        self.run_warnings.departures(model, self.grid.cell_size)
        self._attempts = [plain, patient] if model.analysis.line_search is None else [plain]
        self.run_warnings.bounds(bound_domains(self.points, self.grid))

    @classmethod
    def restored(cls, model: Model, arrays: dict[str, npt.NDArray[Any]]) -> Simulation:
        """Returns a simulation in the state that `arrays` stored.

        Raises:
            MissingState: they lack something that a step reads.
        """
        names = MaterialPoints.array_names()
        missing = [name for name in names if name not in arrays]
        if missing:
            raise MissingState(missing[0])
        state = {name: arrays[name] for name in names}
        simulation = cls(model, MaterialPoints(bodies=initial_points(model).bodies, **state))
        restore_all(simulation._owners(), arrays)
        return simulation

    @property
    def warnings(self) -> list[str]:
        """Texts not yet reported; the caller empties the list."""
        return self.run_warnings.texts

    @property
    def solved(self) -> str:
        """How many linear systems were solved by what."""
        return self._solver.summary

    def surface_shapes(self) -> tuple[SurfaceShape, ...]:
        """Returns the tracked surfaces of the bodies as they are now."""
        return tuple(surface.shape() for surface in self.surfaces.values())

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Returns all arrays that a later step reads: points, and what else remembers."""
        return dict(self.points.arrays()) | state_of(self._owners())

    def _owners(self) -> dict[str, Stateful]:
        """Returns all that remembers from step to step, but for the points, by a name of its own.

        Numbers for names of the user's, so that none of these is like another.
        """
        owners: dict[str, Stateful] = {
            "ghost": self._ghost,
            "last step": self._predictor,
            "axis": self.axis,
        }
        owners |= {f"boundary {number}": each for number, each in enumerate(self.implicit)}
        owners |= {f"surface {i}": each for i, each in enumerate(self.surfaces.values())}
        return owners

    def check(self) -> ActiveGrid:
        """Locates the points and checks the conditions of the first step; returns the grid.

        Raises:
            BadInput: contradicting conditions, or a rigid motion that none of them holds.
        """
        try:
            active = locate(self.points, self.grid, self._buffers)
        except StepFailed as failure:
            raise BadInput(
                f"{failure.reason} before the first step (point {failure.point})",
                "move the body, or widen grid.limits",
                key="bodies",
            ) from failure
        first = self.model.schedule.regular_time(1)
        conditions = self._conditions(active, 0.0, first).conditions
        constraints = self._constraints(active, conditions.held, 0.0, first)
        for boundary in self.implicit:
            boundary.require_soil(self.points.position)
        times = turning_times(self.model)
        require_agreement(self.boundaries, constraints, times, self.model.boundary_keys())
        require_on_axis(self.axis, self.boundaries, self.implicit, active, times)
        require_no_rigid_motion(active, self.kind, conditions.held, constraints)
        require_near_soil(self.model, self.surfaces, active)
        self.run_warnings.places(conditions, constraints)
        return active

    def _conditions(self, active: ActiveGrid, before: float, after: float) -> OnAxis:
        """Returns the conditions on nodes, and what else holds the soil on the axis."""
        declared = Conditions.gather(self.boundaries, active, before, after)
        return self.axis.hold(active, declared)

    def _constraints(
        self, active: ActiveGrid, held: npt.NDArray[np.bool_], before: float, after: float
    ) -> ImplicitConstraints:
        with self.timers.measure("boundaries"):
            return ImplicitConstraints.gather(
                self.implicit, self.points, active, self.kind, before, after, held
            )

    def advance(
        self,
        before: float,
        after: float,
        on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
        is_least: bool = False,
    ) -> StepResult:
        """Takes the step from time `before` to `after`; changes the state only if it converges.

        is_least: whether the step cannot be shortened: soil that passes through a boundary then is
            warned of only.

        Raises:
            StepFailed: no equilibrium, an inverted point, a point that left the grid, soil that
                passes through an implicit boundary.
        """
        self.grid = self._grid_at(before)
        with self.timers.measure("basis"):
            active = locate(self.points, self.grid, self._buffers)
        on_axis = self._conditions(active, before, after)
        conditions = on_axis.conditions
        constraints = self._constraints(active, conditions.held, before, after)
        self.run_warnings.places(conditions, constraints)
        terms = self._gather(active, on_axis, constraints, before, after)
        with self.timers.measure("basis"):  # for this includes the matrix's pattern
            balance = Balance(active, terms)
            active = balance.active
        guess = None
        if self.model.analysis.predictor:
            guess = self._predictor.guess(self.soil, active, after - before)
        for newton in self._attempts:
            try:
                equilibrium = solve_step(
                    balance, conditions, self._solver, newton, self.timers, guess, on_iteration
                )
                break
            except StepFailed as failure:
                if newton is self._attempts[-1]:
                    raise
                guess = None
                self.run_warnings.line_search(failure.reason, after)
        moved = self.soil.interpolate(active, equilibrium.displacement)
        self._require_inside(moved, equilibrium)
        if not is_least:
            self._require_in_front(moved, equilibrium, before, after)
        corners = self._moved_corners(active, equilibrium)
        self._move_surfaces(active, equilibrium, moved)
        self._ghost.commit(active, equilibrium.displacement)
        self.soil.advance(active, equilibrium.displacement, corners)
        self._predictor.commit(active, equilibrium.displacement, after - before)
        self.run_warnings.bounds(bound_domains(self.points, self.grid))
        with self.timers.measure("boundaries"):
            carried = constraints.after(equilibrium.displacement)
            forces = conditions.forces(equilibrium.reaction) | constraints.forces(carried)
            reaction_before = constraints.reaction_before(
                equilibrium.initial_reaction, conditions.held, balance.constant_force()
            )
            constraints.commit(carried)
            self.run_warnings.depths(self.implicit, self.points, after, self.grid.cell_size)
            if np.array_equal(balance.load_before, equilibrium.load):
                driven = np.abs(conditions.increment).max(initial=constraints.largest_increment())
                self.run_warnings.jump(
                    moved, float(driven), self.points, self.grid.cell_size, after
                )
            self.axis.commit(on_axis, active, equilibrium.displacement)
        result = StepResult(active, equilibrium, forces, 0.0, after)
        twice = balance.load_before + equilibrium.load + reaction_before + result.reaction
        return replace(result, work=0.5 * float((twice * equilibrium.displacement).sum()))

    def _gather(
        self,
        active: ActiveGrid,
        on_axis: OnAxis,
        constraints: ImplicitConstraints,
        before: float,
        after: float,
    ) -> list[Term]:
        """Returns all forces of the step from time `before` to `after`."""
        held = on_axis.conditions.held
        with self.timers.measure("boundaries"):
            boundaries = LinearForces(
                constraints.couplings(), constraints.carried_force, constraints.reached()
            )
        with self.timers.measure("basis"):
            ghost = LinearForces(
                self._ghost.couplings(self.soil, active, held, constraints.behind()),
                supported=self._ghost.holds(active, held),
            )
            terms = [
                SoilForces(self.soil),
                boundaries,
                ghost,
                LinearForces(on_axis.couplings()),
                PointLoads(self.loads, self.soil, active, before, after),
                SurfaceLoads(self._surface_loads, self.kind, self.surfaces, active, before, after),
            ]
            supported = union(active.nodes, (term.supported_nodes() for term in terms))
            return [*terms, WeakSprings.of(self.soil, active, supported)]

    def _grid_at(self, time: float) -> Grid:
        """Returns the grid of the step that begins at `time`: it may follow a boundary."""
        follow = self.model.grid.follow
        if follow is None:
            return self.grid
        boundary = next(b for b in self.implicit if b.name == follow.boundary)
        place = boundary.motion.place(np.array([follow.place]), boundary.factor(time))[0]
        axes = [AXES.index(axis) for axis in follow.axes]
        origin = self.grid.origin.copy()
        origin[axes] = place[axes]
        return replace(self.grid, origin=origin)

    def _move_surfaces(
        self, active: ActiveGrid, equilibrium: Equilibrium, moved_by: Floats
    ) -> None:
        """Moves tracked surfaces with the grid; moved_by: of the points in the step, (n, dim)."""
        surfaces = list(self.surfaces.values())
        if not surfaces:
            return
        displacement = equilibrium.displacement
        position = self.points.position + moved_by
        moved = [surface.moved(active, displacement, self.points, position) for surface in surfaces]
        for surface, (state, warning) in zip(surfaces, moved, strict=True):
            surface.commit(state)
            if warning:
                self.run_warnings.note(f"crossing of {surface.name}", warning)

    def _require_inside(self, moved: Floats, equilibrium: Equilibrium) -> None:
        """Checks that no point leaves the limits of the grid; moved: in the step, (points, dim)."""
        if self.grid.lower is None:
            return
        outside = self.grid.first_point_outside(self.points.position + moved)
        if outside is not None:
            raise StepFailed(
                "a point left the limits of the grid",
                point=int(self.points.point_id[outside]),
                residuals=equilibrium.residuals,
            )

    def _require_in_front(
        self, moved: Floats, equilibrium: Equilibrium, before: float, after: float
    ) -> None:
        """Checks that no soil that was free passes through an implicit boundary."""
        if not self.implicit:
            return
        with self.timers.measure("boundaries"):
            place = self.points.position + moved
            found = [
                find_passage(boundary, self.points, place, before, after, self.grid.cell_size)
                for boundary in self.implicit
            ]
        passed = [passage for passage in found if passage is not None]
        if not passed:
            return
        passage = min(passed, key=lambda each: each.share)
        start, depth, tries = self._passage
        tries = tries + 1 if start == before else 0
        self._passage = (before, passage.depth, tries)
        if tries >= TRIES and passage.depth > FUTILE * depth:
            return  # the soil jumps however short the step is
        raise StepFailed(
            f"soil reaches the boundary {passage.boundary!r} within the step and would end "
            f"{passage.depth:.3g} behind it",
            point=int(self.points.point_id[passage.point]),
            residuals=equilibrium.residuals,
            share=passage.share,
        )

    def _moved_corners(
        self, active: ActiveGrid, equilibrium: Equilibrium
    ) -> dict[int, tuple[Floats, Floats]]:
        try:
            with self.timers.measure("rest"):
                return self.soil.moved_corners(active, equilibrium.displacement)
        except StepFailed as failure:
            failure.residuals = equilibrium.residuals
            raise
