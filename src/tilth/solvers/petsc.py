# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers of several processes: PETSc's Krylov methods with multigrid, and MUMPS."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec

import numpy as np

from tilth.arrays import Floats
from tilth.comm import norm
from tilth.errors import BadInput
from tilth.mpi import INSTALL
from tilth.solvers.bordered_system import solve_condensed
from tilth.solvers.cycle import Cycle
from tilth.solvers.linear import MULTIGRID_FROM_UNKNOWNS, effective_size
from tilth.solvers.petsc_bordered import solve_bordered_directly
from tilth.solvers.petsc_matrices import OPTIONS, AssembledMatrix, MatrixOfMultigrid, PetscMatrix
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.schwarz import SchwarzMultigrid
from tilth.solvers.system import LinearSystem

DIRECT = "mumps"
ITERATIVE = "multigrid"
NAMES = (ITERATIVE, *OPTIONS)
"""The solvers by their name in a case file."""


class PetscSolver:
    """Solves the linear systems of all load steps; each step calls `begin`.

    Args:
        name: "auto", or one of `NAMES`.
        note: is called with the reason why an iterative solver failed.

    Attributes:
        solved: number of systems solved by each solver.
        iterations: of iterative solvers, for each system.

    Raises:
        BadInput: petsc4py cannot be imported.
    """

    def __init__(self, name: str, note: Callable[[str], None] = lambda reason: None) -> None:
        require_petsc()
        self.name, self.note = name, note
        self.solved: Counter[str] = Counter()
        self.iterations: list[int] = []
        self._kept: dict[type[PetscMatrix], PetscMatrix] = {}
        self._cycles: dict[str, SchwarzMultigrid] = {}

    def begin(self, system: LinearSystem) -> PetscStepSolver:
        """Returns the solver of the systems of one step, whose matrices `system` has in turn.

        "auto" takes multigrid where one process does. It is faster than MUMPS already for a tenth
        as many unknowns, but so the two runs agree to more digits.
        """
        name = self.name
        if name == "auto":
            large = self.takes_multigrid(system, system.components)
            name = ITERATIVE if large else DIRECT
        return PetscStepSolver(self, system, name)

    def takes_multigrid(self, system: LinearSystem, components: int) -> bool:
        """Returns whether an iterative solver is tried first; components: see `effective_size`."""
        least = MULTIGRID_FROM_UNKNOWNS[system.active.grid.dim]
        if self.name == "auto":
            return effective_size(system, components) >= least
        return self.name != DIRECT

    def cycle(self, system: LinearSystem, name: str) -> Cycle:
        """As `CycleMaker.cycle`."""
        kept = self._cycles.get(name)
        if kept is not None and kept.begin(system):
            return kept
        kept = None  # frees its memory before the new levels are made
        self._cycles.pop(name, None)
        return self._cycles.setdefault(name, SchwarzMultigrid(system))

    def counted(self, name: str, iterations: int | None) -> None:
        """Counts a solution by a solver; iterations: None of a direct one."""
        self.solved[name] += 1
        if iterations is not None:
            self.iterations.append(iterations)

    def matrix(self, system: LinearSystem, name: str) -> PetscMatrix:
        """Returns the matrix for a solver; what the last step's has in common with it is kept.

        Raises:
            SolveFailed: there are no levels of multigrid.
        """
        kind = MatrixOfMultigrid if name == ITERATIVE else AssembledMatrix
        kept = self._kept.get(kind)
        if kept is not None and kept.begin(system):
            return kept
        if kept is not None:  # frees its memory before the new one is made
            del self._kept[kind]
            kept.destroy()
        return self._kept.setdefault(kind, kind(system))

    @property
    def summary(self) -> str:
        """Number of systems by solver, and the iterations of the iterative ones."""
        texts = [f"{number:,} by {name}" for name, number in self.solved.items()]
        if self.iterations:
            mean, most = float(np.mean(self.iterations)), max(self.iterations)
            texts.append(f"{mean:.1f} iterations each of the iterative solver, at most {most}")
        return ", ".join(texts) or "none"


def require_petsc() -> None:
    """Checks that petsc4py can be imported.

    Raises:
        BadInput: it cannot.
    """
    try:
        from petsc4py import PETSc  # noqa: F401
    except (ImportError, ValueError) as error:  # of another version of NumPy
        missing = find_spec("petsc4py") is None
        reason = "is not installed" if missing else f"cannot be imported ({error})"
        raise BadInput(
            f"petsc4py, the linear solver of several processes, {reason}", INSTALL
        ) from error


class PetscStepSolver:
    """Solves the linear systems of one load step.

    If the iterative solver fails, the direct one solves the remaining systems of the step.

    Args:
        owner: keeps what is used by several steps, and counts.
        system: has the matrix; `renew` says that it is a new one.
        name: of the solver.
    """

    def __init__(self, owner: PetscSolver, system: LinearSystem, name: str) -> None:
        self._owner, self._system, self._name = owner, system, name
        self._matrix: PetscMatrix | None = None
        self._filled = False
        self._similar = False  # whether the preconditioner is that of an earlier matrix

    @property
    def by_multigrid(self) -> bool:
        """Whether an iterative solver solves the next system."""
        return self._name != DIRECT

    def renew(self, similar: bool = False) -> None:
        """Discards what was made of the last matrix: the system has another one.

        similar: whether it is so close to the last one that the levels of multigrid may stay.
        """
        self._similar = similar and self._matrix is not None
        self._filled = False

    def solve(self, right_side: Floats, tolerance: float) -> Floats:
        """Returns the nodal solution of A x = r, shape (nodes, components), 0 where constrained.

        A border of the system is left out. At nodes of other processes the solution is theirs.

        Args:
            right_side: r, shape (nodes, components).
            tolerance: relative residual required of an iterative solver.

        Raises:
            SolveFailed: if the direct solver fails.
        """
        if not self.by_multigrid:
            return self._solve(right_side, tolerance)
        try:
            try:
                return self._solve(right_side, tolerance)
            except SolveFailed:
                if not self._similar:
                    raise
                self.renew()
                return self._solve(right_side, tolerance)
        except SolveFailed as failure:
            self._leave_multigrid(failure)
        return self._solve(right_side, tolerance)

    def solve_bordered(
        self, right_side: Floats, global_right_side: Floats, tolerance: float
    ) -> tuple[Floats, Floats]:
        """As `StepSolver.solve_bordered`."""
        system = self._system
        if system.border is None:
            return self.solve(right_side, tolerance), np.zeros(0)
        scale, border = system.border.scale, system.border.scaled()
        scaled = global_right_side / scale
        if self.by_multigrid:
            try:
                x, g = solve_condensed(system, border, self.solve, right_side, scaled, tolerance)
                return x, g / scale
            except SolveFailed as error:
                self._leave_multigrid(error)
        x, g = solve_bordered_directly(system, border, right_side, scaled)
        self._owner.counted(DIRECT, None)
        return x, g / scale

    def _leave_multigrid(self, failure: SolveFailed) -> None:
        self._owner.note(str(failure))
        self._name, self._matrix = DIRECT, None
        self.renew()

    def _solve(self, right_side: Floats, tolerance: float) -> Floats:
        system = self._system
        owned = np.where(system.constrained, 0.0, right_side)[system.active.owned]
        size = norm(system.comm, owned)
        if not math.isfinite(size):
            raise SolveFailed("the linear system has entries that are not numbers")
        found = np.zeros_like(right_side)
        if size == 0.0:
            return found
        if self._matrix is None:
            self._matrix = self._owner.matrix(system, self._name)
        if not self._filled:
            self._matrix.fill(self._name, self._similar)
            self._filled = True
        solution, iterations = self._matrix.solve(owned, size, tolerance)
        self._owner.counted(self._name, iterations if self.by_multigrid else None)
        found[system.active.owned] = solution
        found[system.constrained] = 0.0  # the solver may leave round-off
        return system.active.updated(found)
