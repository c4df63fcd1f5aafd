# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid of several processes: as many iterations as that of one, and the same solution."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from lattice_fields import LAW, edge_nodes, poisson
from processes import run_together

from tilth.arrays import Flags, Floats
from tilth.comm import SERIAL, Communicator
from tilth.mpm.distribution import Distribution
from tilth.mpm.grid import ActiveGrid, Buffers, Grid, locate
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.solvers import LinearSystem, Multigrid, coarse_correction
from tilth.solvers.krylov import flexible_gmres
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
