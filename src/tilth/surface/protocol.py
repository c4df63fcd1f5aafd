# SPDX-License-Identifier: BSD-3-Clause
"""What the surface of a body must offer: a curve in the plane or triangles in space."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import SurfaceShape
from tilth.surface.quadrature import SurfaceQuadrature


class BodySurface(Protocol):
    """A surface that moves with the soil and carries loads."""

    name: str

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """Returns quadrature points for a load step on this grid."""
        ...

    def loaded(self, number: int, quadrature: SurfaceQuadrature) -> tuple[Integers, Floats]:
        """Returns the rows that load `number` of the model covers, and arc lengths there."""
        ...

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[Any, str | None]:
        """Returns the state after a converged step, and a warning where the surface crosses itself.

        Args:
            active: the grid of the step.
            displacement: of its nodes [length], shape (nodes, dim).
            points: the material points at its start; `position` theirs at its end.

        Raises:
            StepFailed: a boundary point left the soil.
        """
        ...

    def commit(self, state: Any) -> None:
        """Takes on a state that `moved` returned."""
        ...

    def enclosed(self) -> float:
        """Returns the area, in space the volume, that it encloses [length^dim].

        Raises:
            BadSurface: the curve or surface is open.
        """
        ...

    def shape(self) -> SurfaceShape:
        """Returns the surface as it is written."""
        ...

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns what a checkpoint must hold."""
        ...

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Goes on from the state of a checkpoint."""
        ...
