# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers: direct solvers, and multigrid with a direct solver as fallback."""

from __future__ import annotations

from collections.abc import Callable

from tilth.errors import BadInput
from tilth.solvers.banded import BandedLU
from tilth.solvers.linear import MULTIGRID_FROM_UNKNOWNS, LinearSolver, StepSolver
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.pardiso import Pardiso
from tilth.solvers.petsc import NAMES, PetscSolver
from tilth.solvers.petsc_matrices import OPTIONS
from tilth.solvers.protocol import Solution, SolveFailed, Solver
from tilth.solvers.superlu import SuperLU
from tilth.solvers.system import LinearSystem

_DIRECT: list[type[Solver]] = [Pardiso, SuperLU, BandedLU]
SOLVERS = {solver.name: solver for solver in _DIRECT}
"""Direct solvers by their name in a case file, in the order of preference."""
_PACKAGES = {Pardiso.name: "pypardiso"}
"""Package of each solver that is optional."""

__all__ = [
    "MULTIGRID_FROM_UNKNOWNS",
    "SOLVERS",
    "LinearSolver",
    "LinearSystem",
    "Multigrid",
    "PetscSolver",
    "Solution",
    "SolveFailed",
    "Solver",
    "StepSolver",
    "choose_solver",
    "distributed_solver",
    "linear_solver",
]


THREADED_FROM_POINTS = 20_000
"""Number of points from which a threaded direct solver is faster."""


def linear_solver(
    name: str, dimension: int, points: int, note: Callable[[str], None]
) -> LinearSolver | PetscSolver:
    """Returns the linear solver of an analysis; `note` gets the reason if multigrid fails.

    Raises:
        BadInput: if the named solver is not installed.
    """
    if name in OPTIONS:
        return PetscSolver(name, note)
    if name == "multigrid":
        return LinearSolver(choose_solver("auto", points), 0, note)
    direct = choose_solver(name, points)
    if name == "auto":
        return LinearSolver(direct, MULTIGRID_FROM_UNKNOWNS[dimension], note, banded=BandedLU())
    return LinearSolver(direct, note=note)


def distributed_solver(name: str, note: Callable[[str], None]) -> PetscSolver:
    """Returns the linear solver of an analysis by several processes.

    Raises:
        BadInput: it is a solver of one process, or PETSc is not installed.
    """
    if name not in ("auto", *NAMES):
        raise BadInput(
            "several processes do not share this solver",
            'choose solver = "auto"',
            key="analysis.solver",
            value=name,
        )
    return PetscSolver(name, note)


def choose_solver(name: str, points: int = THREADED_FROM_POINTS) -> Solver:
    """Returns a direct solver by name; "auto" takes SuperLU for few points.

    Raises:
        BadInput: if the named solver is not installed.
    """
    if name == "auto" and points < THREADED_FROM_POINTS:
        return SuperLU()
    if name == "auto":
        return next(solver() for solver in SOLVERS.values() if solver.available())
    if not SOLVERS[name].available():
        raise BadInput(
            f"the solver {name!r} is not installed",
            f'install it with `pip install {_PACKAGES[name]}`, or choose solver = "auto"',
            key="analysis.solver",
            value=name,
        )
    return SOLVERS[name]()
