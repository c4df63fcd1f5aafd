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
"""Added to the mass matrix relative to its diagonal: where slivers of domains, or few points, give
nodes almost dependent masses, velocities that they cannot tell apart are those of `lumped`."""

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

    def lumped(self, momentum: Floats) -> Floats:
        """Returns the nodal field of a momentum with the lumped mass of the points, (nodes, k).

        Around a point that is alone it is constant; zero at nodes without mass.
        """
        mass = self._soil.scatter(self._mass[:, None])
        return np.where(mass > 0.0, momentum / np.where(mass > 0.0, mass, 1.0), 0.0)

    def projected(self, quantity: Floats, known: Flags, value: Floats | None = None) -> Floats:
        """Returns the nodal field q with M q = sum_p S_ap m_p q_p, except where it is known.

        So it has the points' momentum, and their energy if it is a field of the grid's.

        Args:
            quantity: of the points, such as a velocity, shape (n, k), k at most 12 and a
                multiple of the number of directions.
            known: which nodal components are given, shape (nodes, k).
            value: these components, shape (nodes, k); all are zero if None.

        Raises:
            StepFailed: the iteration does not converge.
        """
        momentum = self._soil.scatter(self._mass[:, None] * quantity)
        used, dim = momentum.shape[1], self._pattern.grid.dim
        start = np.where(known, 0.0 if value is None else value, self.lumped(momentum))
        parts = np.hsplit(start, used // dim)
        right = momentum - np.hstack([self.times(np.ascontiguousarray(part)) for part in parts])
        columns = -(-used // 4) * 4  # the kernel works on four at once
        scale, padded = np.zeros((2, len(right), columns))
        scale[:, :used], padded[:, :used] = momentum, right
        zero = np.ones(padded.shape, dtype=bool)
        zero[:, :used] = known
        pattern = self._pattern
        if not _core.project(
            pattern.row_start, pattern.column, self.blocks, LEAST_EIGENVALUE, zero,
            PROJECTION_TOLERANCE, MOST_ITERATIONS, scale, padded,
        ):  # fmt: skip
            raise StepFailed(f"no projection of the velocities in {MOST_ITERATIONS} iterations")
        return np.asarray(start + padded[:, :used])
