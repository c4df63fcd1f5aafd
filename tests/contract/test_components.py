# SPDX-License-Identifier: BSD-3-Clause
"""Every solver takes any number of components per node, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest
from lattice_fields import ball, edge_nodes, error, load, poisson

from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers import SOLVERS, LinearSolver, Multigrid, linear_solver

NAMES = [name for name, solver in SOLVERS.items() if solver.available()] + ["multigrid", "auto"]
OVER_RADIUS = {2: 8, 3: 4}
COUPLINGS = {
    1: np.array([[2.5]]),
    2: np.array([[2.0, 0.7], [0.7, 1.0]]),
    3: np.array([[2.0, 0.7, -0.2], [0.7, 1.0, 0.3], [-0.2, 0.3, 0.8]]),
}
"""Symmetric and positive definite: as large as the fields' own stiffness."""

every_solver = pytest.mark.parametrize("name", NAMES)
every_dimension = pytest.mark.parametrize("dim", [2, 3])
every_number = pytest.mark.parametrize("components", [1, 2, 3])


def solver_of(name: str, dim: int) -> LinearSolver:
    """A solver by its name in a case file; multigrid may not leave its work to another."""
    return linear_solver(name, dim, 0, pytest.fail)


def solved(
    name: str, active: ActiveGrid, coupling: Floats, exact: Floats, source: Floats
) -> Floats:
    """The fields (nodes, components) with the exact values at the edge, to round-off."""
    system = poisson(active, coupling, edge_nodes(active))
    prescribed = np.where(system.constrained, exact, 0.0)
    right = load(active, source @ coupling) - system.times(prescribed)
    found = solver_of(name, active.grid.dim).begin(system).solve(right, 1e-12)
    assert not found[system.constrained].any()
    return prescribed + found


@every_solver
@every_dimension
@every_number
def test_linear_fields_are_exact(name: str, dim: int, components: int) -> None:
    """They are in the space of the elements and satisfy Poisson's equation without a source."""
    active = ball(dim, OVER_RADIUS[dim])
    assert 0 < edge_nodes(active).sum() < active.nodes
    slope = np.random.default_rng(components).normal(size=(dim, components))
    exact = 0.5 + active.position @ slope
    found = solved(name, active, COUPLINGS[components], exact, np.zeros_like(exact))
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-10 * np.abs(exact).max())


WAVE = np.array([1.3, 2.1, 1.7])


@every_solver
@every_dimension
def test_error_falls_with_the_square_of_the_cell_size(name: str, dim: int) -> None:
    """u = product of sin(k x + 0.4): -div grad u = |k|^2 u. The same cells, cut in half."""
    wave = WAVE[:dim]

    def exact(place: Floats) -> Floats:
        return np.asarray(np.sin(wave * place + 0.4).prod(axis=1))

    errors = []
    for halvings in (0, 1, 2) if dim == 2 else (0, 1):
        active = ball(dim, 5 - dim, halvings)
        field = exact(active.position)[:, None]
        found = solved(name, active, COUPLINGS[1], field, (wave @ wave) * field)
        errors.append(error(active, found[:, 0], exact))
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (np.abs(rates - 2.0) < 0.15).all(), rates


@every_dimension
@every_number
def test_iterations_of_multigrid_do_not_grow_with_the_grid(dim: int, components: int) -> None:
    """Smoother and coarse correction together damp each error by a factor that no cell size enters.

    Chebyshev's polynomial of degree 5 damps eigenvalues from 0.025 of the largest to 0.52, twice in
    a cycle; coarse grids do the rest. At a factor of 0.25 a cycle, 1e-8 takes 14 iterations even
    without conjugate directions.
    """
    counts = []
    for over_radius in (OVER_RADIUS[dim], 2 * OVER_RADIUS[dim], 4 * OVER_RADIUS[dim]):
        active = ball(dim, over_radius)
        system = poisson(active, COUPLINGS[components], edge_nodes(active))
        multigrid = Multigrid(active, system.constrained)
        multigrid.fill(system.blocks)
        right = np.random.default_rng(0).normal(size=system.constrained.shape)
        counts.append(multigrid.solve(right, 1e-8).iterations)
    assert max(counts) <= 14
    assert counts[2] <= counts[1] + 1


@every_dimension
def test_coupled_fields_are_solved_as_one_after_the_other(dim: int) -> None:
    """Components that are not coupled: each is the scalar problem's solution."""
    active = ball(dim, OVER_RADIUS[dim])
    right = np.random.default_rng(1).normal(size=(active.nodes, 3))
    stiffness = np.array([1.0, 40.0, 0.2])
    for name in NAMES:
        solver = solver_of(name, dim)
        system = poisson(active, np.diag(stiffness), edge_nodes(active))
        whole = solver.begin(system).solve(right, 1e-12)
        for k, own in enumerate(stiffness):
            system = poisson(active, np.array([[own]]), edge_nodes(active))
            alone = solver.begin(system).solve(np.ascontiguousarray(right[:, k : k + 1]), 1e-12)
            np.testing.assert_allclose(
                whole[:, k : k + 1], alone, rtol=0, atol=1e-9 * np.abs(alone).max()
            )
