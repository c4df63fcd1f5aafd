# SPDX-License-Identifier: BSD-3-Clause
"""LU factorisation of a band matrix: the fastest direct solver for a slender body."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats
from tilth.solvers.protocol import Matrix, Solution, refined, unsolved


class BandedLU:
    """LU factorisation with partial pivoting, in an order of the unknowns with a narrow band.

    The order is reverse Cuthill-McKee (1969); the work per unknown is proportional to the square
    of the bandwidth.
    """

    name: ClassVar[str] = "banded"

    def __init__(self) -> None:
        self._indices: npt.NDArray[np.int32] = np.zeros(0, dtype=np.int32)
        self._indptr = self._indices

    @classmethod
    def available(cls) -> bool:
        """Returns True: the solver is part of the core."""
        return True

    def setup(self, matrix: Matrix, near_null_space: Floats | None = None) -> None:
        """Factorises `matrix`; `near_null_space` is not used."""
        self._matrix = matrix
        same = np.array_equal(matrix.indptr, self._indptr)
        if not (same and np.array_equal(matrix.indices, self._indices)):
            self._indices, self._indptr = matrix.indices, matrix.indptr
            self._factors = _core.BandFactors(matrix.indptr, matrix.indices)
        if not self._factors.factorise(matrix.data):
            raise unsolved(matrix.data, "a pivot is zero")

    def solve(self, right_side: Floats) -> Solution:
        """Returns the solution for one right side, shape (n,)."""
        matrix = self._matrix
        return refined(matrix.times, right_side, matrix.data, self._apply_inverse, matrix.comm)

    def _apply_inverse(self, right_side: Floats) -> Floats:
        x = np.empty_like(right_side)
        self._factors.solve(right_side, x)
        return x
