# SPDX-License-Identifier: BSD-3-Clause
"""Checkpoints are written beside the next step (docs/decisions/0036-checkpoints-beside-the-run.md).

Waiting for the disk takes as long as a step of a small model, but needs no processor.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

LARGEST_COPY = 64_000_000
"""Size of a state up to which it is copied, so that it is written beside the next step [byte].
With a larger one a step takes longer than the disk does."""


PAUSE = 4.0
"""Pause after a checkpoint over the time that it took: disk and processor are for the run."""


class CheckpointThread:
    """Writes one checkpoint at a time in a thread, which ends when there is none left to write.

    At most one waits, also for the end of the pause after another: a later one takes its place.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._hurry = threading.Event()
        self._waiting: Callable[[], None] | None = None
        self._thread: threading.Thread | None = None
        self._error: BaseException | None = None

    def write(self, action: Callable[[], None]) -> None:
        """Runs ``action``, which writes a checkpoint, beside what the caller does next.

        Raises the error with which an earlier one ended; then this one is not written.
        """
        self._raise()
        with self._lock:
            self._waiting = action
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name="checkpoint")
                self._thread.start()

    def wait(self) -> None:
        """Returns when all checkpoints are on the disk; raises the error of one that is not."""
        self._hurry.set()
        if (thread := self._thread) is not None:
            thread.join()
        self._hurry.clear()
        self._raise()

    def _raise(self) -> None:
        error, self._error = self._error, None
        if error is not None:
            raise error

    def _work(self) -> None:
        while (action := self._next()) is not None:
            begin = time.monotonic()
            try:
                action()
            except BaseException as error:
                self._error = error
            else:
                self._hurry.wait(PAUSE * (time.monotonic() - begin))

    def _next(self) -> Callable[[], None] | None:
        """Returns what to do next; after an error nothing, and the thread is about to end."""
        with self._lock:
            action = None if self._error is not None else self._waiting
            self._waiting = None
            if action is None:
                self._thread = None
            return action
