# SPDX-License-Identifier: BSD-3-Clause
"""The linear system of one step: node blocks in, free degrees of freedom out."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from tilth import _core
from tilth.algebra.border import Border
from tilth.arrays import Flags, Floats, Integers, Shorts
from tilth.comm import inner
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.protocol import Matrix


class LinearSystem:
    """Node-block matrix with a pattern fixed over the step, and its restriction to free unknowns.

    Each node has as many unknowns as `constrained` has columns, 1, 2 or 3, for any dimension of
    the grid. With a border the system has global unknowns g in addition to the nodal ones x:
    [[A, B], [C, D]] [x; g] = [r; s]. A may then be singular, if the whole matrix is not.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components).
        memory: for the values, at least entries times components^2 numbers; allocated if not given.

    Attributes:
        blocks: the values, shape (entries of the pattern, components, components).
        active, constrained: see above.
        comm: the processes that share the grid.
        border: rows and columns of global unknowns; None without such unknowns.
        exact_nodes: sets of nodes, shape (nodes,) each, from many to few, whose equations an
            iterative solver may solve directly because it converges slowly there.
    """

    def __init__(
        self,
        active: ActiveGrid,
        constrained: Flags,
        memory: Floats | None = None,
    ) -> None:
        components = constrained.shape[1]
        size = len(active.column) * components**2
        memory = np.empty(size) if memory is None else memory[:size]
        self.blocks: Floats = memory.reshape(-1, components, components)
        self.active = active
        self.constrained = constrained
        self.comm = active.comm
        self.border: Border | None = None
        self.exact_nodes: list[Flags] = []

    @property
    def components(self) -> int:
        """Number of unknowns of each node."""
        return int(self.constrained.shape[1])

    def times(self, vector: Floats) -> Floats:
        """Returns A times a nodal vector, constrained rows included, shape (nodes, components)."""
        product = np.empty(vector.shape)
        _core.block_product(
            self.components, self.active.row_start, self.active.column, self.blocks,
            np.zeros(vector.shape, dtype=bool), vector, product,
        )  # fmt: skip
        return product

    def inner_products(self, rows: Floats, vector: Floats) -> Floats:
        """Returns the products of rows (m, nodes, components) with a nodal vector, shape (m,)."""
        own = self.active.owned
        return np.array([inner(self.comm, row[own], vector[own]) for row in rows])

    @property
    def free(self) -> Integers:
        """node * components + component of each free unknown, in a fill-reducing order."""
        return self._restriction[0]

    def matrix(self) -> Matrix:
        """Returns A on the free unknowns, in the fill-reducing order of `free`."""
        _, start, row, source = self._restriction
        values = np.empty(len(source))
        _core.gather(source, self.blocks, values)
        return Matrix(values, row, start, self.comm)

    @cached_property
    def _restriction(self) -> tuple[Integers, Shorts, Shorts, Integers]:
        active = self.active
        order = np.asarray(_core.nested_dissection(active.lattice, active.coupling_distance))
        free, start, row, source = _core.restrict_to_free(
            self.components, active.row_start, active.column, order, self.constrained
        )
        return np.asarray(free), np.asarray(start), np.asarray(row), np.asarray(source)
