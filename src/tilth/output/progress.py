# SPDX-License-Identifier: BSD-3-Clause
"""The progress bar of ``tilth run``."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO, cast

from tilth.errors import visible
from tilth.output.screen import Screen

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress as RichProgress
    from rich.progress import TaskID
    from typing_extensions import Self


class Progress:
    """Shows the progress of a run; a context manager.

    On a terminal it is a progress bar; elsewhere (a file, a queue system) a plain line at most
    every ``seconds_between_lines``; with ``quiet`` nothing is printed. It ends silently with the
    terminal or the reader of a pipe. ``end`` is the end of the schedule and ``points`` the number
    of material points.
    """

    def __init__(
        self,
        end: float,
        points: int,
        *,
        start: float = 0.0,
        quiet: bool = False,
        console: Console | None = None,
        seconds_between_lines: float = 5.0,
    ) -> None:
        """Nothing is shown before the context is entered."""
        self._start, self._end, self._points = start, end, points
        self._quiet = quiet
        self._console = console
        self._seconds_between_lines = seconds_between_lines
        self._began = self._last_line = time.perf_counter()
        self._now = start
        self._step = 0
        self._live: tuple[RichProgress, TaskID] | None = None
        self._stage = ""

    def stage(self, name: str, number: int, count: int, points: int) -> None:
        """Shows that the stage with this number, from 1, of ``count`` has begun.

        Both count all stages of the case file. ``points`` is its number of material points. Call it
        for the first stage before the context is entered.
        """
        self._stage, self._points = f"stage {number}/{count} {name}", points
        if self._live is not None:
            bar, task = self._live
            bar.update(task, stage=visible(self._stage), points=f"{points:,}")

    def __enter__(self) -> Self:
        """Shows the bar."""
        if self._quiet:
            return self
        from rich.console import Console
        from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
        from rich.progress import Progress as RichProgress

        self._console = self._console or Console(file=cast(TextIO, Screen(sys.stderr)))
        if not self._console.is_terminal:
            return self
        bar = RichProgress(
            *([TextColumn("{task.fields[stage]}", markup=False)] if self._stage else []),
            TextColumn("step {task.fields[step]:>4}"),
            BarColumn(bar_width=24),
            TextColumn("time {task.fields[now]}"),
            TextColumn("{task.fields[newton]:<20}"),
            TextColumn("{task.fields[points]} points"),
            TimeElapsedColumn(),
            TextColumn("{task.fields[left]}"),
            console=self._console,
            transient=False,
        )
        task = bar.add_task(
            "",
            total=1.0,
            stage=visible(self._stage),
            step=self._step,
            now=self._time_text(),
            newton="",
            points=f"{self._points:,}",
            left="",
        )
        bar.start()
        self._live = (bar, task)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stops updating the bar."""
        if self._live is not None:
            self._live[0].stop()
            self._live = None

    def iteration(self, step: int, iteration: int, residual: float) -> None:
        """Shows a Newton iteration of ``step`` and its relative residual."""
        self._step = step
        if self._live is not None:
            bar, task = self._live
            newton = f"Newton {iteration:>2} {residual:.1e}"
            bar.update(task, step=step, newton=newton, left=self._left_text())

    def step_done(self, step: int, time_reached: float, iterations: int) -> None:
        """Shows that ``step`` is complete and the schedule has reached this time."""
        self._step, self._now = step, time_reached
        if self._quiet or self._console is None:
            return
        if self._live is not None:
            bar, task = self._live
            bar.update(
                task,
                completed=self._fraction(),
                step=step,
                now=self._time_text(),
                left=self._left_text(),
            )
            return
        clock = time.perf_counter()
        at_end = self._fraction() >= 1.0
        if at_end or clock - self._last_line >= self._seconds_between_lines:
            self._last_line = clock
            of_stage = f"{visible(self._stage)}, " if self._stage else ""
            self._console.print(
                f"{of_stage}step {step}, time {self._time_text()}, {iterations} Newton iterations, "
                f"{self._points:,} points, {clock_text(clock - self._began)} elapsed"
                + (f", {left}" if (left := self._left_text()) and not at_end else ""),
                soft_wrap=True,
                highlight=False,
                markup=False,
            )

    def message(self, text: str) -> None:
        """Prints a line (a warning, a step cut) above the bar."""
        if not self._quiet and self._console is not None:
            line = visible(text)
            self._console.print(line, soft_wrap=True, highlight=False, markup=False, emoji=False)

    def _fraction(self) -> float:
        return (self._now - self._start) / (self._end - self._start)

    def _time_text(self) -> str:
        return f"{self._now:.4g}/{self._end:.4g}"

    def _left_text(self) -> str:
        """Returns the estimated remaining time; empty before the first step."""
        fraction = self._fraction()
        if fraction <= 0.0:
            return ""
        elapsed = time.perf_counter() - self._began
        return f"{clock_text(elapsed * (1.0 - fraction) / fraction)} left"


def clock_text(seconds: float) -> str:
    """Returns a time [s] as hours, minutes and seconds, such as 1:02:03."""
    whole = int(seconds + 0.5)
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours}:{minutes:02d}:{whole % 60:02d}"
