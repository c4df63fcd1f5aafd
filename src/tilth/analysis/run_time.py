# SPDX-License-Identifier: BSD-3-Clause
"""Estimate of the time that a run takes: its first steps are taken on this machine."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from tilth.analysis.staged import StagedAnalysis
from tilth.errors import TilthError
from tilth.model import Model

BUDGET = 1.0
"""Time after which no further step or Newton iteration is begun to be measured [s]."""

MOST_STEPS = 10
"""Steps that are measured, at most."""

ITERATIONS = 3.0
"""Newton iterations of a step where not even the first one could be measured whole."""


@dataclass(frozen=True)
class RunTime:
    """Time of the load steps of a run, as the first ones were.

    Attributes:
        steps: regular steps of all stages.
        per_step: wall-clock time of a step [s].
        iterations: Newton iterations in a step.
        measured: whole steps that were measured; 0 if only iterations of the first one.
        of_first_stage: whether there are other stages, which may take longer or shorter.
    """

    steps: int
    per_step: float
    iterations: float
    measured: int
    of_first_stage: bool

    @property
    def seconds(self) -> float:
        """Of all steps [s]."""
        return self.steps * self.per_step

    def __str__(self) -> str:
        whole, step = duration_text(self.seconds), duration_text(self.per_step)
        steps = f"{self.steps:,} step{'s' * (self.steps != 1)} of {step}"
        assumed = "" if self.measured else " assumed"
        like = f"first {self.measured}" if self.measured > 1 else "first"
        like = like if self.measured else "first iterations"
        stage = " of the first stage" * self.of_first_stage
        return (
            f"about {whole}: {steps} ({self.iterations:.3g} Newton iterations{assumed}), as the "
            f"{like}{stage} took here"
        )


SEARCH = 3.0
"""Time after which the search for equilibrium before the first step is given up [s]."""


class StillSearching(Exception):
    """The search for equilibrium before the first step takes too long to be measured."""


class _Enough(Exception):
    """The time for measuring is over."""


def run_time_of(model: Model, clock: Callable[[], float] = time.perf_counter) -> RunTime | None:
    """Returns the estimate; None if the first step has no equilibrium. Nothing is written.

    It takes about a second, or as long as the first Newton iteration. Steps that yield, are cut, or
    go beyond a limit load take longer than the first ones; start, output and report come in
    addition.

    clock: returns a time [s].

    Raises:
        StillSearching: equilibrium before the first step, as of gravity loading in many parts, is
            not found in `SEARCH` seconds.
    """
    analysis = StagedAnalysis(model)
    begin, stamps, ends, iterations = clock(), [0.0], [0.0], []

    def on_iteration(iteration: int, residual: float) -> None:
        stamps.append(clock() - begin)
        if iteration > 0 and stamps[-1] > BUDGET:
            raise _Enough

    def on_search(iteration: int, residual: float) -> None:
        if clock() - begin > SEARCH:
            raise StillSearching

    try:
        if analysis.begin(on_search) is not None:
            begin = clock()
        for _, result in analysis.steps(on_iteration):
            ends.append(clock() - begin)
            iterations.append(result.equilibrium.iterations)
            if ends[-1] > BUDGET or len(iterations) == MOST_STEPS:
                break
    except TilthError:
        return None
    except _Enough:
        pass
    return _estimate(model, stamps[1:], ends, iterations)


def time_text(model: Model) -> str:
    """Returns the estimate in words, with what it assumes."""
    try:
        found = run_time_of(model)
    except StillSearching:
        return (
            f"not known: equilibrium before the first step takes more than {SEARCH:g} s to find, "
            "such as gravity loading in many parts"
        )
    if found is None:
        return "not known: the first step has no equilibrium"
    return f"{found}; yielding soil and step cuts take more, start, output and report come on top"


def _estimate(
    model: Model, stamps: list[float], ends: list[float], iterations: list[int]
) -> RunTime:
    """Returns the estimate from the measured times since the first step began [s].

    stamps: of the residuals of the Newton iterations. ends: of the steps, the first one is 0.
    iterations: of each step.
    """
    steps = sum(each.schedule.number_of_steps for each in model.of_stages)
    staged = len(model.of_stages) > 1
    if not iterations:
        of_iterations = (stamps[-1] - stamps[0]) / (len(stamps) - 1)
        per_step = stamps[0] + ITERATIONS * of_iterations
        return RunTime(steps, per_step, ITERATIONS, 0, staged)
    warm = min(len(iterations) - 1, 1)  # the first step has no predictor and prepares the solver
    taken = len(iterations) - warm
    per_step, mean = (ends[-1] - ends[warm]) / taken, sum(iterations[warm:]) / taken
    return RunTime(steps, per_step, mean, len(iterations), staged)


def duration_text(seconds: float) -> str:
    """Returns a duration in words, with about two digits."""
    for unit, size, least in (("days", 86400, 2), ("h", 3600, 2), ("min", 60, 2), ("s", 1, 1)):
        if seconds >= least * size:
            return f"{_digits(seconds / size)} {unit}"
    return f"{_digits(1e3 * seconds)} ms"


def _digits(number: float) -> str:
    return f"{number:.2g}" if number < 9.95 else f"{number:.0f}"
