# SPDX-License-Identifier: BSD-3-Clause
"""Reductions over all processes; the serial run is the run with one process.

Sums within a process are those of the core; they are identical for any number of threads.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth import _core

Floats = npt.NDArray[np.float64]


class Communicator(Protocol):
    """Reductions over all processes that the algorithms use."""

    def sum(self, value: float) -> float:
        """Returns the sum of each process's `value`."""
        ...

    def max(self, value: float) -> float:
        """Returns the largest of the processes' `value`."""
        ...


class Serial:
    """One process: every reduction returns its argument."""

    def sum(self, value: float) -> float:
        """Returns `value`."""
        return value

    def max(self, value: float) -> float:
        """Returns `value`."""
        return value


SERIAL = Serial()
"""The communicator of a serial run."""


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
