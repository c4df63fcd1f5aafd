# SPDX-License-Identifier: BSD-3-Clause
"""Protocol of linear solvers, their matrix and solution."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Protocol

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Shorts
from tilth.comm import SERIAL, Communicator, norm

if TYPE_CHECKING:
    import scipy.sparse as sp


class SolveFailed(Exception):
    """The linear system could not be solved; the message says why."""


@dataclass(frozen=True)
class Matrix:
    """A square matrix in compressed columns.

    Attributes:
        data: the entries, column by column, shape (entries,).
        indices: row of each entry, shape (entries,).
        indptr: first entry of each column, shape (n + 1,).
        comm: the processes that share the vectors.
    """

    data: Floats
    indices: Shorts
    indptr: Shorts
    comm: Communicator = SERIAL

    def times(self, x: Floats) -> Floats:
        """Returns the product with a vector, shape (n,)."""
        product = np.empty(len(self.indptr) - 1)
        _core.column_product(self.indptr, self.indices, self.data, x, product)
        return product

    def in_scipy(self) -> sp.csc_matrix:
        """Returns the matrix in SciPy's format, without a copy."""
        import scipy.sparse as sp  # takes 0.2 s: only where its solvers are used

        size = len(self.indptr) - 1
        return sp.csc_matrix((self.data, self.indices, self.indptr), shape=(size, size))


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
    """A linear solver; its state is that of the last `setup`.

    Attributes:
        name: its name in a case file.
    """

    name: ClassVar[str]

    @classmethod
    def available(cls) -> bool:
        """Returns whether the library it needs is installed."""
        ...

    def setup(self, matrix: Matrix, near_null_space: Floats | None = None) -> None:
        """Factorises or prepares `matrix` (n, n).

        Raises:
            SolveFailed: if the matrix is singular.
        """
        ...

    def solve(self, right_side: Floats) -> Solution:
        """Returns the solution for one right side, shape (n,).

        Raises:
            SolveFailed: if the true residual remains above the size of round-off.
        """
        ...


LARGEST_RESIDUAL = 1e-8
"""Relative residual above which the matrix of a direct solution counts as singular."""


def unsolved(entries: Floats, detail: object) -> SolveFailed:
    """Returns the failure of a direct solver for a matrix with these entries, shape (m,).

    Factorisations take an entry that is not a number for a pivot of zero.
    """
    if not np.isfinite(entries).all():
        return SolveFailed("the matrix of the linear system has entries that are not numbers")
    return SolveFailed(f"the linear system is singular ({detail})")


def refined(
    times: Callable[[Floats], Floats],
    right_side: Floats,
    entries: Floats,
    apply_inverse: Callable[[Floats], Floats],
    comm: Communicator = SERIAL,
) -> Solution:
    """Solves with `apply_inverse` and, if needed, iterative refinement.

    Args:
        times: returns the matrix times a vector.
        right_side: b, shape (n,).
        entries: of the matrix, shape (m,); tell why there is no solution.
        apply_inverse: returns an approximate solution for a right side.
        comm: the processes that share the vectors.

    Raises:
        SolveFailed: if the residual does not fall below `LARGEST_RESIDUAL`.
    """
    size = norm(comm, right_side)
    if size == 0.0:
        return Solution(np.zeros_like(right_side), 0, 0.0)
    x = apply_inverse(right_side)
    refinements = 0
    while True:
        residual = right_side - times(x)
        relative = norm(comm, residual) / size
        if relative < 1e-12 or refinements == 3 or not np.isfinite(relative):
            break
        x = x + apply_inverse(residual)
        refinements += 1
    if not relative < LARGEST_RESIDUAL:
        raise unsolved(entries, f"relative residual {relative:.1e}")
    return Solution(x, refinements, relative)
