# SPDX-License-Identifier: BSD-3-Clause
"""What any field at the nodes of the grid needs from the points: sums, values, gradients, blocks.

The basis values S_ap [-] and gradients grad S_ap [1/length] are those at the start of the step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers, Shorts
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.stencil import Stencil


class PointIntegrals:
    """Sums over the points on the grid of one step, and nodal fields at the points.

    A field with gradients or blocks has 1 or dim components, others any number of them.

    active: the grid of the step with the n points' stencils.
    """

    def __init__(self, active: ActiveGrid) -> None:
        self.active = active

    def _ranges(self) -> Iterator[tuple[slice, Stencil]]:
        """Yields the points of each range, and their stencil."""
        for range_, stencil in zip(self.active.points.ranges, self.active.stencils, strict=True):
            yield range_.points, stencil

    def scattered(self, values: Floats) -> Floats:
        """Returns sum_p S_ap value_p, (n, c) -> (nodes, c) or (n,) -> (nodes,)."""
        nodal = np.zeros((self.active.nodes, *values.shape[1:]))
        for points, stencil in self._ranges():
            part = np.ascontiguousarray(values[points], dtype=np.float64)
            _core.scatter(stencil, part, nodal)
        return nodal

    def scattered_gradient(self, flux: Floats) -> Floats:
        """Returns sum_p flux_p grad S_ap, (n, c, dim) -> (nodes, c).

        It has the unit of the flux over length.
        """
        nodal = np.zeros((self.active.nodes, flux.shape[1]))
        for points, stencil in self._ranges():
            _core.scatter_gradient(stencil, flux[points], nodal)
        return nodal

    def interpolated(self, nodal: Floats) -> Floats:
        """Returns sum_a S_ap nodal_a, (nodes, c) -> (n, c)."""
        values = np.empty((len(self.active.points), nodal.shape[1]))
        for points, stencil in self._ranges():
            _core.interpolate(stencil, nodal, values[points])
        return values

    def gradient(self, nodal: Floats) -> Floats:
        """Returns sum_a nodal_a grad S_ap, (nodes, c) -> (n, c, dim).

        It has the unit of the field over length; in axisymmetry it is without the hoop strain.
        """
        gradient = np.empty((len(self.active.points), nodal.shape[1], self.active.grid.dim))
        for points, stencil in self._ranges():
            _core.interpolate_gradient(stencil, nodal, gradient[points])
        return gradient

    def add_blocks(
        self, positions: Sequence[tuple[Integers, Shorts]], matrices: Floats, blocks: Floats
    ) -> None:
        """Adds to `blocks` the derivative of a field's residual by the nodal values of a field.

        block_ab[i, j] = sum_p sum_kl S_pa[k] matrix_p[i, k, j, l] S_pb[l], where S is the value of
        a basis function, then its gradient.

        Args:
            positions: per range, those of the blocks of its groups in the pattern, such as
                `Pattern.block_positions`; those of no group where a range has not both fields.
            matrices: derivative of each point's values and fluxes, k, of the first field, which is
                that of the rows, by value and gradient, l, of the second one at the point, shape
                (n, r, 1 + dim, c, 1 + dim); r and c are 1 or dim.
            blocks: to which they are added, shape (entries, r, c).

        Raises:
            ValueError: shapes or positions do not fit together.
        """
        for (points, stencil), (start, position) in zip(self._ranges(), positions, strict=True):
            if len(position) == 0:  # a range without one of the fields
                continue
            _core.add_point_blocks(stencil, start, position, matrices[points], blocks)
