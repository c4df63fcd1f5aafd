# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid of several processes: cycles of each on its part of the grid, and a coarse correction.

A two-level Schwarz method (Toselli and Widlund 2005, chapters 2 and 3). Besides the nodes that it
owns a process has copies of nodes around them, the overlap. It takes from its cycle what belongs to
its own nodes (restricted additive Schwarz: Cai and Sarkis 1999). The coarse correction comes first.
"""

from __future__ import annotations

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats
from tilth.comm import together
from tilth.solvers.coarse_correction import CoarseCorrection
from tilth.solvers.multigrid import Multigrid
from tilth.solvers.protocol import SolveFailed
from tilth.solvers.system import LinearSystem

COMPLETE = 1e-6
"""Relative difference of two processes' sums up to which these have all terms."""


class SchwarzMultigrid:
    """The preconditioner of one active grid; all processes call its methods together.

    Args:
        system: has the matrices, the first one already.

    Raises:
        SolveFailed: the nodes are scattered over a box that is far too large for their number.
    """

    def __init__(self, system: LinearSystem) -> None:
        self._system = system
        self._constrained = system.constrained
        self._owned = np.arange(system.active.nodes)[system.active.owned]
        self._held = _held(system)
        with together(system.comm, SolveFailed):
            self._local = Multigrid(system.active, self._held)
        self._coarse = CoarseCorrection(system.active, system.constrained)

    def begin(self, system: LinearSystem) -> bool:
        """Prepares for the systems of another step, the first of which is there.

        Returns False if their pattern differs.
        """
        active, held = system.active, _held(system)
        same = (
            self._local.begin(active, held)
            and np.array_equal(self._owned, np.arange(active.nodes)[active.owned])
            and np.array_equal(self._constrained, system.constrained)
        )
        if system.comm.max(float(not same)) > 0.0:
            return False
        self._system = system
        self._coarse.begin()
        return True

    def fill(self, keep_levels: bool = False) -> None:
        """Takes the matrix of the system.

        keep_levels: whether the levels of the last matrix precondition this one, too.

        Raises:
            SolveFailed: if the matrix has entries that are not numbers.
        """
        system = self._system
        with together(system.comm, SolveFailed):
            self._local.fill(system.blocks, system.exact_nodes, keep_levels=keep_levels)
        if not keep_levels:
            self._coarse.fill(system.blocks)

    @property
    def may_increase(self) -> bool:
        """Whether the equations of more nodes could be solved directly."""
        return self._system.comm.max(float(self._local.may_increase)) > 0.0

    def increase(self) -> None:
        """Solves the equations of more nodes directly until the next step.

        Raises:
            SolveFailed: if their matrix is singular.
        """
        with together(self._system.comm, SolveFailed):
            if self._local.may_increase:
                self._local.increase()

    def product(self, owned: Floats) -> Floats:
        """Returns A x at the owned nodes from x there, (owned nodes, components) each.

        It is zero where constrained, where x has to be zero, too.
        """
        active = self._system.active
        return self._product(active.updated(self._at_all(owned)))[active.owned]

    def precondition(self, owned: Floats) -> Floats:
        """Returns the correction for a residual, both (owned nodes, components)."""
        active = self._system.active
        residual = self._at_all(owned)
        correction = np.empty_like(residual)
        self._coarse.correct(residual, correction)
        remaining = active.updated(residual - self._product(correction))
        remaining[self._held] = 0.0
        found = np.empty_like(remaining)
        self._local.precondition(remaining.ravel(), found.ravel())
        return (correction + found)[active.owned]

    def _at_all(self, owned: Floats) -> Floats:
        active = self._system.active
        nodal = np.zeros((active.nodes, self._system.components))
        nodal[active.owned] = owned
        return nodal

    def _product(self, x: Floats) -> Floats:
        """Returns A x at all nodes; it is complete where this process owns them."""
        system, active = self._system, self._system.active
        product = np.empty_like(x)
        _core.block_product(
            system.components, active.row_start, active.column, system.blocks,
            system.constrained, x, product,
        )  # fmt: skip
        return product


def _held(system: LinearSystem) -> Flags:
    """Returns where the cycle of a process leaves zero: constrained, or not all soil is there.

    What adds to a row adds to its diagonal, too: rows are whole where that is as at the owner.
    """
    own = system.blocks[system.active.diagonal].trace(axis1=1, axis2=2)
    whole = system.active.updated(own)
    incomplete = ~(np.abs(own - whole) <= COMPLETE * np.abs(whole))
    return np.asarray(system.constrained | incomplete[:, None])
