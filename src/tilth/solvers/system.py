# SPDX-License-Identifier: BSD-3-Clause
"""The linear system of one step: node blocks in, free degrees of freedom out."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from tilth import _core
from tilth.grid import ActiveGrid

Floats = npt.NDArray[np.float64]


class LinearSystem:
    """Node-block matrix with a pattern fixed over the step, and its restriction to free unknowns.

    Attributes:
        blocks: the values, shape (entries of the pattern, dim, dim).
        free: node * dim + direction of each free unknown, in a fill-reducing order.

    Args:
        active: the active grid, which owns the pattern.
        fixed: prescribed degrees of freedom, shape (nodes, dim).
    """

    def __init__(self, active: ActiveGrid, fixed: npt.NDArray[np.bool_]) -> None:
        dim = active.grid.dim
        self.blocks: Floats = np.empty((len(active.column), dim, dim))
        self._pattern = (active.column, active.row_start)
        self._shape = (active.nodes * dim, active.nodes * dim)
        order = np.asarray(_core.nested_dissection(active.lattice, active.reach))
        self.free, self._start, self._row, self._place = _core.restrict_to_free(
            dim, active.row_start, active.column, order, fixed
        )

    def times(self, displacement: Floats) -> Floats:
        """Returns the product of the whole matrix with nodal vectors, shape (nodes, dim)."""
        matrix = sp.bsr_matrix((self.blocks, *self._pattern), shape=self._shape)
        product: Floats = matrix @ displacement.ravel()
        return product.reshape(displacement.shape)

    def matrix(self) -> sp.csc_matrix:
        """Returns the matrix of the free unknowns, in the fill-reducing order of `free`."""
        values = np.empty(len(self._place))
        _core.gather(self._place, self.blocks, values)
        size = len(self.free)
        return sp.csc_matrix((values, self._row, self._start), shape=(size, size))
