# SPDX-License-Identifier: BSD-3-Clause
"""The exact solution on few nodes, which helps multigrid where its smoother does badly."""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.mpm.grid import ActiveGrid
from tilth.solvers.protocol import SolveFailed


class ExactPart:
    """The factors of the matrix of the free unknowns of some nodes, and those nodes' whole rows.

    Args:
        active: the active grid, which owns the pattern.
        constrained: prescribed degrees of freedom, shape (nodes, components).
        blocks: of the matrix, shape (entries of the pattern, components, components).
        chosen: the nodes, shape (nodes,).

    Raises:
        SolveFailed: if the part's matrix is singular.
    """

    def __init__(
        self, active: ActiveGrid, constrained: Flags, blocks: Floats, chosen: Flags
    ) -> None:
        import scipy.sparse as sp  # take 0.2 s: only where they are used
        from scipy.sparse.linalg import splu

        components = blocks.shape[1]
        node = np.flatnonzero(chosen)
        place = np.ascontiguousarray(active.lattice[node])
        node = node[np.asarray(_core.nested_dissection(place, active.reach))]
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
        try:
            self._factors = splu(
                sp.csc_matrix(self._rows[:, self.unknown]),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            raise SolveFailed(f"the part's matrix is singular ({error})") from error

    def solve(self, residual: Floats) -> Floats:
        """Returns the correction that balances `residual` on the chosen nodes; zero elsewhere."""
        correction = np.zeros_like(residual)
        correction[self.unknown] = self._factors.solve(residual[self.unknown])
        return correction

    def improve(self, approximate: Floats, residual: Floats) -> None:
        """Corrects an approximate solution for `residual` on the chosen nodes, in place."""
        remaining = residual[self.unknown] - self._rows @ approximate
        approximate[self.unknown] += self._factors.solve(remaining)
