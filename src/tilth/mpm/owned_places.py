# SPDX-License-Identifier: BSD-3-Clause
"""Places that all processes know, with values that each finds for those in its own cells."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.comm import Communicator
from tilth.mpm.active_grid import ActiveGrid


class OwnedPlaces:
    """Which process owns each of n places: the owner of its cell.

    Args:
        comm: the processes.
        owner: of each place, shape (n,).
    """

    def __init__(self, comm: Communicator, owner: Integers) -> None:
        self._comm, self._owner = comm, owner

    @classmethod
    def at(cls, active: ActiveGrid, position: Floats) -> OwnedPlaces:
        """Returns those at positions [length], shape (n, dim), which all processes know."""
        if active.shared is None:
            return cls(active.comm, np.zeros(len(position), dtype=np.int64))
        cell = np.floor(active.grid.in_cells(position)).astype(np.int64)
        return cls(active.comm, active.shared.boxes.owner(cell))

    @property
    def count(self) -> int:
        """The number n of places."""
        return len(self._owner)

    @cached_property
    def own(self) -> Integers:
        """Numbers of the places that this process owns, ascending, shape (own,)."""
        return np.flatnonzero(self._owner == self._comm.rank)

    def of(self, chosen: Integers) -> OwnedPlaces:
        """Returns the chosen places, shape (k,), numbered in this order."""
        return OwnedPlaces(self._comm, self._owner[chosen])

    def of_all(self, *values: npt.NDArray[Any]) -> list[npt.NDArray[Any]]:
        """Returns values (n, ...) of all places, of those at the owned ones, (own, ...) each.

        All processes call it, with the same number of arrays.
        """
        if self._comm.size == 1:
            return list(values)
        found = [np.empty((len(self._owner), *each.shape[1:]), each.dtype) for each in values]
        for rank, parts in enumerate(self._comm.gathered(values)):
            own = self._owner == rank
            for whole, part in zip(found, parts, strict=True):
                whole[own] = part
        return found

    def rows_of_all(
        self, place: Integers, *values: npt.NDArray[Any]
    ) -> tuple[Integers, list[npt.NDArray[Any]]]:
        """Returns rows of all processes ordered by place: their places (m,) and values (m, ...).

        Any number of them at each place; those of one place stay in their order. All processes call
        it.

        place: of each row among `own`, ascending, shape (r,). values: of the rows, (r, ...) each.
        """
        if self._comm.size == 1:
            return place, list(values)
        parts = self._comm.gathered((self.own[place], *values))
        whole, *joined = (np.concatenate(each) for each in zip(*parts, strict=True))
        order = np.argsort(whole, kind="stable")
        return whole[order], [each[order] for each in joined]
