# SPDX-License-Identifier: BSD-3-Clause
"""What a process that is timed says of itself; imports next to nothing, for that is timed, too."""

from __future__ import annotations

import resource
import sys
from pathlib import Path


def user_seconds() -> float:
    """User time of this process and its threads [s]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def peak_memory() -> int:
    """Largest resident memory of this process so far [byte].

    From Linux' list, where there is one: getrusage counts what the process that started this one
    held at that moment, too.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM"):
                return int(line.split()[1]) * 1024
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
