# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of the free unknowns of several fields, and where their coefficients are in memory."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats, Integers
from tilth.solvers.coupled_system import CoupledSystem


class FreeUnknowns:
    """Order of the free unknowns: process by process, in each of them field by field.

    Global unknowns come after all others, at the last process. A vector of a process has its own
    unknowns only.

    Args:
        system: says which unknowns are free; all processes call this together.

    Attributes:
        comm: the processes.
        count: number of unknowns that this process owns, without the global ones.
        first: number of its first one.
        total: number of those of all processes.
        number: of all unknowns that this process knows, by the fields' names, shape (nodes,
            components) each; -1 where constrained.
    """

    def __init__(self, system: CoupledSystem) -> None:
        self.comm = system.displacement.comm
        self._fields = system.matrix.fields
        self._own: dict[str, Integers] = {}
        for name, field in self._fields.items():
            free = np.zeros(field.shape, dtype=bool)
            free[field.nodes.owned] = ~system.constrained[name][field.nodes.owned]
            self._own[name] = np.flatnonzero(free)
        self.count = sum(map(len, self._own.values()))
        counts = self.comm.gathered(self.count)
        self.first, self.total = sum(counts[: self.comm.rank]), sum(counts)
        self.number: dict[str, Integers] = {}
        at = self.first
        for name, field in self._fields.items():
            number = np.full(field.shape, -1, dtype=np.int64)
            number.ravel()[self._own[name]] = np.arange(at, at + len(self._own[name]))
            self.number[name] = field.nodes.updated(number)
            at += len(self._own[name])

    @property
    def has_globals(self) -> bool:
        """Whether the global unknowns, if there are any, are in the vectors of this process."""
        return self.comm.rank == self.comm.size - 1

    def vector(self, values: Unknowns) -> Floats:
        """Returns the values of the unknowns that this process owns, shape (n,)."""
        parts = [values.of[name].ravel()[own] for name, own in self._own.items()]
        return np.concatenate([*parts, values.globals[: None if self.has_globals else 0]])

    def at_owned(self, vector: Floats) -> dict[str, Floats]:
        """Returns the values of a vector at the nodes of this process, 0 elsewhere."""
        of, at = {}, 0
        for name, own in self._own.items():
            of[name] = self._fields[name].zero()
            of[name].ravel()[own] = vector[at : at + len(own)]
            at += len(own)
        return of

    def values(self, vector: Floats, unknowns: int) -> Unknowns:
        """Returns the values of a vector at all nodes, 0 where constrained.

        All processes call it. unknowns: number of global ones.
        """
        own = self.at_owned(vector)
        of = {name: self._fields[name].nodes.updated(each) for name, each in own.items()}
        if unknowns == 0:
            return Unknowns(of)
        return Unknowns(of, self.comm.gathered(vector[self.count :].copy())[-1])

    def of_fields(self, values: dict[str, Floats]) -> Floats:
        """Returns values of each component of the fields, (components,), at the unknowns."""
        return self.vector(
            Unknowns({name: np.tile(values[name], (each.nodes.count, 1))
                      for name, each in self._fields.items()})
        )  # fmt: skip


@dataclass(frozen=True)
class Entries:
    """Coefficients of free unknowns in the rows of this process, shape (entries,) each.

    Attributes:
        row, column: numbers of the unknowns.
        source: place in the memory of the matrix.
    """

    row: Integers
    column: Integers
    source: Integers

    @classmethod
    def of(
        cls, matrix: BlockMatrix, unknowns: FreeUnknowns, chosen: Flags | None = None
    ) -> Entries:
        """Returns those of a matrix, of all rows or of those of nodes with chosen unknowns.

        chosen: which of all unknowns, shape (`unknowns.total`,).
        """
        parts, first = [], 0
        for (row, column), block in matrix.blocks.items():
            start, size = block.pattern.row_start, block.values[:1].size
            own = np.zeros(block.row.nodes.count, dtype=bool)
            own[block.row.nodes.owned] = True
            if chosen is not None:
                number = unknowns.number[row]
                own &= ((number >= 0) & chosen[number]).any(axis=1)
            node = np.repeat(np.arange(len(own)), np.diff(start))
            entry = np.flatnonzero(own[node])
            shape = (len(entry), *block.values.shape[1:])
            rows = unknowns.number[row][node[entry]][:, :, None]
            columns = unknowns.number[column][block.pattern.column[entry]][:, None, :]
            free = (rows >= 0) & (columns >= 0)
            within = np.arange(block.values[:1].size).reshape(shape[1:])
            source = first + entry[:, None, None] * size + within
            parts.append(
                tuple(np.broadcast_to(each, shape)[free] for each in (rows, columns, source))
            )
            first += block.values.size
        return cls(*(np.concatenate(each) for each in zip(*parts, strict=True)))
