# SPDX-License-Identifier: BSD-3-Clause
"""A screen that may be closed while a run goes on."""

from __future__ import annotations

from typing import Any, TextIO


class Screen:
    """A text stream for `rich.console.Console` that is silent once it cannot be written.

    A terminal that is closed, a pipe whose reader has ended and a full disk then do not end the
    run. All else is that of ``stream``.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._gone = False

    def write(self, text: str) -> int:
        """Writes ``text``; returns its length."""
        self._attempt(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        """Shows what has been written."""
        self._attempt(self._stream.flush)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _attempt(self, action: Any, *arguments: str) -> None:
        if self._gone:
            return
        try:
            action(*arguments)
        except (OSError, ValueError):  # ValueError: the stream is closed
            self._gone = True
