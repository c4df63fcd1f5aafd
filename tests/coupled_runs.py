# SPDX-License-Identifier: BSD-3-Clause
"""Solutions of systems of several fields by the processes of a run."""

from __future__ import annotations

from typing import Any

import numpy as np
from coupled_blocks import Block, dense_solution, right_side, system_of

from tilth.algebra.unknowns import Unknowns
from tilth.comm import Communicator
from tilth.solvers import PetscSolver, SolveFailed
from tilth.solvers.coupled import begin_system

BLOCKS = [
    Block((8, 6), skew=1.0, wet=0.6, unknowns=2),
    Block((8, 6), has_pile=True, has_water=False),
    Block((8, 6), has_pile=True, unknowns=3, skew=1.0),
]
"""Water with global unknowns, a member, and all together."""


def largest_error(found: Unknowns, block: Block, comm: Communicator) -> float:
    """Over the largest value of a field, at all nodes that this process knows."""
    whole, active = system_of(block), system_of(block, comm).displacement.active
    expected = dense_solution(whole, right_side(whole, block))
    place = np.searchsorted(whole.displacement.active.key, active.key)
    errors = [
        np.abs(found.of[name] - (each if name == "pile" else each[place])).max()
        / np.abs(each).max() for name, each in expected.of.items()
    ]  # fmt: skip
    of_globals = np.abs(found.globals - expected.globals) / np.abs(expected.globals)
    return float(max([*errors, *of_globals]))


def solved(comm: Communicator) -> list[tuple[str, float]]:
    """The summary and the error of each solver and block, with a second matrix."""
    results = []
    for name in ("mumps", "multigrid"):
        for block in BLOCKS:
            notes: list[str] = []
            solver = PetscSolver(name, notes.append)
            system = system_of(block, comm)
            right = right_side(system, block)
            of_step = begin_system(solver, system)
            error = 0.0
            for factor in (1.0, 2.0):
                system.matrix.memory *= factor
                system.schur = {each: factor * v for each, v in system.schur.items()}
                if (border := system.matrix.border) is not None:
                    for part in (border.columns, border.rows, border.corner):
                        part *= factor
                of = {each: factor * values for each, values in right.of.items()}
                right = Unknowns(of, factor * right.globals)
                of_step.renew(similar=factor > 1.0)
                error = max(error, largest_error(of_step.solve(right, 1e-11), block, comm))
            assert not notes
            results.append((solver.summary, error))
    return results


def failures(comm: Communicator) -> list[str]:
    """What the solvers say of a matrix that is not one of numbers, and of a singular one."""
    block, said = Block((8, 6)), []
    for name in ("mumps", "multigrid"):
        for pair in (("p", "u"), None):
            system = system_of(block, comm)
            if pair is not None:
                system.matrix[pair].values[:] = np.nan
            else:
                system.constrained["u"][:] = False
            right = right_side(system, block)
            try:
                begin_system(PetscSolver(name), system).solve(right, 1e-8)
            except SolveFailed as failure:
                said.append(str(failure))
    return said


def taken_over(comm: Communicator) -> list[Any]:
    """No iteration reaches a residual below round-off: MUMPS solves the rest of the step."""
    block, notes = BLOCKS[2], list[str]()
    system = system_of(block, comm)
    right = right_side(system, block)
    solver = PetscSolver("multigrid", notes.append)
    of_step = begin_system(solver, system)
    errors = [largest_error(of_step.solve(right, 1e-18), block, comm) for _ in range(2)]
    again = begin_system(solver, system)
    return [len(notes), max(errors), solver.summary, of_step.by_multigrid, again.by_multigrid]
