# SPDX-License-Identifier: BSD-3-Clause
"""Forces of elements with few nodes that are linear in the displacement of the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.algebra.field import DISPLACEMENT
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats, Integers
from tilth.mpm.pattern import Elements, same_starts
from tilth.terms.protocol import DisplacementTerm, Role, Term
from tilth.terms.space import Coupled, Space


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

        magnitude: whether to use the absolute values of the matrix's entries.
        """
        ...

    def add_stiffness(self, elements: Elements, blocks: Floats) -> None:
        """Adds the matrix to the node-block matrix (blocks, dim, dim) [force/length]."""
        ...


@dataclass(frozen=True)
class EqualElements:
    """Elements of n nodes each.

    Attributes:
        node: node numbers, shape (elements, n).
    """

    node: npt.NDArray[np.int32]

    @property
    def node_start(self) -> Integers:
        """As `LinearElements.node_start`."""
        return same_starts(self.node)


@dataclass(frozen=True)
class Coupling(EqualElements):
    """Elements of n nodes each, with the force f_a + sum_b matrix_ab u_b on node a.

    Attributes:
        matrix: [force/length], shape (elements, n, n, dim, dim).
        force: at zero displacement [force], shape (elements, n, dim).
    """

    matrix: Floats
    force: Floats

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
    """Elements with different numbers of nodes and the force r (r . u + constant), r a row.

    Attributes:
        node_start: first entry of each element, shape (elements + 1,).
        node: node numbers, shape (entries,).
        row: r [(force/length)^(1/2)], shape (entries, dim).
        constant: of each element [(force length)^(1/2)], shape (elements,).
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


class LinearForces(Term):
    """The sum of linear couplings in one step.

    Args:
        couplings: elements of few nodes.
        constant: additional force independent of the displacement [force], shape (nodes, dim).
        held: see `Term.held_nodes`.
        commit: see `AssembledTerm.commit`; nothing if not given.
        role, label: see `AssembledTerm`.
    """

    def __init__(
        self,
        couplings: Sequence[LinearElements],
        constant: Floats | None = None,
        held: Flags | None = None,
        commit: Callable[[Floats], None] = lambda displacement: None,
        role: Role = Role.OTHER,
        label: str = "",
    ) -> None:
        self._couplings = couplings
        self._constant = constant
        self._held = held
        self._commit, self._role, self._label = commit, role, label

    @property
    def coupled(self) -> list[Coupled]:
        """As `Term.coupled`."""
        return [Coupled(each.node_start, each.node.ravel()) for each in self._couplings]

    def held_nodes(self) -> Flags | None:
        """As `Term.held_nodes`."""
        return self._held

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledLinearForces:
        """As `Term.assembled`."""
        parts = list(zip(self._couplings, elements, strict=True))
        constant = np.zeros((space.active.nodes, space.active.grid.dim))
        if self._constant is not None:
            constant += self._constant
        return AssembledLinearForces(parts, constant, self._commit, self._role, self._label)


class AssembledLinearForces(DisplacementTerm):
    """`LinearForces` in the matrix's pattern.

    Args:
        parts: couplings, each with the positions of its blocks in the matrix.
        constant: see `LinearForces`; the couplings' constant forces are added in place.
        commit, role, label: see `LinearForces`.

    Attributes:
        constant: force at zero displacement [force], shape (nodes, dim).
    """

    def __init__(
        self,
        parts: Sequence[tuple[LinearElements, Elements]],
        constant: Floats,
        commit: Callable[[Floats], None] = lambda displacement: None,
        role: Role = Role.OTHER,
        label: str = "",
    ) -> None:
        self._parts = parts
        self._commit = commit
        self.role, self.label = role, label
        self.constant = constant
        for coupling, elements in parts:
            _core.add_element_forces(elements, coupling.force, constant)

    def force(self, displacement: Floats) -> Floats:
        """As `AssembledTerm.force`."""
        force = self.constant.copy()
        for coupling, elements in self._parts:
            coupling.add_product(elements, displacement, force)
        return force

    def commit(self, x: Unknowns, checked: None) -> None:
        """As `AssembledTerm.commit`."""
        self._commit(x.u)

    def constant_force(self) -> Floats:
        """As `AssembledTerm.constant_force`."""
        return self.constant

    def magnitude(self, x: Unknowns) -> dict[str, Floats]:
        """As `AssembledTerm.magnitude`."""
        terms, magnitude = np.abs(self.constant), np.abs(x.u)
        for coupling, elements in self._parts:
            coupling.add_product(elements, magnitude, terms, magnitude=True)
        return {DISPLACEMENT: terms}

    def joined_nodes(self) -> Flags:
        """As `AssembledTerm.joined_nodes`: the nodes of row couplings."""
        joined = np.zeros(len(self.constant), dtype=bool)
        for coupling, _ in self._parts:
            if isinstance(coupling, RowCoupling):
                joined[coupling.node] = True
        return joined

    def add_stiffness(self, displacement: Floats, blocks: Floats) -> None:
        """As `AssembledTerm.add_stiffness`."""
        for coupling, elements in self._parts:
            coupling.add_stiffness(elements, blocks)
