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
        unknowns = (order[:, None] * dim + np.arange(dim)).ravel()
        self.free = unknowns[~fixed.ravel()[unknowns]]
        place = np.arange(self.blocks.size).reshape(self.blocks.shape)
        places = sp.bsr_matrix((place, *self._pattern), shape=self._shape).tocsr()
        self._places = places[self.free][:, self.free].tocsc()
        self._places.sort_indices()
        self._places.indices = self._places.indices.astype(np.int32)
        self._places.indptr = self._places.indptr.astype(np.int32)

    def times(self, displacement: Floats) -> Floats:
        """Returns the product of the whole matrix with nodal vectors, shape (nodes, dim)."""
        matrix = sp.bsr_matrix((self.blocks, *self._pattern), shape=self._shape)
        product: Floats = matrix @ displacement.ravel()
        return product.reshape(displacement.shape)

    def matrix(self) -> sp.csc_matrix:
        """Returns the matrix of the free unknowns, in the order of `free`."""
        places = self._places
        values = self.blocks.ravel()[places.data]
        return sp.csc_matrix((values, places.indices, places.indptr), shape=places.shape)
