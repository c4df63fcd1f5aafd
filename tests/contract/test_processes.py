# SPDX-License-Identifier: BSD-3-Clause
"""Every term and boundary on several processes has the forces and the matrix of a serial run.

With cells shared out at random, by the nodes that each process owns: of one step, and of the next
one after points, stresses and faces have moved.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from balances import blocks_at, residual_at
from processes import random_boxes, run_together, whole_rows
from terms_of_blocks import CASES

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.comm import SERIAL, Communicator
from tilth.terms.balance import Balance
from tilth.terms.protocol import Role

__all__ = ["whole_rows"]
pytestmark = pytest.mark.slow

Rows = dict[tuple[int, ...], Floats]


def displacement(balance: Balance) -> Floats:
    """Of the nodes, a small one that does not depend on their numbers."""
    active = balance.active
    x = active.position / active.grid.cell_size
    phase = x @ np.array([0.7, 1.3, 0.4])[: x.shape[1]]
    size = 1e-3 * float(active.grid.cell_size.min())
    return size * np.stack([np.sin(phase + k) for k in range(x.shape[1])], axis=1)


def rows_of(simulation: Simulation, before: float, after: float) -> tuple[Rows, Rows, list[str]]:
    """Forces and matrix rows of the nodes that a process owns, by the nodes' keys; the terms."""
    step = simulation.prepare(before, after)
    balance = Balance(step.active, simulation.terms(step, simulation.soil_on(step.active)))
    active, u = balance.active, displacement(balance)
    forces = residual_at(balance, u)
    blocks = blocks_at(balance, u)
    owned = np.zeros(active.nodes, dtype=bool)
    owned[active.owned] = True
    parts = np.stack([forces.u, forces.load, forces.sum_of(Role.SOIL), balance.load_before], axis=1)
    of_nodes = {
        (int(key),): part for key, part in zip(active.key[owned], parts[owned], strict=True)
    }
    row = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    of_blocks = {
        (int(active.key[i]), int(active.key[j])): block
        for i, j, block in zip(row, active.column, blocks, strict=True)
        if owned[i] and block.any()
    }
    return of_nodes, of_blocks, [type(term).__name__ for term in balance.terms]


def stepped(model: Model, comm: Communicator, times: list[float]) -> list[Any]:
    """What `rows_of` gives in the first step and, once it is taken, in the second one."""
    simulation = Simulation(model)
    simulation.check()
    simulation.distribute(comm)
    first = rows_of(simulation, times[0], times[1])
    simulation.advance(times[0], times[1])
    return [first, rows_of(simulation, times[1], times[2])]


def marched(model: Model, comm: Communicator, times: list[float]) -> list[Any]:
    """Reactions of all steps, and the state of all points at the end."""
    simulation = Simulation(model)
    simulation.check()
    simulation.distribute(comm)
    found = []
    for before, after in pairwise(times):
        result = simulation.advance(before, after)
        found.append({name: result.resultant(name) for name in result.forces})
    points = simulation.state.distribution.whole(simulation.state.points)
    order = points.in_order
    return [found, points.position[order], points.stress[order], points.plastic[order]]


def together(parts: list[Rows]) -> Rows:
    """The rows of all processes, none of which two have."""
    found: Rows = {}
    for part in parts:
        assert not found.keys() & part.keys(), "two processes own a node"
        found |= part
    return found


@pytest.mark.usefixtures("whole_rows")
@pytest.mark.parametrize("size", [2, 3])
@pytest.mark.parametrize("name", CASES)
def test_forces_and_rows_are_those_of_a_serial_run(
    name: str, size: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, times = CASES[name]()
    reference = stepped(model, SERIAL, times)
    seed = 10 * size + len(name)
    monkeypatch.setattr("tilth.mpm.distribution.bisected", random_boxes(seed))
    found = run_together(size, lambda comm: stepped(model, comm, times))
    for number, (forces, blocks, terms) in enumerate(reference):
        assert all(each[number][2] == terms for each in found)
        for serial, kind in ((forces, 0), (blocks, 1)):
            parallel = together([each[number][kind] for each in found])
            assert parallel.keys() == serial.keys()
            keys = sorted(serial)
            a, b = (np.array([each[key] for key in keys]) for each in (serial, parallel))
            scale = np.abs(a).max(axis=0) if kind == 0 else np.abs(a).max()
            tolerance = (1e-9 if number else 1e-11) * np.maximum(scale, 1e-6 * np.abs(a).max())
            assert (np.abs(a - b) <= tolerance).all(), (number, kind, np.abs(a - b).max())


@pytest.mark.usefixtures("whole_rows")
@pytest.mark.parametrize("name", CASES)
def test_cells_shared_out_anew_in_each_step(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Points, faces of the ghost stabilisation and the last step go to other processes."""
    model, times = CASES[name]()
    reference = marched(model, SERIAL, times)
    monkeypatch.setattr("tilth.mpm.distribution.bisected", random_boxes(3))
    monkeypatch.setattr("tilth.mpm.distribution.LARGEST_LOAD", 0.0)
    found = run_together(3, lambda comm: marched(model, comm, times))
    for each in found:
        for serial, parallel in zip(reference[0], each[0], strict=True):
            scale = max(np.abs(force).max() for force in serial.values())
            for boundary, force in serial.items():
                assert np.abs(force - parallel[boundary]).max() <= 1e-8 * scale
        for serial, parallel in zip(reference[1:], each[1:], strict=True):
            assert np.abs(serial - parallel).max() <= 1e-8 * np.abs(serial).max()
