# SPDX-License-Identifier: BSD-3-Clause
"""The progress bar of `tilth study`."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import TYPE_CHECKING, TextIO, cast

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn

from tilth.errors import visible
from tilth.output.progress import clock_text
from tilth.output.screen import Screen

if TYPE_CHECKING:
    from typing_extensions import Self

BETWEEN_LINES = 5.0
"""Time between two lines where there is no terminal, at least [s]."""


class StudyProgress:
    """Shows how many samples are complete; a context manager.

    On a terminal a bar, elsewhere a line every `BETWEEN_LINES`; with `quiet` nothing. A sample that
    fails is named at once, with the reason.
    """

    def __init__(self, samples: int, complete: int, failed: int, *, quiet: bool) -> None:
        self._samples, self._complete, self._failed = samples, complete, failed
        self._first = complete
        self._console = Console(file=cast(TextIO, Screen(sys.stderr)), quiet=quiet)
        self._began = self._last = time.monotonic()
        self._live: tuple[Progress, TaskID] | None = None

    def __enter__(self) -> Self:
        if self._complete:
            self._say(f"{self._complete} of {self._samples} samples are complete already")
        if self._console.is_terminal and not self._console.quiet:
            bar = Progress(
                TextColumn("{task.completed}/{task.total} samples"),
                BarColumn(bar_width=24),
                TextColumn("{task.fields[failed]}"),
                TimeElapsedColumn(),
                TextColumn("{task.fields[left]}"),
                console=self._console,
            )
            task = bar.add_task(
                "", total=self._samples, completed=self._complete, failed="", left=""
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
        if self._live is not None:
            self._live[0].stop()

    def sample(self, number: int, reason: str) -> None:
        """Shows that a sample is complete; reason: why it failed, "" if it is done."""
        self._complete += 1
        if reason:
            self._failed += 1
            self._say(f"sample {number} failed: {reason}")
        if self._live is not None:
            bar, task = self._live
            shown = self._fields()
            bar.update(task, completed=self._complete, failed=shown["failed"], left=shown["left"])
            return
        now = time.monotonic()
        if now - self._last >= BETWEEN_LINES or self._complete == self._samples:
            self._last = now
            left = self._fields()
            parts = [f"{self._complete}/{self._samples} samples", left["failed"], left["left"]]
            self._say(", ".join(part for part in parts if part))

    def _say(self, text: str) -> None:
        self._console.print(
            visible(text), soft_wrap=True, highlight=False, markup=False, emoji=False
        )

    def _fields(self) -> dict[str, str]:
        done = self._complete - self._first
        left = ""
        if done and self._complete < self._samples:
            each = (time.monotonic() - self._began) / done
            left = f"{clock_text(each * (self._samples - self._complete))} left"
        return {"failed": f"{self._failed} failed" if self._failed else "", "left": left}
