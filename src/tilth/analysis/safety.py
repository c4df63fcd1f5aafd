# SPDX-License-Identifier: BSD-3-Clause
"""The factor of safety by strength reduction (docs/theory/strength_reduction.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from tilth.analysis.mechanism import WIDTH
from tilth.analysis.safety_search import Search, Trial
from tilth.analysis.safety_trials import Trials
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import StrengthReduction
from tilth.model.davis import DavisForm
from tilth.mpm.frozen_points import require_reducible
from tilth.output.safety_files import bracket_text, whose_text


@dataclass(frozen=True)
class SafetyResult:
    """The factor of safety, between an equilibrium and a collapse.

    Attributes:
        factor: greatest factor with an equilibrium [-].
        above: least factor with a collapse above it [-]; infinite if none was found.
        tolerance: greatest difference of the two that was asked for [-].
        undecided: factors between them that showed neither of the two, increasing [-].
        trials: in the order in which they were made.
        elastic_displacement: mean elastic strain times the soil's thickness [length].
        largest_displacement: beyond which connected soil has collapsed [length].
        residual: relative residual of an equilibrium, at most [-].
        displacement: of the points in the last equilibrium, since the start [length], on the frozen
            geometry, shape (n, dim), in the order of the points' permanent numbers.
        plastic_strain: equivalent plastic strain in it since the start [-], shape (n,).
        davis: form of Davis' associated equivalent whose factor it is; None of the soil itself.
    """

    factor: float
    above: float
    tolerance: float
    undecided: tuple[float, ...]
    trials: tuple[Trial, ...]
    elastic_displacement: float
    largest_displacement: float
    residual: float
    displacement: Floats
    plastic_strain: Floats
    davis: DavisForm | None = None

    @property
    def is_decided(self) -> bool:
        """Whether the two factors are as close to each other as was asked for."""
        return self.above - self.factor <= self.tolerance * (1.0 + 1e-9)

    @property
    def text(self) -> str:
        """The factor, or what is certain of one that is undecided, in words."""
        whose = whose_text(self.davis)
        if self.is_decided:
            return f"factor of safety {self.factor:.4g} (collapse from {self.above:.4g} on){whose}"
        above = None if math.isinf(self.above) else self.above
        certain = bracket_text(self.factor, above, self.undecided)
        return f"factor of safety undecided{whose}: {certain}"

    @property
    def iterations(self) -> int:
        """Iterations of Newton's method in all trials."""
        return sum(trial.iterations for trial in self.trials)

    @property
    def criterion(self) -> str:
        """What counts as equilibrium and as collapse, with its numbers."""
        ratio = self.largest_displacement / self.elastic_displacement
        return (
            f"equilibrium: Newton's method converges to a relative residual of {self.residual:g}, "
            "if need be from where the soil has crept to against a drag; collapse: connected soil, "
            f"at least {WIDTH} cells wide, moves by more than {self.largest_displacement:.3g} "
            f"({ratio:g} times the elastic displacement); undecided: neither is found"
            f"{'' if self.davis is None else f'; strength{whose_text(self.davis)}'}"
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
        AnalysisFailed: no equilibrium with the least factor, or one with the greatest; at a factor
            of at most 1 neither equilibrium nor collapse of the soil itself is found.
    """
    settings = settings or StrengthReduction()
    require_reducible(simulation.setup.model, settings.davis)
    trials = Trials(simulation, time, settings, on_iteration)
    search = Search(settings)
    while (factor := search.next_factor()) is not None:
        trial = trials.at(factor, search.pursues)
        on_trial(trial)
        search.record(trial)
    assert search.stable is not None
    displacement, plastic_strain = trials.mechanism(search.stable)
    return SafetyResult(
        search.stable, search.above, settings.tolerance, tuple(search.undecided),
        tuple(search.trials), trials.elastic_displacement, trials.largest_displacement,
        trials.tolerance, displacement, plastic_strain, settings.davis,
    )  # fmt: skip
