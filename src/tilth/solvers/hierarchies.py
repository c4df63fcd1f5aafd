# SPDX-License-Identifier: BSD-3-Clause
"""The multigrid levels of a grid with one or several overlays.

Nodes of different overlays lie at the same places. Each overlay has levels of its own, which leave
out the blocks that couple it with the others, such as those of contact between bodies.

Each level has twice the cell size of the one before. On a graded grid this is the size of its
smallest cells: lines that are farther apart stay until the cells between the others have become as
large. So cells that are long in one direction are first joined along the others, and smoothing by
points suffices (docs/theory/linear_solvers.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers, Shorts
from tilth.mpm.active_grid import ActiveGrid


class Hierarchy(Protocol):
    """Levels with the interface of `_core.Multigrid`."""

    def begin(self) -> None:
        """Discards all matrices."""

    def fill(self, blocks: Floats) -> None:
        """Sets the blocks of the matrix."""

    def cycle(self, residual: Floats, approximate: Floats) -> None:
        """Fills `approximate` with one V-cycle for `residual`, (unknowns,) each."""

    def bytes(self) -> int:
        """Memory of all levels [byte]."""


def make_hierarchy(active: ActiveGrid, constrained: Flags) -> Hierarchy:
    """Returns the levels of an active grid; constrained: shape (nodes, components)."""
    lattice = lattice_by_size(active)
    if active.overlays == 1:
        return _core.Multigrid(
            active.grid.dim, constrained.shape[1], lattice, active.row_start, active.column,
            constrained,
        )  # fmt: skip
    return _HierarchyOfFields(active, constrained, lattice)


def lattice_by_size(active: ActiveGrid) -> Integers:
    """Returns lattice indices of the nodes in which a cell is as wide as it is large.

    Along a graded axis the width of a cell is a power of two, near its size over that of the
    smallest cell with nodes, and at most the largest power that divides its lower index. All
    processes that share the grid call it.
    """
    lattice, size = active.lattice, active.grid.cell_size
    if not active.grid.graded:
        return lattice
    lattice = lattice.copy()
    for k in range(active.grid.dim):
        low = -int(active.comm.max(float(-active.lattice[:, k].min())))
        high = int(active.comm.max(float(active.lattice[:, k].max())))
        cell = np.arange(low, high)
        place = np.zeros((len(cell), active.grid.dim), dtype=np.int64)
        place[:, k] = cell
        sizes = active.grid.sizes(place)[:, k]
        steps = dyadic_steps(sizes / size.min())
        index = np.concatenate([[0], np.cumsum(steps)])
        lattice[:, k] = index[active.lattice[:, k] - low]
    return lattice


def dyadic_steps(ratio: Floats) -> Integers:
    """Returns powers of two near ratios, each of which divides the sum of those before it."""
    wanted = np.maximum(np.rint(np.log2(ratio)), 0.0).astype(np.int64)
    steps, at = np.empty(len(ratio), dtype=np.int64), 0
    for i, power in enumerate(wanted):
        step = 1 << int(power)
        while at % step:
            step >>= 1
        steps[i] = step
        at += step
    return steps


@dataclass(frozen=True)
class PatternOfOverlay:
    """The part of a matrix that couples the nodes of one overlay with each other.

    Attributes:
        nodes: numbers of its nodes.
        entries: which blocks of the whole matrix these are, shape (blocks,); all if None.
        row_start, column: its pattern.
    """

    nodes: slice
    entries: Integers | None
    row_start: Integers
    column: Shorts


def patterns_of_overlays(active: ActiveGrid) -> Iterator[PatternOfOverlay]:
    """Yields the part of the pattern of each overlay, also of one without nodes."""
    if active.overlays == 1:
        yield PatternOfOverlay(slice(0, active.nodes), None, active.row_start, active.column)
        return
    row = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    within = active.overlay[row] == active.overlay[active.column]
    for number in range(active.overlays):
        own = active.of_overlay(number).nodes
        entries = np.flatnonzero(within & (row >= own.start) & (row < own.stop))
        count = np.bincount(row[entries] - own.start, minlength=own.stop - own.start)
        yield PatternOfOverlay(
            own,
            entries,
            np.concatenate([[0], np.cumsum(count)]),
            (active.column[entries] - own.start).astype(np.int32),
        )


class _HierarchyOfFields:
    """Levels of each overlay."""

    def __init__(self, active: ActiveGrid, constrained: Flags, lattice: Integers) -> None:
        components = constrained.shape[1]
        self._parts: list[tuple[slice, Integers, _core.Multigrid]] = []
        for overlay in patterns_of_overlays(active):
            own = overlay.nodes
            if own.start == own.stop or overlay.entries is None:
                continue
            levels = _core.Multigrid(
                active.grid.dim, components, np.ascontiguousarray(lattice[own]), overlay.row_start,
                overlay.column, np.ascontiguousarray(constrained[own]),
            )  # fmt: skip
            unknowns = slice(own.start * components, own.stop * components)
            self._parts.append((unknowns, overlay.entries, levels))

    def begin(self) -> None:
        """As `Hierarchy.begin`."""
        for _, _, levels in self._parts:
            levels.begin()

    def fill(self, blocks: Floats) -> None:
        """As `Hierarchy.fill`."""
        for _, entries, levels in self._parts:
            levels.fill(blocks[entries])

    def cycle(self, residual: Floats, approximate: Floats) -> None:
        """As `Hierarchy.cycle`."""
        for unknowns, _, levels in self._parts:
            levels.cycle(residual[unknowns], approximate[unknowns])

    def bytes(self) -> int:
        """As `Hierarchy.bytes`."""
        return sum(entries.nbytes + levels.bytes() for _, entries, levels in self._parts)
