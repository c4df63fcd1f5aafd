# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid of several processes: as many iterations as that of one, and the same solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lattice_fields import LAW, edge_nodes, poisson
from processes import run_together

from tilth.arrays import Flags, Floats, Integers
from tilth.comm import SERIAL, Communicator
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.distribution import Distribution
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.solvers import LinearSystem, Multigrid, coarse_correction
from tilth.solvers.krylov import flexible_gmres
from tilth.solvers.multigrid import SYMMETRY_TOLERANCE
from tilth.solvers.schwarz import SchwarzMultigrid

COUPLINGS = {
    1: np.array([[2.5]]),
    2: np.array([[2.0, 0.7], [0.7, 1.0]]),
    3: np.array([[2.0, 0.7, -0.2], [0.7, 1.0, 0.3], [-0.2, 0.3, 0.8]]),
}
CELLS = {2: (30, 20), 3: (12, 8, 6)}
TOLERANCE = 1e-8


def grid_of(dim: int, comm: Communicator) -> ActiveGrid:
    """A process' part of a block of cells with a point in each; one corner is missing."""
    size = np.array([1.0, 0.8, 1.2])[:dim]
    place = np.stack(np.meshgrid(*map(np.arange, CELLS[dim]), indexing="ij"), axis=-1)
    place = place.reshape(-1, dim) - 3
    place = place[(place > 0).any(axis=1)]
    body = PointRange("body", 0, len(place), "linear", None, LAW, np.array([1.0, 0.0]), 1.0)
    points = MaterialPoints.undeformed(
        [body], (place + 0.5) * size, np.full(len(place), size.prod()),
        np.tile(0.5 * size, (len(place), 1)),
    )  # fmt: skip
    grid = Grid(np.zeros(dim), size)
    distribution = Distribution(comm, points, grid)
    own = distribution.owned(points)
    distribution.own = distribution.own[distribution.own]
    return distribution.located(locate(distribution.arranged(own, grid), grid, Buffers()))


def right_side(active: ActiveGrid, components: int) -> Floats:
    """Irregular, but the same in all processes."""
    wave = np.array([12.9898, 78.233, 37.719])[:components]
    phase = active.lattice[:, :1] * 3.1 + active.lattice[:, 1:2] * 7.7 + active.lattice[:, 2:] * 1.9
    return np.asarray(np.sin(wave * (phase + 0.3)))


def at_the_edge(active: ActiveGrid) -> Flags:
    """Where the nodes of the whole block are held, as their owners know it."""
    return active.updated(edge_nodes(active).astype(np.float64)) > 0.0


def solved(system: LinearSystem, multigrid: SchwarzMultigrid, right: Floats) -> tuple[Floats, int]:
    """The solution at the owned nodes, and the iterations."""
    shape = right[system.active.owned].shape

    def product(x: Floats, result: Floats) -> None:
        result[:] = multigrid.product(x.reshape(shape)).ravel()

    def precondition(residual: Floats, result: Floats) -> None:
        result[:] = multigrid.precondition(residual.reshape(shape)).ravel()

    owned = np.where(system.constrained, 0.0, right)[system.active.owned].ravel()
    found = flexible_gmres(product, precondition, owned, TOLERANCE, 50, system.comm)
    return found.x.reshape(shape), found.iterations


@pytest.mark.parametrize("processes", [2, 3, 4])
@pytest.mark.parametrize("coarsest", [20_000, 60])
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("components", [1, 2, 3])
def test_solution_and_iterations_are_those_of_one_process(
    processes: int, coarsest: int, dim: int, components: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The overlap and the coarse correction leave a few iterations to the cuts, not more."""
    monkeypatch.setattr(coarse_correction, "LARGEST_COARSE_NODES", coarsest)
    whole = grid_of(dim, SERIAL)
    system = poisson(whole, COUPLINGS[components], edge_nodes(whole))
    alone = Multigrid(whole, system.constrained)
    alone.fill(system.blocks)
    right = right_side(whole, components)
    expected = alone.solve(right, 1e-12).x.reshape(right.shape)
    iterations = alone.solve(right, TOLERANCE).iterations

    def work(comm: Communicator) -> tuple[Floats, Floats, int]:
        active = grid_of(dim, comm)
        own = poisson(active, COUPLINGS[components], at_the_edge(active))
        multigrid = SchwarzMultigrid(own)
        multigrid.fill()
        found, steps = solved(own, multigrid, right_side(active, components))
        return active.key[active.owned], found, steps

    results = run_together(processes, work)
    key, found = (np.concatenate([each[k] for each in results]) for k in (0, 1))
    np.testing.assert_array_equal(np.sort(key), whole.key)
    np.testing.assert_allclose(
        found[np.argsort(key)], expected, rtol=0, atol=1e-6 * np.abs(expected).max()
    )
    assert max(each[2] for each in results) <= iterations + 6


@pytest.mark.parametrize("processes", [2, 3])
@pytest.mark.parametrize("coarsest", [20_000, 60])
def test_the_coarse_correction_is_that_of_one_process(
    processes: int, coarsest: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Matrix and residual of the coarse grid are sums over the processes that meet there."""
    monkeypatch.setattr(coarse_correction, "LARGEST_COARSE_NODES", coarsest)

    def work(comm: Communicator) -> tuple[Integers, Floats]:
        active = grid_of(2, comm)
        held = edge_nodes(active) if comm.size == 1 else at_the_edge(active)
        system = poisson(active, COUPLINGS[2], held)
        coarse = coarse_correction.CoarseCorrection(active, system.constrained)
        coarse.begin()
        coarse.fill(system.blocks)
        residual = np.where(system.constrained, 0.0, right_side(active, 2))
        found = np.empty_like(residual)
        coarse.correct(residual, found)
        return active.key[active.owned], found[active.owned]

    ((key, expected),) = run_together(1, work)
    for own, found in run_together(processes, work):
        there = expected[np.searchsorted(key, own)]
        np.testing.assert_allclose(found, there, rtol=0, atol=1e-5 * np.abs(expected).max())


SKEW = np.array([[0.0, 0.9], [-0.9, 0.0]])


def test_nodes_that_are_solved_exactly_leave_no_residual() -> None:
    """Of an unsymmetric matrix, where the chosen nodes bear the whole solution."""
    active = grid_of(2, SERIAL)
    system = poisson(active, COUPLINGS[2] + SKEW, edge_nodes(active))
    twist = 1.0 + 0.5 * np.sin(active.lattice[:, 0])  # so that rows and columns differ in size
    row = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    system.blocks *= twist[row][:, None, None]
    multigrid = Multigrid(active, system.constrained)
    chosen = active.lattice[:, 0] < 5
    multigrid.fill(system.blocks, [chosen])
    x = np.where(system.constrained | ~chosen[:, None], 0.0, right_side(active, 2))
    residual = np.zeros_like(x)
    np.add.at(residual, row, np.einsum("bij,bj->bi", system.blocks, x[active.column]))
    residual[system.constrained] = 0.0
    found = np.empty(x.size)
    multigrid.precondition(residual.ravel(), found)
    np.testing.assert_allclose(found.reshape(x.shape), x, rtol=0, atol=1e-10)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e9])
def test_symmetric_matrices_are_told_from_others_in_any_unit(unit: float) -> None:
    """Conjugate gradients are for the former; a skew part of a thousandth is not round-off."""
    active = grid_of(2, SERIAL)
    for skew in (0.0, 1e-3):
        system = poisson(active, unit * (COUPLINGS[2] + skew * SKEW), edge_nodes(active))
        multigrid = Multigrid(active, system.constrained)
        multigrid.fill(system.blocks)
        assert (multigrid._asymmetry < SYMMETRY_TOLERANCE) == (skew == 0.0)
        if skew:
            assert 1e-3 * skew < multigrid._asymmetry < skew


def test_levels_stay_while_the_pattern_does() -> None:
    """A step on the same grid takes them over and gives the same bits; other constraints do not."""

    def work(comm: Communicator) -> list[bool]:
        active = grid_of(3, comm)
        system = poisson(active, COUPLINGS[2], at_the_edge(active))
        multigrid = SchwarzMultigrid(system)
        multigrid.fill()
        right = right_side(active, 2)
        first, _ = solved(system, multigrid, right)
        other = LinearSystem(replace(active), system.constrained)
        other.blocks[:] = system.blocks
        same = multigrid.begin(other)
        multigrid.fill()
        again, _ = solved(other, multigrid, right)
        held = system.constrained.copy()
        if comm.rank == 0:
            held[active.owned] = True
        freed = LinearSystem(active, held)
        freed.blocks[:] = system.blocks
        return [same, bool((first == again).all()), not multigrid.begin(freed)]

    assert np.all(run_together(2, work))
