# SPDX-License-Identifier: BSD-3-Clause
"""What every geometry of a boundary or a rigid body says of itself."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any, ClassVar

from tilth.errors import Problem
from tilth.model.base import Declared


def unit(direction: Sequence[float]) -> tuple[float, ...]:
    """Returns the unit vector of a direction that is not zero."""
    greatest = max(abs(c) for c in direction)  # scaled first: no overflow or underflow
    scaled = [c / greatest for c in direction]
    length = math.hypot(*scaled)
    return tuple(c / length for c in scaled)


class DeclaredGeometry(Declared):
    """What every geometry says of itself; a class below this one is a `Geometry` by that."""

    type: str
    dimensions: ClassVar[tuple[int, ...]]
    """Numbers of directions of the analyses that it exists in."""

    @property
    def radius_at_rest(self) -> float | None:
        """Its radius at time 0 [length], which `radius_change` changes; None where it has none."""
        return None

    @property
    def has_two_sides(self) -> bool:
        """Whether soil is on both sides of it: it is thin, and has no inside."""
        return False

    most_cells: ClassVar[int] = 1_000_000
    """Cells through which it passes, about, at most: each makes pieces of it."""

    def cells_passed(self, cell: float, soil: float) -> float:
        """Returns the number of cells through which it passes, about.

        cell: edge of a cell [length]. soil: extent of the soil [length], which bounds what is
            infinite.
        """
        return 0.0

    def sizes(self) -> dict[str, Any]:
        """Returns its sizes [length], > 0, by key; that of the whole by an empty one."""
        return {} if self.radius_at_rest is None else {"radius": self.radius_at_rest}

    def vectors(self, dimension: int) -> dict[str, Any]:
        """Returns the entries that have one component per direction, by key."""
        return {}

    def axes_named(self) -> dict[str, Sequence[str]]:
        """Returns the entries that name axes, by key."""
        return {}

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """Yields what else does not fit an analysis of this dimension, with the keys there."""
        yield from ()

    def axisymmetry_problems(self) -> Iterator[Problem]:
        """Yields what has no meaning where x is the radius, with keys of the geometry."""
        yield from ()
