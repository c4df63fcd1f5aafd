# SPDX-License-Identifier: BSD-3-Clause
"""Direct solution of the equations of selected nodes, where the smoother of multigrid is slow."""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.memory_errors import is_memory_error
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.protocol import SolveFailed


class SubdomainCorrection:
    """Factors of the matrix of selected nodes' free unknowns, and the whole rows of these nodes.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components).
        blocks: of the matrix, shape (entries of the pattern, components, components).
        selected: whether a node is selected, shape (nodes,).

    Raises:
        SolveFailed: if the matrix of the selected nodes is singular.
    """

    def __init__(
        self, active: ActiveGrid, constrained: Flags, blocks: Floats, selected: Flags
    ) -> None:
        import scipy.sparse as sp  # take 0.2 s: only where they are used
        from scipy.sparse.linalg import splu

        components = blocks.shape[1]
        node = np.flatnonzero(selected)
        index = np.ascontiguousarray(active.lattice[node])
        node = node[np.asarray(_core.nested_dissection(index, active.coupling_distance))]
        first, count = active.row_start[node], np.diff(active.row_start)[node]
        start = np.concatenate([[0], np.cumsum(count)])
        entry = np.repeat(first - start[:-1], count) + np.arange(start[-1])
        rows = sp.bsr_matrix(
            (blocks[entry], active.column[entry], start),
            shape=(len(node) * components, active.nodes * components),
        ).tocsr()
        unknown = (node[:, None] * components + np.arange(components)).ravel()
        free = ~constrained.ravel()[unknown]
        self.unknown = unknown[free]
        self._rows = rows[free]
        self._columns = self._rows.T  # shares its memory
        try:
            self._factors = splu(
                sp.csc_matrix(self._rows[:, self.unknown]),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            if is_memory_error(error):
                raise MemoryError(f"SuperLU: {error}") from error
            raise SolveFailed(f"the matrix of the selected nodes is singular ({error})") from error

    def solve(self, residual: Floats) -> Floats:
        """Returns the correction that removes `residual` on the selected nodes; zero elsewhere."""
        correction = np.zeros_like(residual)
        correction[self.unknown] = self._factors.solve(residual[self.unknown])
        return correction

    def remaining(self, residual: Floats, correction: Floats) -> Floats:
        """Returns the residual that a correction of the selected nodes leaves, (unknowns,).

        Only for a symmetric matrix: its columns are the rows of the selected nodes.
        """
        return np.asarray(residual - self._columns @ correction[self.unknown])

    def improve(self, approximate: Floats, residual: Floats) -> None:
        """Removes the residual of an approximate solution on the selected nodes, in place.

        residual: that of the zero solution, shape (unknowns,).
        """
        remaining = residual[self.unknown] - self._rows @ approximate
        approximate[self.unknown] += self._factors.solve(remaining)
