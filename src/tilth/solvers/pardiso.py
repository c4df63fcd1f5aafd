# SPDX-License-Identifier: BSD-3-Clause
"""MKL's PARDISO, by the optional package pypardiso: threaded, the fastest direct solver."""

from __future__ import annotations

import importlib.util
from typing import ClassVar

from tilth.arrays import Floats
from tilth.solvers.protocol import Matrix, Solution, refined, unsolved

REAL_UNSYMMETRIC = 11
NOT_ENOUGH_MEMORY = -2
"""Error number of PARDISO."""


class Pardiso:
    """Threaded sparse LU factorisation; installed by `pip install pypardiso`."""

    name: ClassVar[str] = "pardiso"

    @classmethod
    def available(cls) -> bool:
        """Returns whether pypardiso is installed."""
        return importlib.util.find_spec("pypardiso") is not None

    def __init__(self) -> None:
        from pypardiso import PyPardisoSolver

        self._pardiso = PyPardisoSolver(mtype=REAL_UNSYMMETRIC)

    def setup(self, matrix: Matrix, near_null_space: Floats | None = None) -> None:
        """Factorises `matrix`; `near_null_space` is not used."""
        from pypardiso.pardiso_wrapper import PyPardisoError

        self._comm = matrix.comm
        self._matrix = matrix.in_scipy().tocsr()
        try:
            self._pardiso.factorize(self._matrix)
        except (PyPardisoError, ValueError) as error:  # ValueError: an empty row
            if getattr(error, "value", 0) == NOT_ENOUGH_MEMORY:
                raise MemoryError("PARDISO: not enough memory") from error
            raise unsolved(matrix.data, error) from error

    def solve(self, right_side: Floats) -> Solution:
        """Returns the solution for one right side, shape (n,)."""
        return refined(
            lambda x: self._matrix @ x,
            right_side,
            self._matrix.data,
            lambda b: self._pardiso.solve(self._matrix, b).ravel(),
            self._comm,
        )
