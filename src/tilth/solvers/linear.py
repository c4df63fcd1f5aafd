# SPDX-License-Identifier: BSD-3-Clause
"""The choice of the linear solver: direct, or multigrid with a direct one in reserve."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.protocol import SolveFailed, Solver
from tilth.solvers.system import LinearSystem

MOST_OF_BAND = 64
"""Half the width of a band up to which its LU factors are found sooner than sparse ones."""


def section(system: LinearSystem) -> float:
    """Returns the mean number of active nodes in a slice across the grid's longest side."""
    return system.active.nodes / float(np.ptp(system.active.lattice, axis=0).max() + 1)


def size(system: LinearSystem) -> float:
    """Returns the number of unknowns, of a slender body those of a square or cube as thick.

    A direct solver's work for an unknown grows with the cross-section, not with the length.
    """
    dim = system.active.grid.dim
    return float(min(system.held.size, dim * section(system) ** (dim / (dim - 1))))


class LinearSolver:
    """Solves the systems of a step; multigrid from `multigrid_from` unknowns on.

    Where multigrid fails, the direct solver takes over for the rest of the step.

    Args:
        direct: the direct solver.
        multigrid_from: least `size` of a system for multigrid; None for never.
        note: is told why multigrid failed.
        banded: takes the direct solver's place where the matrix is a narrow band.
    """

    def __init__(
        self,
        direct: Solver,
        multigrid_from: int | None = None,
        note: Callable[[str], None] = lambda reason: None,
        banded: Solver | None = None,
    ) -> None:
        self._direct = direct
        self._multigrid_from = multigrid_from
        self._note = note
        self._banded = banded
        self._now = direct  # or banded
        self._system: LinearSystem | None = None
        self._multigrid: Multigrid | None = None
        self._large = False  # whether this step's systems are for multigrid
        self._begun = False  # whether the levels belong to this step
        self._direct_systems: Counter[str] = Counter()
        self._iterations: list[int] = []

    def solve(self, system: LinearSystem, right_side: Floats, tolerance: float) -> Floats:
        """Returns the nodal solution, shape (nodes, dim), zero where held.

        `tolerance` is the relative residual asked of multigrid; a direct solution is exact.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        if system is not self._system:
            self._system, self._begun = system, False
            self._large = self._multigrid_from is not None and size(system) >= self._multigrid_from
            self._now = self._direct_for(system)
        if self._large:
            try:
                multigrid = self._levels(system)
                multigrid.fill(system.blocks, system.hard)
                found = multigrid.solve(right_side, tolerance)
                self._iterations.append(found.iterations)
                return found.x.reshape(right_side.shape)
            except SolveFailed as error:
                self._large = False
                self._note(str(error))
        solution = np.zeros_like(right_side)
        if len(system.free):
            self._now.setup(system.matrix())
            free = self._now.solve(right_side.ravel()[system.free]).x
            solution.ravel()[system.free] = free
            self._direct_systems[self._now.name] += 1
        return solution

    @property
    def summary(self) -> str:
        """How many systems were solved by what, and with how many iterations of multigrid."""
        texts = [f"{number:,} by {name}" for name, number in self._direct_systems.items()]
        if self._iterations:
            number, mean = len(self._iterations), float(np.mean(self._iterations))
            most = max(self._iterations)
            texts.insert(0, f"{number:,} by multigrid ({mean:.1f} iterations each, at most {most})")
        return ", ".join(texts) or "none"

    def _direct_for(self, system: LinearSystem) -> Solver:
        active = system.active
        half_band = active.grid.dim * section(system) * (active.reach + 1)
        if self._banded is not None and half_band <= MOST_OF_BAND:
            return self._banded
        return self._direct

    def _levels(self, system: LinearSystem) -> Multigrid:
        """Returns the levels of a step, the last step's where the active grid is the same."""
        if not self._begun:
            if self._multigrid is None or not self._multigrid.begin(system.active, system.held):
                self._multigrid = None  # its memory is free before the new levels need theirs
                self._multigrid = Multigrid(system.active, system.held)
            self._begun = True
        assert self._multigrid is not None
        return self._multigrid
