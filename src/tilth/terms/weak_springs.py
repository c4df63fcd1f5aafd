# SPDX-License-Identifier: BSD-3-Clause
"""Degrees of freedom that no point supports well, and what keeps them solvable.

A node that only a sliver of material touches has a stiffness that vanishes with the square of the
overlap (GIMP), or belongs to a cell whose few points leave some of its motions without strain. Such
nodes are constrained to their place at the start of the step by weak springs, in the force and in
the stiffness alike, so that Newton's iteration stays quadratic. They resist the rigid part of the
step's motion, too: in the 64-cell column they carry 1e-9 of the weight, and a body that hangs on
few points (an edge 1e-4 of a cell wide) up to 3e-5 of it (docs/decisions/0004-weak-springs.md).

Motions without any strain at the points, such as the hour-glass motions of cells with a single
point, get a still smaller stiffness in the matrix only: the equilibrium that Newton's iteration
finds is not changed by it, and such motions stay zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, Term

RELATIVE_STIFFNESS = 1e-8
"""Stiffness of a spring relative to Young's modulus times the cell's size to the power dim - 2."""

LEAST_SUPPORT = 0.5
"""A node is badly supported below this share of what a corner of a full cell gives it."""


RELATIVE_SHIFT = 1e-11
"""The same measure of the stiffness added to all nodes in the matrix only."""


def well_supported(soil: Soil) -> Flags:
    """Returns which nodes have at least `LEAST_SUPPORT`, shape (nodes,)."""
    grid = soil.active.grid
    full = 0.5**grid.dim * np.prod(grid.cell_size) * _circumference(soil)
    return np.asarray(soil.nodal_volume >= LEAST_SUPPORT * full)


def _circumference(soil: Soil) -> Floats:
    """What a cell's area is multiplied by at each node: of the ring in axisymmetry, else 1."""
    active = soil.active
    if soil.kind != "axisymmetric":
        return np.ones(active.nodes)
    radius = np.abs(active.position[:, 0])
    return np.asarray(2.0 * np.pi * np.maximum(radius, 0.5 * active.grid.cell_size[0]))


@dataclass(frozen=True)
class WeakSprings(Term):
    """Weak springs on badly supported nodes.

    Attributes:
        stiffness: of the springs [force/length], shape (nodes,).
        shift: stiffness added to the matrix alone [force/length], shape (nodes,).
    """

    stiffness: Floats
    shift: Floats

    @classmethod
    def of(cls, soil: Soil, coupled: Flags | None = None) -> WeakSprings:
        """Returns the springs of a step; zero at well supported and `coupled` nodes, (nodes,)."""
        cell = soil.active.grid.cell_size
        stiffness = _circumference(soil) * np.prod(cell) / cell.max() ** 2
        stiffness *= soil.elastic_moduli.young.max()
        badly = ~well_supported(soil)
        if coupled is not None:
            badly &= ~coupled
        return cls(np.where(badly, RELATIVE_STIFFNESS * stiffness, 0.0), RELATIVE_SHIFT * stiffness)

    def assembled(self, active: ActiveGrid, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _WeakSprings(self, active.diagonal)


class _WeakSprings(AssembledTerm):
    def __init__(self, springs: WeakSprings, diagonal: Integers) -> None:
        self._springs, self._diagonal = springs, diagonal

    def force(self, displacement: Floats) -> Floats:
        return np.asarray(self._springs.stiffness[:, None] * displacement)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        for k in range(displacement.shape[1]):
            blocks[self._diagonal, k, k] += self._springs.stiffness + self._springs.shift
