# SPDX-License-Identifier: BSD-3-Clause
"""What the processes of a run tell each other; the serial run is the run with one process.

Sums within a process are those of the core; they are identical for any number of threads. Sums over
the processes are taken in the order of their numbers, so that a run has the same bits each time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.errors import TilthError

Floats = npt.NDArray[np.float64]
Array = npt.NDArray[Any]
T = TypeVar("T")


class Communicator(Protocol):
    """What the processes of a run tell each other; all of them call each method at the same place.

    Attributes:
        rank: number of this process, from 0.
        size: number of processes.
        sent: bytes that this process has sent to others in exchanges.
    """

    rank: int
    size: int
    sent: int

    def sum(self, value: float) -> float:
        """Returns the sum of each process's `value`, in the order of their numbers."""
        ...

    def max(self, value: float) -> float:
        """Returns the largest of the processes' `value`."""
        ...

    def gathered(self, value: T) -> list[T]:
        """Returns each process's `value`, in the order of their numbers, in all processes."""
        ...

    def gathered_first(self, value: T) -> list[T]:
        """Returns the same in process 0; an empty list in the others."""
        ...

    def exchanged(self, values: Sequence[T]) -> list[T]:
        """Sends `values[r]` to each process r; returns what the processes sent to this one."""
        ...

    def exchange_arrays(self, given: Sequence[Array | None], found: Sequence[Array | None]) -> None:
        """Sends `given[r]` to each process r; fills `found[r]` with what r sends to this one.

        The arrays are contiguous, and of the size and type that the other process has; None where
        nothing is sent. What a process would send to itself is left out.
        """
        ...


class Serial:
    """One process: every reduction returns its argument."""

    rank, size, sent = 0, 1, 0

    def sum(self, value: float) -> float:
        """Returns `value`."""
        return value

    def max(self, value: float) -> float:
        """Returns `value`."""
        return value

    def gathered(self, value: T) -> list[T]:
        """Returns `value` alone."""
        return [value]

    def gathered_first(self, value: T) -> list[T]:
        """Returns `value` alone."""
        return [value]

    def exchanged(self, values: Sequence[T]) -> list[T]:
        """Returns `values`."""
        return list(values)

    def exchange_arrays(self, given: Sequence[Array | None], found: Sequence[Array | None]) -> None:
        """Does nothing."""


SERIAL = Serial()
"""The communicator of a serial run."""


@contextmanager
def together(comm: Communicator, kind: type[Exception] = TilthError) -> Iterator[None]:
    """Raises an error that one process meets inside in all processes.

    No process may wait for another one inside. kind: of the error; those of tilth if not given.
    """
    failure: Exception | None = None
    try:
        yield
    except kind as error:
        if comm.size == 1:
            raise
        failure = error
    if comm.size > 1:
        found = [each for each in comm.gathered(failure) if each is not None]
        if found:  # the same one in all, that of which the least of a step is possible
            raise min(found, key=lambda each: getattr(each, "share", None) or 0.0)


def total(comm: Communicator, array: Floats) -> Floats:
    """Returns the sum of each process's `array`, in the order of their numbers."""
    return np.asarray(np.sum(comm.gathered(array), axis=0)) if comm.size > 1 else array


def from_owners(comm: Communicator, mine: npt.NDArray[np.bool_], values: Floats) -> Floats:
    """Returns n rows of values in all processes, each row from the process that knows it.

    mine: which rows this process knows, shape (n,); each row is known to one process.
    values: these rows, in their order.
    """
    if comm.size == 1:
        return values
    parts = comm.gathered((np.flatnonzero(mine), values))
    order = np.argsort(np.concatenate([row for row, _ in parts]))
    assert len(order) == len(mine), "a row is known to no process or to several"
    return np.asarray(np.concatenate([part for _, part in parts])[order])


def inner(comm: Communicator, a: Floats, b: Floats) -> float:
    """Returns the inner product of vectors distributed over the processes."""
    return comm.sum(_core.inner(a, b))


def norm(comm: Communicator, owned: Floats) -> float:
    """Returns the Euclidean norm of a vector distributed over the processes."""
    return math.sqrt(inner(comm, owned, owned))


def two_inner(comm: Communicator, a: Floats, b: Floats, c: Floats) -> tuple[float, float]:
    """Returns the inner products a . b and a . c, as `inner`, in one pass."""
    with_b, with_c = _core.two_inner(a, b, c)
    return comm.sum(with_b), comm.sum(with_c)


def advance(comm: Communicator, length: float, p: Floats, q: Floats, x: Floats, r: Floats) -> float:
    """Adds `length` p to x, subtracts `length` q from r, in place; returns r . r, as `inner`."""
    return comm.sum(_core.advance(length, p, q, x, r))


def count(comm: Communicator, number: int) -> int:
    """Returns the sum of each process's integer `number`."""
    return int(comm.sum(float(number)))
