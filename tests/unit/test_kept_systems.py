# SPDX-License-Identifier: BSD-3-Clause
"""What later iterations of a step keep: the levels of multigrid, and the matrix."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from balances import residual_at
from test_multigrid import TOLERANCE, footing, systems_of

from tilth.analysis.residual import Newton
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Reuse, reused
from tilth.solvers import LinearSolver, Multigrid, StepSolver, choose_solver
from tilth.solvers import multigrid as multigrid_module
from tilth.solvers.subdomain_correction import SubdomainCorrection
from tilth.terms.balance import Balance

pytestmark = pytest.mark.slow

NEWTON = Newton(tolerance=1e-6, maximum_iterations=15, line_search=False, round_off={})


@pytest.mark.parametrize(
    ("residuals", "last", "expected"),
    [
        ([1e-3], Reuse.NOTHING, Reuse.NOTHING),
        ([1e-2, 2e-3], Reuse.NOTHING, Reuse.NOTHING),
        ([1e-2, 9e-4], Reuse.NOTHING, Reuse.LEVELS),
        ([1e-2, 4e-6], Reuse.LEVELS, Reuse.MATRIX),
        ([1e-2, 6e-6], Reuse.LEVELS, Reuse.LEVELS),
        ([2e-5, 4e-6], Reuse.NOTHING, Reuse.NOTHING),
        ([1e-2, 4e-5, 3e-6], Reuse.MATRIX, Reuse.LEVELS),
    ],
)
def test_what_is_reused(residuals: list[float], last: Reuse, expected: Reuse) -> None:
    assert reused(residuals, last, NEWTON) is expected
    assert reused(residuals, last, replace(NEWTON, line_search=True)) is Reuse.NOTHING


@pytest.mark.parametrize("solver", ["multigrid", "superlu"])
def test_an_iteration_near_the_solution_keeps_the_matrix(
    solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The direct solver has a new one in every iteration. Terms are told of new ones only."""
    counts = {"solve_bordered": 0, "linearise": 0, "linearised": 0}

    def counted(owner: type, name: str) -> None:
        call = getattr(owner, name)

        def counting(*arguments: Any) -> Any:
            counts[name] += 1
            return call(*arguments)

        monkeypatch.setattr(owner, name, counting)

    counted(StepSolver, "solve_bordered")
    counted(Balance, "linearise")
    counted(Balance, "linearised")
    simulation = Simulation(footing(**{"analysis.solver": solver, "analysis.tolerance": 1e-8}))
    time = simulation.setup.model.schedule.regular_time
    for step in range(6):
        residuals = simulation.advance(time(step), time(step + 1)).equilibrium.residuals
        assert residuals[-1] <= 1e-8
    kept = counts["solve_bordered"] - counts["linearise"]
    assert kept > 0 if solver == "multigrid" else kept == 0
    assert counts["linearised"] == counts["linearise"]


def test_nodes_to_be_solved_exactly() -> None:
    """All of them, and where these are too many the larger and the smaller part."""
    simulation = Simulation(footing())
    time = simulation.setup.model.schedule.regular_time
    simulation.advance(0.0, time(1))
    step = simulation.prepare(time(1), time(2))
    soil = simulation.soil_on(step.active)
    balance = Balance(step.active, simulation.terms(step, soil))
    residual_at(balance, np.zeros((balance.active.nodes, balance.active.grid.dim)))
    yielding, joined = (np.zeros(balance.active.nodes, dtype=bool) for _ in range(2))
    yielding[:3], joined[2:9] = True, True
    first = balance.terms[0]
    for flags, name in ((yielding, "yielding_nodes"), (joined, "joined_nodes")):
        for term in balance.terms:
            setattr(term, name, lambda own=flags if term is first else None: own)
    found = balance.exact_nodes()
    assert [list(np.flatnonzero(each)) for each in found] == [
        list(range(9)), list(range(2, 9)), [0, 1, 2],
    ]  # fmt: skip


def test_levels_of_a_similar_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    """They solve the next system to the tolerance; where they fail, new ones are tried."""
    first, last = (systems_of(footing(), steps=steps)[-1] for steps in (1, 6))
    filled: list[bool] = []
    fill = Multigrid.fill

    def watched(multigrid: Multigrid, *arguments: Any, keep_levels: bool = False) -> None:
        filled.append(keep_levels)
        fill(multigrid, *arguments, keep_levels=keep_levels)

    monkeypatch.setattr(Multigrid, "fill", watched)
    system, right = first
    solver = LinearSolver(choose_solver("superlu"), 0).begin(system)
    solver.solve(right, TOLERANCE)
    solver.solve(right, TOLERANCE)
    system.blocks[:], system.exact_nodes = last[0].blocks, last[0].exact_nodes
    solver.renew(similar=True)
    found = solver.solve(last[1], TOLERANCE)
    free = np.where(system.constrained, 0.0, last[1])
    rest = np.where(system.constrained, 0.0, free - system.times(found))
    assert np.linalg.norm(rest) <= 2.0 * TOLERANCE * np.linalg.norm(free)
    assert filled == [False, True]
    monkeypatch.setattr(multigrid_module, "MAXIMUM_ITERATIONS", 1)
    solver.renew(similar=True)
    solver.solve(last[1], TOLERANCE)
    assert filled == [False, True, True, False], "the direct solver is asked only then"


def test_the_residual_that_a_symmetric_matrix_leaves() -> None:
    system, right = systems_of(footing(), steps=6)[-1]
    free = np.where(system.constrained, 0.0, right)
    exact = SubdomainCorrection(
        system.active, system.constrained, system.blocks, system.exact_nodes[0]
    )
    correction = exact.solve(free.ravel())
    assert correction.any()
    product = system.times(correction.reshape(free.shape))
    expected = np.where(system.constrained, 0.0, free - product)
    found = exact.remaining(free.ravel(), correction).reshape(free.shape)
    scale = np.abs(free).max()
    np.testing.assert_allclose(
        found[~system.constrained], expected[~system.constrained], rtol=0, atol=1e-12 * scale
    )
