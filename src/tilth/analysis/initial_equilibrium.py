# SPDX-License-Identifier: BSD-3-Clause
"""Equilibrium of the starting state, found before the first step (docs/theory/initial_stress.md).

Newton's iteration finds the stress that balances the loads and boundaries at the start. Then the
soil is put back to where it was and keeps this stress. Its forces change with the strain of this
motion only, so the residual falls by a factor of the order of the strain each time; this is
repeated until the stressed soil is in equilibrium where it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from tilth.algebra.field import DISPLACEMENT, MOMENTUM
from tilth.analysis.attempts import solve
from tilth.analysis.residual import ITERATIONS_BEFORE_ROUND_OFF, Equations, Iterate, Newton
from tilth.analysis.simulation import Simulation
from tilth.analysis.state import State
from tilth.analysis.step import Equilibrium, reactions_at
from tilth.analysis.step_result import PreparedStep, StepResult, result_of
from tilth.arrays import Floats
from tilth.boundaries.contact.rigid_body import RigidBody
from tilth.comm import together
from tilth.errors import AnalysisFailed, BadInput, StepFailed
from tilth.model import Model
from tilth.model.initial import GravityStress
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.initial_stress import require_within_yield
from tilth.mpm.pattern import Elements
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Term
from tilth.terms.space import Space
from tilth.variation.tables import place_text

RESIDUAL = 1e-8
"""Residual of the undisplaced soil relative to the forces, at most [-]."""

NEWTON_RESIDUAL = 1e-9
"""Residual that Newton's iteration leaves, at most [-]."""

LEAST_PART = 1.0 / 1024.0
"""Least part of the unbalanced force that is applied at once [-]."""

MOST_CORRECTIONS = 100
"""Returns to the undisplaced soil, at most."""

_KEPT = (
    "position", "displacement", "last_displacement", "last_gradient", "deformation_gradient",
    "assumed_jacobian", "half_length", "corner",
)  # fmt: skip
"""Arrays of the points that describe where the soil is."""


@dataclass(frozen=True)
class InitialEquilibrium:
    """What was done to find the equilibrium of the starting state.

    Attributes:
        iterations: linear solves in all.
        parts: parts in which the unbalanced force was applied.
        corrections: how often the soil was put back and balanced again.
        residual_before, residual_after: relative residuals of the undisplaced soil [-].
        change: largest change of a component of the stress [stress].
        largest: largest component of the stress afterwards [stress].
        place: of the point with this change [length], shape (dim,).
        result: forces at the start, without displacement.
    """

    iterations: int
    parts: int
    corrections: int
    residual_before: float
    residual_after: float
    change: float
    largest: float
    place: Floats
    result: StepResult

    def text(self, unit: str) -> str:
        """Returns the report as a sentence; unit: label of stresses."""
        if self.iterations == 0:
            return f"in equilibrium as declared: relative residual {self.residual_after:.1e}"
        parts = f"{self.iterations} iterations" + (f", {self.parts} parts" * (self.parts > 1))
        share = f" ({self.change / self.largest:.2g} of the largest)" if self.largest > 0.0 else ""
        return (
            f"equilibrium found in {parts}: relative residual {self.residual_before:.1e} before, "
            f"{self.residual_after:.1e} after; the stress changed by at most {self.change:.4g} "
            f"{unit}{share}, at {place_text(self.place)}"
        )


def has_initial_equilibrium(model: Model) -> bool:
    """Returns whether equilibrium is found before the first step."""
    return bool(model.initial.stress) and model.initial.equilibrium


def find_initial_equilibrium(
    simulation: Simulation,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
) -> InitialEquilibrium:
    """Finds the stress in equilibrium with the loads and boundaries at time 0; moves no point.

    With gravity loading, and where one step has no equilibrium, the unbalanced force is applied in
    parts.

    on_iteration: is called with the number of each Newton iteration and its relative residual.

    Raises:
        AnalysisFailed: there is no equilibrium.
        BadInput: without its plastic strain a stress lies outside the yield surface, or code of
            the user fails.
    """
    model, comm = simulation.setup.model, simulation.state.comm
    own = simulation.state.distribution.owned(simulation.state.points)
    number, before = np.sort(own.point_id), own.stress[own.in_order]
    gravity = [each.steps for each in model.initial.stress if isinstance(each, GravityStress)]
    search = _Search(simulation, max(gravity, default=1), on_iteration)
    try:
        result, residual = search.run()
    except BadInput as error:  # code of the user that fails
        raise error.during("in the search for the equilibrium of the starting state") from error
    points = simulation.state.points
    if model.initial.reset_plastic_strain:
        points.plastic[:] = 0.0
        with together(comm):
            for range_ in points.ranges:
                require_within_yield(points.part(range_), "initial.reset_plastic_strain")
    own = simulation.state.distribution.owned(points)
    order = own.in_order
    assert np.array_equal(own.point_id[order], number), "points that do not move changed process"
    change = np.abs(own.stress[order] - before).max(axis=1)
    mine = None  # largest change, number of its point and place
    if len(change):
        worst = int(change.argmax())
        mine = float(change[worst]), int(number[worst]), own.position[order[worst]].copy()
    changes = [each for each in comm.gathered(mine) if each is not None]
    most, _, place = min(changes, key=lambda each: (-each[0], each[1]))
    return InitialEquilibrium(
        iterations=search.iterations,
        parts=search.parts,
        corrections=search.corrections,
        residual_before=search.first_residual,
        residual_after=residual,
        change=most,
        largest=comm.max(float(np.abs(own.stress).max(initial=0.0))),
        place=place,
        result=result,
    )


class _Withheld(Term, DisplacementTerm):
    """The part of the unbalanced force that is not applied yet.

    Attributes:
        withheld: internal minus external force [force], shape (nodes, dim).
    """

    def __init__(self, active: ActiveGrid) -> None:
        self.withheld: Floats = np.zeros((active.nodes, active.grid.dim))

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return self

    def force(self, displacement: Floats) -> Floats:
        return -self.withheld

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """It does not depend on the displacement."""


class _Search:
    """The search for equilibrium of a simulation.

    Attributes:
        iterations, parts, corrections, first_residual: as in `InitialEquilibrium`.
    """

    def __init__(
        self, simulation: Simulation, parts: int, on_iteration: Callable[[int, float], None]
    ) -> None:
        self._simulation, self._on_iteration = simulation, on_iteration
        self._regular_size = self._size = 1.0 / parts
        self._left = 1.0  # of the unbalanced force
        self._successes = 0
        self.iterations = self.parts = self.corrections = 0
        self.first_residual = 0.0
        self._last_residual = np.inf
        self._is_down = False  # whether bodies have come down on the soil
        self._flying: list[RigidBody] = []

    def run(self) -> tuple[StepResult, float]:
        """Finds equilibrium; returns the forces and the residual of the undisplaced soil."""
        try:
            self._flying = self._flying_bodies()
            return self._equilibrium()
        finally:
            self._flying = []
            self._load_bodies(1.0)

    def _equilibrium(self) -> tuple[StepResult, float]:
        simulation = self._simulation
        first = True
        while True:
            self._load_bodies(1.0)
            step = simulation.prepare(0.0, 0.0)
            soil = simulation.soil_on(step.active)
            withheld = _Withheld(step.active)
            balance = simulation.balance(step, soil, [withheld])
            if not self._is_down:
                self._is_down = True
                if balance.come_down():
                    continue
            constrained = step.conditions.constrained
            equations = Equations(balance)
            zero = np.zeros_like(step.conditions.increment)
            try:
                now = equations.at(balance.at(zero))
            except StepFailed as failure:
                raise self._failed(failure) from failure
            if first:
                self.first_residual, first = now.relative, False
            if self._settled(equations, now):
                return _result_at_rest(simulation.state, step, balance, now), now.relative
            share = self._share()
            unbalanced = np.where(constrained, 0.0, now.residual.u)
            withheld.withheld = (1.0 - share) * unbalanced
            try:
                self._load_bodies(1.0 - (1.0 - share) * self._left)
                self._advance(step, soil, balance)
            except StepFailed as failure:
                self._cut(failure)
                continue
            self._accept(share, equations, now)

    def _load_bodies(self, share: float) -> None:
        """Lets a share of the forces on the rigid bodies act, but for those that move freely."""
        for body in self._simulation.state.bodies:
            body.load_share = 0.0 if body in self._flying else share

    def _flying_bodies(self) -> list[RigidBody]:
        """Returns the bodies with inertia that begin with a velocity or off the soil."""
        simulation = self._simulation
        if simulation.state.declared_dynamics is None:
            return []
        contacts = simulation.prepare(0.0, 0.0).constraints.contacts
        return [
            body
            for body in simulation.state.bodies
            if body.free.any()
            and (body.is_moving or not any(c.touches for c in contacts if c.boundary.body is body))
        ]

    def _settled(self, equations: Equations, now: Iterate) -> bool:
        simulation, last = self._simulation, self._last_residual
        loaded = simulation.state.comm.max(float(now.residual.load.any())) > 0.0
        if self._left == 1.0 and self._size < 1.0 and loaded:
            return now.relative == 0.0  # gravity loading has not begun
        self._last_residual = now.relative
        wanted = min(RESIDUAL, simulation.setup.model.analysis.tolerance)
        if now.relative > 0.5 * last and self._left == 0.0:
            wanted = RESIDUAL  # it does not become less
        late = ITERATIONS_BEFORE_ROUND_OFF if self.parts else 0
        newton = Newton(wanted, 0, False, {MOMENTUM: simulation.setup.round_off})
        return equations.balanced(now, newton, late)

    def _share(self) -> float:
        """Returns the part of the force still unbalanced that is applied next."""
        return 1.0 if self._left <= self._size * (1.0 + 1e-9) else self._size / self._left

    def _advance(self, step: PreparedStep, soil: Soil, balance: Balance) -> None:
        """Finds equilibrium with the applied part, then puts soil and rigid bodies back.

        What springs hold of a body stays where it has come to.
        """
        simulation = self._simulation
        equilibrium = solve(
            simulation.setup.with_tolerance(NEWTON_RESIDUAL), simulation.state,
            simulation.services, step, soil, balance, self._on_iteration,
        )  # fmt: skip
        self.iterations += equilibrium.iterations
        with together(simulation.state.comm):
            checked = balance.check(equilibrium.x)
        points = simulation.state.points
        kept = {name: getattr(points, name).copy() for name in _KEPT}
        if self._left == 0.0:
            kept["elastic_share"] = points.elastic_share.copy()
        places = [body.place_now() for body in simulation.state.bodies]
        balance.commit(equilibrium.x, checked)
        put_back(points, kept)
        for body, place in zip(simulation.state.bodies, places, strict=True):
            body.put_back(place)

    def _accept(self, share: float, equations: Equations, before: Iterate) -> None:
        if self._left == 0.0:
            self.corrections += 1
            if self.corrections > MOST_CORRECTIONS:
                point = equations.worst_point(before)
                reason = f"the residual of the undisplaced soil stays at {before.relative:.1e}"
                raise self._failed(StepFailed(reason, point=point))
        else:
            self.parts += 1
        self._left = 0.0 if share == 1.0 else self._left - self._size
        self._successes += 1
        if self._successes >= 2 and self._size < self._regular_size:
            self._size, self._successes = min(2.0 * self._size, self._regular_size), 0

    def _cut(self, failure: StepFailed) -> None:
        self._size *= 0.5
        self._successes = 0
        if self._size < LEAST_PART * self._regular_size or self._left == 0.0:
            raise self._failed(failure) from failure

    def _failed(self, failure: StepFailed) -> AnalysisFailed:
        where = ""
        if failure.point is not None:
            simulation = self._simulation
            place = simulation.state.distribution.place(simulation.state.points, failure.point)
            where = f", at the point {failure.point} at {place_text(place)}"
        loaded = [each.name for each in self._simulation.state.bodies if each.is_loaded(0.0)]
        loose = ""
        if loaded:
            loose = (
                f"; the weight of the free rigid body {loaded[0]!r} and the forces on it at time 0 "
                "are in the search as well: the soil must bear them in each free component"
            )
        applied = "" if self._left == 0.0 else f", with {1.0 - self._left:.1%} of it applied"
        return AnalysisFailed(
            "the starting state has no equilibrium with the loads and boundaries at time 0: "
            f"{failure.reason}{where}{applied}",
            "check strength and boundaries there, and that what the stress has to balance acts at "
            f"time 0 (factor = [[0, 1], [1, 1]]){loose}; initial.equilibrium = false starts "
            "without the search, from the stress as declared",
        )


def _result_at_rest(state: State, step: PreparedStep, balance: Balance, now: Iterate) -> StepResult:
    """Returns the forces on soil that does not move, from its state without displacement."""
    reactions = reactions_at(balance, now)
    reaction = reactions[DISPLACEMENT]
    still = Equilibrium(now.x, now.residual.load, reactions, reaction, [now.relative])
    return result_of(step, balance, still, state.kept_contact, state.kept_ghost)


def forces_at_rest(simulation: Simulation) -> StepResult:
    """Returns the forces at time 0 of a stage, without displacement.

    Raises:
        StepFailed: they cannot be computed.
    """
    step = simulation.prepare(0.0, 0.0)
    balance = simulation.balance(step, simulation.soil_on(step.active))
    zero = np.zeros_like(step.conditions.increment)
    now = Equations(balance).at(balance.at(zero))
    return _result_at_rest(simulation.state, step, balance, now)


def put_back(points: MaterialPoints, kept: dict[str, Floats]) -> None:
    """Puts points back to where they were; they keep their elastic deformation.

    The Kirchhoff stress follows from this deformation; the Cauchy stress is over the volume ratio.

    kept: arrays of the points, in their present order, that hold where the soil was.
    """
    kirchhoff = points.stress * points.stress_jacobian[:, None]
    for name, array in kept.items():
        getattr(points, name)[:] = array
    points.stress[:] = kirchhoff / points.stress_jacobian[:, None]
