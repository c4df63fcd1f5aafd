# SPDX-License-Identifier: BSD-3-Clause
"""Forces among few nodes that are linear in the displacement of the step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import scipy.sparse as sp

from tilth import _core
from tilth.grid import ActiveGrid

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Coupling:
    """Elements of n nodes each with the force f_a + sum_b matrix_ab u_b on node a.

    Attributes:
        node: node numbers, shape (elements, n).
        matrix: [force/length], shape (elements, n, n, dim, dim).
        force: at zero displacement [force], shape (elements, n, dim).
    """

    node: npt.NDArray[np.int32]
    matrix: Floats
    force: Floats


def reached(active: ActiveGrid, couplings: list[Coupling]) -> npt.NDArray[np.bool_]:
    """Returns the nodes that a coupling reaches, shape (nodes,)."""
    found = np.zeros(active.nodes, dtype=bool)
    for coupling in couplings:
        found[coupling.node] = True
    return found


class LinearForces:
    """The sum of all couplings of a step, in the matrix's pattern.

    Attributes:
        constant: force at zero displacement [force], shape (nodes, dim).
        blocks: derivative of the force [force/length], shape (blocks, dim, dim).
    """

    def __init__(self, active: ActiveGrid, couplings: list[Coupling]) -> None:
        dim = active.grid.dim
        for coupling in couplings:
            active.couple(coupling.node)
        self.blocks: Floats = np.zeros((len(active.column), dim, dim))
        self.constant = np.zeros((active.nodes, dim))
        for coupling in couplings:
            start = np.arange(len(coupling.node) + 1, dtype=np.int64) * coupling.node.shape[1]
            node = np.ascontiguousarray(coupling.node, dtype=np.int32).ravel()
            positions = _core.block_positions(start, node, active.row_start, active.column)
            rows = np.ascontiguousarray(coupling.matrix.transpose(0, 1, 3, 4, 2))
            _core.add_blocks(dim, start, node, *positions, rows, self.blocks)
            np.add.at(self.constant, coupling.node, coupling.force)
        self._any = bool(couplings)
        size = active.nodes * dim
        self._matrix = sp.bsr_matrix(
            (self.blocks, active.column, active.row_start), shape=(size, size)
        )

    def force(self, displacement: Floats) -> Floats:
        """Returns the force for a nodal displacement of the step [force], shape (nodes, dim)."""
        if not self._any:
            return np.zeros_like(displacement)
        product: Floats = self._matrix @ displacement.ravel()
        return self.constant + product.reshape(displacement.shape)

    def round_off(self, displacement: Floats) -> float:
        """Returns the force that round-off alone may leave where stiff couplings cancel [force]."""
        if not self._any:
            return 0.0
        magnitude = sp.bsr_matrix(
            (np.abs(self.blocks), self._matrix.indices, self._matrix.indptr),
            shape=self._matrix.shape,
        )
        terms = magnitude @ np.abs(displacement).ravel() + np.abs(self.constant).ravel()
        return float(np.finfo(np.float64).eps * np.linalg.norm(terms))

    def add_stiffness(self, blocks: Floats) -> None:
        """Adds the matrix of all couplings to the node-block matrix."""
        if self._any:
            blocks += self.blocks
