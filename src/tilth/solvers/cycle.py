# SPDX-License-Identifier: BSD-3-Clause
"""Cycles of multigrid as preconditioners of the equations of one of several fields."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tilth.arrays import Floats
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.system import LinearSystem


class Cycle(Protocol):
    """A preconditioner of the equations of one field; all processes call its methods together."""

    def fill(self, keep_levels: bool = False) -> None:
        """Takes the matrix that the system has now.

        keep_levels: whether the levels of the last matrix precondition this one, too.

        Raises:
            SolveFailed: it has entries that are not numbers.
        """
        ...

    @property
    def may_increase(self) -> bool:
        """Whether the equations of more nodes could be solved directly."""
        ...

    def increase(self) -> None:
        """Solves the equations of more nodes directly until the next step.

        Raises:
            SolveFailed: if their matrix is singular.
        """
        ...

    def precondition(self, owned: Floats) -> Floats:
        """Returns the correction for a residual, both (owned nodes, components).

        The residual is 0 where constrained.
        """
        ...


class CycleOfOne:
    """The preconditioner of a field of one process, see `Cycle`."""

    def __init__(self, multigrid: Multigrid, system: LinearSystem) -> None:
        self._multigrid, self._system = multigrid, system

    def fill(self, keep_levels: bool = False) -> None:
        """As `Cycle.fill`."""
        system = self._system
        self._multigrid.fill(system.blocks, system.exact_nodes, keep_levels=keep_levels)

    @property
    def may_increase(self) -> bool:
        """As `Cycle.may_increase`."""
        return self._multigrid.may_increase

    def increase(self) -> None:
        """As `Cycle.increase`."""
        self._multigrid.increase()

    def precondition(self, owned: Floats) -> Floats:
        """As `Cycle.precondition`."""
        found = np.empty_like(owned)
        self._multigrid.precondition(owned.ravel(), found.ravel())
        return found


class CycleMaker(Protocol):
    """Makes preconditioners of single fields, and keeps them for later steps."""

    def cycle(self, system: LinearSystem, name: str) -> Cycle:
        """Returns the preconditioner of a field of the grid; `system` has its first matrix.

        Raises:
            SolveFailed: there are no levels of multigrid.
        """
        ...
