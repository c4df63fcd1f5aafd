# SPDX-License-Identifier: BSD-3-Clause
"""What a step solves its linear systems with: a direct solver, or multigrid and one behind it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from tilth.solvers.multigrid import Multigrid
from tilth.solvers.protocol import SolveFailed, Solver
from tilth.solvers.system import LinearSystem

Floats = npt.NDArray[np.float64]


class LinearSolver:
    """Solves the systems of a step; multigrid from `multigrid_from` unknowns on.

    Where multigrid fails, the direct solver takes over for the rest of the step.

    Args:
        direct: the direct solver.
        multigrid_from: least number of unknowns for multigrid; None for never.
        note: is told why multigrid failed.
    """

    def __init__(
        self,
        direct: Solver,
        multigrid_from: int | None = None,
        note: Callable[[str], None] = lambda reason: None,
    ) -> None:
        self._direct = direct
        self._multigrid_from = multigrid_from
        self._note = note
        self._system: LinearSystem | None = None
        self._multigrid: Multigrid | None = None

    def solve(self, system: LinearSystem, right_side: Floats, tolerance: float) -> Floats:
        """Returns the nodal solution, shape (nodes, dim), zero where held.

        `tolerance` is the relative residual asked of multigrid; a direct solution is exact.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        fresh = system is not self._system
        self._system = system
        if fresh:
            self._multigrid = None
        if self._multigrid_from is not None and system.held.size >= self._multigrid_from:
            try:
                if fresh:
                    self._multigrid = Multigrid(system.active, system.held)
                if self._multigrid is not None:
                    self._multigrid.fill(system.blocks, system.hard)
                    x = self._multigrid.solve(right_side, tolerance).x
                    return x.reshape(right_side.shape)
            except SolveFailed as error:
                self._multigrid = None
                self._note(str(error))
        solution = np.zeros_like(right_side)
        if len(system.free):
            self._direct.setup(system.matrix())
            free = self._direct.solve(right_side.ravel()[system.free]).x
            solution.ravel()[system.free] = free
        return solution
