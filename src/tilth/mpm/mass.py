# SPDX-License-Identifier: BSD-3-Clause
"""Consistent mass of the soil on the grid of one step, and the projection of the points' motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Shorts
from tilth.comm import total
from tilth.errors import StepFailed
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.pattern import Elements
from tilth.mpm.soil import Soil

PROJECTION_TOLERANCE = 1e-11
"""Residual of the projection relative to the momentum [-]."""

LEAST_EIGENVALUE = 1e-10
"""Added to the mass matrix relative to its diagonal: where slivers of domains, or few points, give
nodes almost dependent masses, velocities that they cannot tell apart are those of `lumped`."""

MOST_ITERATIONS = 1000
"""Iterations of the projection after which it counts as failed."""

NO_PROJECTION = f"no projection of the velocities in {MOST_ITERATIONS} iterations"


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
        self._soil, self._mass, self._has_ghost = soil, mass, len(faces) > 0
        self.blocks: Floats = np.zeros(len(pattern.column))
        for range_, stencil, (start, position) in zip(
            points.ranges, soil.active.stencils, pattern.block_positions, strict=True
        ):
            _core.add_mass(stencil, start, position, mass[range_.points], self.blocks)
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

    def ghost_times(self, nodal: Floats) -> Floats:
        """Returns the ghost mass times a nodal vector, shape (nodes, dim)."""
        if not self._has_ghost:
            return np.zeros_like(nodal)
        of_points = self._soil.scatter(self._mass[:, None] * self._soil.interpolate(nodal))
        return self.times(nodal) - of_points

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
        start = np.where(known, 0.0 if value is None else value, self.lumped(momentum))
        start = self._pattern.updated(start)
        right = momentum - self._products(start)
        if self._pattern.shared is not None:
            return np.asarray(start + self._solved_together(right, known, momentum))
        used = momentum.shape[1]
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
            raise StepFailed(NO_PROJECTION)
        return np.asarray(start + padded[:, :used])

    def _products(self, nodal: Floats) -> Floats:
        """Returns M times several nodal vectors side by side, shape (nodes, k)."""
        parts = np.hsplit(nodal, nodal.shape[1] // self._pattern.grid.dim)
        return np.hstack([self.times(np.ascontiguousarray(part)) for part in parts])

    def _solved_together(self, right: Floats, known: Flags, scale: Floats) -> Floats:
        """Returns the solutions for right sides, zero where known, by all processes, (nodes, k).

        By conjugate gradients, with the diagonal as preconditioner and the tolerance of a single
        process: in each iteration the processes exchange the values at the nodes that they share.

        scale: right sides to which the tolerance refers, shape (nodes, k).

        Raises:
            StepFailed: the iteration does not converge.
        """
        pattern = self._pattern
        own, comm = pattern.owned, pattern.comm
        diagonal = self.blocks[pattern.diagonal][:, None]
        free = (~known & (diagonal > 0.0))[own]
        shifted = np.where(diagonal > 0.0, (1.0 + LEAST_EIGENVALUE) * diagonal, 1.0)[own]
        inverse = np.where(free, 1.0 / shifted, 0.0)
        shift = LEAST_EIGENVALUE * diagonal[own]

        def products(a: Floats, b: Floats) -> Floats:
            return total(comm, (a * b).sum(axis=0))

        target = PROJECTION_TOLERANCE**2 * products(scale[own], inverse * scale[own])
        r, x, p = right[own], np.zeros_like(right[own]), np.zeros_like(right)
        z = inverse * r
        r_z = products(r, z)
        ratio = np.zeros_like(r_z)
        for _ in range(MOST_ITERATIONS):
            if (r_z <= target).all():
                break
            p[own] = z + ratio * p[own]
            p = pattern.updated(p)
            q = self._products(p)[own] + shift * p[own]
            p_q = products(p[own], q)
            goes = (r_z > target) & (p_q > 0.0)
            length = np.where(goes, r_z / np.where(goes, p_q, 1.0), 0.0)
            x += length * p[own]
            r -= length * q
            z = inverse * r
            before, r_z = r_z, products(r, z)
            ratio = r_z / np.where(before > 0.0, before, 1.0)
        else:
            raise StepFailed(NO_PROJECTION)
        p[own] = x
        return pattern.updated(p)
