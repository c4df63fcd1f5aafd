# SPDX-License-Identifier: BSD-3-Clause
"""Cells and points over several processes: equal shares, one owner each, all points gathered."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from lattice_fields import LAW
from processes import random_boxes, run_together, whole_rows
from staged_problems import staged_entries

from tilth import Model
from tilth.analysis.gathering import gathered_state
from tilth.analysis.owners import DECLARED_POSITION
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats, Integers
from tilth.comm import SERIAL, Communicator
from tilth.grid.background import Grid
from tilth.grid.decomposition import Boxes, Cut, bisected
from tilth.mpi import Processes
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.distribution import Distribution
from tilth.mpm.points import MaterialPoints, PointRange

__all__ = ["whole_rows"]


def cells_of(*counts: int) -> Integers:
    """Each cell of a block that begins at -3 once, shape (n, dim)."""
    axes = [np.arange(count) - 3 for count in counts]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))


@pytest.mark.parametrize("parts", [2, 3, 4, 6])
def test_layers_with_as_many_points_each_are_shared_out_evenly(parts: int) -> None:
    for cell in (cells_of(12, 2), cells_of(2, 12), cells_of(2, 2, 12)):
        owner = bisected(SERIAL, parts, cell).owner(cell)
        assert np.bincount(owner).tolist() == [len(cell) // parts] * parts


def test_a_cut_is_where_the_shares_are_most_equal() -> None:
    """Of layers with 1 to 9 points: 1 + ... + 6 = 21 and 7 + 8 + 9 = 24 are the halves."""
    cell = np.repeat(np.stack([np.arange(9), np.zeros(9, dtype=np.int64)], axis=1),
                     np.arange(1, 10), axis=0)  # fmt: skip
    owner = bisected(SERIAL, 2, cell).owner(cell)
    assert np.bincount(owner).tolist() == [21, 24]


def test_every_cell_is_in_the_box_of_its_owner_alone() -> None:
    """Boxes and owners agree; the layers around a box are as many as were asked for."""
    boxes = Boxes(Cut(0, 2, Cut(1, 0, 0, 1), Cut(0, 5, 2, 3)), 2)
    cell = cells_of(12, 8)
    owner = boxes.owner(cell)
    by_hand = np.where(
        cell[:, 0] < 2, np.where(cell[:, 1] < 0, 0, 1), np.where(cell[:, 0] < 5, 2, 3)
    )
    np.testing.assert_array_equal(owner, by_hand)
    for rank in range(4):
        np.testing.assert_array_equal(boxes.near(rank, cell, 0), owner == rank)
    np.testing.assert_array_equal(boxes.near(2, cell, 1), (cell[:, 0] >= 1) & (cell[:, 0] < 6))


def points_of(cell: Integers) -> MaterialPoints:
    """A point in the middle of each unit cell; two bodies, one after the other."""
    count, dim = cell.shape
    half, more = count // 2, (LAW, np.array([1.0, 0.0]), 1.0)
    bodies = [
        PointRange("one", 0, half, "linear", None, *more),
        PointRange("two", half, count, "linear", None, *more, body=1),
    ]
    return MaterialPoints.undeformed(bodies, cell + 0.5, np.ones(count), np.full((count, dim), 0.5))


@pytest.mark.parametrize("processes", [2, 3])
def test_points_are_gathered_in_the_order_of_their_numbers(
    processes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever process owns them: a checkpoint is that of a run of one process."""
    monkeypatch.setattr("tilth.mpm.distribution.bisected", random_boxes(4))
    cell = np.random.default_rng(2).permutation(cells_of(9, 7))

    def work(comm: Communicator) -> dict[str, Any]:
        points, grid = points_of(cell), Grid(np.zeros(2), np.ones(2))
        distribution = Distribution(comm, points, grid)
        own = distribution.owned(points)
        distribution.own = distribution.own[distribution.own]
        arranged = distribution.arranged(own, grid)
        distribution.located(locate(arranged, grid, Buffers()))
        return distribution.gathered(arranged)

    first, *others = run_together(processes, work)
    assert others == [{}] * (processes - 1)
    expected = points_of(cell).arrays()
    assert first.keys() == expected.keys()
    for name, array in expected.items():
        np.testing.assert_array_equal(first[name], array, err_msg=name)


class Numbers:
    """What mpi4py's communicator does with one number of each process, of which this is one."""

    def __init__(self, values: Floats, rank: int) -> None:
        self.values, self.rank, self.size = values, rank, len(values)

    def Allgather(self, value: Floats, found: Floats) -> None:  # noqa: N802
        assert value == self.values[self.rank]
        found[:] = self.values


@pytest.mark.parametrize("place", [0, 1, 2])
def test_sum_and_maximum_are_those_of_all_processes(place: int) -> None:
    values = np.roll([7.0, -2.0, 1e-17], place)
    for rank, own in enumerate(values):
        processes = Processes(Numbers(values, rank))
        assert processes.max(own) == 7.0
        assert processes.sum(own) == 5.0
    values = np.roll([np.inf, np.nan, 0.0], place)
    number = int(np.isfinite(values).argmax())
    assert np.isnan(Processes(Numbers(values, number)).max(0.0))


@pytest.mark.usefixtures("whole_rows")
def test_the_checkpoint_of_a_stage_has_where_its_points_were_declared() -> None:
    """A stage that resets displacements could not be gone on with otherwise."""
    model = Model.from_dict(staged_entries()).of_stages[1]
    serial = Simulation(model).state.arrays()

    def gathered(comm: Communicator) -> dict[str, Any]:
        simulation = Simulation(model)
        simulation.distribute(comm)
        return gathered_state(simulation.state)

    first, other = run_together(2, gathered)
    assert other == {}
    assert first.keys() == serial.keys()
    order, number = (np.argsort(each["point_id"]) for each in (first, serial))
    np.testing.assert_array_equal(
        first[DECLARED_POSITION][order], serial[DECLARED_POSITION][number]
    )
