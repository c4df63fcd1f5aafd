# SPDX-License-Identifier: BSD-3-Clause
"""Wall-clock and processor time of the parts of a run: basis, stress, assembly, solve, other."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


@dataclass
class Timers:
    """Sums of wall-clock and processor time [s] by name of the part."""

    wall: dict[str, float] = field(default_factory=dict)
    processor: dict[str, float] = field(default_factory=dict)

    def measure(self, name: str) -> _Measured:
        """Adds the time of the `with` block to the part `name`; blocks must not be nested."""
        return _Measured(self, name)


class _Measured:
    """Context manager that adds the time of its block to one part."""

    __slots__ = ("_name", "_processor", "_timers", "_wall")

    def __init__(self, timers: Timers, name: str) -> None:
        self._timers, self._name = timers, name

    def __enter__(self) -> None:
        self._wall, self._processor = time.perf_counter(), time.process_time()

    def __exit__(self, *error: object) -> None:
        wall, processor, name = self._timers.wall, self._timers.processor, self._name
        wall[name] = wall.get(name, 0.0) + time.perf_counter() - self._wall
        processor[name] = processor.get(name, 0.0) + time.process_time() - self._processor
