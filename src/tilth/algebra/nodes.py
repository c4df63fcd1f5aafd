# SPDX-License-Identifier: BSD-3-Clause
"""Nodes that carry a field: those of the active grid, or of a mesh of its own."""

from __future__ import annotations

from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.comm import SERIAL, Communicator

Value = TypeVar("Value", bound=np.generic)


class Nodes(Protocol):
    """Nodes of a field; each node belongs to one process, others may have copies of it."""

    @property
    def count(self) -> int:
        """Number of nodes that this process has."""
        ...

    @property
    def comm(self) -> Communicator:
        """The processes that share the nodes."""
        ...

    @property
    def owned(self) -> slice | Integers:
        """The nodes that this process owns."""
        ...

    @property
    def position(self) -> Floats:
        """[length], shape (count, dim)."""
        ...

    def updated(self, nodal: npt.NDArray[Value]) -> npt.NDArray[Value]:
        """Returns nodal values (count, ...), those of other processes' nodes as they are there.

        All processes call it.
        """
        ...


class MeshNodes:
    """Nodes of a mesh that all processes have whole; the last process owns them.

    Args:
        position: [length], shape (nodes, dim).
        comm: the processes.
    """

    def __init__(self, position: Floats, comm: Communicator = SERIAL) -> None:
        self.position, self.comm = position, comm

    @property
    def count(self) -> int:
        """As `Nodes.count`."""
        return len(self.position)

    @property
    def owned(self) -> slice:
        """As `Nodes.owned`."""
        return slice(0, self.count if self.comm.rank == self.comm.size - 1 else 0)

    def updated(self, nodal: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """As `Nodes.updated`."""
        return nodal if self.comm.size == 1 else self.comm.gathered(nodal)[-1]
