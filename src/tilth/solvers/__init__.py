# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers behind one protocol; `SOLVERS` is the list of all that tilth knows."""

from __future__ import annotations

from tilth.errors import BadInput
from tilth.solvers.pardiso import Pardiso
from tilth.solvers.protocol import Solution, SolveFailed, Solver
from tilth.solvers.superlu import SuperLU
from tilth.solvers.system import LinearSystem

SOLVERS: dict[str, type[Solver]] = {"pardiso": Pardiso, "superlu": SuperLU}
"""Solvers by the name that stands in a case file, the preferred one first."""

__all__ = ["SOLVERS", "LinearSystem", "Solution", "SolveFailed", "Solver", "choose_solver"]


SMALL = 20_000
"""Number of points below which a threaded solver does not pay."""


def choose_solver(name: str, points: int = SMALL) -> Solver:
    """Returns a solver by name; "auto" takes SuperLU for few points, else the first installed.

    Raises:
        BadInput: if the named solver is not installed.
    """
    if name == "auto" and points < SMALL:
        return SuperLU()
    if name == "auto":
        return next(solver() for solver in SOLVERS.values() if solver.available())
    if not SOLVERS[name].available():
        raise BadInput(
            f"the solver {name!r} is not installed",
            f'install it with `pip install "tilth[{name}]"`, or choose solver = "auto"',
            key="analysis.solver",
            value=name,
        )
    return SOLVERS[name]()
