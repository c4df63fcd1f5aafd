# SPDX-License-Identifier: BSD-3-Clause
"""The size of a run and the memory that it is estimated to need."""

from __future__ import annotations

from dataclasses import dataclass

from tilth.available_memory import size_text

UNDEFORMED = "the undeformed points of the stages"


@dataclass(frozen=True)
class MemoryEstimate:
    """Size of a run and the memory that it needs.

    Attributes:
        points: number of material points.
        cells: number of active grid cells.
        nodes: number of active nodes.
        unknowns: number of nodal unknowns, constrained ones included.
        solver: name of the linear solver.
        parts: peak memory [byte] by what needs it.
    """

    points: float
    cells: float
    nodes: float
    unknowns: float
    solver: str
    parts: dict[str, float]

    @property
    def total(self) -> float:
        """Peak memory [byte]."""
        return sum(self.parts.values())

    @property
    def of_set_up(self) -> float:
        """Memory before the first step [byte]: program and material points."""
        of_points = self.parts["the material points"] + self.parts.get(UNDEFORMED, 0.0)
        return self.parts["the program"] + of_points

    @property
    def size(self) -> str:
        """Numbers of points and unknowns."""
        return f"{_number(self.points)} points, {_number(self.unknowns)} unknowns"

    def __str__(self) -> str:
        largest = max(self.parts, key=lambda name: self.parts[name])
        return f"about {size_text(self.total)}, of which {largest} {size_text(self.parts[largest])}"


def _number(count: float) -> str:
    return f"{count:,.0f}" if count < 1e6 else f"{count:.3g}"
