# SPDX-License-Identifier: BSD-3-Clause
"""The interface of essential boundaries that act by elimination."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid


@dataclass(frozen=True)
class Prescribed:
    """Degrees of freedom that a boundary prescribes in one step.

    Attributes:
        constrained: whether each degree of freedom is prescribed, shape (nodes, dim).
        increment: prescribed displacement in the step [length], shape (nodes, dim); 0 elsewhere.
        motion: velocity and accelerations before the step of what has a given acceleration, shape
            (nodes, 3, dim); 0 elsewhere. None without such.
    """

    constrained: Flags
    increment: Floats
    motion: Floats | None = None


class Boundary(Protocol):
    """An essential boundary, with the name that the user gives it."""

    name: str

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns the degrees of freedom prescribed in the step from time `before` to `after`."""
        ...

    def distance_from(self, active: ActiveGrid) -> float:
        """Returns how far the nearest active node is from where the boundary acts [length]."""
        ...
