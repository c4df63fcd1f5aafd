# SPDX-License-Identifier: BSD-3-Clause
"""The interrupt key (Ctrl-C): stops a run between two Newton iterations, never in between files."""

from __future__ import annotations

import signal
import threading
from types import FrameType, TracebackType
from typing import Any


class InterruptKey:
    """Within this context the key is only noted; `check` raises. A second press acts at once."""

    def __init__(self) -> None:
        self._pressed = False
        self._before: Any = None

    def __enter__(self) -> InterruptKey:
        if threading.current_thread() is threading.main_thread():
            self._before = signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._before is not None:
            signal.signal(signal.SIGINT, self._before)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._pressed:
            raise KeyboardInterrupt
        self._pressed = True

    def check(self) -> None:
        """Raises KeyboardInterrupt if the key was pressed."""
        if self._pressed:
            raise KeyboardInterrupt
