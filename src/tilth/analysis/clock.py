# SPDX-License-Identifier: BSD-3-Clause
"""Adaptive load steps: where an analysis stands in its schedule and how large the next step is."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from typing import Any

from tilth.model import Schedule

SHORT = 0.25
"""Size over the regular one up to which a step is short."""

GROW_AFTER = 2
"""Steps in a row that must converge before a step that was cut grows again."""


@dataclass
class Clock:
    """Time of a schedule, advanced by accepted steps.

    Regular times and output times are always hit exactly. A failed step is halved, or shortened as
    the failure requires; after two converged ones in a row the size doubles, up to the regular one.

    Attributes:
        step: number of accepted steps.
        time: time reached.
        size: size of the next step, unless an event comes first.
        successes: steps accepted since the last cut.
        relaxing: whether the soil comes to rest at the time reached, so that the time stands still.
        until: time at which to stop before the end of the schedule; None for its end.
    """

    schedule: Schedule
    step: int = 0
    time: float = 0.0
    size: float = 0.0
    successes: int = 0
    relaxing: bool = False
    until: float | None = None

    def __post_init__(self) -> None:
        self._outputs = self.schedule.times_of_output()
        self._regular_size = self.schedule.regular_size(self.time)
        self._round_off = 1e-9 * self.schedule.first_step
        if self.size == 0.0:
            self.size = self._regular_size

    def state(self) -> dict[str, Any]:
        """Returns what a checkpoint has of it."""
        names = ("step", "time", "size", "successes", "relaxing")
        return {name: getattr(self, name) for name in names}

    @property
    def done(self) -> bool:
        """Whether the end of the schedule is reached."""
        return self.time >= self.schedule.end and not self.relaxing

    @property
    def stops(self) -> bool:
        """Whether `until` is reached, by the end of a step: the steps do not depend on it."""
        until = self.until
        if until is None or self.relaxing:
            return False
        return self.time >= until - self._round_off and self.step > 0

    def next_time(self) -> float:
        """Returns the time at the end of the step to try next."""
        event = self.next_event
        if event - self.time <= self.size + self._round_off:
            return event
        return self.time + self.size

    @property
    def next_event(self) -> float:
        """The next regular time or time of output."""
        return min(self._next_output_time(), self._next_regular_time())

    @property
    def is_output(self) -> bool:
        """Whether the schedule has an output at the time reached, after the start."""
        if self.relaxing:
            return False
        before = bisect_left(self._outputs, self.time)
        return self._outputs[before : before + 1] == (self.time,)

    def _next_regular_time(self) -> float:
        """Returns the end of the first regular step that ends after the time reached."""
        return self.schedule.regular_time(self.schedule.step_at(self.time))

    def _next_output_time(self) -> float:
        """Returns the first time of output after the time reached."""
        return self._outputs[bisect_right(self._outputs, self.time)]

    def accept(self, time: float, possible: float = math.inf) -> None:
        """Records that the step to `time` has converged; possible: size of the next one at most."""
        is_whole = self.size >= self._regular_size
        self.step += 1
        self.time = time
        self._regular_size = self.schedule.regular_size(time)
        self.successes += 1
        if is_whole:
            self.size = self._regular_size
        elif self.successes >= GROW_AFTER:
            self.size = min(2.0 * self.size, self._regular_size)
            self.successes = 0
        self.size = min(self.size, max(possible, self.schedule.least_step))

    def relax(self, time: float, at_rest: bool) -> None:
        """Records a step in which the soil comes to rest at `time`; at_rest: whether it has."""
        self.step += 1
        self.time = time
        self._regular_size = self.schedule.regular_size(time)
        self.relaxing = not at_rest
        self.size, self.successes = self._regular_size, 0

    @property
    def is_least(self) -> bool:
        """Whether the next step is of the least size, and so cannot be cut."""
        least = self.schedule.least_step * (1.0 + 1e-9)
        return self.schedule.adaptive and self.next_time() - self.time <= least

    @property
    def is_short(self) -> bool:
        """Whether the next step is so short that its failure is not put down to its size."""
        size = self.next_time() - self.time
        return (self.schedule.adaptive and size <= SHORT * self._regular_size) or self.is_least

    def cut(self, share: float | None = None) -> bool:
        """Shortens the step that failed; returns whether it is still large enough to be tried.

        A step that is not shortened, because an event follows within round-off, is not tried again.

        share: part of the step that is known to be possible, which then is not shorter than the
            least step; a half, however short, where nothing is known.
        """
        if not self.schedule.adaptive:
            return False
        size, least = self.next_time() - self.time, self.schedule.least_step
        self.size = 0.5 * size if share is None else max(share * size, least)
        self.successes = 0
        return self.size >= least * (1.0 - 1e-9) and self.next_time() - self.time < size
