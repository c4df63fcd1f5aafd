# SPDX-License-Identifier: BSD-3-Clause
"""The search for the factor of safety: which factor is tried next."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from tilth.errors import AnalysisFailed
from tilth.model import StrengthReduction
from tilth.output import safety_files

LARGER_STEP_AFTER = 2
"""Trials, without any failure yet, after which the factor grows twice as fast."""

SMALLER = 0.8
"""Ratio of the next factor where that before has no equilibrium, and no smaller one is known."""

MOST_UNDECIDED = 6
"""Undecided trials above the greatest equilibrium after which no collapse is sought any more."""

DIGITS = 9
"""Decimal places of factors."""


class Outcome(str, Enum):
    """What a trial showed.

    Its value is what files and reports call it. A deferred trial failed from an equilibrium so far
    below that it shows nothing: the factor is tried again from nearer, or another one decides.
    """

    EQUILIBRIUM = safety_files.EQUILIBRIUM
    COLLAPSE = safety_files.COLLAPSE
    UNDECIDED = safety_files.UNDECIDED
    DEFERRED = safety_files.DEFERRED


@dataclass(frozen=True)
class Trial:
    """A factor that was tried.

    Attributes:
        factor: of the strength [-].
        displacement: largest displacement of a point since the start [length], on the frozen
            geometry, in equilibrium or where the collapse was recognised; else "not a number".
        iterations: of Newton's method.
        outcome: what it showed.
        failure: why there is no equilibrium; "" if there is.
        crept: whether the soil crept to where it shows that.
    """

    factor: float
    displacement: float
    iterations: int
    outcome: Outcome
    failure: str = ""
    crept: bool = False

    @property
    def in_equilibrium(self) -> bool:
        """Whether the soil with this factor is in equilibrium."""
        return self.outcome is Outcome.EQUILIBRIUM


class Search:
    """Growing steps up to the first trial without equilibrium, then bisection.

    A collapse ends the search only if the trial began at an equilibrium within the tolerance below
    it, so that it cannot be put down to the size of the step; until then it is tried again. Where
    trials next to the greatest equilibrium remain undecided, the least factor with a collapse above
    them is sought.

    Attributes:
        stable: greatest factor with an equilibrium; None before there is one.
        trials: so far.
    """

    def __init__(self, settings: StrengthReduction) -> None:
        self._settings = settings
        self._step = settings.first_step
        self._near = settings.tolerance * (1.0 + 1e-9)
        self._confirmed: set[float] = set()
        self._wide = settings.tolerance
        self._creeps = False  # whether soil crept to an equilibrium: it may have to again
        self._next = math.nan
        self.stable: float | None = None
        self.trials: list[Trial] = []

    def _above(self, *outcomes: Outcome) -> list[float]:
        """Returns the factors above all equilibria whose last trial had one of these outcomes."""
        least = -math.inf if self.stable is None else self.stable
        last = {trial.factor: trial.outcome for trial in self.trials}
        if self._creeps:
            outcomes = tuple(each for each in outcomes if each is not Outcome.DEFERRED)
        return sorted(f for f, outcome in last.items() if f > least and outcome in outcomes)

    def _failed(self) -> list[float]:
        """Returns the factors above all equilibria where none was found."""
        return self._above(Outcome.COLLAPSE, Outcome.UNDECIDED, Outcome.DEFERRED)

    @property
    def above(self) -> float:
        """Least factor above `stable` with a collapse; infinite before there is one."""
        return min(self._above(Outcome.COLLAPSE), default=math.inf)

    @property
    def undecided(self) -> list[float]:
        """Factors of the bracket that are undecided, increasing."""
        return [each for each in self._above(Outcome.UNDECIDED) if each < self.above]

    @property
    def pursues(self) -> bool:
        """Whether the next trial is worth the motion of the soil, if Newton's method fails."""
        if self.stable is None or self._creeps or self.undecided:
            return True
        return self._next - self.stable <= self._near

    def next_factor(self) -> float | None:
        """Returns the factor to try, None if no other trial helps.

        Raises:
            AnalysisFailed: the factor of safety is below the least or above the greatest factor.
        """
        found = self._factor()
        self._next = math.nan if found is None else found
        return found

    def _factor(self) -> float | None:
        settings, stable = self._settings, self.stable
        failed = self._failed()
        if stable is None:
            return self._smaller(failed[0]) if failed else settings.start
        if not failed:
            if stable >= settings.maximum_factor:
                raise AnalysisFailed(
                    f"there is equilibrium up to the factor {settings.maximum_factor:g}, the "
                    "greatest one",
                    "give a greater maximum_factor, or look whether boundaries or elastic parts "
                    "hold all soil",
                )
            return min(round(stable + self._step, DIGITS), settings.maximum_factor)
        lowest = failed[0]
        if lowest - stable > self._near:
            return round(0.5 * (stable + lowest), DIGITS)
        if lowest in self._above(Outcome.DEFERRED):
            return lowest
        if lowest == self.above:
            return None if lowest in self._confirmed else lowest
        return self._towards_collapse()

    def _towards_collapse(self) -> float | None:
        """Returns a factor between the greatest undecided one and the least with a collapse."""
        undecided, above = self.undecided, self.above
        highest, greatest = undecided[-1], self._settings.maximum_factor
        if len(undecided) >= MOST_UNDECIDED or highest >= greatest:
            return None
        if math.isinf(above):
            self._wide *= 2.0
            return min(round(highest + self._wide, DIGITS), greatest)
        if above - highest > self._near:
            return round(0.5 * (highest + above), DIGITS)
        return None

    def _smaller(self, failed: float) -> float:
        least = self._settings.minimum_factor
        if failed <= least:
            raise AnalysisFailed(
                f"there is no equilibrium even at the factor {least:g}, the least one "
                f"({self.trials[-1].failure})",
                "the state is none of equilibrium: check the loads, or give a smaller "
                "minimum_factor",
            )
        next_one = max(round(SMALLER * failed, DIGITS), least)
        return max(next_one, 1.0) if failed > 1.0 else next_one

    def record(self, trial: Trial) -> None:
        """Takes note of the last trial.

        Raises:
            AnalysisFailed: it is undecided at a factor of at most 1, where soil that the run left
                in equilibrium has one; not if Davis' equivalent takes its place.
        """
        as_in_the_run = self._settings.davis is None
        if as_in_the_run and trial.outcome is Outcome.UNDECIDED and trial.factor <= 1.0:
            raise AnalysisFailed(
                f"the equilibrium at the factor {trial.factor:g} is not found again "
                f"({trial.failure}): this is no collapse, and no factor of safety follows",
                "let the soil come to rest in the run by a smaller analysis.tolerance or "
                'analysis.beyond_limit = "relax", or choose smaller cells',
            )
        growing, begun = not self._failed(), self.stable
        self.trials.append(trial)
        if trial.outcome is Outcome.COLLAPSE:
            if begun is not None and trial.factor - begun <= self._near:
                self._confirmed.add(trial.factor)
        elif trial.in_equilibrium:
            self.stable = trial.factor
            self._creeps = self._creeps or trial.crept
            if growing and begun is not None and len(self.trials) % LARGER_STEP_AFTER == 1:
                self._step *= 2.0
            elif not growing and not self._failed():  # they failed because the step was too large
                self._step = 2.0 * self._settings.tolerance
