# SPDX-License-Identifier: BSD-3-Clause
"""Degrees of freedom that no point supports well, and what keeps them solvable.

A node that only a sliver of material touches has a stiffness that vanishes with the square of
the overlap (GIMP), or belongs to a cell whose few points leave some of its motions without
strain. Such nodes are held to their place at the start of the step by weak springs, in the force
and in the stiffness alike, so that Newton's iteration stays quadratic. The springs are so weak
that they change the solution by less than the tolerance of the iteration (docs/decisions).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.grid import ActiveGrid
from tilth.soil import Soil

Floats = npt.NDArray[np.float64]

RELATIVE_STIFFNESS = 1e-8
"""Stiffness of a spring relative to Young's modulus times the cell's size to the power dim - 2."""

LEAST_SUPPORT = 0.5
"""A node is badly supported below this share of what a corner of a full cell gives it."""


@dataclass(frozen=True)
class Springs:
    """Weak springs on badly supported nodes: stiffness [force/length], shape (nodes,)."""

    stiffness: Floats

    @classmethod
    def of(cls, soil: Soil, active: ActiveGrid) -> Springs:
        """Returns the springs of a step; zero stiffness at well supported nodes."""
        points, cell = soil.points, active.grid.cell_size
        support = soil.scatter(active, points.volume) / np.prod(cell)
        stiffness = np.full(active.nodes, float(np.prod(cell) / cell.max() ** 2))
        if soil.kind == "axisymmetric":
            circumference = 2.0 * np.pi * np.maximum(np.abs(active.position[:, 0]), 0.5 * cell[0])
            support /= circumference
            stiffness *= circumference
        young_modulus = max(float(body.parameters[0]) for body in points.bodies)
        stiffness *= RELATIVE_STIFFNESS * young_modulus
        stiffness[support >= LEAST_SUPPORT * 0.5**active.grid.dim] = 0.0
        return cls(stiffness)

    def force(self, displacement: Floats) -> Floats:
        """Returns the springs' internal force [force], shape (nodes, dim)."""
        return self.stiffness[:, None] * displacement

    def add_stiffness(self, active: ActiveGrid, blocks: Floats) -> None:
        """Adds the springs to the diagonal blocks of the matrix (blocks, dim, dim)."""
        nodes = np.flatnonzero(self.stiffness)
        for k in range(active.grid.dim):
            blocks[active.diagonal[nodes], k, k] += self.stiffness[nodes]
