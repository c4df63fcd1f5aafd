# SPDX-License-Identifier: BSD-3-Clause
"""A straight bar with skin springs to the soil, as a field on nodes of its own for tests.

    EA w'' = k (w - u),  EA w' = P at the head, 0 at the toe

w is the displacement of the bar in the step, u that of the soil, k the stiffness of the springs per
length. Across the bar only the springs act.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.field import Field
from tilth.algebra.nodes import MeshNodes
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.setup import InStep, Maker
from tilth.arrays import Floats
from tilth.mpm.pattern import Elements, same_starts
from tilth.mpm.quadrature import locate_in_cells
from tilth.terms.protocol import AssembledTerm, Role, Term
from tilth.terms.space import Coupled, Space

GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)


@dataclass
class Bar:
    """Declaration and state of the bar.

    Attributes:
        nodes: its nodes from head to toe [length], (n, dim), on a line along the last axis.
        axial: EA [force].
        skin: k [force/length^2].
        load: P at the head at time 1, in proportion to time, downwards [force].
        moved: displacement so far [length], shape (n, dim).
    """

    nodes: Floats
    axial: float
    skin: float
    load: float
    name: str = "pile"
    moved: Floats = field(default_factory=lambda: np.zeros(0))
    slip: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        self.moved = np.zeros_like(self.nodes)
        self.slip = np.zeros((2 * (len(self.nodes) - 1), self.nodes.shape[1]))

    def in_step(self, of: InStep) -> Field:
        """As `FieldOwner.in_step`: the increment of the displacement."""
        nodes = MeshNodes(self.nodes + self.moved, of.step.active.comm)
        return Field(self.name, nodes, self.nodes.shape[1], "momentum")

    def state(self) -> dict[str, npt.NDArray[Any]]:
        """As `Stateful.state`."""
        return {"moved": self.moved, "slip": self.slip}

    def restore(self, state: Mapping[str, npt.NDArray[Any]]) -> None:
        """As `Stateful.restore`."""
        self.moved, self.slip = state["moved"], state["slip"]

    def terms(self) -> Maker:
        """A maker of its terms."""
        return lambda of: [BarForces(self, of), Skin(self, of)]


class BarForces(Term):
    """The bar's normal force, and the load on its head."""

    def __init__(self, bar: Bar, of: InStep) -> None:
        self._bar, self._after = bar, of.step.after
        pair = np.column_stack([np.arange(len(bar.nodes) - 1), np.arange(1, len(bar.nodes))])
        self._coupled = Coupled(same_starts(pair), pair.astype(np.int32).ravel(), bar.name)

    @property
    def coupled(self) -> Sequence[Coupled]:
        return [self._coupled]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return _BarForces(self._bar, self._after, space, self._coupled)


class _BarForces(AssembledTerm):
    role = Role.SOIL

    def __init__(self, bar: Bar, after: float, space: Space, coupled: Coupled) -> None:
        self._bar, self._after = bar, after
        (self._blocks,) = space.blocks_of(coupled)
        self._stiffness = bar.axial / np.abs(np.diff(bar.nodes[:, -1]))

    def evaluate(self, x: Unknowns) -> Unknowns:
        bar = self._bar
        normal = self._stiffness * np.diff((bar.moved + x[bar.name])[:, -1])
        force = np.zeros_like(bar.nodes)
        force[:-1, -1] -= normal
        force[1:, -1] += normal
        force[0, -1] += self._after * bar.load
        return Unknowns({bar.name: force})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        dim = self._bar.nodes.shape[1]
        values = np.zeros((len(self._stiffness), 2, 2, dim, dim))
        sign = np.array([[1.0, -1.0], [-1.0, 1.0]])
        values[..., -1, -1] = self._stiffness[:, None, None] * sign
        self._blocks.add(matrix, values.reshape(-1, dim, dim))


class Skin(Term):
    """Springs between the bar and the soil around it, at two points of each of its elements."""

    def __init__(self, bar: Bar, of: InStep) -> None:
        self._bar = bar
        start, end = bar.nodes[:-1] + bar.moved[:-1], bar.nodes[1:] + bar.moved[1:]
        share = 0.5 * (1.0 + GAUSS)
        place = start[:, None] + share[:, None] * (end - start)[:, None]
        order, self._at = locate_in_cells(of.step.active, place.reshape(-1, place.shape[2]))
        element = np.repeat(np.arange(len(start)), 2)[order]
        self._order = order
        self._node = np.column_stack([element, element + 1]).astype(np.int32)
        self._value = np.column_stack([1.0 - np.tile(share, len(start))[order],
                                       np.tile(share, len(start))[order]])  # fmt: skip
        self._length = 0.5 * np.abs(end - start)[element, -1]
        cell = np.ascontiguousarray(self._at.node[self._at.cell])
        own = Coupled(same_starts(self._node), self._node.ravel(), bar.name)
        soil = Coupled(same_starts(cell), cell.ravel())
        self._coupled = [soil, own, Coupled(soil.start, soil.node, "u", own)]

    @property
    def coupled(self) -> Sequence[Coupled]:
        return self._coupled

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        return _Skin(self, space)


class _Skin(AssembledTerm):
    def __init__(self, skin: Skin, space: Space) -> None:
        self._skin, self._bar = skin, skin._bar
        self._blocks = [each for of in skin._coupled for each in space.blocks_of(of)]

    def _slip(self, x: Unknowns) -> Floats:
        skin, bar = self._skin, self._bar
        of_bar = np.einsum("qa,qai->qi", skin._value, x[bar.name][skin._node])
        return bar.slip[skin._order] + of_bar - skin._at.interpolate(x.u)

    def evaluate(self, x: Unknowns) -> Unknowns:
        skin, bar = self._skin, self._bar
        force = bar.skin * skin._length[:, None] * self._slip(x)
        on_bar = np.zeros_like(bar.nodes)
        np.add.at(on_bar, skin._node, skin._value[:, :, None] * force[:, None])
        return Unknowns({"u": -skin._at.scatter(force, len(x.u)), bar.name: on_bar})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        skin, dim = self._skin, self._bar.nodes.shape[1]
        stiffness = self._bar.skin * skin._length
        values = {"u": skin._at.value, self._bar.name: skin._value}
        for each in self._blocks:
            row, column = (values[name] for name in each.pair)
            sign = 1.0 if each.pair[0] == each.pair[1] else -1.0
            products = np.einsum("q,qa,qb->qab", sign * stiffness, row, column)
            each.add(matrix, products.reshape(-1, 1, 1) * np.eye(dim))

    def commit(self, x: Unknowns, checked: None) -> None:
        slip = np.empty_like(self._bar.slip)
        slip[self._skin._order] = self._slip(x)
        self._bar.slip = slip
        self._bar.moved = self._bar.moved + x[self._bar.name]
