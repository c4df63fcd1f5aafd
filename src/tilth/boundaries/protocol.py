# SPDX-License-Identifier: BSD-3-Clause
"""What an essential boundary must offer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tilth.arrays import Flags, Floats
from tilth.mpm.grid import ActiveGrid


@dataclass(frozen=True)
class Prescribed:
    """Degrees of freedom that a boundary holds during one step.

    Attributes:
        constrained: which, shape (nodes, dim).
        increment: their displacement in the step [length], shape (nodes, dim); 0 elsewhere.
    """

    constrained: Flags
    increment: Floats


class Boundary(Protocol):
    """An essential boundary; `name` is the user's."""

    name: str

    def prescribe(self, active: ActiveGrid, before: float, after: float) -> Prescribed:
        """Returns what the boundary holds in the step from time `before` to `after`."""
        ...
