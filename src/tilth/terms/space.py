# SPDX-License-Identifier: BSD-3-Clause
"""The fields of a step, which of their nodes terms couple, and where the blocks are."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix, BlockPattern, Pair
from tilth.algebra.field import DISPLACEMENT, MOMENTUM, Field, Prescribed
from tilth.arrays import Floats, Integers, Shorts
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Pattern

OF_DISPLACEMENT: Pair = (DISPLACEMENT, DISPLACEMENT)


@dataclass(frozen=True, eq=False)
class Coupled:
    """Elements in each of which all nodes of a field are coupled.

    Attributes:
        start: first entry of each element in `node`, shape (elements + 1,).
        node: node numbers, shape (entries,).
        field: name of the field.
        other: the nodes of another field in the same elements, with which they are coupled, both
            ways; with each other if None.
    """

    start: Integers
    node: Shorts
    field: str = DISPLACEMENT
    other: Coupled | None = None

    @property
    def pair(self) -> Pair:
        """Names of the fields."""
        return self.field, (self.other or self).field

    @property
    def of_displacement(self) -> bool:
        """Whether it is the displacement that is coupled with itself."""
        return self.pair == OF_DISPLACEMENT

    def reversed(self) -> Coupled:
        """Returns the same with the other field first."""
        if self.other is None:
            return self
        own = Coupled(self.start, self.node, self.field)
        return Coupled(self.other.start, self.other.node, self.other.field, own)


@dataclass(frozen=True)
class RectangularPattern:
    """Which nodes of two fields are coupled, see `BlockPattern`."""

    row_start: Integers
    column: Shorts

    @classmethod
    def of(cls, rows: int, columns: int, coupled: Iterable[Coupled]) -> RectangularPattern:
        """Returns that of elements, for so many nodes of either field."""
        keys = [np.zeros(0, dtype=np.int64)]
        for each in coupled:
            row, column = entries_of(each)
            keys.append(row * columns + column)
        key = np.unique(np.concatenate(keys))
        row = key // max(columns, 1)
        row_start = np.searchsorted(row, np.arange(rows + 1))
        return cls(row_start.astype(np.int64), (key - row * columns).astype(np.int32))


def entries_of(coupled: Coupled) -> tuple[Integers, Integers]:
    """Returns nodes of row and column of all entries of the elements' matrices, row by row."""
    other = coupled.other or coupled
    rows, columns = np.diff(coupled.start), np.diff(other.start)
    sizes = rows * columns
    element = np.repeat(np.arange(len(rows)), sizes)
    within = np.arange(len(element)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    row = coupled.node[coupled.start[element] + within // columns[element]]
    column = other.node[other.start[element] + within % columns[element]]
    return row.astype(np.int64), column.astype(np.int64)


@dataclass(frozen=True, eq=False)
class ElementBlocks:
    """Places of elements' matrices in a block of the matrix.

    Attributes:
        pair: names of the fields of row and column.
        position: of each entry of the elements' matrices, row by row, element by element.
    """

    pair: Pair
    position: Integers

    def add(self, matrix: BlockMatrix, values: Floats) -> None:
        """Adds matrices of the elements, (entries, row components, column components)."""
        np.add.at(matrix[self.pair].values, self.position, values)


class Space:
    """The fields of a step, and which of their nodes its matrix couples.

    Args:
        active: the grid of the step.
        fields: the displacement, then all others.
        coupled: elements of all terms.
        at_points: pairs of fields of the grid that terms couple at material points, both ways; the
            displacement with itself in any case.

    Attributes:
        active: the grid with the pattern of the displacement.
        fields: by their names.
    """

    def __init__(
        self,
        active: ActiveGrid,
        fields: Sequence[Field],
        coupled: Sequence[Coupled],
        at_points: Iterable[Pair] = (),
    ) -> None:
        alone = [each for each in coupled if each.of_displacement]
        self.active = active.with_couplings([(each.start, each.node) for each in alone])
        self.fields = {each.name: each for each in fields}
        self._others = [each for each in coupled if not each.of_displacement]
        self._at_points = [pair for pair in at_points if pair != OF_DISPLACEMENT]
        self._key_of: dict[int, Integers] = {}  # by the pattern, which `patterns` keeps alive

    def _on_grid(self, name: str) -> bool:
        return isinstance(self.fields[name].nodes, ActiveGrid)

    @cached_property
    def _of_grid(self) -> Pattern:
        """Pattern of the other fields of the grid, with each other and with the displacement."""
        active = self.active
        none = np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int32)
        wet = [self.fields[name].active for pair in self._at_points for name in pair]
        flags = [each for each in wet if each is not None]
        groups = []
        for stencil in active.stencils:
            node = stencil.node
            there = bool(self._at_points) and all(each[node].any() for each in flags)
            groups.append((stencil.node_start, node) if there else none)
        single = np.arange(active.nodes + 1), np.arange(active.nodes, dtype=np.int32)
        couplings = [single]
        for each in self._others:
            if all(map(self._on_grid, each.pair)):
                other = each.other or Coupled(*none)
                couplings.append(_joined(each, other))
        pattern = active.buffers.pattern(
            active.key, groups, couplings, active.overlays, "of other fields"
        )
        same = np.array_equal(pattern.row_start, active.row_start) and np.array_equal(
            pattern.column, active.column
        )
        if same:  # one in memory
            pattern.row_start, pattern.column = active.row_start, active.column
        return pattern

    @cached_property
    def patterns(self) -> dict[Pair, BlockPattern]:
        """Of each pair of fields that are coupled, that of the displacement first."""
        found: dict[Pair, BlockPattern] = {OF_DISPLACEMENT: self.active}
        diagonal = [(name, name) for name in self.fields]
        pairs = [*diagonal, *self._at_points, *(each.pair for each in self._others)]
        for row, column in pairs:
            for pair in ((row, column), (column, row)):
                if pair not in found:
                    found[pair] = self._pattern(pair)
        return found

    def _pattern(self, pair: Pair) -> BlockPattern:
        if all(map(self._on_grid, pair)):
            return self._of_grid
        rows, columns = (self.fields[name].nodes.count for name in pair)
        elements = [each for each in self._others if each.pair == pair]
        if pair[0] != pair[1]:
            elements += [each.reversed() for each in self._others if each.pair == pair[::-1]]
        else:  # each node has a diagonal block
            elements.append(Coupled(np.arange(rows + 1), np.arange(rows, dtype=np.int32), pair[0]))
        return RectangularPattern.of(rows, columns, elements)

    def matrix(self) -> BlockMatrix:
        """Returns the matrix of the step, its entries undefined, in memory that steps reuse."""
        buffers = self.active.buffers
        return BlockMatrix(self.fields, self.patterns, lambda size: buffers.take("matrix", size))

    def positions(self, pair: Pair) -> list[tuple[Integers, Shorts]]:
        """Returns, per range of points, positions of the blocks of its groups: start, position.

        No groups of a range none of whose nodes has the fields.
        """
        pattern = self.active if pair == OF_DISPLACEMENT else self._of_grid
        return pattern.block_positions

    def blocks_of(self, coupled: Coupled) -> list[ElementBlocks]:
        """Returns the places of elements' matrices: of the pair, and of the pair reversed."""
        found = []
        both = (coupled,) if coupled.other is None else (coupled, coupled.reversed())
        for each in both:
            row, column = entries_of(each)
            columns = self.fields[each.pair[1]].nodes.count
            position = np.searchsorted(self._keys(each.pair), row * columns + column)
            found.append(ElementBlocks(each.pair, position))
        return found

    def _keys(self, pair: Pair) -> Integers:
        """Returns row times the number of columns plus column of each entry of a pattern."""
        pattern = self.patterns[pair]
        if id(pattern) not in self._key_of:
            rows = np.repeat(np.arange(len(pattern.row_start) - 1), np.diff(pattern.row_start))
            columns = self.fields[pair[1]].nodes.count
            self._key_of[id(pattern)] = rows * columns + pattern.column
        return self._key_of[id(pattern)]


def _joined(one: Coupled, other: Coupled) -> tuple[Integers, Shorts]:
    """Returns the nodes of both in each element: first entries, and nodes."""
    if len(other.start) != len(one.start):
        return one.start, one.node
    element = [np.repeat(np.arange(len(e.start) - 1), np.diff(e.start)) for e in (one, other)]
    order = np.argsort(np.concatenate(element), kind="stable")
    return one.start + other.start, np.concatenate([one.node, other.node])[order]


def displacement_of(active: ActiveGrid, prescribed: Prescribed | None = None) -> Field:
    """Returns the field of the displacement on a grid; prescribed: in the step."""
    return Field(DISPLACEMENT, active, active.grid.dim, MOMENTUM, prescribed=prescribed)
