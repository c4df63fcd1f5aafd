# SPDX-License-Identifier: BSD-3-Clause
"""LAPACK's LU factors of a band matrix: the quickest way to solve for a slender body."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp
from scipy.linalg.lapack import dgbtrf, dgbtrs
from scipy.sparse.csgraph import reverse_cuthill_mckee

from tilth.solvers.protocol import Floats, Solution, SolveFailed, refined

Integers = npt.NDArray[np.int64]


class BandedLU:
    """LU factorisation with partial pivoting, in an order of the unknowns with a narrow band.

    The order is the reverse of Cuthill and McKee's (1969); work for an unknown is proportional to
    the square of the band's width.
    """

    def __init__(self) -> None:
        self._indices = self._indptr = np.zeros(0, dtype=np.int32)

    @classmethod
    def available(cls) -> bool:
        """Returns True: SciPy is a requirement of tilth."""
        return True

    def setup(self, matrix: sp.csc_matrix, near_null_space: Floats | None = None) -> None:
        """Factorises `matrix`; `near_null_space` is not needed."""
        self._matrix = matrix
        same = np.array_equal(matrix.indptr, self._indptr)
        if not (same and np.array_equal(matrix.indices, self._indices)):
            self._find_band(matrix)
        lower, upper = self._lower, self._upper
        rows, n = 2 * lower + upper + 1, matrix.shape[0]  # as LAPACK wants it
        values = np.zeros(rows * n)
        values[self._place] = matrix.data
        band = values.reshape((rows, n), order="F")
        self._factors, self._pivots, info = dgbtrf(band, lower, upper, overwrite_ab=True)
        if info > 0:
            raise SolveFailed(f"the linear system is singular (pivot {info} is zero)")

    def _find_band(self, matrix: sp.csc_matrix) -> None:
        """Orders the unknowns; the place in LAPACK's storage of each entry of such a pattern."""
        self._indices, self._indptr = matrix.indices, matrix.indptr
        n = matrix.shape[0]
        self._order: Integers = reverse_cuthill_mckee(matrix).astype(np.int64)
        rank = np.empty(n, dtype=np.int64)
        rank[self._order] = np.arange(n)
        row = rank[matrix.indices]
        column = np.repeat(rank, np.diff(matrix.indptr))
        below = row - column
        self._lower, self._upper = (int(width.max(initial=0)) for width in (below, -below))
        rows = 2 * self._lower + self._upper + 1
        self._place = column * rows + self._lower + self._upper + below

    def solve(self, right_side: Floats) -> Solution:
        """Solves for one right side, shape (n,)."""
        return refined(self._matrix, right_side, self._apply_inverse)

    def _apply_inverse(self, right_side: Floats) -> Floats:
        x = np.empty_like(right_side)
        x[self._order], _ = dgbtrs(
            self._factors, self._lower, self._upper, right_side[self._order], self._pivots
        )
        return x
