# SPDX-License-Identifier: BSD-3-Clause
"""The linear system of one step: node blocks in, free degrees of freedom out."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers, Shorts
from tilth.comm import SERIAL, Communicator, inner
from tilth.mpm.bordered_matrix import Border
from tilth.mpm.grid import ActiveGrid
from tilth.solvers.protocol import Matrix


class LinearSystem:
    """Node-block matrix with a pattern fixed over the step, and its restriction to free unknowns.

    Each node has as many unknowns as `constrained` has columns, 1, 2 or 3, whatever the dimension
    of the grid. With a border the system has global unknowns g beside the nodal ones x:
    [[A, B], [C, D]] [x; g] = [r; s]. A may then be singular, if the whole matrix is not.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components).
        memory: where the values stand, at least entries times components^2; its own if not given.
        comm: the processes that share the grid.

    Attributes:
        blocks: the values, shape (entries of the pattern, components, components).
        active, constrained, comm: see above.
        border: what global unknowns add; None for no such unknowns.
        exact_nodes: choices of nodes, shape (nodes,) each, from many to few, whose equations an
            iterative solver may solve exactly, for it is slow there.
    """

    def __init__(
        self,
        active: ActiveGrid,
        constrained: Flags,
        memory: Floats | None = None,
        comm: Communicator = SERIAL,
    ) -> None:
        components = constrained.shape[1]
        size = len(active.column) * components**2
        memory = np.empty(size) if memory is None else memory[:size]
        self.blocks: Floats = memory.reshape(-1, components, components)
        self.active = active
        self.constrained = constrained
        self.comm = comm
        self.border: Border | None = None
        self.exact_nodes: list[Flags] = []

    @property
    def components(self) -> int:
        """Number of unknowns of each node."""
        return int(self.constrained.shape[1])

    def times(self, vector: Floats) -> Floats:
        """Returns the product of all of A with a nodal vector, shape (nodes, components)."""
        product = np.empty(vector.shape)
        _core.block_product(
            self.components, self.active.row_start, self.active.column, self.blocks,
            np.zeros(vector.shape, dtype=bool), vector, product,
        )  # fmt: skip
        return product

    def inner_products(self, rows: Floats, vector: Floats) -> Floats:
        """Returns those of each row, (m, nodes, components), with a nodal vector, shape (m,)."""
        own = slice(*self.active.owned)
        return np.array([inner(self.comm, row[own], vector[own]) for row in rows])

    @property
    def free(self) -> Integers:
        """node * components + component of each free unknown, in a fill-reducing order."""
        return self._restriction[0]

    def matrix(self) -> Matrix:
        """Returns A on the free unknowns, in the fill-reducing order of `free`."""
        _, start, row, place = self._restriction
        values = np.empty(len(place))
        _core.gather(place, self.blocks, values)
        return Matrix(values, row, start, self.comm)

    @cached_property
    def _restriction(self) -> tuple[Integers, Shorts, Shorts, Integers]:
        active = self.active
        order = np.asarray(_core.nested_dissection(active.lattice, active.reach))
        free, start, row, place = _core.restrict_to_free(
            self.components, active.row_start, active.column, order, self.constrained
        )
        return np.asarray(free), np.asarray(start), np.asarray(row), np.asarray(place)
