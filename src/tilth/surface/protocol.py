# SPDX-License-Identifier: BSD-3-Clause
"""Interface of the surface of a body: a curve in the plane or triangles in space."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy.typing as npt

from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.output.snapshot import SurfaceShape
from tilth.surface.quadrature import SurfaceQuadrature


class BodySurface(Protocol):
    """A surface that moves with the soil and carries loads."""

    name: str

    def quadrature(self, active: ActiveGrid) -> SurfaceQuadrature:
        """Returns the quadrature points of the surface for a load step on this grid."""
        ...

    def material_quadrature(self) -> SurfaceQuadrature:
        """Returns quadrature points that stay with the soil as long as no boundary point is added.

        Several in a cell, independent of the grid.
        """
        ...

    def of_part(self, key: str, quadrature: SurfaceQuadrature) -> tuple[SurfaceQuadrature, Floats]:
        """Returns the m quadrature points of a declared part, and their arc lengths, shape (m,).

        key: of the load or flow boundary on it in the case file (`parts.py`). quadrature: of the
        whole surface. The arc lengths [length] are initial ones from the part's start.
        """
        ...

    def long_parts(self) -> dict[str, float]:
        """Returns parts with ends that cover more than half their closed curve: key and share.

        The key is that of the load or flow boundary, the share that of the curve's length.
        """
        ...

    def moved(
        self, active: ActiveGrid, displacement: Floats, points: MaterialPoints, position: Floats
    ) -> tuple[Any, str | None]:
        """Returns the state after a converged step, and a warning if the surface crosses itself.

        Args:
            active: the grid of the step.
            displacement: of its nodes [length], shape (nodes, dim).
            points: the material points at the start of the step.
            position: of the material points at its end [length], shape (points, dim).

        Raises:
            StepFailed: a boundary point is more than a cell away from the soil, or the surface is
                not valid.
        """
        ...

    def commit(self, state: Any) -> None:
        """Sets the state that `moved` returned."""
        ...

    def move_vertically(self, displacement: Callable[[Floats], Floats]) -> None:
        """Moves the undeformed surface of new soil vertically, before the first step.

        displacement: at horizontal positions (n, dim - 1) [length], shape (n,).
        """
        ...

    def enclosed(self) -> float:
        """Returns the enclosed area (2D) or volume (3D) [length^dim].

        Raises:
            BadSurface: the curve or surface is open.
        """
        ...

    def shape(self) -> SurfaceShape:
        """Returns the surface for the results file."""
        ...

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays of a checkpoint by name."""
        ...

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restores the state from the arrays of a checkpoint."""
        ...
