# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety by strength reduction (docs/theory/strength_reduction.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.analysis.residual import Newton
from tilth.analysis.simulation import ROUND_OFF, Simulation
from tilth.analysis.step import Equilibrium, solve_step
from tilth.arrays import Floats
from tilth.comm import together
from tilth.errors import AnalysisFailed, BadInput, StepFailed
from tilth.model import StrengthReduction
from tilth.mpm.background import largest_face
from tilth.mpm.frozen_points import (
    FROZEN_STRAIN,
    FrozenPoints,
    mean_elastic_strain,
    require_reducible,
    thickness,
)
from tilth.mpm.points import MaterialPoints
from tilth.solvers import LinearSolver, PetscSolver, distributed_solver, linear_solver
from tilth.terms.balance import Balance

TOLERANCE = 1e-6
"""Relative residual of an equilibrium, at most: that of the analysis if it is greater [-]."""

LARGER_STEP_AFTER = 2
"""Trials, without any failure yet, after which the factor grows twice as fast."""

SMALLER = 0.8
"""Ratio of the next factor where that before has no equilibrium, and no smaller one is known."""

DIGITS = 9
"""Decimal places of factors."""


@dataclass(frozen=True)
class Trial:
    """A factor that was tried.

    Attributes:
        factor: of the strength [-].
        displacement: largest displacement of a point since the start [length], on the frozen
            geometry; "not a number" without a solution.
        iterations: of Newton's method.
        failure: why there is no equilibrium; "" if there is.
    """

    factor: float
    displacement: float
    iterations: int
    failure: str

    @property
    def in_equilibrium(self) -> bool:
        """Whether the soil with this factor is in equilibrium."""
        return not self.failure


@dataclass(frozen=True)
class SafetyResult:
    """The factor of safety.

    Attributes:
        factor: greatest factor with an equilibrium [-].
        above: least factor without one above it [-].
        trials: in the order in which they were made.
        elastic_displacement: mean elastic strain times the soil's thickness [length].
        largest_displacement: that still counts as equilibrium [length].
        displacement: of the points in the last equilibrium, since the start [length], on the frozen
            geometry, shape (n, dim), in the order of the points' permanent numbers.
        plastic_strain: equivalent plastic strain in it since the start [-], shape (n,).
    """

    factor: float
    above: float
    trials: tuple[Trial, ...]
    elastic_displacement: float
    largest_displacement: float
    displacement: Floats
    plastic_strain: Floats

    @property
    def iterations(self) -> int:
        """Iterations of Newton's method in all trials."""
        return sum(trial.iterations for trial in self.trials)

    @property
    def criterion(self) -> str:
        """What counts as no equilibrium, with its number."""
        ratio = self.largest_displacement / self.elastic_displacement
        return (
            "no equilibrium: Newton's method with line search fails from the equilibrium next "
            f"below, or a point moves by more than {self.largest_displacement:.3g} "
            f"({ratio:g} times the elastic displacement)"
        )


def strength_reduction(
    simulation: Simulation,
    time: float,
    settings: StrengthReduction | None = None,
    on_trial: Callable[[Trial], None] = lambda trial: None,
    on_iteration: Callable[[int, float], None] = lambda iteration, residual: None,
) -> SafetyResult:
    """Finds the factor of safety of a state in equilibrium; the state does not change.

    Args:
        simulation: in the state whose factor is searched for.
        time: of the schedule (of the stage) that the state belongs to; loads, boundaries and water
            are those at it.
        settings: of the search.
        on_trial: is called with each factor that was tried.
        on_iteration: is called with each iteration of Newton's method and its relative residual.

    Raises:
        BadInput: a material whose strength cannot be reduced, all elastic, or soil without stress.
        AnalysisFailed: no equilibrium with the least factor, or one with the greatest.
    """
    settings = settings or StrengthReduction()
    require_reducible(simulation.model)
    trials = _Trials(simulation, time, settings, on_iteration)
    search = _Search(settings)
    while (factor := search.next_factor()) is not None:
        trial = trials.at(factor)
        search.record(trial)
        on_trial(trial)
    assert search.stable is not None
    assert search.above is not None
    displacement, plastic_strain = trials.mechanism(search.stable)
    return SafetyResult(
        search.stable, search.above, tuple(search.trials), trials.elastic_displacement,
        trials.largest_displacement, displacement, plastic_strain,
    )  # fmt: skip


class _Search:
    """Which factor comes next: growing steps up to the first failure, then bisection.

    A failure counts only if the trial began at an equilibrium within the tolerance below it, so
    that it cannot be put down to the size of the step; until then it is tried again.

    Attributes:
        stable: greatest factor with an equilibrium; None before there is one.
        above: least factor without one above `stable`; None before there is one.
        trials: so far.
    """

    def __init__(self, settings: StrengthReduction) -> None:
        self._settings = settings
        self._step = settings.first_step
        self._confirmed = False
        self.stable: float | None = None
        self.above: float | None = None
        self.trials: list[Trial] = []

    def next_factor(self) -> float | None:
        """Returns the factor to try, None if the factor of safety is known.

        Raises:
            AnalysisFailed: it is below the least or above the greatest factor.
        """
        settings, stable, above = self._settings, self.stable, self.above
        if stable is None:
            return settings.start if above is None else self._smaller(above)
        if above is not None:
            if above - stable > settings.tolerance * (1.0 + 1e-9):
                return round(0.5 * (stable + above), DIGITS)
            return None if self._confirmed else above
        if stable >= settings.maximum_factor:
            raise AnalysisFailed(
                f"there is equilibrium up to the factor {settings.maximum_factor:g}, the greatest "
                "one",
                "give a greater maximum_factor, or look whether boundaries or elastic parts hold "
                "all soil",
            )
        return min(round(stable + self._step, DIGITS), settings.maximum_factor)

    def _smaller(self, failed: float) -> float:
        least = self._settings.minimum_factor
        if failed <= least:
            raise AnalysisFailed(
                f"there is no equilibrium even at the factor {least:g}, the least one "
                f"({self.trials[-1].failure})",
                "the state is none of equilibrium: check the loads, or give a smaller "
                "minimum_factor",
            )
        return max(round(SMALLER * failed, DIGITS), least)

    def record(self, trial: Trial) -> None:
        """Takes note of the last trial."""
        self.trials.append(trial)
        if not trial.in_equilibrium:
            self.above = trial.factor
            near = self._settings.tolerance * (1.0 + 1e-9)
            self._confirmed = self.stable is not None and trial.factor - self.stable <= near
            return
        if self.above is None:
            if len(self.trials) % LARGER_STEP_AFTER == 1 and self.stable is not None:
                self._step *= 2.0
        elif trial.factor >= self.above:  # the failure there was one of too large a step
            self.above, self._step = None, 2.0 * self._settings.tolerance
        self.stable = trial.factor


class _Trials:
    """The equilibria of one state with reduced strengths, each found from that next below."""

    def __init__(
        self,
        simulation: Simulation,
        time: float,
        settings: StrengthReduction,
        on_iteration: Callable[[int, float], None],
    ) -> None:
        points, analysis = simulation.points, simulation.model.analysis
        distribution, self._comm = simulation.distribution, simulation.comm
        own = distribution.owned(points)
        strain = mean_elastic_strain(own, self._comm)
        if strain == 0.0:
            raise BadInput(
                "the soil is without stress: there is nothing that could fail",
                "run the analysis with its loads first",
            )
        self.elastic_displacement = strain * thickness(own, self._comm)
        self.largest_displacement = settings.displacement_ratio * self.elastic_displacement
        self._frozen = FrozenPoints(simulation.model, points, strain / FROZEN_STRAIN)
        self._simulation, self._on_iteration = simulation, on_iteration
        frozen = self._frozen.points
        note = simulation.run_warnings.fallback
        self._solver: LinearSolver | PetscSolver = (
            linear_solver(analysis.solver, simulation.model.dimension, len(points), note)
            if distribution.serial
            else distributed_solver(analysis.solver, note)
        )
        self._newton = Newton(
            tolerance=max(TOLERANCE, analysis.tolerance),
            maximum_iterations=2 * analysis.maximum_iterations,
            line_search=True,
            round_off=ROUND_OFF * self._comm.max(float(frozen.elastic_moduli().young.max()))
            * largest_face(simulation.grid),
        )  # fmt: skip
        simulation.points = frozen
        simulation.distribution = distribution.with_ranges(self._frozen.range)
        try:
            step = simulation.prepare(time, time)
            self._frozen.points = simulation.points
            self._own = simulation.distribution.own
            self._soil = simulation.soil_on(step.active)
            self._balance = Balance(step.active, simulation.terms(step, self._soil))
        finally:
            simulation.points, simulation.distribution = points, distribution
        self._conditions = step.conditions
        self._last: Equilibrium | None = None

    def at(self, factor: float) -> Trial:
        """Looks for the equilibrium with a factor."""
        self._soil.points = self._frozen.reduced(factor)
        guess = None if self._last is None else self._last.displacement
        try:
            found = solve_step(
                self._balance, self._conditions, self._solver, self._newton,
                self._simulation.timers, guess, self._on_iteration,
            )  # fmt: skip
        except StepFailed as failure:
            return Trial(factor, float("nan"), len(failure.residuals), failure.reason)
        moved = self._comm.max(float(np.linalg.norm(self._moved(found), axis=1).max()))
        failure_reason = ""
        if moved > self.largest_displacement:
            failure_reason = "the displacement exceeds its bound"
        else:
            self._last = found
        return Trial(factor, moved, found.iterations, failure_reason)

    def _moved(self, found: Equilibrium) -> Floats:
        """Returns the displacement of the points [length], shape (n, dim), as on the geometry."""
        return self._frozen.stiffening * self._soil.interpolate(found.displacement)

    def mechanism(self, factor: float) -> tuple[Floats, Floats]:
        """Returns displacement and plastic strain of the last equilibrium, that with a factor.

        Shape (n, dim) and (n,), of the points of all processes, in the order of the permanent
        numbers.
        """
        assert self._last is not None
        points: MaterialPoints = self._frozen.reduced(factor)
        self._soil.points = points
        with together(self._comm):
            self._soil.update(self._last.displacement)
        plastic = self._frozen.stiffening * self._soil.plastic_increment()
        own = [each[self._own] for each in (points.point_id, self._moved(self._last), plastic)]
        parts = zip(*self._comm.gathered(own), strict=True)
        number, displacement, plastic = (np.concatenate(each) for each in parts)
        order = np.argsort(number)
        return displacement[order], plastic[order]
