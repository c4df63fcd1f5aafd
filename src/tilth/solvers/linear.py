# SPDX-License-Identifier: BSD-3-Clause
"""Choice of the linear solver: direct, or multigrid with a direct solver as fallback."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import numpy as np

from tilth.algebra.field import DISPLACEMENT
from tilth.arrays import Floats
from tilth.comm import count
from tilth.solvers.bordered_system import factorise_bordered, solve_condensed
from tilth.solvers.cycle import Cycle, CycleOfOne
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.protocol import SolveFailed, Solver
from tilth.solvers.system import LinearSystem

MULTIGRID_FROM_UNKNOWNS = {2: 10_000, 3: 4_000}
"""Dimension -> `effective_size` from which multigrid is faster than sparse direct solvers."""

LARGEST_HALF_BANDWIDTH = 64
"""Half bandwidth up to which band LU is faster than sparse LU."""


def mean_cross_section(system: LinearSystem) -> float:
    """Returns the mean number of active nodes in a slice across the grid's longest side."""
    comm, lattice = system.comm, system.active.lattice
    sides = [comm.max(float(k.max())) + comm.max(float(-k.min())) for k in lattice.T]
    return count(comm, system.active.owned_nodes) / (max(sides) + 1.0)


def effective_size(system: LinearSystem, components: int = 0) -> float:
    """Returns the number of unknowns; for a slender body that of a square or cube as thick as it.

    A direct solver's work per unknown grows with the cross-section, not with the length.

    components: number of unknowns of a node, with those of other fields; of the system if 0.
    """
    dim, components = system.active.grid.dim, components or system.components
    thick = components * mean_cross_section(system) ** (dim / (dim - 1))
    return float(min(components * count(system.comm, system.active.owned_nodes), thick))


class LinearSolver:
    """Solves the linear systems of all load steps; each step calls `begin`.

    Args:
        direct: the direct solver.
        multigrid_from: least `effective_size` of a system for multigrid; None for never.
        note: is called with the reason why multigrid failed.
        banded: replaces the direct solver if the matrix is a narrow band.

    Attributes:
        direct, note: see above.
        direct_systems: number of systems solved by each direct solver.
        iterations: of multigrid, for each system that it solved.
    """

    def __init__(
        self,
        direct: Solver,
        multigrid_from: int | None = None,
        note: Callable[[str], None] = lambda reason: None,
        banded: Solver | None = None,
    ) -> None:
        self.direct = direct
        self._multigrid_from = multigrid_from
        self.note = note
        self._banded = banded
        self._multigrid: dict[str, Multigrid] = {}
        self.direct_systems: Counter[str] = Counter()
        self.iterations: list[int] = []

    def begin(self, system: LinearSystem) -> StepSolver:
        """Returns the solver of the systems of one step, whose matrices `system` has in turn."""
        count = system.components
        direct = self.direct_for(system, count)
        return StepSolver(self, system, direct, self.takes_multigrid(system, count))

    def takes_multigrid(self, system: LinearSystem, components: int) -> bool:
        """Returns whether multigrid is tried first; components: see `effective_size`."""
        least = self._multigrid_from
        return least is not None and effective_size(system, components) >= least

    def direct_for(self, system: LinearSystem, components: int) -> Solver:
        """Returns the direct solver, or that of narrow bands where the nodes make one.

        components: number of unknowns of a node, with those of other fields.
        """
        half_band = components * mean_cross_section(system) * (system.active.coupling_distance + 1)
        if self._banded is not None and half_band <= LARGEST_HALF_BANDWIDTH:
            return self._banded
        return self.direct

    def levels(self, system: LinearSystem, name: str = DISPLACEMENT) -> Multigrid:
        """Returns the levels of a field in a step: the last step's if the active grid is the same.

        name: of the field.
        """
        kept = self._multigrid.get(name)
        if kept is not None and kept.begin(system.active, system.constrained):
            return kept
        kept = None  # frees its memory before the new levels are made
        self._multigrid.pop(name, None)
        return self._multigrid.setdefault(name, Multigrid(system.active, system.constrained))

    def cycle(self, system: LinearSystem, name: str) -> Cycle:
        """As `CycleMaker.cycle`."""
        return CycleOfOne(self.levels(system, name), system)

    def counted(self, name: str, iterations: int | None) -> None:
        """Counts a solution: iterations of multigrid, or None of the direct solver `name`."""
        if iterations is None:
            self.direct_systems[name] += 1
        else:
            self.iterations.append(iterations)

    @property
    def summary(self) -> str:
        """Number of systems by solver, and the iterations of multigrid."""
        texts = [f"{number:,} by {name}" for name, number in self.direct_systems.items()]
        if self.iterations:
            number, mean = len(self.iterations), float(np.mean(self.iterations))
            most = max(self.iterations)
            texts.insert(0, f"{number:,} by multigrid ({mean:.1f} iterations each, at most {most})")
        return ", ".join(texts) or "none"


class StepSolver:
    """Solves the linear systems of one load step.

    If multigrid fails, the direct solver solves the remaining systems of the step.

    Args:
        owner: keeps what is used by several steps, and counts.
        system: has the matrix; `renew` says that it is a new one.
        direct: the direct solver.
        large: whether multigrid is tried first.
    """

    def __init__(
        self, owner: LinearSolver, system: LinearSystem, direct: Solver, large: bool
    ) -> None:
        self._owner, self._system, self._direct, self._large = owner, system, direct, large
        self._levels: Multigrid | None = None
        self._filled = False
        self._similar = False  # whether the levels are those of an earlier matrix

    @property
    def by_multigrid(self) -> bool:
        """Whether multigrid solves the next system."""
        return self._large

    def renew(self, similar: bool = False) -> None:
        """Discards what was made of the last matrix: the system has another one.

        similar: whether it is so close to the last one that the levels of multigrid may stay.
        """
        self._similar = similar and self._levels is not None
        self._filled = False

    def solve(self, right_side: Floats, tolerance: float) -> Floats:
        """Returns the nodal solution of A x = r, shape (nodes, components), 0 where constrained.

        A border of the system is left out.

        Args:
            right_side: r, shape (nodes, components).
            tolerance: relative residual required of multigrid; a direct solution is exact.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        system = self._system
        if self._large:
            try:
                return self._by_multigrid()(right_side, tolerance)
            except SolveFailed as error:
                self._leave_multigrid(error)
        solution = np.zeros_like(right_side)
        if len(system.free):
            self._direct.setup(system.matrix())
            free = self._direct.solve(right_side.ravel()[system.free]).x
            solution.ravel()[system.free] = free
            self._owner.direct_systems[self._direct.name] += 1
        return solution

    def solve_bordered(
        self, right_side: Floats, global_right_side: Floats, tolerance: float
    ) -> tuple[Floats, Floats]:
        """Returns nodal and global unknowns of [[A, B], [C, D]] [x; g] = [r; s].

        Direct solvers allow a singular A if the whole matrix is regular, such as that of soil that
        only a rigid body supports. Multigrid requires a regular A; other systems are left to the
        direct solver.

        Args:
            right_side: r, shape (nodes, components).
            global_right_side: s, shape (m,); without a border there is no g.
            tolerance: see `solve`; the residual is that of all equations, over the border's scale.

        Returns:
            x, shape (nodes, components), 0 where constrained, and g, shape (m,).

        Raises:
            SolveFailed: if the direct solver fails, or the equations of g are singular.
        """
        system = self._system
        if system.border is None:
            return self.solve(right_side, tolerance), np.zeros(0)
        scale, border = system.border.scale, system.border.scaled()
        scaled = global_right_side / scale
        if self._large:
            try:
                solve = self._by_multigrid()
                x, g = solve_condensed(system, border, solve, right_side, scaled, tolerance)
                return x, g / scale
            except SolveFailed as error:
                self._leave_multigrid(error)
        direct = self._owner.direct
        solve_whole = factorise_bordered(direct, system, border)
        found = solve_whole(np.concatenate([right_side.ravel()[system.free], scaled]))
        self._owner.direct_systems[direct.name] += 1
        solution = np.zeros_like(right_side)
        solution.ravel()[system.free] = found[: len(system.free)]
        return solution, found[len(system.free) :] / scale

    def _by_multigrid(self) -> Callable[[Floats, float], Floats]:
        """Returns a function that solves A x = r for a right side and a tolerance."""
        if self._levels is None:
            self._levels = self._owner.levels(self._system)
        multigrid, system = self._levels, self._system
        if not self._filled:
            multigrid.fill(system.blocks, system.exact_nodes, keep_levels=self._similar)
            self._filled = True

        def solve(right_side: Floats, tolerance: float) -> Floats:
            try:
                found = multigrid.solve(right_side, tolerance)
            except SolveFailed:
                if not self._similar:
                    raise
                self._similar = False
                multigrid.fill(system.blocks, system.exact_nodes)
                found = multigrid.solve(right_side, tolerance)
            self._owner.iterations.append(found.iterations)
            return found.x.reshape(right_side.shape)

        return solve

    def _leave_multigrid(self, error: SolveFailed) -> None:
        self._large = False
        self._owner.note(str(error))
