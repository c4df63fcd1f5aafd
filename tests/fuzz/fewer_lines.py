# SPDX-License-Identifier: BSD-3-Clause
"""The fewest lines of a case file that still fail."""

from __future__ import annotations

from collections.abc import Callable


def fewest_lines(content: bytes, fails: Callable[[bytes], bool], attempts: int) -> bytes:
    """Returns a text without the lines that its fault does not need.

    fails: whether another text has the same fault. attempts: texts that are tried, at most.
    """
    lines = content.splitlines(keepends=True)
    size = max(1, len(lines) // 2)
    while True:
        at = 0
        while at < len(lines) and attempts > 0:
            fewer = lines[:at] + lines[at + size :]
            attempts -= 1
            if fails(b"".join(fewer)):
                lines = fewer
            else:
                at += size
        if size == 1 or attempts <= 0:
            return b"".join(lines)
        size //= 2
