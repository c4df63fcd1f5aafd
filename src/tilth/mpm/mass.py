# SPDX-License-Identifier: BSD-3-Clause
"""Consistent mass of the soil on the grid of one step, and the projection of the points' motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Shorts
from tilth.errors import StepFailed
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil

PROJECTION_TOLERANCE = 1e-11
"""Residual of the projection relative to the momentum [-]."""

LEAST_EIGENVALUE = 1e-10
"""Added to the mass matrix relative to its diagonal: where slivers of domains give nodes almost
dependent masses, velocities that they cannot tell apart are zero."""

MOST_ITERATIONS = 1000
"""Iterations of the projection after which it counts as failed."""


class ConsistentMass:
    """M_ab = sum_p m_p S_ap S_bp, with the ghost mass of badly cut cells.

    Args:
        soil: the material points on the grid.
        mass: of the points [mass], shape (n,).
        pattern: the grid of the step with the pattern of the matrix.
        faces: elements of equal nodes with their unit matrices (units, n, n), which of them each
            has and its weight (elements,), in the pattern; weight times unit is a mass.

    Attributes:
        blocks: the entries in the pattern of the matrix [mass], shape (blocks,).
    """

    def __init__(
        self,
        soil: Soil,
        mass: Floats,
        pattern: ActiveGrid,
        faces: Sequence[tuple[Elements, Floats, Shorts, Floats]] = (),
    ) -> None:
        points = soil.points
        self._soil, self._mass = soil, mass
        self.blocks: Floats = np.zeros(len(pattern.column))
        for body, stencil, (start, position) in zip(
            points.bodies, soil.active.stencils, pattern.block_positions, strict=True
        ):
            _core.add_mass(stencil, start, position, mass[body.points], self.blocks)
        for elements, unit, which, weight in faces:
            free = np.ones((len(weight), unit.shape[1], 1), dtype=bool)
            scalar = self.blocks.reshape(-1, 1, 1)
            _core.add_scaled_blocks(elements, weight, unit, which, free, scalar)
        self._pattern = pattern

    def times(self, nodal: Floats) -> Floats:
        """Returns M times a nodal vector, shape (nodes, dim)."""
        product = np.empty_like(nodal)
        pattern = self._pattern
        _core.symmetric_product(pattern.row_start, pattern.column, self.blocks, nodal, product)
        return product

    def projected(self, quantity: Floats, known: Flags, value: Floats | None = None) -> Floats:
        """Returns the nodal field q with M q = sum_p S_ap m_p q_p, except where it is known.

        So it has the points' momentum, and their energy if it is a field of the grid's.

        Args:
            quantity: of the points, such as a velocity, shape (n, k), k at most 12.
            known: which nodal components are given, shape (nodes, k).
            value: these components, zero elsewhere, shape (nodes, k), k a multiple of the number
                of directions; all are zero if None.

        Raises:
            StepFailed: the iteration does not converge.
        """
        right = self._soil.scatter(self._mass[:, None] * quantity)
        if value is not None:
            dim = self._pattern.grid.dim
            parts = np.hsplit(value, value.shape[1] // dim)
            right -= np.hstack([self.times(np.ascontiguousarray(part)) for part in parts])
        used = right.shape[1]
        columns = -(-used // 4) * 4  # the kernel works on four at once
        padded = np.zeros((len(right), columns))
        padded[:, :used] = right
        zero = np.ones(padded.shape, dtype=bool)
        zero[:, :used] = known
        pattern = self._pattern
        if not _core.project(
            pattern.row_start, pattern.column, self.blocks, LEAST_EIGENVALUE, zero,
            PROJECTION_TOLERANCE, MOST_ITERATIONS, padded,
        ):  # fmt: skip
            raise StepFailed(f"no projection of the velocities in {MOST_ITERATIONS} iterations")
        found = padded[:, :used]
        return found if value is None else found + value
