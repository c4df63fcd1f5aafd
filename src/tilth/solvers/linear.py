# SPDX-License-Identifier: BSD-3-Clause
"""The choice of the linear solver: direct, or multigrid with a direct one in reserve."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats
from tilth.comm import count
from tilth.solvers.border import factorise_bordered, solve_condensed
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.protocol import SolveFailed, Solver
from tilth.solvers.system import LinearSystem

LARGEST_HALF_BANDWIDTH = 64
"""Half the width of a band up to which its LU factors are found sooner than sparse ones."""


def section(system: LinearSystem) -> float:
    """Returns the mean number of active nodes in a slice across the grid's longest side."""
    comm, lattice = system.comm, system.active.lattice
    sides = [comm.max(float(k.max())) + comm.max(float(-k.min())) for k in lattice.T]
    first, last = system.active.owned
    return count(comm, last - first) / (max(sides) + 1.0)


def size(system: LinearSystem) -> float:
    """Returns the number of unknowns, of a slender body those of a square or cube as thick.

    A direct solver's work for an unknown grows with the cross-section, not with the length.
    """
    dim = system.active.grid.dim
    thick = system.components * section(system) ** (dim / (dim - 1))
    first, last = system.active.owned
    return float(min(system.components * count(system.comm, last - first), thick))


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
        """Returns the nodal solution of A x = r, shape (nodes, components), 0 where constrained.

        A border of the system is left out.

        Args:
            system: has A; the same object for all matrices of a step.
            right_side: r, shape (nodes, components).
            tolerance: relative residual asked of multigrid; a direct solution is exact.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        self._begin(system)
        if self._large:
            try:
                return self._by_multigrid(system)(right_side, tolerance)
            except SolveFailed as error:
                self._give_multigrid_up(error)
        solution = np.zeros_like(right_side)
        if len(system.free):
            self._now.setup(system.matrix())
            free = self._now.solve(right_side.ravel()[system.free]).x
            solution.ravel()[system.free] = free
            self._direct_systems[self._now.name] += 1
        return solution

    def solve_bordered(
        self,
        system: LinearSystem,
        right_side: Floats,
        global_right_side: Floats,
        tolerance: float,
    ) -> tuple[Floats, Floats]:
        """Returns nodal and global unknowns of [[A, B], [C, D]] [x; g] = [r; s].

        Direct solvers allow a singular A where the whole matrix is regular: soil that nothing but a
        rigid body holds. Multigrid does not, and leaves such systems to the direct solver.

        Args:
            system: A and the border, as for `solve`; without a border there is no g.
            right_side: r, shape (nodes, components).
            global_right_side: s, shape (m,).
            tolerance: see `solve`; the residual is that of all equations, over the border's scale.

        Returns:
            x, shape (nodes, components), 0 where constrained, and g, shape (m,).

        Raises:
            SolveFailed: if the direct solver fails, or the equations of g are singular.
        """
        if system.border is None:
            return self.solve(system, right_side, tolerance), np.zeros(0)
        self._begin(system)
        scale, border = system.border.scale, system.border.scaled()
        scaled = global_right_side / scale
        if self._large:
            try:
                solve = self._by_multigrid(system)
                x, g = solve_condensed(system, border, solve, right_side, scaled, tolerance)
                return x, g / scale
            except SolveFailed as error:
                self._give_multigrid_up(error)
        factorise_bordered(self._direct, system, border)
        found = self._direct.solve(np.concatenate([right_side.ravel()[system.free], scaled])).x
        self._direct_systems[self._direct.name] += 1
        solution = np.zeros_like(right_side)
        solution.ravel()[system.free] = found[: len(system.free)]
        return solution, found[len(system.free) :] / scale

    @property
    def summary(self) -> str:
        """How many systems were solved by what, and with how many iterations of multigrid."""
        texts = [f"{number:,} by {name}" for name, number in self._direct_systems.items()]
        if self._iterations:
            number, mean = len(self._iterations), float(np.mean(self._iterations))
            most = max(self._iterations)
            texts.insert(0, f"{number:,} by multigrid ({mean:.1f} iterations each, at most {most})")
        return ", ".join(texts) or "none"

    def _begin(self, system: LinearSystem) -> None:
        """Chooses how to solve the systems of a step, when its first one comes."""
        if system is self._system:
            return
        self._system, self._begun = system, False
        self._large = self._multigrid_from is not None and size(system) >= self._multigrid_from
        self._now = self._direct_for(system)

    def _direct_for(self, system: LinearSystem) -> Solver:
        half_band = system.components * section(system) * (system.active.reach + 1)
        if self._banded is not None and half_band <= LARGEST_HALF_BANDWIDTH:
            return self._banded
        return self._direct

    def _by_multigrid(self, system: LinearSystem) -> Callable[[Floats, float], Floats]:
        """Returns what solves A x = r for a right side and a tolerance."""
        multigrid = self._levels(system)
        multigrid.fill(system.blocks, system.exact_nodes)

        def solve(right_side: Floats, tolerance: float) -> Floats:
            found = multigrid.solve(right_side, tolerance)
            self._iterations.append(found.iterations)
            return found.x.reshape(right_side.shape)

        return solve

    def _give_multigrid_up(self, error: SolveFailed) -> None:
        self._large = False
        self._note(str(error))

    def _levels(self, system: LinearSystem) -> Multigrid:
        """Returns the levels of a step, the last step's where the active grid is the same."""
        if not self._begun:
            if self._multigrid is None or not self._multigrid.begin(
                system.active, system.constrained
            ):
                self._multigrid = None  # its memory is free before the new levels need theirs
                self._multigrid = Multigrid(system.active, system.constrained, system.comm)
            self._begun = True
        assert self._multigrid is not None
        return self._multigrid
