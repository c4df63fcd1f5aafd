# SPDX-License-Identifier: BSD-3-Clause
"""What steps use and no result depends on: time measurement, warnings, solver, memory."""

from __future__ import annotations

from dataclasses import dataclass, field

from tilth.analysis.observer import UNOBSERVED, Observer
from tilth.analysis.run_warnings import RunWarnings
from tilth.comm import Communicator
from tilth.model import Model
from tilth.mpm.active_grid import Buffers
from tilth.solvers import LinearSolver, PetscSolver, distributed_solver, linear_solver
from tilth.timers import Timers


@dataclass
class Services:
    """What an analysis uses besides its declaration and its state; no checkpoint has it.

    Attributes:
        warnings: of probable mistakes.
        solver: of the linear systems.
        timers: time spent in basis, stress, assembly, solve and other.
        observer: watches steps; changes nothing.
        buffers: memory that is used again from step to step.
    """

    warnings: RunWarnings
    solver: LinearSolver | PetscSolver
    timers: Timers = field(default_factory=Timers)
    observer: Observer = UNOBSERVED
    buffers: Buffers = field(default_factory=Buffers)

    @classmethod
    def of(cls, model: Model, points: int, comm: Communicator) -> Services:
        """Returns those of a model with so many points on these processes.

        Raises:
            BadInput: PETSc is missing.
        """
        warnings = RunWarnings()
        return cls(warnings, solver_for(model, points, comm, warnings))

    def distribute(self, model: Model, comm: Communicator) -> None:
        """Goes on on several processes; raises as `of`."""
        self.buffers = Buffers()  # those were of all points
        self.solver = solver_for(model, 0, comm, self.warnings)

    def go_on_from(self, last: Services) -> None:
        """Takes over time, observer and what was warned of from those of the last stage."""
        self.timers, self.observer = last.timers, last.observer
        self.warnings.go_on_from(last.warnings)


def solver_for(
    model: Model, points: int, comm: Communicator, warnings: RunWarnings
) -> LinearSolver | PetscSolver:
    """Returns the solver that a model declares, for so many points; it warns where it falls back.

    Raises:
        BadInput: PETSc is missing, which several processes need.
    """
    declared, note = model.analysis.solver, warnings.fallback
    if comm.size > 1:
        return distributed_solver(declared, note)
    return linear_solver(declared, model.dimension, points, note)
