# SPDX-License-Identifier: BSD-3-Clause
"""The background grid: its lines, uniform or graded along each axis."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth import grid_lines
from tilth.arrays import Floats, Integers
from tilth.errors import StepFailed
from tilth.model import Model

LEFT_LIMITS = "a point left the limits of the grid"
"""Reason of a step that failed because of the grid's limits."""


@dataclass(frozen=True)
class Grid:
    """Unbounded grid, uniform or graded along each axis.

    Attributes:
        origin: position of the node with the lattice index 0 [length], shape (dim,).
        cell_size: sizes of the smallest cell along each axis [length], shape (dim,), positive;
            those of all cells where the grid is uniform.
        lower, upper: limits that no point may leave [length], shape (dim,); None if unbounded.
        lines: for each axis the distances of its lines from the origin (`tilth/grid_lines.py`),
            empty along a uniform axis; () if all are uniform.
    """

    origin: Floats
    cell_size: Floats
    lower: Floats | None = None
    upper: Floats | None = None
    lines: tuple[Floats, ...] = ()

    @property
    def dim(self) -> int:
        """Number of directions: 2 or 3."""
        return len(self.origin)

    @property
    def graded(self) -> list[int]:
        """The graded axes."""
        return [k for k, line in enumerate(self.lines) if len(line) > 0]

    def in_cells(self, position: Floats) -> Floats:
        """Returns positions (..., dim) in cells: lattice index of the line below plus a share."""
        cells = np.asarray((position - self.origin) / self.cell_size)
        for k in self.graded:
            cells[..., k] = grid_lines.in_cells(position[..., k] - self.origin[k], self.lines[k])
        return cells

    def position(self, cells: Floats) -> Floats:
        """Returns the positions [length] of coordinates in cells, shape (..., dim)."""
        position = np.asarray(self.origin + cells * self.cell_size)
        for k in self.graded:
            position[..., k] = self.origin[k] + grid_lines.distance(
                np.asarray(cells)[..., k], self.lines[k]
            )
        return position

    def sizes(self, cell: Integers) -> Floats:
        """Returns the sizes [length] of cells by their lattice indices (..., dim)."""
        size = np.broadcast_to(self.cell_size, np.shape(cell))
        if self.graded:
            size = size.copy()
        for k in self.graded:
            size[..., k] = grid_lines.size(cell[..., k], self.lines[k])
        return size

    def sizes_at(self, position: Floats) -> Floats:
        """Returns the sizes [length] of the cells that contain positions (..., dim)."""
        if not self.graded:
            return np.broadcast_to(self.cell_size, np.shape(position))
        return self.sizes(np.floor(self.in_cells(position)).astype(np.int64))

    def sizes_around(self, node: Integers) -> Floats:
        """Returns the mean sizes [length] of the cells on both sides of nodes (..., dim).

        Their product over the axes is the mean volume of the cells around the node.
        """
        if not self.graded:
            return np.broadcast_to(self.cell_size, np.shape(node))
        return np.asarray(0.5 * (self.sizes(node - 1) + self.sizes(node)))

    def has_lines_of(self, other: Grid) -> bool:
        """Returns whether the lines of another grid are at the same places."""
        return (
            np.array_equal(self.cell_size, other.cell_size)
            and np.array_equal(self.origin, other.origin)
            and self.graded == other.graded
            and all(np.array_equal(self.lines[k], other.lines[k]) for k in self.graded)
        )

    @property
    def largest_size(self) -> Floats:
        """Sizes of the largest cell along each axis [length], shape (dim,)."""
        size = self.cell_size.copy()
        for k in self.graded:
            size[k] = np.diff(self.lines[k]).max()
        return size

    def require_inside(self, position: Floats, point_id: Integers) -> None:
        """Checks that no point is beyond the limits; positions (n, dim), numbers (n,).

        Raises:
            StepFailed: one is; carries its number.
        """
        if self.lower is None or self.upper is None:
            return
        outside = ((position < self.lower) | (position > self.upper)).any(axis=1)
        if outside.any():
            raise StepFailed(LEFT_LIMITS, point=int(point_id[outside.argmax()]))


def cell_corners(dim: int) -> Integers:
    """Returns the lattice offsets of a cell's corners, x fastest, shape (2^dim, 3)."""
    return np.array([[i, j, k] for k in range(dim - 1) for j in (0, 1) for i in (0, 1)])


def background_grid(model: Model) -> Grid:
    """Returns the grid of a model at the start; `analysis/grid_motion.py` has it over time."""
    limits, lines = model.grid.limits, model.lines
    return Grid(
        origin=np.array(model.origin, dtype=float),
        cell_size=np.array(model.cell_size, dtype=float),
        lower=None if limits is None else np.array(limits.lower, dtype=float),
        upper=None if limits is None else np.array(limits.upper, dtype=float),
        lines=lines if any(len(line) for line in lines) else (),
    )


def largest_face(grid: Grid) -> float:
    """Returns the area of the largest face of a cell, per unit thickness in 2D a length."""
    size = grid.largest_size
    return float(np.prod(size) / size.max())
