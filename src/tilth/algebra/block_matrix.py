# SPDX-License-Identifier: BSD-3-Clause
"""The matrix of a step: a block of node blocks for each pair of fields that terms couple."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from tilth import _core
from tilth.algebra.border import Border
from tilth.algebra.field import DISPLACEMENT, Field
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats, Integers, Shorts
from tilth.comm import inner

Pair = tuple[str, str]
"""Names of the fields of a block: that of its rows, and that of its columns."""


class BlockPattern(Protocol):
    """Which nodes of two fields are coupled."""

    @property
    def row_start(self) -> Integers:
        """First entry of each row, shape (row nodes + 1,)."""
        ...

    @property
    def column(self) -> Shorts:
        """Node of the column of each entry, sorted within a row."""
        ...


@dataclass(frozen=True, eq=False)
class Block:
    """Derivative of a field's residual by another field.

    Attributes:
        row, column: the fields.
        pattern: which of their nodes are coupled.
        values: shape (entries of the pattern, row.components, column.components); its memory is
            that of the whole matrix.
    """

    row: Field
    column: Field
    pattern: BlockPattern
    values: Floats

    def times(self, vector: Floats, magnitude: bool = False) -> Floats:
        """Returns the product with nodal values of the column's field, (row nodes, components).

        magnitude: whether to use the absolute values of the block's entries.
        """
        row_start, column = self.pattern.row_start, self.pattern.column
        values = np.abs(self.values) if magnitude else self.values
        if self.row is self.column and self.row.components <= 3:
            product = np.empty(self.row.shape)
            nothing = np.zeros(self.row.shape, dtype=bool)
            _core.block_product(
                self.row.components, row_start, column, values, nothing, vector, product
            )
            return product
        import scipy.sparse as sp  # takes 0.2 s: only where fields are coupled

        shape = (self.row.zero().size, self.column.zero().size)
        whole = sp.bsr_matrix((values, column, row_start), shape=shape)
        return np.asarray(whole @ vector.ravel()).reshape(self.row.shape)


class BlockMatrix:
    """Derivative of all residuals by all unknowns, in one piece of memory.

    Args:
        fields: by their names, in the order of the unknowns.
        patterns: of each pair of fields that are coupled; that of a pair both ways.
        take: returns memory for so many numbers; new memory if not given.

    Attributes:
        fields: see above.
        blocks: by pairs of names.
        border: rows and columns of the global unknowns, which only the displacement has; None
            without such unknowns.
        memory: the numbers of all blocks, one block after the other in the order of `blocks`.
    """

    def __init__(
        self,
        fields: Mapping[str, Field],
        patterns: Mapping[Pair, BlockPattern],
        take: Callable[[int], Floats] = np.empty,
    ) -> None:
        self.fields = dict(fields)
        self.border: Border | None = None
        sizes = {
            pair: len(pattern.column) * fields[pair[0]].components * fields[pair[1]].components
            for pair, pattern in patterns.items()
        }
        self.memory = take(sum(sizes.values()))
        self.blocks: dict[Pair, Block] = {}
        at = 0
        for pair, pattern in patterns.items():
            row, column = fields[pair[0]], fields[pair[1]]
            part = self.memory[at : at + sizes[pair]]
            values = part.reshape(-1, row.components, column.components)
            self.blocks[pair] = Block(row, column, pattern, values)
            at += sizes[pair]

    def __getitem__(self, pair: Pair) -> Block:
        if pair not in self.blocks:
            raise ValueError(
                f"the matrix has no block of {pair[0]!r} by {pair[1]!r}: the term that adds to it "
                "has to name this pair in `pairs_at_points`, or its elements in `coupled`"
            )
        return self.blocks[pair]

    def clear(self) -> None:
        """Sets all entries to zero."""
        self.memory.fill(0.0)

    def magnitude(self, x: Unknowns, name: str) -> Floats:
        """Returns the sum of the absolute values of the summands of a field's rows times x.

        Shape (nodes, components), without the block of the displacement by itself.
        """
        total = self.fields[name].zero()
        for (row, column), block in self.blocks.items():
            if row == name and (row, column) != (DISPLACEMENT, DISPLACEMENT):
                total += block.times(np.abs(x.of[column]), magnitude=True)
        return total

    def times(self, x: Unknowns) -> Unknowns:
        """Returns the product with all unknowns, rows of constrained ones included.

        It is complete at the nodes that this process owns.
        """
        product: dict[str, Floats] = {}
        for (row, column), block in self.blocks.items():
            part = block.times(x.of[column])
            product[row] = product[row] + part if row in product else part
        of_globals = np.zeros_like(x.globals)
        if self.border is not None:
            nodes = self.fields[DISPLACEMENT].nodes
            own, of_globals = nodes.owned, self.border.corner @ x.globals
            for name, rows in self.border.rows_by_field().items():
                values = x.of[name][own]
                of_globals += [inner(nodes.comm, row[own], values) for row in rows]
            of_border = np.tensordot(x.globals, self.border.columns, axes=1)
            product[DISPLACEMENT] = product[DISPLACEMENT] + of_border
        return Unknowns(product, of_globals)
