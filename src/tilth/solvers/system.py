# SPDX-License-Identifier: BSD-3-Clause
"""The linear system of one step: node blocks in, free degrees of freedom out."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid
from tilth.solvers.protocol import Matrix


class LinearSystem:
    """Node-block matrix with a pattern fixed over the step, and its restriction to free unknowns.

    Args:
        memory: where the values stand, at least entries times dim^2; its own if not given.

    Attributes:
        blocks: the values, shape (entries of the pattern, dim, dim).
        active: the active grid, which owns the pattern.
        held: prescribed degrees of freedom, shape (nodes, dim).
        hard: nodes where an iterative solver may need help, shape (nodes,): all of them first, then
            the fewer that need it most.
    """

    def __init__(
        self, active: ActiveGrid, held: npt.NDArray[np.bool_], memory: Floats | None = None
    ) -> None:
        dim = active.grid.dim
        size = len(active.column) * dim**2
        memory = np.empty(size) if memory is None else memory[:size]
        self.blocks: Floats = memory.reshape(-1, dim, dim)
        self.active = active
        self.held = held
        self.hard: list[npt.NDArray[np.bool_]] = []

    def times(self, displacement: Floats) -> Floats:
        """Returns the product of the whole matrix with nodal vectors, shape (nodes, dim)."""
        product = np.empty(displacement.shape)
        _core.block_product(
            displacement.shape[1], self.active.row_start, self.active.column, self.blocks,
            np.zeros(displacement.shape, dtype=bool), displacement, product,
        )  # fmt: skip
        return product

    @property
    def free(self) -> Integers:
        """node * dim + direction of each free unknown, in a fill-reducing order."""
        return self._restriction[0]

    def matrix(self) -> Matrix:
        """Returns the matrix of the free unknowns, in the fill-reducing order of `free`."""
        _, start, row, place = self._restriction
        values = np.empty(len(place))
        _core.gather(place, self.blocks, values)
        return Matrix(values, row, start)

    @cached_property
    def _restriction(
        self,
    ) -> tuple[Integers, npt.NDArray[np.int32], npt.NDArray[np.int32], Integers]:
        active = self.active
        order = np.asarray(_core.nested_dissection(active.lattice, active.reach))
        free, start, row, place = _core.restrict_to_free(
            active.grid.dim, active.row_start, active.column, order, self.held
        )
        return np.asarray(free), np.asarray(start), np.asarray(row), np.asarray(place)
