# SPDX-License-Identifier: BSD-3-Clause
"""The soil of one state with reduced strengths: its equilibria and its collapses.

docs/theory/strength_reduction.md, docs/decisions/0041-failure-is-no-collapse.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tilth.algebra.field import DISPLACEMENT, MOMENTUM
from tilth.analysis.creep import creep
from tilth.analysis.mechanism import WIDTH, moving_cells
from tilth.analysis.observer import UNOBSERVED
from tilth.analysis.prepare import prepare, soil_on
from tilth.analysis.residual import Equations, Guess, Newton, Refinement
from tilth.analysis.safety_search import Outcome, Trial
from tilth.analysis.services import solver_for
from tilth.analysis.setup import ROUND_OFF, InStep
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium, solve_step
from tilth.analysis.step_terms import balance_of, terms_of
from tilth.arrays import Floats
from tilth.comm import together
from tilth.errors import BadInput, StepFailed
from tilth.grid.background import largest_face
from tilth.model import StrengthReduction
from tilth.mpm.frozen_points import FROZEN_STRAIN, FrozenPoints, mean_elastic_strain, thickness
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import PastFlow
from tilth.terms.drag import Drag
from tilth.terms.protocol import Changes, Role

TOLERANCE = 1e-6
"""Relative residual of an equilibrium, at most: that of the analysis if it is greater [-]."""


class Trials:
    """The soil with each strength, from the equilibrium next below.

    Args:
        simulation: in the state whose factor is searched for.
        time: of the schedule (of the stage) that the state belongs to.
        settings: of the search.
        on_iteration: is called with each iteration of Newton's method and its relative residual.

    Attributes:
        elastic_displacement: mean elastic strain times the soil's thickness [length].
        largest_displacement: beyond which connected soil has collapsed [length].
        tolerance: relative residual of an equilibrium [-].

    Raises:
        BadInput: the soil is without stress.
    """

    def __init__(
        self,
        simulation: Simulation,
        time: float,
        settings: StrengthReduction,
        on_iteration: Callable[[int, float], None],
    ) -> None:
        setup, state, services = simulation.setup, simulation.state, simulation.services
        model, self._comm = setup.model, state.comm
        own = state.owned_points
        strain = mean_elastic_strain(own, self._comm)
        if strain == 0.0:
            raise BadInput(
                "the soil is without stress: there is nothing that could fail",
                "run the analysis with its loads first",
            )
        self.elastic_displacement = strain * thickness(own, self._comm)
        self.largest_displacement = settings.displacement_ratio * self.elastic_displacement
        self._frozen = FrozenPoints(model, state.points, strain / FROZEN_STRAIN)
        self._setup, self._on_iteration = setup, on_iteration
        self._davis = settings.davis
        frozen = self._frozen.points
        solver = solver_for(model, len(frozen), self._comm, services.warnings)
        self._services = replace(services, solver=solver, observer=UNOBSERVED)
        self.tolerance = max(TOLERANCE, model.analysis.tolerance)
        young = self._comm.max(float(frozen.elastic_moduli().young.max()))
        self._newton = Newton(
            tolerance=self.tolerance,
            maximum_iterations=2 * model.analysis.maximum_iterations,
            line_search=True,
            round_off={MOMENTUM: ROUND_OFF * young * largest_face(state.grid)},
            refinement=Refinement.SETTLED,
        )
        stored = state.ghost.state()
        distribution = state.distribution.with_ranges(self._frozen.range)
        self._state = state = state.with_points(frozen, distribution)
        try:
            state.ghost.keep_forces()  # they are part of the equilibrium that the run has found
            step = prepare(setup, state, services, time, time)
            self._frozen.points = state.points
            self._soil = soil_on(step.active, setup, state, services)
            self._drag = Drag.of(self._soil)
            of = InStep(setup, state, step, self._soil, self._frozen.stiffening)
            terms = [*terms_of(of, services.timers), self._drag]
            self._balance = balance_of(of, terms, holds_others=True)
        finally:
            state.ghost.restore(stored)
        self._equations = Equations(self._balance)
        self._last: Equilibrium | None = None
        self._past: PastFlow | None = None
        self._iterations = 0

    def at(self, factor: float, pursues: bool) -> Trial:
        """Looks for the equilibrium with a factor, from that with the next one below.

        pursues: whether the soil is let go where Newton's iteration finds none.
        """
        self._soil.points = self._frozen.reduced(factor, self._davis)
        self._soil.past = self._past
        self._iterations = 0
        guess = None
        if self._last is not None:
            guess = Guess(self._last.x.of, self._last.x.globals)
        try:
            found = self._solve(self._newton, guess)
        except StepFailed as failure:
            if pursues:
                return self._let_go(factor, guess, failure)
            return self._trial(factor, Outcome.DEFERRED, reason=failure.reason)
        return self._judged(factor, found, crept=False)

    def _solve(self, newton: Newton, guess: Guess | None) -> Equilibrium:
        """Solves the balance as `solve_step`, and counts the iterations."""
        self._balance.restart(Changes.USUAL)
        try:
            found = solve_step(self._balance, self._services, newton, guess, self._on_iteration)
        except StepFailed as failure:
            self._iterations += max(len(failure.residuals) - 1, 0)
            raise
        self._iterations += found.iterations
        return found

    def _let_go(self, factor: float, guess: Guess | None, failure: StepFailed) -> Trial:
        """Lets the soil creep from the last equilibrium to the next one, or on."""
        if guess is None:
            guess = Guess({DISPLACEMENT: np.zeros_like(self._drag.before)})
        try:
            self._drag.stiffness = self._drag_stiffness(guess)
        except StepFailed:
            return self._trial(factor, Outcome.UNDECIDED, reason=failure.reason)
        moved = 0.0
        path = creep(self._solve, self._drag, self._newton, self._equations, guess, self._soil)
        for each in path:
            if each.at_rest or self._mechanism(each.found):
                return self._judged(factor, each.found, crept=True)
            moved = self._largest_of(each.found)
        reason = f"the soil does not come to rest ({failure.reason})"
        if moved > self.largest_displacement:
            reason += f", but none {WIDTH} cells wide moves as a whole"
        return self._trial(factor, Outcome.UNDECIDED, reason=reason, crept=True)

    def _drag_stiffness(self, guess: Guess) -> Floats:
        """Returns that of a pseudo-step of size 1 [force/length], shape (nodes,).

        All forces move the soil by the elastic displacement in it; shared out by volume.
        """
        with together(self._comm):
            residual = self._balance.evaluate(self._balance.at(guess.u, guess.of_globals))
        soil = residual.sum_of(Role.SOIL)
        owned, volume = self._soil.active.owned, self._soil.nodal_volume
        force = self._comm.sum(float(np.linalg.norm(soil[owned], axis=1).sum()))
        whole = self._comm.sum(float(volume[owned].sum()))
        stiffness = force * self._frozen.stiffening / self.elastic_displacement
        return np.asarray(volume * (stiffness / whole))

    def _judged(self, factor: float, found: Equilibrium, crept: bool) -> Trial:
        """Returns the trial that ends with an equilibrium, or where creeping soil is."""
        cells, moved = self._mechanism(found), self._largest_of(found)
        if cells:
            reason = (
                f"a mechanism of {cells} cells moves by more than {self.largest_displacement:.3g}"
            )
            return self._trial(factor, Outcome.COLLAPSE, moved, reason, crept)
        self._last, self._past = found, self._soil.past
        return self._trial(factor, Outcome.EQUILIBRIUM, moved, crept=crept)

    def _trial(
        self,
        factor: float,
        outcome: Outcome,
        moved: float = math.nan,
        reason: str = "",
        crept: bool = False,
    ) -> Trial:
        return Trial(factor, moved, self._iterations, outcome, reason, crept)

    def _mechanism(self, found: Equilibrium) -> int:
        """Returns the cells of the largest mechanism beyond the bound, see `moving_cells`."""
        own = self._state.distribution.own
        moved = np.linalg.norm(self._moved(found)[own], axis=1)
        return moving_cells(
            self._state.distribution.owned(self._frozen.points),
            moved > self.largest_displacement,
            self._state.grid,
            self._setup.kind == "axisymmetric",
            self._comm,
        )

    def _largest_of(self, found: Equilibrium) -> float:
        moved = np.linalg.norm(self._moved(found), axis=1)
        return self._comm.max(float(moved.max(initial=0.0)))

    def _moved(self, found: Equilibrium) -> Floats:
        """Returns the displacement of the points [length], shape (n, dim), as on the geometry."""
        return self._frozen.stiffening * self._soil.interpolate(found.displacement)

    def mechanism(self, factor: float) -> tuple[Floats, Floats]:
        """Returns displacement and plastic strain of the last equilibrium, that with a factor.

        Shape (n, dim) and (n,), of the points of all processes, in the order of the permanent
        numbers.
        """
        assert self._last is not None
        points: MaterialPoints = self._frozen.reduced(factor, self._davis)
        self._soil.points, self._soil.past = points, self._past
        with together(self._comm):
            self._soil.update(self._last.displacement)
        plastic = self._frozen.stiffening * self._soil.plastic_increment()
        own = self._state.distribution.own
        owned = [each[own] for each in (points.point_id, self._moved(self._last), plastic)]
        parts = zip(*self._comm.gathered(owned), strict=True)
        number, displacement, plastic = (np.concatenate(each) for each in parts)
        order = np.argsort(number)
        return displacement[order], plastic[order]
