# SPDX-License-Identifier: BSD-3-Clause
"""Viscous drag on the nodes, against which soil creeps to its equilibrium or to its collapse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.terms.protocol import AssembledTerm, Term


@dataclass
class Drag(Term):
    """The force stiffness (u - before) / size of a step of backward Euler in pseudo-time.

    It has no effect while the size is infinite. What it holds may be changed between solutions.

    Attributes:
        stiffness: of a pseudo-step of size 1 [force/length], shape (nodes,).
        before: displacement at the start of the pseudo-step [length], shape (nodes, dim).
        size: of the pseudo-step [-].
    """

    stiffness: Floats
    before: Floats
    size: float = np.inf

    @classmethod
    def of(cls, active: ActiveGrid) -> Drag:
        """Returns a drag without effect on the nodes of a grid."""
        shape = (active.nodes, active.grid.dim)
        return cls(np.zeros(shape[0]), np.zeros(shape))

    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _Drag(self, active)


class _Drag(AssembledTerm):
    def __init__(self, drag: Drag, active: ActiveGrid) -> None:
        self._drag, self._active = drag, active

    def force(self, displacement: Floats) -> Floats:
        drag = self._drag
        return np.asarray(drag.stiffness[:, None] / drag.size * (displacement - drag.before))

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        for k in range(displacement.shape[1]):
            blocks[self._active.diagonal, k, k] += self._drag.stiffness / self._drag.size
