# SPDX-License-Identifier: BSD-3-Clause
"""The schedule: pseudo-time of the loading, load steps and output times."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import Any

from pydantic import model_validator

from tilth.errors import Problem
from tilth.model.base import Declared
from tilth.model.fields import Count, Flag, Fraction, Positive, Times
from tilth.model.problems import rejection

MOST_STEPS = 1_000_000
"""Regular steps of a schedule, at most: up to there the round-off of time is below 1e-9 of one."""

MOST_OUTPUTS = 100_000
"""Outputs of a schedule, at most."""

_ROUND_OFF = 1e-9
"""Fraction of the first regular step within which two times are the same."""

_RESOLUTION = 1e-12
"""Part of the schedule that a step must exceed, so that it is not lost in the round-off of time."""

LARGEST_GROWTH = 10.0
"""Size of a step over that of the one before, at most, of steps that grow [-]."""


def _grown(first: float, steps: int, growth: float) -> float:
    """Returns the sum of so many steps, each `growth` times the one before."""
    if growth == 1.0:
        return first * steps
    try:
        return first * math.expm1(steps * math.log(growth)) / (growth - 1.0)
    except OverflowError:
        return math.inf


class Schedule(Declared):
    """Load steps from time 0 to `end`; exactly one of `steps` and `step_size` gives their size.

    Results are written at the start, at the end and at the times given by at most one of
    `output_times`, `outputs` and `output_every` (at about 10 regular steps if none is given).

    There are at most 1,000,000 regular steps: with more, the round-off of time would reach 1e-9 of
    a step, within which two times are the same. There are at most 100,000 outputs, each of which
    takes about 200 bytes per material point in the results file.
    """

    end: Positive = 1.0
    """Time at the end, > 0; time is the argument of the tables of load factors."""
    steps: Count | None = None
    """Number of steps: equal ones, or those that `first_step_size` grows to."""
    first_step_size: Positive | None = None
    """With `steps`: time increment of the first of them [time], less than `end` over `steps`. Each
    step is then longer than the one before by the same factor, at most 10, as for soil that
    consolidates fast at first and slowly later; all are equal if not given.
    """
    step_size: Positive | None = None
    """Time increment of the steps, > 0; the last one is shorter if they do not sum to `end`."""
    adaptive: Flag = True
    """Whether a failed step is undone and halved; steps grow again afterwards."""
    minimum_step: Fraction = 1.0 / 1024.0
    """Least step size as a fraction of the first one, which must be at least 1e-12 of `end`; the
    analysis ends if it is not enough.
    """
    output_times: Times | None = None
    """Times of output, increasing, in (0, end]; the end is added if missing."""
    outputs: Count | None = None
    """Number of outputs, equally spaced in time; the last one is at the end."""
    output_every: Count | None = None
    """Number of regular steps from one output to the next."""

    @model_validator(mode="after")
    def _entries_fit_together(self) -> Any:
        problems = []
        if (self.steps is None) == (self.step_size is None):
            what = "missing" if self.steps is None else "given together with `step_size`"
            problems.append(Problem("steps", what, "give exactly one of `steps` and `step_size`"))
        elif self.step_size is not None and self.step_size > self.end:
            what = f"is larger than the whole schedule, which ends at {self.end:g}"
            problems.append(Problem("step_size", what, value=self.step_size))
        else:
            problems += self._first_step_problems() or self._resolution_problems()
        ways = ("output_times", "outputs", "output_every")
        given = [way for way in ways if getattr(self, way) is not None]
        if len(given) > 1:
            remedy = "give at most one of `output_times`, `outputs` and `output_every`"
            what = f"given together with `{given[0]}`"
            problems.append(Problem(given[1], what, remedy, getattr(self, given[1])))
        if self.output_times is not None and self.output_times[-1] > self.end:
            what = f"the schedule ends at {self.end:g}"
            remedy = "give times in (0, end]"
            problems.append(Problem("output_times", what, remedy, self.output_times))
        if problems:
            raise rejection(problems)
        return self

    def _first_step_problems(self) -> list[Problem]:
        """Returns what is wrong with steps that grow."""
        first, steps = self.first_step_size, self.steps
        if first is None:
            return []
        key, remedy = "first_step_size", "give it with `steps`, or leave it out"
        if steps is None:
            return [Problem(key, "is given with `step_size`, for equal steps", remedy, first)]
        if first * steps >= self.end:
            what = f"is not less than {self.end / steps:g}, the size of {steps} equal steps"
            return [Problem(key, what, "leave it out for equal steps, or give fewer", first)]
        if _grown(first, steps, LARGEST_GROWTH) < self.end:
            what = f"would make each step more than {LARGEST_GROWTH:g} times the one before"
            return [Problem(key, what, "give more steps, or a longer first one", first)]
        return []

    def _resolution_problems(self) -> Iterator[Problem]:
        """Yields numbers of steps and outputs, and steps, that cannot be computed."""
        steps, end = self.number_of_steps, self.end
        if steps > MOST_STEPS:
            key = "steps" if self.steps is not None else "step_size"
            what = f"makes {steps:.3g} steps" if key == "step_size" else "is too many steps"
            remedy = f"a schedule has at most {MOST_STEPS:,} steps"
            if key == "step_size":
                remedy += f": give a step_size of at least {end / MOST_STEPS:.6g}"
            yield Problem(key, what, remedy, getattr(self, key))
            return
        if self.least_step < _RESOLUTION * end:
            what = "is a step so short that it is lost in the round-off of time"
            remedy = f"give at least {_RESOLUTION * end / self.first_step:.3g}, or fewer steps"
            yield Problem("minimum_step", what, remedy, self.minimum_step)
        for key, outputs in (
            ("output_times", len(self.output_times or ())),
            ("outputs", self.outputs or 0),
            ("output_every", steps // self.output_every if self.output_every else 0),
        ):
            if outputs > MOST_OUTPUTS:
                what = f"makes {outputs:,} outputs"
                remedy = f"a schedule has at most {MOST_OUTPUTS:,} outputs"
                yield Problem(key, what, remedy, getattr(self, key))
        times = (0.0, *(self.output_times or ()))
        close = [after for before, after in pairwise(times) if after - before < _RESOLUTION * end]
        if close:
            what = f"the step to the output at {close[0]:.17g} is lost in the round-off of time"
            remedy = f"leave at least {_RESOLUTION * end:.3g} between the times of output"
            yield Problem("output_times", what, remedy, self.output_times)

    @property
    def number_of_steps(self) -> int:
        """Number of regular steps."""
        if self.steps is not None:
            return self.steps
        assert self.step_size is not None
        return max(1, math.ceil(self.end / self.step_size - _ROUND_OFF))

    @property
    def first_step(self) -> float:
        """Time increment of the first regular step."""
        return self.regular_time(1)

    @property
    def least_step(self) -> float:
        """Least time increment of adaptive stepping."""
        return self.minimum_step * self.first_step

    def regular_time(self, step: int) -> float:
        """Returns the time at the end of the regular step number `step` (0: the start)."""
        if step >= self.number_of_steps:
            return self.end
        if self.first_step_size is not None:
            return _grown(self.first_step_size, step, self._growth)
        if self.step_size is not None:
            return step * self.step_size
        return self.end * step / self.number_of_steps

    @cached_property
    def _growth(self) -> float:
        """Size of each step over that of the one before, of steps that grow [-]."""
        first, steps, end = self.first_step_size, self.number_of_steps, self.end
        assert first is not None
        low, high = 1.0, LARGEST_GROWTH
        while (middle := 0.5 * (low + high)) not in (low, high):
            low, high = (low, middle) if _grown(first, steps, middle) > end else (middle, high)
        return high

    def step_at(self, time: float) -> int:
        """Returns the number of the regular step in which a time lies, from 1 on.

        The end of a step belongs to the next one, but for the last.
        """
        number = int(time / self.first_step)  # to round-off: the true one is beside it
        if self.first_step_size is not None:
            share = 1.0 + time / self.first_step_size * (self._growth - 1.0)
            number = int(math.log(share) / math.log(self._growth))
        while self.regular_time(number) > time:
            number -= 1
        while self.regular_time(number) <= time and number < self.number_of_steps:
            number += 1
        return max(number, 1)

    def regular_size(self, time: float) -> float:
        """Returns the time increment of the regular step in which a time lies; see `step_at`."""
        if self.first_step_size is None:
            return self.first_step
        number = self.step_at(time)
        return self.regular_time(number) - self.regular_time(number - 1)

    @property
    def largest_step(self) -> float:
        """Greatest time increment of a regular step."""
        return self.regular_size(self.end)

    def times_of_output(self) -> tuple[float, ...]:
        """Returns the times of output after the start, increasing; the last is `end`.

        A time that equals a regular one to round-off is replaced by it.
        """
        last = self.number_of_steps
        if self.output_times is not None:
            times = {self._snapped(time) for time in self.output_times}
        elif self.outputs is not None:
            count = self.outputs
            times = {self._snapped(self.end * k / count) for k in range(1, count)}
        elif self.output_every is not None:
            times = {
                self.regular_time(k) for k in range(self.output_every, last, self.output_every)
            }
        else:  # regular times only, so that the number of steps does not change
            times = {self.regular_time(round(last * k / 10)) for k in range(1, 10)} - {0.0}
        return tuple(sorted(times | {self.end}))

    def snapped(self, time: float) -> float:
        """Returns the regular time or time of output that equals `time` to round-off, or `time`."""
        events = (self._snapped(time), *self.times_of_output())
        nearest = min(events, key=lambda event: abs(event - time))
        return nearest if abs(time - nearest) <= _ROUND_OFF * self.first_step else time

    def _snapped(self, time: float) -> float:
        """Returns the regular time that equals `time` to round-off, or `time` itself."""
        number = round(time / self.first_step)
        if self.first_step_size is not None:
            here = self.step_at(time)
            around = [k for k in (here - 1, here) if k > 0]
            number = min(around, key=lambda k: abs(self.regular_time(k) - time))
        nearest = self.regular_time(number)
        return nearest if abs(time - nearest) <= _ROUND_OFF * self.first_step else time
