# SPDX-License-Identifier: BSD-3-Clause
"""SciPy's SuperLU, always available; the unknowns are in a fill-reducing order already."""

from __future__ import annotations

from typing import Any, ClassVar

from tilth.arrays import Floats
from tilth.memory_errors import is_memory_error
from tilth.solvers.protocol import Matrix, Solution, refined, unsolved


class SuperLU:
    """Sparse LU factorisation that keeps the given (nested-dissection) order of unknowns."""

    name: ClassVar[str] = "superlu"

    def __init__(self) -> None:
        self._factors: Any = None

    @classmethod
    def available(cls) -> bool:
        """Returns True: SciPy is a requirement of tilth."""
        return True

    def setup(self, matrix: Matrix, near_null_space: Floats | None = None) -> None:
        """Factorises `matrix`; `near_null_space` is not used."""
        from scipy.sparse.linalg import splu  # takes 0.2 s: only where it is used

        self._matrix = matrix
        self._factors = None  # frees their memory before the new factors are made
        try:
            self._factors = splu(
                matrix.in_scipy(),
                permc_spec="NATURAL",
                diag_pivot_thresh=0.01,
                options={"SymmetricMode": True},
            )
        except RuntimeError as error:
            if is_memory_error(error):
                raise MemoryError(f"SuperLU: {error}") from error
            raise unsolved(matrix.data, error) from error

    def solve(self, right_side: Floats) -> Solution:
        """Returns the solution for one right side, shape (n,)."""
        matrix = self._matrix
        return refined(matrix.times, right_side, matrix.data, self._factors.solve, matrix.comm)
