# SPDX-License-Identifier: BSD-3-Clause
"""Sparsity pattern of a step's node-block matrix; reused while the active nodes stay the same."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tilth import _core
from tilth.arrays import Integers, Shorts, make_read_only
from tilth.grid.keys import places_of_keys


@dataclass(frozen=True)
class Elements:
    """Elements of few nodes each in the matrix's pattern; the arrays become read-only.

    Attributes:
        node_start: first entry of each element in `node`, shape (elements + 1,).
        node: node numbers, shape (entries,).
        colour_start, slab_start, order: order of parallel assembly (kernel/stencil.hpp).
        block_start, block_position: positions of their blocks in the matrix (sparse/pattern.hpp).
        coupling_distance: largest number of cells between two nodes of an element.
    """

    node_start: Integers
    node: Shorts
    colour_start: Integers
    slab_start: Integers
    order: Integers
    block_start: Integers
    block_position: Shorts
    coupling_distance: int

    def __post_init__(self) -> None:
        make_read_only(
            self.node_start, self.node, self.colour_start, self.slab_start, self.order,
            self.block_start, self.block_position,
        )  # fmt: skip


class Pattern:
    """Pattern of the matrix that couples the nodes of each group, and those of each element.

    Args:
        key: sorted keys of the active nodes, shape (nodes,).
        groups: per range, first entry of each group in the list of nodes, and this list.
        couplings: per coupling, first entry of each element in the list of nodes, and this list.
        overlays: their number.

    Attributes:
        row_start: first block of each row, shape (nodes + 1,).
        column: of each block, sorted within a row.
    """

    def __init__(
        self,
        key: Integers,
        groups: list[tuple[Integers, Shorts]],
        couplings: list[tuple[Integers, Shorts]],
        overlays: int = 1,
    ) -> None:
        self._overlays = overlays
        self._key, self._groups, self._couplings = key, groups, couplings
        lists = groups + couplings
        offsets = np.cumsum([0] + [len(node) for _, node in lists])
        start = [start[:-1] + offset for (start, _), offset in zip(lists, offsets, strict=False)]
        self.row_start: Integers
        self.column: Shorts
        self.row_start, self.column = _core.block_pattern(
            len(key),
            np.concatenate([*start, offsets[-1:]]),
            np.concatenate([node for _, node in lists]),
        )

    def matches(
        self,
        key: Integers,
        groups: list[tuple[Integers, Shorts]],
        couplings: list[tuple[Integers, Shorts]],
    ) -> bool:
        """Returns whether this is also the pattern of these nodes, groups and couplings."""
        own = self._groups + self._couplings
        arrays = [self._key, *(array for pair in own for array in pair)]
        other = [key, *(array for pair in groups + couplings for array in pair)]
        return len(arrays) == len(other) and all(map(np.array_equal, arrays, other))

    @cached_property
    def block_positions(self) -> list[tuple[Integers, Shorts]]:
        """Per range, positions of the blocks of its groups in the matrix: start, position."""
        return [
            _core.block_positions(start, node, self.row_start, self.column)
            for start, node in self._groups
        ]

    @cached_property
    def elements(self) -> list[Elements]:
        """The elements of each coupling, in the order in which the couplings were declared."""
        lattice, _ = places_of_keys(self._key, self._overlays)
        return [self._elements(start, node, lattice[node]) for start, node in self._couplings]

    def _elements(self, start: Integers, node: Shorts, index: Integers) -> Elements:
        positions = _core.block_positions(start, node, self.row_start, self.column)
        if len(node) == 0:
            first, last = np.zeros((2, len(start) - 1, 3), dtype=np.int64)
        else:
            first = np.minimum.reduceat(index, start[:-1])
            last = np.maximum.reduceat(index, start[:-1])
        count = (last - first + 1).astype(np.int32)
        distance = int(count.max(initial=1)) - 1
        return Elements(start, node, *_core.colour_groups(first, count), *positions, distance)

    @cached_property
    def diagonal(self) -> Integers:
        """Position of each node's diagonal block in the matrix, shape (nodes,)."""
        rows = np.repeat(np.arange(len(self._key)), np.diff(self.row_start))
        return np.flatnonzero(rows == self.column)


def same_starts(node: Shorts) -> Integers:
    """Returns the first entries of elements of n nodes each, (elements, n) -> (elements + 1,)."""
    return np.arange(len(node) + 1, dtype=np.int64) * int(node.shape[1])
