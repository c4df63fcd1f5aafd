# SPDX-License-Identifier: BSD-3-Clause
"""What a shape is asked for (`Request`) and what it gives back (`BodyPoints`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.bodies.corners import corner_signs
from tilth.errors import NOT_GIVEN, BadInput

MAXIMUM_POINTS = 1_000_000_000
# Largest distance of the points, in cells. One point per cell of a body that does not fit the grid
# lies this far apart at most; beyond it cells inside the body are left without points.
WIDEST = 1.5


@dataclass(frozen=True)
class BodyPoints:
    """Initial material points of one body, n points in d dimensions, units of the model.

    position: shape (n, d).
    volume: shape (n,), initial volume; per unit thickness in plane strain, per full circle
        (2 pi r times the area) in axisymmetry.
    half_length: shape (n, d), half lengths of the points' domains along the grid axes. A rotated
        box gives the half lengths along its own axes, see `frame`, and a mesh cut into domains
        with corners the means of opposite edges.
    frame: shape (d, d), the columns are the directions of a rotated box's own axes; None where
        the domains lie along the grid axes.
    corner: shape (n, 2^d, d), corners of the domains seen from the points, x fastest; None where
        they are boxes with the half lengths.
    """

    position: Floats
    volume: Floats
    half_length: Floats
    frame: Floats | None = None
    corner: Floats | None = None

    def corners(self) -> Floats:
        """Corners of the domains, also of boxes, seen from the points, shape (n, 2^d, d)."""
        if self.corner is not None:
            return self.corner
        corner = corner_signs(self.position.shape[1]) * self.half_length[:, None]
        return corner if self.frame is None else corner @ self.frame.T


@dataclass(frozen=True)
class Request:
    """Resolution wanted of one body: exactly one of points_per_cell, points, spacing is given.

    grid_origin, cell_size: shape (d,), any crossing of grid lines and the cell's side lengths.
    points_per_cell, points, spacing: shape (d,) each; material points per cell and direction,
    points per side, or distance of the points along each direction.
    basis: name of the basis, which says what domains the points have.
    """

    name: str
    axisymmetric: bool
    grid_origin: Floats
    cell_size: Floats
    points_per_cell: Floats | None = None
    points: Floats | None = None
    spacing: Floats | None = None
    basis: str = "linear"

    @property
    def has_corners(self) -> bool:
        """Whether the domains of the points have corners (CPDI)."""
        return self.basis in _core.corner_basis_names()

    def wanted_spacing(self) -> Floats:
        """Distance of the points along each direction, shape (d,); needs no shape's size."""
        if self.points_per_cell is not None:
            return self.cell_size / self.points_per_cell
        assert self.spacing is not None, "a Body takes `points` for a box only"
        return self.spacing

    def circumference(self, position: Floats) -> Floats:
        """Volume per area at `position` (n, d): 2 pi r in axisymmetry, otherwise 1; shape (n,)."""
        if self.axisymmetric:
            return 2.0 * np.pi * position[:, 0]
        return np.ones(len(position))

    @property
    def resolution(self) -> str:
        """The key that says how fine this body is divided."""
        if self.points_per_cell is not None:
            return "points_per_cell"
        return "points" if self.points is not None else "spacing"

    def refused(
        self, problem: str, remedy: str, key: str = "shape", value: Any = NOT_GIVEN
    ) -> BadInput:
        """The error to raise for this body: what is wrong with it and what to do.

        key, value: the entry of the body that is wrong, and what it says if that is worth showing.
        """
        return BadInput(problem, remedy, key=f'bodies "{self.name}".{key}', value=value)

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
                self.resolution,
            )

    def check_distance(self, points: BodyPoints) -> None:
        """Refuses points so far apart that cells of the grid inside the body hold none.

        The sides of the domains are the distances; those of a turned box and of domains with
        corners are measured by the smallest side of a cell.
        """
        turned = points.frame is not None or points.corner is not None
        cell = np.full_like(self.cell_size, self.cell_size.min()) if turned else self.cell_size
        distance = 2.0 * points.half_length.max(axis=0)
        worst = int(np.argmax(distance / cell))
        if distance[worst] <= WIDEST * cell[worst] * (1.0 + 1e-9):
            return
        along = f" along {'its own ' if turned else ''}{'xyz'[worst]}"
        if points.corner is not None:
            along = ""
        remedy = "points_per_cell = 1 or more, or a smaller spacing"
        if self.points_per_cell is not None:
            remedy = "more points per cell"
        raise self.refused(
            f"material points {distance[worst]:.6g} apart{along} in cells of "
            f"{cell[worst]:.6g}: cells without points lose the material",
            f"put them at most {WIDEST * cell[worst]:.6g} apart: {remedy}",
            self.resolution,
        )


def per_direction(value: float | Sequence[float] | None, dimension: int) -> Floats | None:
    """A number, or one per direction, as an array of shape (dimension,); None stays None."""
    if value is None:
        return None
    return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (dimension,)))
