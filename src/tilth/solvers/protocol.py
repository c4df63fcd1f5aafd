# SPDX-License-Identifier: BSD-3-Clause
"""What a linear solver must offer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

Floats = npt.NDArray[np.float64]


class SolveFailed(Exception):
    """The linear system could not be solved; the message says why."""


@dataclass(frozen=True)
class Solution:
    """Solution of one linear system.

    Attributes:
        x: shape (n,).
        iterations: iterations, or refinements of a direct solver.
        residual: ||b - A x|| / ||b||, recomputed with the matrix itself.
    """

    x: Floats
    iterations: int
    residual: float


class Solver(Protocol):
    """A linear solver without memory beyond `setup`."""

    @classmethod
    def available(cls) -> bool:
        """Returns whether the library it needs is installed."""
        ...

    def setup(self, matrix: sp.csc_matrix, near_null_space: Floats | None = None) -> None:
        """Factorises or prepares `matrix` (n, n).

        Raises:
            SolveFailed: if the matrix is singular.
        """
        ...

    def solve(self, right_side: Floats) -> Solution:
        """Solves for one right side, shape (n,).

        Raises:
            SolveFailed: if the true residual stays above what round-off explains.
        """
        ...


LARGEST_RESIDUAL = 1e-8
"""Relative residual above which a direct solution is refused: the matrix is singular."""


def refined(
    matrix: sp.csc_matrix,
    right_side: Floats,
    apply_inverse: Callable[[Floats], Floats],
) -> Solution:
    """Solves with `apply_inverse` and improves by iterative refinement where that is needed.

    Raises:
        SolveFailed: if the residual does not fall below `LARGEST_RESIDUAL`.
    """
    size = float(np.linalg.norm(right_side))
    if size == 0.0:
        return Solution(np.zeros_like(right_side), 0, 0.0)
    x = apply_inverse(right_side)
    refinements = 0
    while True:
        rest = right_side - matrix @ x
        residual = float(np.linalg.norm(rest)) / size
        if residual < 1e-12 or refinements == 3 or not np.isfinite(residual):
            break
        x = x + apply_inverse(rest)
        refinements += 1
    if not residual < LARGEST_RESIDUAL:
        raise SolveFailed(f"the linear system is singular (relative residual {residual:.1e})")
    return Solution(x, refinements, residual)
