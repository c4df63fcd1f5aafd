# SPDX-License-Identifier: BSD-3-Clause
"""Weak springs on hardly covered nodes, which keep the matrix regular.

The stiffness of a node vanishes with the square of its overlap with points' domains (GIMP). With
few points in a cell, some motions of its nodes cause no strain. Weak springs connect such nodes to
their positions at the start of the step. They are in the force and in the stiffness, so that
Newton's iteration converges quadratically. They also resist the rigid part of the step's motion: in
the 64-cell column they carry 1e-9 of the weight, and in a body of few points (an edge
1e-4 of a cell wide) up to 3e-5 of it (docs/decisions/0004-weak-springs.md).

A still smaller stiffness, in the matrix only, acts on all nodes. It keeps motions without strain at
the points at zero, such as the hourglass motions of cells with a single point, and does not change
the equilibrium.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil
from tilth.terms.protocol import AssembledTerm, DisplacementTerm, Term
from tilth.terms.space import Space

RELATIVE_STIFFNESS = 1e-8
"""Stiffness of a spring relative to Young's modulus times the cell's size to the power dim - 2."""

LEAST_COVER = 0.5
"""Least nodal volume of a covered node, relative to the share from one full cell, in the
mean over the cells around it."""


RELATIVE_SHIFT = 1e-11
"""Stiffness added to all nodes in the matrix only, relative to the same reference."""


def covered_nodes(soil: Soil) -> Flags:
    """Returns which nodes are covered by soil (`LEAST_COVER`), shape (nodes,)."""
    size = _cell_size(soil.active)
    full = 0.5 ** size.shape[1] * size.prod(axis=1) * _circumference(soil)
    return np.asarray(soil.nodal_volume >= LEAST_COVER * full)


def _cell_size(active: ActiveGrid) -> Floats:
    """Returns the mean sizes of the cells around each node [length], shape (nodes, dim)."""
    return active.grid.sizes_around(active.lattice[:, : active.grid.dim])


def _circumference(soil: Soil) -> Floats:
    """Returns the cells' thickness at each node: the circumference in axisymmetry, otherwise 1."""
    active = soil.active
    if soil.kind != "axisymmetric":
        return np.ones(active.nodes)
    radius = np.abs(active.position[:, 0])
    return np.asarray(2.0 * np.pi * np.maximum(radius, 0.5 * _cell_size(active)[:, 0]))


@dataclass(frozen=True)
class WeakSprings(Term):
    """Weak springs on hardly covered nodes.

    Attributes:
        stiffness: of the springs [force/length], shape (nodes,).
        shift: stiffness added in the matrix only [force/length], shape (nodes,).
    """

    stiffness: Floats
    shift: Floats

    @classmethod
    def of(cls, soil: Soil, held: Flags | None = None) -> WeakSprings:
        """Returns the springs of a step.

        held: nodes that other terms hold and that need no spring, shape (nodes,).
        """
        size = _cell_size(soil.active)
        stiffness = _circumference(soil) * size.prod(axis=1) / size.max(axis=1) ** 2
        stiffness *= soil.active.comm.max(float(soil.elastic_moduli.young.max(initial=0.0)))
        loose = ~covered_nodes(soil)
        if held is not None:
            loose &= ~held
        return cls(np.where(loose, RELATIVE_STIFFNESS * stiffness, 0.0), RELATIVE_SHIFT * stiffness)

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        return _WeakSprings(self, space.active.diagonal)


class _WeakSprings(DisplacementTerm):
    label = "weak springs"

    def __init__(self, springs: WeakSprings, diagonal: Integers) -> None:
        self._springs, self._diagonal = springs, diagonal

    def force(self, displacement: Floats) -> Floats:
        return np.asarray(self._springs.stiffness[:, None] * displacement)

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        for k in range(displacement.shape[1]):
            blocks[self._diagonal, k, k] += self._springs.stiffness + self._springs.shift
