# SPDX-License-Identifier: BSD-3-Clause
"""Requested resolution of a body (`Request`) and its resulting points (`BodyPoints`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from tilth import _core, grid_lines
from tilth.arrays import Floats, Integers
from tilth.bodies.corners import corner_signs, mean_half_edges
from tilth.errors import NOT_GIVEN, BadInput

if TYPE_CHECKING:
    from tilth.grid.background import Grid

MAXIMUM_POINTS = 1_000_000_000
MAXIMUM_PER_CELL = 200  # points per cell and direction; `tilth check` takes 10 s at most
# Largest distance of neighbouring points [cell sizes]. With one point per cell and a body that does
# not fit the grid it is at most this; beyond it cells inside the body may be empty.
MAXIMUM_SPACING = 1.5
# Sides within this fraction of a cell of a grid line lie on it.
ON_LINE = 1e-9


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
    corner: shape (n, 2^d, d), corners of the domains relative to the points, x fastest; None where
        they are boxes with the half lengths.
    group: shape (n,), names of the physical groups of a mesh, "" for none; None for other shapes.
    """

    position: Floats
    volume: Floats
    half_length: Floats
    frame: Floats | None = None
    corner: Floats | None = None
    group: npt.NDArray[np.str_] | None = None

    def ordered(self, order: Integers) -> BodyPoints:
        """Returns the points in another order: the point with index `order[i]` moves to index i."""
        return BodyPoints(
            self.position[order],
            self.volume[order],
            self.half_length[order],
            self.frame,
            None if self.corner is None else self.corner[order],
            None if self.group is None else self.group[order],
        )

    def corners(self) -> Floats:
        """Returns the domains' corners, also of boxes, relative to the points, (n, 2^d, d)."""
        if self.corner is not None:
            return self.corner
        corner = corner_signs(self.position.shape[1]) * self.half_length[:, None]
        return corner if self.frame is None else corner @ self.frame.T


@dataclass(frozen=True)
class Request:
    """Requested resolution of one body: exactly one of points_per_cell, points, spacing is given.

    grid: the background grid.
    points_per_cell, points, spacing: shape (d,) each; material points per cell and direction,
    points per side, or distance of the points along each direction.
    basis: name of the basis, which determines the domains of the points.
    entry: key of the entry with the shape, for messages; that of the body if not given.
    """

    name: str
    axisymmetric: bool
    grid: Grid
    points_per_cell: Floats | None = None
    points: Floats | None = None
    spacing: Floats | None = None
    basis: str = "linear"
    entry: str = ""

    @property
    def has_corners(self) -> bool:
        """Whether the domains of the points have corners (CPDI)."""
        return self.basis in _core.corner_basis_names()

    @property
    def cell_size(self) -> Floats:
        """Sizes of the smallest cell along each axis, shape (d,)."""
        return self.grid.cell_size

    @property
    def per_graded_cell(self) -> dict[int, float]:
        """Points per cell along each axis where their distance varies with the cells."""
        if self.points_per_cell is None:
            return {}
        return {k: float(self.points_per_cell[k]) for k in self.grid.graded}

    def requested_spacing(self) -> Floats:
        """Distance of the points along each direction, shape (d,); needs no shape's size.

        In the smallest cells, where it varies.
        """
        if self.points_per_cell is not None:
            return self.cell_size / self.points_per_cell
        assert self.spacing is not None, "a Body takes `points` for a box only"
        return self.spacing

    def spacing_within(self, lower: Floats, upper: Floats) -> Floats:
        """Distance of the points along each direction in boxes, (n, d): the least within each.

        lower, upper: their corners, shape (n, d).
        """
        if self.points_per_cell is None:
            return np.broadcast_to(self.requested_spacing(), lower.shape)
        return smallest_cells(self.grid, lower, upper) / self.points_per_cell

    def circumference(self, position: Floats) -> Floats:
        """Returns the volume per area at `position` (n, d): 2 pi r in axisymmetry, else 1; (n,)."""
        if self.axisymmetric:
            return 2.0 * np.pi * position[:, 0]
        return np.ones(len(position))

    @property
    def key(self) -> str:
        """Key of the entry with the shape."""
        return self.entry or f'bodies "{self.name}"'

    @property
    def resolution(self) -> str:
        """Key of the case file that determines the resolution of this body."""
        if self.points_per_cell is not None:
            return "points_per_cell"
        return "points" if self.points is not None else "spacing"

    def refused(
        self, problem: str, remedy: str, key: str = "shape", value: Any = NOT_GIVEN
    ) -> BadInput:
        """Returns the error to raise for this body, with the problem and its remedy.

        key, value: the wrong entry of the body, and its value if the message is to show it.
        """
        return BadInput(problem, remedy, key=f"{self.key}.{key}", value=value)

    def check_radius(self, least: float, what: str) -> None:
        """Refuses, in axisymmetry, a body whose least x is below 0 by more than round-off.

        what: the part of the body with this x, for the message.
        """
        if self.axisymmetric and least < -1e-12 * float(self.cell_size[0]):
            raise self.refused(
                f"{what} extends to x = {least:.6g}, beyond the axis of symmetry",
                "x is the radius: move the body to where x is at least 0",
            )

    def check_spacing(self, per_cell: Floats) -> None:
        """Refuses, before memory is allocated, points so close that it can only be an error.

        per_cell: points per cell along each direction, shape (d,).
        """
        if per_cell.max() > MAXIMUM_PER_CELL:
            raise self.refused(
                f"needs {per_cell.max():.3g} points, more than {MAXIMUM_PER_CELL:,}, per cell "
                f"along {'xyz'[per_cell.argmax()]}",
                "use fewer points per cell, a larger spacing or smaller cells",
                self.resolution,
            )

    def check_number(self, number: float) -> None:
        """Refuses a number of points that can only be an error, before memory is allocated."""
        if number > MAXIMUM_POINTS:
            raise self.refused(
                f"needs about {number:.3g} points, more than {MAXIMUM_POINTS:.0e}",
                "use fewer points per cell or a larger spacing",
                self.resolution,
            )

    def check_distance(self, points: BodyPoints) -> None:
        """Refuses points so far apart that cells of the grid inside the body are empty.

        The sides of the domains are the distances, measured in the cells that they are in.
        """
        in_cells = self._in_cells(points)
        point, worst = divmod(int(in_cells.argmax()), in_cells.shape[1])
        if 2.0 * in_cells[point, worst] <= MAXIMUM_SPACING * (1.0 + 1e-9):
            return
        distance = 2.0 * points.half_length[point, worst]
        cell = 0.5 * distance / in_cells[point, worst]
        rotated = points.frame is not None or points.corner is not None
        along = f" along {'its own ' if rotated else ''}{'xyz'[worst]}"
        if points.corner is not None:
            along = ""
        remedy = "points_per_cell = 1 or more, or a smaller spacing"
        if self.points_per_cell is not None:
            remedy = "more points per cell"
        raise self.refused(
            f"material points {distance:.6g} apart{along} in cells of "
            f"{cell:.6g}: cells without points lose the material",
            f"put them at most {MAXIMUM_SPACING * cell:.6g} apart: {remedy}",
            self.resolution,
        )

    def _in_cells(self, points: BodyPoints) -> Floats:
        """Returns the half lengths of the domains' sides in cells, shape (n, d)."""
        size = self.grid.sizes_at(points.position)
        if points.corner is not None:
            edge = mean_half_edges(points.corner) / size[:, None]
            return np.asarray(np.linalg.norm(edge, axis=2))
        if points.frame is not None:
            direction = points.frame.T / size[:, None]
            return np.asarray(points.half_length * np.linalg.norm(direction, axis=2))
        return np.asarray(points.half_length / size)


def smallest_cells(grid: Grid, lower: Floats, upper: Floats) -> Floats:
    """Returns the sizes [length] of the smallest cells in boxes along each axis, shape (n, d).

    lower, upper: their corners, shape (n, d).
    """
    size = np.array(np.broadcast_to(grid.cell_size, lower.shape))
    for k in grid.graded:
        line = grid.lines[k]
        first, last = (grid_lines.in_cells(x[:, k] - grid.origin[k], line) for x in (lower, upper))
        cells = np.append(np.diff(line), np.inf)
        start = np.clip(np.floor(first + ON_LINE), 0, len(line) - 2)
        end = np.clip(np.ceil(last - ON_LINE), start + 1, len(line) - 1)
        ranges = np.stack([start, end], axis=1).astype(np.int64).ravel()
        size[:, k] = np.minimum.reduceat(cells, ranges)[::2]
    return size


def per_direction(value: float | Sequence[float] | None, dimension: int) -> Floats | None:
    """Returns a number, or one per direction, as an array of shape (dimension,), or None."""
    if value is None:
        return None
    return np.array(np.broadcast_to(np.asarray(value, dtype=np.float64), (dimension,)))
