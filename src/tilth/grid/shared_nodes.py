# SPDX-License-Identifier: BSD-3-Clause
"""The nodes that several processes have in a step: each is owned by one, the others have copies."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Integers
from tilth.comm import Communicator
from tilth.grid.decomposition import Boxes
from tilth.grid.keys import find_keys, places_of_keys

Number = TypeVar("Number", bound=np.generic)

NONE: Integers = np.zeros(0, dtype=np.int64)


class SharedNodes:
    """Owned nodes and copies of a step's grid.

    Args:
        comm: the processes.
        boxes: the cells of each process.
        key: sorted keys of the nodes that this process has, shape (nodes,).
        overlays: their number.

    Attributes:
        comm: the processes.
        boxes: the cells of each process.
        extra: numbers of nodes that are there for terms alone, without soil of this process.
        owned: numbers of the nodes that this process owns, ascending, shape (own,).
        number: of each node among those of all processes: those of one process follow each other,
            in the order of their keys, shape (nodes,).
        total: number of nodes of all processes.
    """

    def __init__(
        self, comm: Communicator, boxes: Boxes, key: Integers, overlays: int, extra: Integers = NONE
    ) -> None:
        self.comm, self.boxes, self.extra, self._overlays = comm, boxes, extra, overlays
        owner = self._owner(key)
        self.owned: Integers = np.flatnonzero(owner == comm.rank)
        self._copies = [
            np.flatnonzero(owner == r) if r != comm.rank else np.zeros(0, dtype=np.int64)
            for r in range(comm.size)
        ]
        asked = comm.exchanged([key[copies] if len(copies) else None for copies in self._copies])
        self._given: list[Integers | None] = [
            None if keys is None or r == comm.rank else self._find(key, keys, owner)
            for r, keys in enumerate(asked)
        ]
        counts = comm.gathered(len(self.owned))
        self.total = sum(counts)
        self.first = sum(counts[: comm.rank])
        number = np.zeros(len(key), dtype=np.int64)
        number[self.owned] = self.first + np.arange(len(self.owned))
        self.number = self.updated(number)

    def _owner(self, key: Integers) -> Integers:
        return self.boxes.owner(places_of_keys(key, self._overlays)[0])

    def owns(self, key: Integers) -> Flags:
        """Returns which of the cells or nodes with these keys this process owns, shape (n,)."""
        return np.asarray(self._owner(key) == self.comm.rank)

    def _find(self, key: Integers, sought: Integers, owner: Integers) -> Integers:
        number = find_keys(key, sought)
        assert (number >= 0).all(), "a node is not there where it is owned"
        assert (owner[number] == self.comm.rank).all(), "two processes differ in a node's owner"
        return number

    def updated(self, nodal: npt.NDArray[Number]) -> npt.NDArray[Number]:
        """Returns nodal values, shape (nodes, ...), with the copies as at their owners."""
        given = [None if n is None else np.ascontiguousarray(nodal[n]) for n in self._given]
        found = [
            np.empty((len(n), *nodal.shape[1:]), dtype=nodal.dtype) if len(n) else None
            for n in self._copies
        ]
        self.comm.exchange_arrays(given, found)
        result = nodal.copy()
        for copies, value in zip(self._copies, found, strict=True):
            if value is not None:
                result[copies] = value
        return result
