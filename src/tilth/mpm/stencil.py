# SPDX-License-Identifier: BSD-3-Clause
"""The stencils of one range of material points: their nodes and basis values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth import _core
from tilth.arrays import Floats, Integers, Shorts, make_read_only


@dataclass(frozen=True)
class Stencil:
    """Basis values of one range of points, in groups of points that share all their nodes.

    The arrays of indices become read-only.

    Attributes:
        start: first point of each group, shape (groups + 1,).
        first, count: lattice index of the first node and nodes per direction of the bounding box
            of each group's nodes, shape (groups, 3).
        cell_start, cell: keys of each group's cells in overlay 0; empty where they fill the box.
        node_key: keys of each group's nodes in overlay 0; empty where they fill the box.
        node_start, node: node numbers of each group, x fastest.
        value_start: first entry of each group in `value`, shape (groups + 1,).
        value: stored data of each point's basis, flat (kernel/basis_values.hpp): for the linear
            basis the local coordinates in the cell; for others whose nodes fill a box the
            one-dimensional factors; else values and gradients.
        hat_slope: slopes of the linear basis [1/length], shape (dim,), on a graded grid
            (groups, dim); empty with others.
        dim: number of directions.
        colour_start, slab_start, order: order of parallel assembly (kernel/stencil.hpp).
    """

    start: Integers
    first: Integers
    count: Shorts
    cell_start: Integers
    cell: Integers
    node_key: Integers
    node_start: Integers
    node: Shorts
    value_start: Integers
    value: Floats
    hat_slope: Floats
    dim: int
    colour_start: Integers
    slab_start: Integers
    order: Integers

    def __post_init__(self) -> None:
        make_read_only(
            self.start, self.node_start, self.value_start, self.colour_start, self.slab_start,
            self.order, self.node, self.count,
        )  # fmt: skip

    @property
    def boxed(self) -> bool:
        """Whether the groups' nodes fill their boxes."""
        return len(self.node_key) == 0

    def basis(self) -> tuple[Floats, Floats]:
        """Returns basis values S [-] and gradients [1/length] of all points, point after point.

        Flat: per point one value for each of its group's nodes; gradients (dim, nodes).
        """
        numbers = int(np.diff(self.node_start) @ np.diff(self.start))
        value, gradient = np.empty(numbers), np.empty(numbers * self.dim)
        _core.basis_values(self, value, gradient)
        return value, gradient
