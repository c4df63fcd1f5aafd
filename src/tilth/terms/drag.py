# SPDX-License-Identifier: BSD-3-Clause
"""Viscous drag against which soil creeps to its equilibrium or to its collapse.

It resists the motion of the nodes, and the strain of the soil as its elasticity does. The former
alone holds motions of single points little and those of all soil much: it would have to be so stiff
for the one that the other takes hundreds of steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tilth import _core
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Term
from tilth.terms.space import Space


@dataclass
class Drag(Term):
    """The force (stiffness + K) (u - before) / size of a step of backward Euler in pseudo-time.

    K is the elastic stiffness of the soil at the start of the step of the load. It has no effect
    while the size is infinite. What it holds may be changed between solutions.

    Attributes:
        soil: of which K is.
        stiffness: of the nodes in a pseudo-step of size 1 [force/length], shape (nodes,).
        before: displacement at the start of the pseudo-step [length], shape (nodes, dim).
        size: of the pseudo-step [-].
    """

    soil: Soil
    stiffness: Floats
    before: Floats
    size: float = np.inf

    @classmethod
    def of(cls, soil: Soil) -> Drag:
        """Returns a drag without effect on soil."""
        shape = (soil.active.nodes, soil.active.grid.dim)
        return cls(soil, np.zeros(shape[0]), np.zeros(shape))

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _Drag(self, space.active)


class _Drag(DisplacementTerm):
    label = "drag"

    def __init__(self, drag: Drag, active: ActiveGrid) -> None:
        self._drag, self._active = drag, active

    @cached_property
    def _elastic(self) -> Floats:
        """Elastic stiffness of the soil [force/length], shape (blocks, dim, dim)."""
        nodes, dim = self._drag.before.shape
        blocks = np.zeros((len(self._active.column), dim, dim))
        elastic = self._drag.soil.without_strain(1.0)
        elastic.update(np.zeros((nodes, dim)))
        elastic.add_stiffness(self._active, blocks)
        return blocks

    def force(self, displacement: Floats) -> Floats:
        drag, active = self._drag, self._active
        if np.isinf(drag.size):
            return np.zeros_like(displacement)
        moved = (displacement - drag.before) / drag.size
        force, no = np.empty_like(moved), np.zeros(moved.shape, dtype=bool)
        _core.block_product(
            moved.shape[1], active.row_start, active.column, self._elastic, no, moved, force
        )
        return np.asarray(force + drag.stiffness[:, None] * moved)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        drag = self._drag
        if np.isinf(drag.size):
            return
        blocks += self._elastic / drag.size
        for k in range(displacement.shape[1]):
            blocks[self._active.diagonal, k, k] += drag.stiffness / drag.size
