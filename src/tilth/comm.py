# SPDX-License-Identifier: BSD-3-Clause
"""Reductions over all processes; the serial run is the run with one process."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth import _core


class Communicator(Protocol):
    """What the algorithms need of a communicator."""

    def sum(self, value: float) -> float:
        """Returns the sum of a number over all processes."""
        ...


class Serial:
    """One process: every reduction returns its argument."""

    def sum(self, value: float) -> float:
        """Returns `value`."""
        return value


SERIAL = Serial()
"""The communicator of a serial run."""


def norm(comm: Communicator, owned: npt.NDArray[np.float64]) -> float:
    """Returns the Euclidean norm of a vector of which each process holds its own part."""
    return math.sqrt(comm.sum(_core.inner(owned, owned)))
