# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid on graded grids, whose cells may be long in one direction."""

from __future__ import annotations

import numpy as np
import pytest
from linear_systems import (
    block,
    require_agreement,
    solve,
    systems_of,
    without_pattern,
)
from small_problems import dimension

from tilth import Model, _core
from tilth.solvers.hierarchies import dyadic_steps
from tilth_verification.cases import varied

pytestmark = pytest.mark.slow


def graded_block(kind: str, smallest: float, largest: float) -> Model:
    """The block with cells that grow along every axis."""
    uniform = block(kind, "linear", 10, anti_locking="f_bar")
    axes = "xyz"[: dimension(kind)]
    return varied(uniform, {"grid.cell_size": {k: [[0, smallest], [1, largest]] for k in axes}})


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_long_cells_of_a_graded_grid(kind: str) -> None:
    """Sides 10 to 1, ratio of neighbours 1.2: half more iterations at most; 30 to 1: three times.

    Beside a uniform grid with as many cells.
    """
    counts = []
    for model in (
        block(kind, "linear", 13, anti_locking="f_bar"),
        graded_block(kind, 0.02, 0.2),
        graded_block(kind, 0.01, 0.3),
    ):
        system, _ = systems_of(model)[0]
        counts.append(solve(system, without_pattern(system))[1])
    assert counts[1] <= 1.5 * counts[0]
    assert counts[2] <= 3.0 * counts[0]


def test_steps_of_the_lattice_by_size() -> None:
    """Powers of two that divide the place at which they begin."""
    ratio = np.array([1.0, 1.3, 1.7, 2.2, 2.9, 3.7, 4.8, 6.2, 8.1])
    assert dyadic_steps(ratio).tolist() == [1, 1, 2, 2, 2, 4, 4, 8, 8]
    assert dyadic_steps(ratio[::-1]).tolist() == [8, 8, 4, 4, 4, 2, 2, 1, 1]


@pytest.mark.usefixtures("every_loop_in_parallel")
def test_same_bits_for_any_number_of_threads() -> None:
    """Nodes are coupled over many positions: coarse matrices are made by rows."""
    system, _ = systems_of(graded_block("3d", 0.01, 0.3))[0]
    solutions = []
    for threads in (1, 2, 3):
        _core.set_threads(threads)
        solutions.append(solve(system, without_pattern(system))[0].tobytes())
    assert len(set(solutions)) == 1


def test_the_direct_solvers_solution() -> None:
    system, right = systems_of(graded_block("3d", 0.02, 0.2))[0]
    require_agreement(system, right, 30)
