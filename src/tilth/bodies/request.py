# SPDX-License-Identifier: BSD-3-Clause
"""What a shape is asked for (`Request`) and what it gives back (`BodyPoints`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.errors import BadInput

FloatArray = npt.NDArray[np.float64]

MAXIMUM_POINTS = 1_000_000_000


@dataclass(frozen=True)
class BodyPoints:
    """Initial material points of one body, n points in d dimensions, units of the model.

    position: shape (n, d).
    volume: shape (n,), initial volume; per unit thickness in plane strain, per full circle
        (2 pi r times the area) in axisymmetry.
    half_length: shape (n, d), half lengths of the points' domains along the grid axes. A rotated
        box gives the half lengths along its own axes: see `frame`.
    frame: shape (d, d), the columns are the directions of a rotated box's own axes; None where
        the domains lie along the grid axes.
    """

    position: FloatArray
    volume: FloatArray
    half_length: FloatArray
    frame: FloatArray | None = None


@dataclass(frozen=True)
class Request:
    """Resolution wanted of one body: exactly one of the last three is given.

    grid_origin, cell_size: shape (d,), any crossing of grid lines and the cell's side lengths.
    points_per_cell, points, spacing: shape (d,) each; material points per cell and direction,
    points per side, or distance of the points along each direction.
    """

    name: str
    axisymmetric: bool
    grid_origin: FloatArray
    cell_size: FloatArray
    points_per_cell: FloatArray | None = None
    points: FloatArray | None = None
    spacing: FloatArray | None = None

    def wanted_spacing(self) -> FloatArray:
        """Distance of the points along each direction, shape (d,); needs no shape's size."""
        if self.points_per_cell is not None:
            return self.cell_size / self.points_per_cell
        assert self.spacing is not None, "a Body takes `points` for a box only"
        return self.spacing

    def circumference(self, position: FloatArray) -> FloatArray:
        """Volume per area at `position` (n, d): 2 pi r in axisymmetry, otherwise 1; shape (n,)."""
        if self.axisymmetric:
            return 2.0 * np.pi * position[:, 0]
        return np.ones(len(position))

    def refused(self, problem: str, remedy: str) -> BadInput:
        """The error to raise for this body: what is wrong with it and what to do."""
        return BadInput(f"body '{self.name}': {problem}", remedy)

    def check_radius(self, least: float, what: str) -> None:
        """Refuses, in axisymmetry, a body whose least x is beyond the axis (more than round-off).

        what: the part of the body that has this x, for the message.
        """
        if self.axisymmetric and least < -1e-12 * float(self.cell_size[0]):
            raise self.refused(
                f"{what} reaches x = {least:.6g}, beyond the axis of symmetry",
                "x is the radius: move the body to where x is at least 0",
            )

    def check_number(self, number: float) -> None:
        """Refuses a number of points that can only be a slip, before memory is asked for."""
        if number > MAXIMUM_POINTS:
            raise self.refused(
                f"needs about {number:.3g} points, more than {MAXIMUM_POINTS:.0e}",
                "use fewer points per cell or a larger spacing",
            )


def per_direction(value: float | Sequence[float] | None, dimension: int) -> FloatArray | None:
    """A number, or one per direction, as an array of shape (dimension,); None stays None."""
    if value is None:
        return None
    return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (dimension,)))
