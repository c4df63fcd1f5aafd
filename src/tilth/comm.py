# SPDX-License-Identifier: BSD-3-Clause
"""Reductions over all processes; the serial run is the run with one process.

Sums within a process are the core's, which have the same bits for any number of threads.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth import _core

Floats = npt.NDArray[np.float64]


class Communicator(Protocol):
    """What the algorithms need of a communicator."""

    def sum(self, value: float) -> float:
        """Returns the sum of a number over all processes."""
        ...

    def max(self, value: float) -> float:
        """Returns the largest of a number over all processes."""
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
    """Returns the inner product of vectors of which each process holds its own part."""
    return comm.sum(_core.inner(a, b))


def norm(comm: Communicator, owned: Floats) -> float:
    """Returns the Euclidean norm of a vector of which each process holds its own part."""
    return math.sqrt(inner(comm, owned, owned))


def two_inner(comm: Communicator, a: Floats, b: Floats, c: Floats) -> tuple[float, float]:
    """Returns the inner products of `a` with `b` and with `c`, as `inner`, in one pass."""
    with_b, with_c = _core.two_inner(a, b, c)
    return comm.sum(with_b), comm.sum(with_c)


def advance(comm: Communicator, length: float, p: Floats, q: Floats, x: Floats, r: Floats) -> float:
    """Adds `length` p to x, takes `length` q from r, in place; returns r . r, as `inner`."""
    return comm.sum(_core.advance(length, p, q, x, r))


def count(comm: Communicator, number: int) -> int:
    """Returns the sum of a whole number over all processes."""
    return int(comm.sum(float(number)))
