# SPDX-License-Identifier: BSD-3-Clause
"""Forces among few nodes that are linear in the displacement of the step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.comm import SERIAL, norm
from tilth.grid import ActiveGrid
from tilth.pattern import Elements, same_starts

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]


class LinearElements(Protocol):
    """Elements of few nodes whose force is linear in the displacement of their nodes."""

    @property
    def node(self) -> npt.NDArray[np.int32]:
        """Node numbers, shape (elements, n), or one element after the other, (entries,)."""
        ...

    @property
    def node_start(self) -> Integers:
        """First entry of each element among all node numbers, shape (elements + 1,)."""
        ...

    @property
    def force(self) -> Floats:
        """Force at zero displacement [force], shape of `node` and dim."""
        ...

    def add_product(
        self, elements: Elements, vector: Floats, product: Floats, magnitude: bool = False
    ) -> None:
        """Adds the matrix times a nodal vector to a nodal `product`, (nodes, dim) each.

        Of the magnitudes of the elements' entries instead, if asked.
        """
        ...

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """Adds the matrix to the node-block matrix (blocks, dim, dim) [force/length]."""
        ...


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

    @property
    def node_start(self) -> Integers:
        """As `LinearElements.node_start`."""
        return same_starts(self.node)

    def add_product(
        self, elements: Elements, vector: Floats, product: Floats, magnitude: bool = False
    ) -> None:
        """As `LinearElements.add_product`."""
        _core.add_dense_products(elements, self.matrix, vector, magnitude, product)

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """As `LinearElements.add_stiffness`."""
        _core.add_dense_blocks(elements, self.matrix, blocks)


@dataclass(frozen=True)
class RowCoupling:
    """Elements of differing numbers of nodes with the force r (r . u + constant), r a row.

    Attributes:
        node_start: first entry of each element, shape (elements + 1,).
        node: node numbers, shape (entries,).
        row: r [(force/length)^(1/2)], shape (entries, dim).
        constant: [(force length)^(1/2)], shape (elements,).
    """

    node_start: Integers
    node: npt.NDArray[np.int32]
    row: Floats
    constant: Floats

    @property
    def force(self) -> Floats:
        """As `LinearElements.force`."""
        return self.row * np.repeat(self.constant, np.diff(self.node_start))[:, None]

    def add_product(
        self, elements: Elements, vector: Floats, product: Floats, magnitude: bool = False
    ) -> None:
        """As `LinearElements.add_product`."""
        _core.add_row_products(elements, self.row, vector, magnitude, product)

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """As `LinearElements.add_stiffness`."""
        _core.add_row_blocks(elements, self.row, blocks)


class LinearForces:
    """The sum of all couplings of a step; makes room for them in the matrix's pattern.

    Args:
        constant: force beside theirs that does not change with the displacement, (nodes, dim).

    Attributes:
        constant: force at zero displacement [force], shape (nodes, dim).
        joined: nodes that rows join beyond their cells, shape (nodes,).
    """

    def __init__(
        self,
        active: ActiveGrid,
        couplings: Sequence[LinearElements],
        constant: Floats | None = None,
    ) -> None:
        numbers = [active.couple(each.node_start, each.node.ravel()) for each in couplings]
        self._parts = [
            (coupling, active.elements(number))
            for coupling, number in zip(couplings, numbers, strict=True)
        ]
        if constant is None:
            constant = np.zeros((active.nodes, active.grid.dim))
        self.constant: Floats = constant
        self.joined = np.zeros(active.nodes, dtype=bool)
        for coupling, elements in self._parts:
            if isinstance(coupling, RowCoupling):
                self.joined[coupling.node] = True
            _core.add_element_forces(elements, coupling.force, self.constant)

    def force(self, displacement: Floats) -> Floats:
        """Returns the force for a nodal displacement of the step [force], shape (nodes, dim)."""
        force = self.constant.copy()
        for coupling, elements in self._parts:
            coupling.add_product(elements, displacement, force)
        return force

    def round_off(self, displacement: Floats) -> float:
        """Returns the force that round-off alone may leave where stiff couplings cancel [force]."""
        terms, magnitude = np.abs(self.constant), np.abs(displacement)
        for coupling, elements in self._parts:
            coupling.add_product(elements, magnitude, terms, magnitude=True)
        return float(np.finfo(np.float64).eps * norm(SERIAL, terms))

    def add_stiffness(self, blocks: Floats) -> None:
        """Adds the matrix of all couplings to the node-block matrix (blocks, dim, dim)."""
        for coupling, elements in self._parts:
            coupling.add_stiffness(elements, blocks)
