# SPDX-License-Identifier: BSD-3-Clause
"""PETSc's solvers of one process beside SuperLU; with several, see test_processes_runs.py."""

from __future__ import annotations

import numpy as np
import pytest
from lattice_fields import ball, edge_nodes, poisson

from tilth.algebra.border import Border
from tilth.arrays import Floats
from tilth.solvers import LinearSystem, PetscSolver, SolveFailed, linear_solver
from tilth.solvers.petsc import NAMES

pytest.importorskip("petsc4py")

COUPLINGS = {
    1: np.array([[2.5]]),
    2: np.array([[2.0, 0.7], [0.7, 1.0]]),
    3: np.array([[2.0, 0.7, -0.2], [0.7, 1.0, 0.3], [-0.2, 0.3, 0.8]]),
}
SKEW = {
    1: np.zeros((1, 1)),
    2: np.array([[0.0, 0.4], [-0.4, 0.0]]),
    3: np.array([[0.0, 0.4, 0.0], [-0.4, 0.0, 0.2], [0.0, -0.2, 0.0]]),
}

every_solver = pytest.mark.parametrize("name", NAMES)
every_dimension = pytest.mark.parametrize("dim", [2, 3])
every_number = pytest.mark.parametrize("components", [1, 2, 3])


def system_of(dim: int, components: int, skew: float = 0.0) -> LinearSystem:
    """Coupled fields; at the edge of the ball some components are held, in the middle a node."""
    active = ball(dim, 8 if dim == 2 else 4)
    system = poisson(
        active, COUPLINGS[components] + skew * SKEW[components], np.zeros(active.nodes, dtype=bool)
    )
    edge = np.flatnonzero(edge_nodes(active))
    system.constrained[edge, np.arange(len(edge)) % components] = True
    system.constrained[active.nodes // 2] = True
    return system


def right_side(system: LinearSystem, seed: int = 0) -> Floats:
    return np.random.default_rng(seed).normal(size=system.constrained.shape)


def expected(system: LinearSystem, right: Floats) -> Floats:
    return linear_solver("superlu", 3, 0, pytest.fail).begin(system).solve(right, 1e-12)


@every_solver
@every_dimension
@every_number
@pytest.mark.parametrize("skew", [0.0, 1.0])
def test_solution_is_that_of_superlu(name: str, dim: int, components: int, skew: float) -> None:
    """Of symmetric and unsymmetric matrices; with a second matrix of the same pattern, too."""
    system = system_of(dim, components, skew)
    solver = PetscSolver(name, pytest.fail)
    for _ in range(2):  # steps
        of_step = solver.begin(system)
        for factor in (1.0, 3.0):
            system.blocks *= factor
            of_step.renew(similar=factor > 1.0)
            right = right_side(system, int(factor))
            exact = expected(system, right)
            found = of_step.solve(right, 1e-10)
            assert not found[system.constrained].any()
            np.testing.assert_allclose(found, exact, rtol=0, atol=1e-7 * np.abs(exact).max())
    assert solver.solved == {name: 4}


@every_solver
def test_global_unknowns(name: str) -> None:
    """[[A, B], [B^T, D]] as SuperLU solves it."""
    system = system_of(2, 2)
    random = np.random.default_rng(3)
    columns = random.normal(size=(2, *system.constrained.shape))
    system.border = Border(columns, columns, np.diag([-3.0, -2.0]), np.array([1.0, 2.0]))
    right, of_border = right_side(system), np.array([1.0, -2.0])
    whole = linear_solver("superlu", 2, 0, pytest.fail).begin(system)
    x, g = whole.solve_bordered(right, of_border, 1e-12)
    found, global_ = PetscSolver(name, pytest.fail).begin(system).solve_bordered(
        right, of_border, 1e-10
    )  # fmt: skip
    np.testing.assert_allclose(found, x, rtol=0, atol=1e-7 * np.abs(x).max())
    np.testing.assert_allclose(global_, g, rtol=1e-7)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "mumps"])
def test_mumps_takes_over_for_the_rest_of_the_step(name: str) -> None:
    """No iterative solver reaches a residual below round-off; the next step tries it again."""
    system = system_of(3, 3)
    notes: list[str] = []
    solver = PetscSolver(name, notes.append)
    right = right_side(system)
    of_step = solver.begin(system)
    for _ in range(2):
        found = of_step.solve(right, 1e-18)
        exact = expected(system, right)
        np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10 * np.abs(exact).max())
    assert len(notes) == 1
    assert notes[0].startswith(name)
    assert solver.solved == {"mumps": 2}
    assert not of_step.by_multigrid
    assert solver.begin(system).by_multigrid


@every_solver
def test_failures(name: str) -> None:
    """A singular matrix, and one with entries that are not numbers, are no solution."""
    system = system_of(2, 2)
    right = right_side(system)
    system.blocks[system.active.diagonal[3]] = np.nan
    with pytest.raises(SolveFailed):
        PetscSolver(name).begin(system).solve(right, 1e-8)
    loose = poisson(system.active, COUPLINGS[2], np.zeros(system.active.nodes, dtype=bool))
    with pytest.raises(SolveFailed):  # nothing holds the fields, and their sources have a sum
        PetscSolver(name).begin(loose).solve(np.ones_like(right), 1e-8)


@every_solver
def test_the_same_bits_each_time(name: str) -> None:
    system = system_of(3, 3)
    right = right_side(system)
    first, again = (PetscSolver(name).begin(system).solve(right, 1e-8) for _ in range(2))
    np.testing.assert_array_equal(first, again)
