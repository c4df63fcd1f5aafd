# SPDX-License-Identifier: BSD-3-Clause
"""Solvers of the linear systems of a step with one or several fields."""

from __future__ import annotations

from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.solvers.coupled_system import CoupledSystem, SystemSolver
from tilth.solvers.linear import LinearSolver, StepSolver
from tilth.solvers.petsc import PetscSolver, PetscStepSolver


def begin_system(solver: LinearSolver | PetscSolver, system: CoupledSystem) -> SystemSolver:
    """Returns the solver of the systems of one step, whose matrices `system` has in turn.

    All processes call it, and the methods of what it returns, together.
    """
    if not system.is_coupled:
        return SolverOfDisplacement(solver.begin(system.displacement), system)
    from tilth.solvers.coupled_step import CoupledStepSolver  # loads the solvers of several fields

    return CoupledStepSolver(solver, system)


class SolverOfDisplacement:
    """Solves systems of the displacement and of global unknowns alone, see `SystemSolver`.

    Args:
        solver: of the displacement's equations in the step.
        system: has the matrices.
    """

    def __init__(self, solver: StepSolver | PetscStepSolver, system: CoupledSystem) -> None:
        self._solver, self._system = solver, system

    @property
    def by_multigrid(self) -> bool:
        """As `SystemSolver.by_multigrid`."""
        return self._solver.by_multigrid

    def renew(self, similar: bool = False) -> None:
        """As `SystemSolver.renew`."""
        self._solver.renew(similar)

    def solve(self, right_side: Unknowns, tolerance: float) -> Unknowns:
        """As `SystemSolver.solve`."""
        self._system.displacement.border = self._system.matrix.border
        of_globals = right_side.globals
        x, of_globals = self._solver.solve_bordered(right_side.u, of_globals, tolerance)
        return Unknowns({DISPLACEMENT: x}, of_globals)
