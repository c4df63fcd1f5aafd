# SPDX-License-Identifier: BSD-3-Clause
"""Solvers of the linear systems of one or several fields."""

from __future__ import annotations

from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.solvers.coupled_system import CoupledSystem, SystemSolver
from tilth.solvers.linear import LinearSolver, StepSolver
from tilth.solvers.petsc import PetscSolver, PetscStepSolver


def begin_system(solver: LinearSolver | PetscSolver, system: CoupledSystem) -> SystemSolver:
    """Returns the solver of the systems of one step, whose matrices `system` has in turn."""
    return _OneField(solver.begin(system.displacement))


class _OneField:
    def __init__(self, solver: StepSolver | PetscStepSolver) -> None:
        self._solver = solver

    @property
    def by_multigrid(self) -> bool:
        return self._solver.by_multigrid

    def renew(self, similar: bool = False) -> None:
        self._solver.renew(similar)

    def solve(self, right_side: Unknowns, tolerance: float) -> Unknowns:
        nodal, of_globals = self._solver.solve_bordered(right_side.u, right_side.globals, tolerance)
        return Unknowns({DISPLACEMENT: nodal}, of_globals)
