# SPDX-License-Identifier: BSD-3-Clause
"""What every shape of a body says of itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from tilth.errors import Problem
from tilth.model.base import Declared

Bounds = tuple[tuple[float, ...], tuple[float, ...]]
"""Least and greatest coordinates [length], each of shape (dimension,)."""


class DeclaredShape(Declared):
    """What every shape of a body says of itself; a class below this one is a `Shape` by that."""

    type: str
    dimensions: ClassVar[tuple[int, ...]]
    """Numbers of directions of the analyses that it exists in."""
    has_own_axes: ClassVar[bool] = False
    """Whether its points are in rows along axes of its own, so that `points` can count them."""
    has_groups: ClassVar[bool] = False
    """Whether its file has physical groups, which layers may name."""

    @property
    def dimension(self) -> int | None:
        """Number of directions; None where only its file says it."""
        return self.dimensions[0] if len(self.dimensions) == 1 else None

    def bounds(self) -> Bounds | None:
        """Returns the bounding box; None where only its file says it."""
        return None

    def measure(self) -> float | None:
        """Returns the area (2D) or volume (3D) [length^dimension]; None where only a file says it.

        In axisymmetry the area of the section.
        """
        return None

    def cavities(self) -> tuple[DeclaredShape, ...]:
        """Returns the holes in it, shapes of as many directions."""
        return tuple(getattr(self, "holes", ()))

    def vectors(self) -> dict[str, Any]:
        """Returns the entries that have one component per direction, by key."""
        return {}

    def size_problems(self, dimension: int) -> Iterator[Problem]:
        """Yields what else does not fit an analysis of this dimension, with keys of the shape."""
        yield from ()

    def may_cross_axis(self) -> bool:
        """Whether in axisymmetry its part at r >= 0 is meant where it reaches beyond the axis."""
        return False
