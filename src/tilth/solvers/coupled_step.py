# SPDX-License-Identifier: BSD-3-Clause
"""Solvers of the linear systems of a step with several fields."""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers.block_multigrid import BlockMultigrid
from tilth.solvers.coupled_direct import WholeMatrix
from tilth.solvers.coupled_system import CoupledSystem
from tilth.solvers.free_unknowns import FreeUnknowns
from tilth.solvers.linear import LinearSolver
from tilth.solvers.petsc import ITERATIVE, PetscSolver
from tilth.solvers.petsc_coupled import MumpsMatrix
from tilth.solvers.protocol import SolveFailed


class DirectMatrix(Protocol):
    """A matrix of all free unknowns with factors."""

    @property
    def name(self) -> str:
        """Name of the solver."""
        ...

    def renew(self) -> None:
        """Says that the system has another matrix."""

    def solve(self, right_side: Floats) -> Floats:
        """Returns the solution for a right side, (n,) each, of this process' unknowns.

        Raises:
            SolveFailed: the matrix is singular or nearly so.
        """
        ...


class CoupledStepSolver:
    """Solves the systems of a step with several fields, see `SystemSolver`.

    If multigrid fails, the direct solver solves the remaining systems of the step.

    Args:
        owner: keeps what is used by several steps, and counts.
        system: has the matrices.
    """

    def __init__(self, owner: LinearSolver | PetscSolver, system: CoupledSystem) -> None:
        self._owner, self._system = owner, system
        fields = system.matrix.fields.values()
        components = sum(e.components for e in fields if isinstance(e.nodes, ActiveGrid))
        self._large = owner.takes_multigrid(system.displacement, components)
        self._unknowns = FreeUnknowns(system)
        self._levels: BlockMultigrid | None = None
        self._filled = False
        self._similar = False  # whether the levels are those of an earlier matrix

    @cached_property
    def _direct(self) -> DirectMatrix:
        if isinstance(self._owner, PetscSolver):
            return MumpsMatrix(self._system, self._unknowns)
        return WholeMatrix(self._system, self._unknowns, self._owner)

    @property
    def by_multigrid(self) -> bool:
        """As `SystemSolver.by_multigrid`."""
        return self._large

    def renew(self, similar: bool = False) -> None:
        """As `SystemSolver.renew`."""
        self._similar = similar and self._levels is not None
        self._filled = False
        if not self._large:
            self._direct.renew()

    def solve(self, right_side: Unknowns, tolerance: float) -> Unknowns:
        """As `SystemSolver.solve`."""
        if self._large:
            try:
                return self._by_multigrid(right_side, tolerance)
            except SolveFailed as error:
                self._large, self._levels = False, None
                self._owner.note(str(error))
        direct = self._direct
        found = direct.solve(self._unknowns.vector(right_side))
        self._owner.counted(direct.name, None)
        return self._unknowns.values(found, len(right_side.globals))

    def _by_multigrid(self, right_side: Unknowns, tolerance: float) -> Unknowns:
        if self._levels is None:
            self._levels = BlockMultigrid(self._system, self._unknowns, self._owner)
        if not self._filled:
            self._levels.fill(keep_levels=self._similar)
            self._filled = True
        try:
            found, iterations = self._levels.solve(right_side, tolerance)
        except SolveFailed:
            if not self._similar:
                raise
            self._similar = False
            self._levels.fill()
            found, iterations = self._levels.solve(right_side, tolerance)
        self._owner.counted(ITERATIVE, iterations)
        return found
