# SPDX-License-Identifier: BSD-3-Clause
"""Consistent mass of the soil on the grid of one step, and the projection of the points' motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp

from tilth import _core
from tilth.arrays import Flags, Floats
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
        faces: elements of equal nodes with their unit matrix (n, n) and weight (elements,), in the
            pattern; weight times unit is a mass.

    Attributes:
        blocks: the entries in the pattern of the matrix [mass], shape (blocks,).
    """

    def __init__(
        self,
        soil: Soil,
        mass: Floats,
        pattern: ActiveGrid,
        faces: Sequence[tuple[Elements, Floats, Floats]] = (),
    ) -> None:
        points = soil.points
        self._soil, self._mass = soil, mass
        self.blocks: Floats = np.zeros(len(pattern.column))
        for body, stencil, (start, position) in zip(
            points.bodies, soil.active.stencils, pattern.block_positions, strict=True
        ):
            _core.add_mass(stencil, start, position, mass[body.points], self.blocks)
        for elements, unit, weight in faces:
            free = np.ones((len(weight), len(unit), 1), dtype=bool)
            scalar = self.blocks.reshape(-1, 1, 1)
            _core.add_scaled_blocks(elements, weight, unit, free, scalar)
        self._matrix = sp.csr_array(
            (self.blocks, pattern.column, pattern.row_start), shape=(pattern.nodes, pattern.nodes)
        )

    def times(self, nodal: Floats) -> Floats:
        """Returns M times a nodal quantity, shape (nodes, k)."""
        return np.asarray(self._matrix @ nodal)

    def projected(self, quantity: Floats, known: Flags, value: Floats) -> Floats:
        """Returns the nodal field q with M q = sum_p S_ap m_p q_p, except where it is known.

        So it has the points' momentum, and their energy if it is a field of the grid's.

        Args:
            quantity: of the points, such as a velocity, shape (n, k).
            known: which nodal components are given, shape (nodes, k).
            value: these components, shape (nodes, k).

        Raises:
            StepFailed: the iteration does not converge.
        """
        right = self._soil.scatter(self._mass[:, None] * quantity)
        q = np.where(known, value, 0.0)
        right = np.where(known, 0.0, right - self.times(q))
        return q + self._solved(right, known)

    def _solved(self, right: Floats, known: Flags) -> Floats:
        """Conjugate gradients with the diagonal as preconditioner, all columns at once."""
        diagonal = self._matrix.diagonal()
        added = LEAST_EIGENVALUE * diagonal[:, None]
        inverse = 1.0 / np.where(diagonal > 0.0, diagonal, 1.0)[:, None]
        x, r = np.zeros_like(right), right
        z = inverse * r
        p, r_z = z, np.einsum("ak,ak->k", r, z)
        target = PROJECTION_TOLERANCE**2 * r_z
        for _ in range(MOST_ITERATIONS):
            if (r_z <= target).all():
                return x
            product = np.where(known, 0.0, self.times(p) + added * p)
            p_product = np.einsum("ak,ak->k", p, product)
            length = np.where(r_z > target, r_z / np.where(p_product > 0.0, p_product, 1.0), 0.0)
            x = x + length * p
            r = r - length * product
            z = inverse * r
            before, r_z = r_z, np.einsum("ak,ak->k", r, z)
            p = z + np.where(before > 0.0, r_z / np.where(before > 0.0, before, 1.0), 0.0) * p
        raise StepFailed(f"no projection of the velocities in {MOST_ITERATIONS} iterations")
