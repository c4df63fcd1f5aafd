# SPDX-License-Identifier: BSD-3-Clause
"""Elements of few nodes in the core against NumPy, and what is reused from step to step."""

from __future__ import annotations

import numpy as np
import pytest
from balances import blocks_at, residual_at
from small_problems import Laboratory

from tilth import _core
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.quadrature import locate_in_cells
from tilth.solvers.system import LinearSystem
from tilth.terms.balance import Balance
from tilth.terms.ghost import FaceCoupling
from tilth.terms.linear import Coupling, LinearElements, LinearForces

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")


KINDS = ["plane_strain", "3d"]
every_kind = pytest.mark.parametrize("kind", KINDS)


def random_couplings(active: ActiveGrid) -> list[LinearElements]:
    """Dense elements on the cells, and scaled ones, on the same nodes, with components left out."""
    random = np.random.default_rng(5)
    dim = active.grid.dim
    node = active.corners(np.asarray(_core.lattice(active.cell_keys)))
    elements, n = node.shape
    unit = random.normal(size=(3, n, n))
    half = node[::2].copy()
    return [
        Coupling(
            node=node,
            matrix=random.normal(size=(elements, n, n, dim, dim)),
            force=random.normal(size=(elements, n, dim)),
        ),
        FaceCoupling(
            node=half,
            unit=unit,
            which=random.integers(0, 3, len(half), dtype=np.int32),
            stiffness=random.random(len(half)),
            free=random.random((len(half), n, dim)) > 0.3,
            force=random.normal(size=(len(half), n, dim)),
        ),
    ]


def dense(coupling: LinearElements) -> Floats:
    """The elements' matrices, (elements, n, n, dim, dim)."""
    if isinstance(coupling, Coupling):
        return coupling.matrix
    assert isinstance(coupling, FaceCoupling)
    free = coupling.free.astype(float)
    identity = np.eye(free.shape[2])
    unit = coupling.stiffness[:, None, None] * coupling.unit[coupling.which]
    return np.asarray(np.einsum("eab,eai,ebk,ik->eabik", unit, free, free, identity))


@every_kind
def test_elements_are_what_numpy_makes_of_them(kind: str) -> None:
    random = np.random.default_rng(0)
    active = Laboratory.of(kind, "linear", "hencky_elastic", random).active
    couplings = random_couplings(active)
    balance = Balance(active, [LinearForces(couplings)])
    u = random.normal(size=(active.nodes, active.grid.dim))
    force, terms = np.zeros_like(u), np.zeros_like(u)
    constant = np.zeros_like(u)
    for each in couplings:
        matrix = dense(each)
        np.add.at(constant, each.node, each.force)
        np.add.at(force, each.node, np.einsum("eabik,ebk->eai", matrix, u[each.node]))
        magnitude = np.einsum("eabik,ebk->eai", np.abs(matrix), np.abs(u[each.node]))
        np.add.at(terms, each.node, magnitude)
    np.testing.assert_allclose(balance.constant_force(), constant, rtol=0, atol=1e-13)
    np.testing.assert_allclose(residual_at(balance, u).u, constant + force, rtol=0, atol=1e-12)
    expected = np.finfo(np.float64).eps * np.linalg.norm(np.abs(constant) + terms)
    assert round_off(balance, u) == pytest.approx(expected, rel=1e-12)
    system = LinearSystem(balance.active, np.zeros(u.shape, dtype=bool))
    system.blocks[:] = blocks_at(balance, u)
    np.testing.assert_allclose(system.times(u), force, rtol=0, atol=1e-12)


def round_off(balance: Balance, u: Floats) -> float:
    """That of the momentum's residual."""
    return balance.round_off(balance.at(u), balance.fields.values())


@every_kind
def test_elements_give_the_same_bits_for_any_number_of_threads(kind: str) -> None:
    results = []
    for threads in (1, 2, 3):
        _core.set_threads(threads)
        random = np.random.default_rng(0)
        active = Laboratory.of(kind, "linear", "hencky_elastic", random, cells=7).active
        balance = Balance(active, [LinearForces(random_couplings(active))])
        u = random.normal(size=(active.nodes, active.grid.dim))
        blocks = blocks_at(balance, u)
        parts = (balance.constant_force(), residual_at(balance, u).u, blocks)
        results.append([part.tobytes() for part in parts] + [round_off(balance, u)])
    assert results[0] == results[1] == results[2]


def test_the_pattern_is_kept_while_the_nodes_and_couplings_are_the_same() -> None:
    laboratory = Laboratory.of("3d", "linear", "hencky_elastic", np.random.default_rng(0))
    buffers = Buffers()

    def located(couplings: int) -> ActiveGrid:
        active = locate(laboratory.points, laboratory.grid, buffers)
        return Balance(active, [LinearForces(random_couplings(active)[:couplings])]).active

    first, second = located(2), located(2)
    assert second.column is first.column
    assert second.elements[1] is first.elements[1]
    fewer = located(1)
    assert fewer.column is not first.column
    again = located(1)
    assert again.column is fewer.column
    laboratory.points.position[:, 0] += laboratory.grid.cell_size[0]  # the same, one cell further
    assert located(1).column is not fewer.column


@every_kind
def test_places_without_soil_act_on_the_nearest_cell(kind: str) -> None:
    random = np.random.default_rng(2)
    active = Laboratory.of(kind, "linear", "hencky_elastic", random).active
    dim, cell = active.grid.dim, active.grid.cell_size
    soil = np.asarray(_core.lattice(active.cell_keys))[:, :dim]
    low, high = soil.min(axis=0), soil.max(axis=0) + 1
    scaled = low - 0.9 + random.random((400, dim)) * (high - low + 1.8)
    order, at = locate_in_cells(active, active.grid.origin + scaled * cell)
    scaled = scaled[order]
    chosen = active.lattice[at.node[at.cell, 0], :dim]
    off = np.maximum(np.abs(scaled[:, None] - (soil + 0.5)) - 0.5, 0.0)  # to all cells of the soil
    least = np.linalg.norm(off, axis=2).min(axis=1)
    own = np.maximum(np.abs(scaled - (chosen + 0.5)) - 0.5, 0.0)
    assert (least > 0.0).sum() > 50
    np.testing.assert_allclose(np.linalg.norm(own, axis=1), least, atol=1e-9)
    nodal = random.normal(size=(active.nodes, 2))
    expected = np.einsum("na,nak->nk", at.value, nodal[at.node[at.cell]])
    np.testing.assert_allclose(at.interpolate(nodal), expected, rtol=0, atol=1e-13)
    vector = random.normal(size=(400, 3))
    scattered = np.zeros((active.nodes, 3))
    np.add.at(scattered, at.node[at.cell], at.value[:, :, None] * vector[:, None])
    np.testing.assert_allclose(at.scatter(vector, active.nodes), scattered, rtol=0, atol=1e-13)
