# SPDX-License-Identifier: BSD-3-Clause
"""Rows of [[A, B], [C, D]] over several processes, where C is not the transpose of B."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from lattice_fields import edge_nodes, poisson
from processes import run_together
from test_schwarz import COUPLINGS, at_the_edge, grid_of

from tilth.algebra.border import Border
from tilth.arrays import Floats, Integers
from tilth.comm import SERIAL, Communicator
from tilth.mpm.active_grid import ActiveGrid
from tilth.solvers import LinearSystem
from tilth.solvers.petsc_bordered import _rows

CORNER = np.array([[3.0, -1.0], [2.0, 5.0]])


def border_of(active: ActiveGrid) -> Border:
    """Smooth columns and other rows, the same at a node in all processes."""
    phase = active.lattice @ np.array([0.7, 1.3, 0.4])
    columns, rows = (
        np.stack([[np.sin(k * phase + i) for i in range(2)] for k in ks]).transpose(0, 2, 1)
        for ks in ((1, 2), (3, 4))
    )
    return Border(columns, rows, CORNER, np.ones(2))


def parts_of(comm: Communicator) -> tuple[sp.csr_matrix, Integers]:
    """A process' rows of the whole matrix, and the keys of its nodes."""
    active = grid_of(2, comm)
    held = edge_nodes(active) if comm.size == 1 else at_the_edge(active)
    system: LinearSystem = poisson(active, COUPLINGS[2], held)
    return _rows(system, border_of(active)), active.key[active.owned]


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_products_are_those_of_the_four_blocks(processes: int) -> None:
    """Of the rows of all processes, one after the other, with any vector."""
    whole = grid_of(2, SERIAL)
    system, border = poisson(whole, COUPLINGS[2], edge_nodes(whole)), border_of(whole)
    random = np.random.default_rng(1)
    x, g = random.normal(size=(whole.nodes, 2)), np.array([2.0, -3.0])
    x[system.constrained] = 0.0

    row = np.repeat(np.arange(whole.nodes), np.diff(whole.row_start))
    a_x: Floats = np.zeros_like(x)
    np.add.at(a_x, row, np.einsum("bij,bj->bi", system.blocks, x[whole.column]))
    nodal = np.where(system.constrained, 0.0, a_x + np.einsum("k,kni->ni", g, border.columns))
    of_border = np.einsum("kni,ni->k", border.rows, x) + CORNER @ g

    parts = run_together(processes, parts_of)
    key = np.concatenate([keys for _, keys in parts])
    order = np.searchsorted(whole.key, key)
    vector = np.concatenate([x[order].ravel(), g])
    product = sp.vstack([rows for rows, _ in parts]) @ vector
    expected = np.concatenate([nodal[order].ravel(), of_border])
    np.testing.assert_allclose(product, expected, rtol=0, atol=1e-11 * np.abs(expected).max())
