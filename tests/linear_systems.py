# SPDX-License-Identifier: BSD-3-Clause
"""Linear systems of small problems, and their solution by multigrid."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, dimension, rollers, weight

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.solvers import LinearSolver, LinearSystem, Multigrid, StepSolver, choose_solver

TOLERANCE = 1e-8


class Systems(LinearSolver):
    """A direct solver that keeps a copy of each system that it solves."""

    def __init__(self) -> None:
        super().__init__(choose_solver("superlu"))
        self.kept: list[tuple[LinearSystem, Floats]] = []

    def begin(self, system: LinearSystem) -> StepSolver:
        kept = self.kept

        class Keeping(StepSolver):
            def solve(self, right_side: Floats, tolerance: float) -> Floats:
                copy = LinearSystem(system.active, system.constrained)
                copy.blocks[:] = system.blocks
                copy.exact_nodes = system.exact_nodes
                kept.append((copy, right_side.copy()))
                return super().solve(right_side, tolerance)

        return Keeping(self, system, self.direct, large=False)


def systems_of(model: Model, steps: int = 1) -> list[tuple[LinearSystem, Floats]]:
    """All linear systems of the last of some steps."""
    simulation = Simulation(model)
    for step in range(steps):
        simulation.services.solver = solver = Systems()
        simulation.advance(model.schedule.regular_time(step), model.schedule.regular_time(step + 1))
    return solver.kept


def without_pattern(system: LinearSystem, seed: int = 0) -> Floats:
    """A right side that excites every mode."""
    return np.random.default_rng(seed).normal(size=system.constrained.shape)


def solve(system: LinearSystem, right: Floats, tolerance: float = TOLERANCE) -> tuple[Floats, int]:
    multigrid = Multigrid(system.active, system.constrained)
    multigrid.fill(system.blocks, system.exact_nodes)
    solution = multigrid.solve(right, tolerance)
    x = solution.x.reshape(right.shape)
    free = np.where(system.constrained, 0.0, right)
    rest = np.where(system.constrained, 0.0, free - system.times(x))
    true = np.linalg.norm(rest) / np.linalg.norm(free)
    assert true == pytest.approx(solution.residual, rel=1e-3, abs=1e-14)
    assert true <= 2.0 * tolerance
    assert not x[system.constrained].any()
    return x, solution.iterations


def require_agreement(system: LinearSystem, right: Floats, most: int) -> None:
    """Both solvers agree as far as the residual and the condition of the matrix allow."""
    x, iterations = solve(system, right, 1e-11)
    exact = LinearSolver(choose_solver("superlu")).begin(system).solve(right, 0.0)
    assert np.linalg.norm(x - exact) <= 1e-5 * np.linalg.norm(exact)
    assert iterations <= most


def block(kind: str, basis: str, cells: int, **body: Any) -> Model:
    """A block under its weight; `top` takes that share of a cell's height off it."""
    entries = block_entries(kind, basis, cells=1, loads=[weight(kind, 2.0)])
    entries["materials"]["soil"]["poisson_ratio"] = 0.48
    dim, size = dimension(kind), 1.0 / cells
    cut = body.pop("cut", 0.0) * size
    entries["boundaries"] = rollers(kind, 1.0)
    entries["grid"]["cell_size"] = size
    upper = [1.0] * (dim - 1) + [1.0 - cut]
    entries["bodies"][0]["shape"]["upper"] = upper
    if cut:
        del entries["bodies"][0]["points_per_cell"]
        entries["bodies"][0]["points"] = [2 * cells] * dim
    entries["bodies"][0].update(body)
    return Model.from_dict(entries)
