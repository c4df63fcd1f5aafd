# SPDX-License-Identifier: BSD-3-Clause
"""Several processes of a run as threads of one: without MPI, in any test.

What they send to each other is pickled, as between processes. Linear systems are solved by each of
them with the rows of all.
"""

from __future__ import annotations

import math
import pickle
import threading
from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
import pytest
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from tilth.arrays import Floats, Integers
from tilth.comm import Array, Communicator
from tilth.grid.decomposition import Boxes, Cut
from tilth.solvers import LinearSystem

T = TypeVar("T")


class Threads:
    """A communicator of threads, see `tilth.comm.Communicator`."""

    def __init__(self, rank: int, size: int, board: list[Any], barrier: threading.Barrier) -> None:
        self.rank, self.size, self.sent = rank, size, 0
        self._board, self._barrier = board, barrier

    def gathered(self, value: T) -> list[T]:
        self._board[self.rank] = pickle.dumps(value)
        self._barrier.wait()
        found = [pickle.loads(each) for each in self._board]
        self._barrier.wait()
        return found

    def gathered_first(self, value: T) -> list[T]:
        found = self.gathered(value)
        return found if self.rank == 0 else []

    def exchanged(self, values: Sequence[T]) -> list[T]:
        return [each[self.rank] for each in self.gathered(list(values))]

    def exchange_arrays(self, given: Sequence[Array | None], found: Sequence[Array | None]) -> None:
        for r, value in enumerate(self.exchanged(given)):
            place = found[r]
            if r != self.rank and place is not None:
                place[...] = value

    def sum(self, value: float) -> float:
        return math.fsum(self.gathered(value))

    def max(self, value: float) -> float:
        return max(self.gathered(value))


def run_together(size: int, work: Callable[[Communicator], T]) -> list[T]:
    """Runs `work` in so many processes; returns what each returns.

    The first error of a process that does not come from another's end is raised.
    """
    board: list[Any] = [None] * size
    barrier = threading.Barrier(size, timeout=300.0)
    results: list[Any] = [None] * size
    errors: list[BaseException] = []

    def run(rank: int) -> None:
        try:
            results[rank] = work(Threads(rank, size, board, barrier))
        except BaseException as error:
            errors.append(error)
            barrier.abort()

    threads = [threading.Thread(target=run, args=(rank,)) for rank in range(size)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    found = [each for each in errors if not isinstance(each, threading.BrokenBarrierError)]
    for error in [*found, *errors]:
        raise error
    return results


class WholeRows:
    """Solves the systems of a step in each process, with the rows of all: see `StepSolver`."""

    by_multigrid = False
    summary = "none"

    def begin(self, system: LinearSystem) -> WholeRows:
        found = WholeRows()
        found.system = system  # type: ignore[attr-defined]
        return found

    def renew(self, similar: bool = False) -> None:
        """Each solution takes the present matrix."""

    def solve_bordered(
        self, right_side: Floats, global_right_side: Floats, tolerance: float
    ) -> tuple[Floats, Floats]:
        system: LinearSystem = self.system  # type: ignore[attr-defined]
        assert system.border is None
        active, k = system.active, system.components
        matrix, number = whole_matrix(system)
        dof = (k * number[:, None] + np.arange(k)).ravel()
        free, side = np.zeros(matrix.shape[0], dtype=bool), np.zeros(matrix.shape[0])
        parts = active.comm.gathered(
            (number[active.owned], ~system.constrained[active.owned], right_side[active.owned])
        )
        for numbers, is_free, values in parts:
            own = (k * numbers[:, None] + np.arange(k)).ravel()
            free[own], side[own] = is_free.ravel(), values.ravel()
        found = np.zeros(len(side))
        rows = np.flatnonzero(free)
        found[rows] = spla.spsolve(matrix[rows][:, rows].tocsc(), side[rows])
        return found[dof].reshape(right_side.shape), np.zeros(0)


def whole_matrix(system: LinearSystem) -> tuple[sp.csr_matrix, Integers]:
    """The matrix of all processes' owned rows, and the number of each node among those of all."""
    active, k = system.active, system.components
    number = np.arange(active.nodes) if active.shared is None else active.shared.number
    total = active.nodes if active.shared is None else active.shared.total
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    own = np.isin(rows, np.arange(active.nodes)[active.owned])
    parts = active.comm.gathered(
        (number[rows[own]], number[active.column[own]], system.blocks[own])
    )
    row, column, block = (np.concatenate(each) for each in zip(*parts, strict=True))
    i = (k * row[:, None, None] + np.arange(k)[:, None]) + np.zeros((k, k), dtype=np.int64)
    j = (k * column[:, None, None] + np.arange(k)) + np.zeros((k, k), dtype=np.int64)[:, :]
    shape = (k * total, k * total)
    return sp.csr_matrix((block.ravel(), (i.ravel(), j.ravel())), shape), number


def random_boxes(seed: int) -> Callable[[Communicator, int, Integers], Boxes]:
    """Returns what stands for `bisected`: cuts at random places, the same in all processes.

    They are others in each call of a process.
    """
    calls: Counter[int] = Counter()

    def cut(random: np.random.Generator, first: int, parts: int, cell: Integers) -> Cut | int:
        if parts == 1:
            return first
        axis = int(random.integers(cell.shape[1]))
        places = np.unique(cell[:, axis])
        if len(places) < parts:
            axis = int(np.ptp(cell, axis=0).argmax())
            places = np.unique(cell[:, axis])
        half = int(random.integers(1, parts))
        index = int(random.integers(half, len(places) - (parts - half) + 1))
        line = int(places[index])
        below = cell[:, axis] < line
        return Cut(
            axis, line, cut(random, first, half, cell[below]),
            cut(random, first + half, parts - half, cell[~below]),
        )  # fmt: skip

    def boxes(comm: Communicator, parts: int, cell: Integers) -> Boxes:
        whole = np.unique(np.concatenate(comm.gathered(cell)), axis=0)
        thread = threading.get_ident()
        calls[thread] += 1
        random = np.random.default_rng([seed, calls[thread]])
        return Boxes(cut(random, 0, parts, whole), cell.shape[1])

    return boxes


@pytest.fixture
def whole_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Linear systems of several processes are solved without PETSc."""
    solver = lambda name, note: WholeRows()  # noqa: E731
    monkeypatch.setattr("tilth.analysis.services.distributed_solver", solver)
