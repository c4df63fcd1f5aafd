# SPDX-License-Identifier: BSD-3-Clause
"""The material points over the processes: each owns those in its cells and copies those around.

With the copies a process has all soil that acts on the nodes that it owns. It computes their forces
and rows of the matrix as a serial run does, and nothing is summed over the processes but what all
of them share (docs/theory/many_machines.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.comm import SERIAL, Communicator, total
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.grid.decomposition import Boxes, TooManyProcesses, bisected
from tilth.grid.keys import places_of_keys
from tilth.grid.shared_nodes import SharedNodes
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints, PointRange

LAYERS = 3
"""Layers of cells around a process' own whose points it copies, besides those that domains reach.

A face of the ghost stabilisation reaches two cells from a node, and whether its cells are at the
edge of the soil one more."""

LAYERS_OF_ROWS = 6
"""The same for states with rows of cells or nodes; more than a step needs."""

LARGEST_LOAD = 1.1
"""Points of a process, relative to the mean, from which on the cells are shared out anew."""


@runtime_checkable
class KeyedRows(Protocol):
    """A state from step to step, some of whose arrays have rows that belong to nodes or cells."""

    def rows(self) -> tuple[Integers, list[str]]:
        """Returns the key of a node or cell for each row, (n,), and the names of these arrays.

        The rows ascend in the first one.
        """
        ...

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """Returns all arrays by name."""
        ...

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """Takes over arrays as `state` returns them."""
        ...


class Distribution:
    """Which points this process owns, and of which it has copies.

    Args:
        comm: the processes.
        points: all points, in all processes.
        grid: of the first step.
        keyed: returns what else persists and follows the cells.

    Attributes:
        comm: the processes.
        boxes: the cells of each process.
        own: which of this process' points it owns, in their order, shape (n,).
        moved: number of points that have come from other processes since the start.

    Raises:
        BadInput: there are more processes than cells with points.
    """

    def __init__(
        self,
        comm: Communicator,
        points: MaterialPoints,
        grid: Grid,
        keyed: Callable[[], Sequence[KeyedRows]] = tuple,
    ) -> None:
        self.comm = comm
        self._keyed = keyed
        self.own: Flags = np.ones(len(points), dtype=bool)
        self.moved = 0
        self._total = len(points)
        self._least_load = 1.0  # after the cells were shared out; layers of cells stay together
        self._ranges = points.ranges
        self._varying = points.varying
        dim = grid.dim
        self.boxes = Boxes(0, dim)
        if comm.size > 1:
            cell = _cells(points, grid)
            try:
                self.boxes = bisected(SERIAL, comm.size, cell)
            except TooManyProcesses:
                raise BadInput(
                    f"there are too few cells with soil for {comm.size} processes",
                    "give mpiexec a smaller number of processes (-n)",
                ) from None
            owner = self.boxes.owner(cell)
            self.own = owner == comm.rank
            for each in keyed():
                self._hand_out(each, None)
            self._least_load = float(np.bincount(owner).max() * comm.size / len(points))

    @property
    def serial(self) -> bool:
        """Whether there is only this process."""
        return self.comm.size == 1

    @property
    def overlays(self) -> int:
        """Number of overlays of all processes' points."""
        return max(range_.overlay for range_ in self._ranges) + 1

    @property
    def total(self) -> int:
        """Number of points of all processes."""
        return self._total

    def owned(self, points: MaterialPoints) -> MaterialPoints:
        """Returns the points without the copies of other processes' points."""
        return points if self.serial else points.selected(self.own)

    def with_ranges(self, changed: Callable[[PointRange], PointRange]) -> Distribution:
        """Returns the same for points whose ranges are others; it never shares the cells out anew.

        changed: returns a range of the other points by that of these.
        """
        other = copy(self)
        other._ranges = [changed(range_) for range_ in self._ranges]
        other._least_load = np.inf
        return other

    def place(self, points: MaterialPoints, number: int) -> Floats:
        """Returns the position of the point with this number, wherever it is [length], (dim,).

        All processes call it.
        """
        row = points.index_of(np.array([number]))[0]
        found = self.comm.gathered(None if row < 0 else points.position[row].copy())
        return next(each for each in found if each is not None)

    def arranged(self, points: MaterialPoints, grid: Grid) -> MaterialPoints:
        """Returns the points of this process' cells at their present places, and the copies.

        All processes call it at the start of a step; the copies of the last step are discarded.
        """
        if self.serial:
            return points
        rank, ranks = self.comm.rank, range(self.comm.size)
        own, cell = self.own, _cells(points, grid)
        self._share_out(cell[own])
        owner = self.boxes.owner(cell)
        goes = own & (owner != rank)
        comes = self._exchanged(points, [goes & (owner == r) if r != rank else None for r in ranks])
        self.moved += sum(map(len, comes))
        same = not goes.any() and not any(map(len, comes))
        if not same:
            points = self._joined([points.selected(own & ~goes), *comes])
            own, cell = np.ones(len(points), dtype=bool), _cells(points, grid)
        found = self.comm.sum(float(own.sum()))
        assert found == self._total, f"{found:.0f} of {self._total} points after their exchange"
        layers = LAYERS + _reach(self.comm, points, grid)
        near = [own & self.boxes.near(r, cell, layers) if r != rank else None for r in ranks]
        copies = self._exchanged(points, near)
        if same and _renewed(points, ~own, copies):
            return points
        copies[rank] = points if own.all() else points.selected(own)
        return self._joined(copies)

    def located(self, active: ActiveGrid) -> ActiveGrid:
        """Returns the grid of a step with what other processes have of it, too."""
        if self.serial:
            return active
        rank = self.comm.rank
        self.own = self.boxes.owner(_cells(active.points, active.grid)) == rank
        shared = SharedNodes(self.comm, self.boxes, active.key, active.overlays)
        return replace(active, shared=shared)

    def _share_out(self, cell: Integers) -> None:
        """Shares the cells out anew if a process has too many points; cell: of the own ones."""
        load = max(self.comm.gathered(len(cell))) * self.comm.size / self._total
        if load > LARGEST_LOAD * max(self._least_load, 1.0):
            before = self.boxes
            self.boxes = bisected(self.comm, self.comm.size, cell)
            for each in self._keyed():
                self._hand_out(each, before)
            owner = self.boxes.owner(cell)
            owned = np.bincount(owner, minlength=self.comm.size).astype(float)
            self._least_load = total(self.comm, owned).max() * self.comm.size / self._total

    def owns(self, key: Integers) -> Flags:
        """Returns which of the cells or nodes with these keys this process owns, shape (n,)."""
        return np.asarray(self.boxes.owner(self._places(key)) == self.comm.rank)

    def _places(self, key: Integers) -> Integers:
        return places_of_keys(key, 1 + max(range_.overlay for range_ in self._ranges))[0]

    def _hand_out(self, keyed: KeyedRows, before: Boxes | None) -> None:
        """Gives each process the rows of the cells of its box and around it.

        before: boxes whose owners have the rows; None if all processes have all.
        """
        state, (key, names) = keyed.state(), keyed.rows()
        cell = self._places(key)
        rank, ranks = self.comm.rank, range(self.comm.size)
        near = [self.boxes.near(r, cell, LAYERS_OF_ROWS) for r in ranks]
        if before is None:
            keyed.restore(state | {name: state[name][near[rank]] for name in names})
            return
        own = before.owner(cell) == rank
        found = self.comm.exchanged([[state[name][own & near[r]] for name in names] for r in ranks])
        arrays = [np.concatenate(parts) for parts in zip(*found, strict=True)]
        order = np.argsort(arrays[0], kind="stable")
        keyed.restore(state | {n: each[order] for n, each in zip(names, arrays, strict=True)})

    def gathered(self, points: MaterialPoints) -> dict[str, npt.NDArray[Any]]:
        """Returns the arrays of the points of all processes, range by range, in process 0.

        An empty dictionary in the others; the arrays of the points themselves in a serial run.
        """
        if self.serial:
            return dict(points.arrays())
        found = {}
        order: Integers | None = None
        for name, array in [("range", self._range_of_points(points)), *points.arrays().items()]:
            parts = self.comm.gathered_first(np.ascontiguousarray(array[self.own]))
            if parts:
                found[name] = np.concatenate(parts)
                if name == "point_id":
                    order = np.lexsort((found["point_id"], found["range"]))
        found.pop("range", None)
        return {name: array[order] for name, array in found.items()}

    def whole(self, points: MaterialPoints) -> MaterialPoints:
        """Returns the points of all processes in each of them."""
        if self.serial:
            return points
        arrays = self.comm.gathered(self.gathered(points))[0]
        own = np.bincount(self._range_of_points(points)[self.own], minlength=len(self._ranges))
        counts = total(self.comm, own.astype(float)).astype(int)
        return MaterialPoints(ranges=self._ranges_of(counts), varying=self._varying, **arrays)

    def _ranges_of(self, counts: Integers) -> list[PointRange]:
        """Returns ranges with these numbers of points that follow each other; no empty ones."""
        ends = np.cumsum(counts).tolist()
        return [
            replace(range_, start=end - count, stop=end)
            for range_, count, end in zip(self._ranges, counts.tolist(), ends, strict=True)
            if count
        ]

    def _exchanged(
        self, points: MaterialPoints, chosen: Sequence[Flags | None]
    ) -> list[MaterialPoints]:
        """Sends points, by flags (n,) for each process; returns what comes from each."""
        values = []
        for flags in chosen:
            part = None if flags is None or not flags.any() else points.selected(flags)
            values.append(
                None
                if part is None
                else ([(b.body, b.layer, b.stop - b.start) for b in part.ranges], part.arrays())
            )
        none = points.selected(np.zeros(len(points), dtype=bool))
        return [
            none if each is None else self._points(*each) for each in self.comm.exchanged(values)
        ]

    def _points(self, counts: list[tuple[int, int, int]], arrays: dict[str, Any]) -> MaterialPoints:
        known = {(range_.body, range_.layer): range_ for range_ in self._ranges}
        ranges: list[PointRange] = []
        start = 0
        for number, layer, count in counts:
            range_ = known[number, layer]
            ranges.append(replace(range_, start=start, stop=start + count))
            start += count
        return MaterialPoints(ranges=ranges, varying=self._varying, **arrays)

    def _joined(self, parts: list[MaterialPoints]) -> MaterialPoints:
        """Returns the points of all parts, those of one range in the order of their numbers."""
        arrays = {
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in MaterialPoints.array_names()
        }
        number = np.concatenate([self._range_of_points(part) for part in parts])
        order = np.lexsort((arrays["point_id"], number))
        ranges = self._ranges_of(np.bincount(number, minlength=len(self._ranges)))
        return MaterialPoints(
            ranges=ranges,
            varying=self._varying,
            **{name: array.take(order, axis=0) for name, array in arrays.items()},
        )

    def _range_of_points(self, points: MaterialPoints) -> Integers:
        """Returns the number of each point's range among those of all points, shape (n,)."""
        of_range = {(range_.body, range_.layer): i for i, range_ in enumerate(self._ranges)}
        number = np.zeros(len(points), dtype=np.int64)
        for range_ in points.ranges:
            number[range_.points] = of_range[range_.body, range_.layer]
        return number


def _renewed(points: MaterialPoints, copied: Flags, copies: Sequence[MaterialPoints]) -> bool:
    """Renews the copies of other processes' points, by flags (n,), if they are of the same points.

    Returns whether they are: else the points are as before.
    """
    index = np.flatnonzero(copied)
    number = np.concatenate([each.point_id for each in copies])
    if len(number) != len(index):
        return False
    index, order = index[np.argsort(points.point_id[index])], np.argsort(number)
    if not np.array_equal(points.point_id[index], number[order]):
        return False
    for name, array in points.arrays().items():
        array[index] = np.concatenate([getattr(each, name) for each in copies])[order]
    return True


def _cells(points: MaterialPoints, grid: Grid) -> Integers:
    """Returns the lattice indices of the points' cells, shape (n, dim)."""
    return np.floor(grid.in_cells(points.position)).astype(np.int64)


def _reach(comm: Communicator, points: MaterialPoints, grid: Grid) -> int:
    """Returns how many cells the domains of the points reach beyond their own, at most."""
    reach = 0.0
    for range_ in points.ranges:
        if range_.basis != "linear":
            half = points.half_length[range_.points]
            size = grid.sizes_at(points.position[range_.points])
            reach = max(reach, float(np.ceil((half / size).max())))
    return int(comm.max(reach))
