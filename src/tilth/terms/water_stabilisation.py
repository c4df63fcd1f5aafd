# SPDX-License-Identifier: BSD-3-Clause
"""Terms that stabilise the pressure of water that flows, and are linear in it.

They move water between nodes that are close to each other, and none away: their parts of the
balance of water sum to 0. Theory: docs/theory/consolidation.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tilth import _core
from tilth.algebra.block_matrix import BlockMatrix
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Flags, Floats, Shorts
from tilth.mpm.pattern import Elements, same_starts
from tilth.terms.filled_cells import cell_places, centre_radii
from tilth.terms.ghost import Faces
from tilth.terms.outcome import Outcome
from tilth.terms.pore_water import PORE_PRESSURE, WaterInStep
from tilth.terms.protocol import AssembledTerm, Role, Term
from tilth.terms.space import Coupled, ElementBlocks, Space

GHOST = 0.25
"""Factor of the ghost stabilisation of the pressure [-]."""

HARDLY_WET = 0.01
"""Volume of wet soil at a node over that of a cell, below which its pressure is tied [-]."""

TIE = 1e-3
"""Share of a cell's own conductivity that ties such pressures [-]."""


class OnElements(Term):
    """A term that is linear in the pressures of the nodes of elements.

    Args:
        node: of the elements, shape (elements, k).
        water: of the step.

    Attributes:
        role, label: as those of a term.
        flow_boundary: name of the one through which it is the flow; empty for none.
    """

    role = Role.STABILISATION
    label: str
    flow_boundary = ""

    def __init__(self, node: Shorts, water: WaterInStep) -> None:
        self._node, self._water = node, water
        self._coupled = Coupled(same_starts(node), node.ravel(), PORE_PRESSURE)

    @property
    def coupled(self) -> Sequence[Coupled]:
        """As `Term.coupled`."""
        return [self._coupled]

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        (blocks,) = space.blocks_of(self._coupled)
        before = self._water.pressure_before(space.fields[PORE_PRESSURE])
        part = self._part(blocks)
        return LinearInPressure(self.role, self.label, [part], before, self.flow_boundary)

    def _part(self, blocks: ElementBlocks) -> LinearPart:
        """Returns what the elements add to the balance; blocks: their places in the matrix."""
        raise NotImplementedError


class Projection(OnElements):
    """Polynomial projection of the pressure's increment, so that it has no chequerboard.

    In each cell tau v Cov(N_a, N_b) acts on the increment of the pressure in the step: the
    covariance of the cell's functions over the whole cell, v the volume of soil in it (Dohrmann and
    Bochev 2004; White and Borja 2008; Zhao and Choo 2020). It moves no water out of a cell.
    tau = max(1/(2G), 3/M) - 12 kappa h / l^2, not negative, l the largest side of the cell: linear
    elements need no less to be monotone in one direction, and nothing in longer steps. The second
    part is a flow by the pressures of the start of the step: steps of order 2 are without it.

    Args:
        water: of the step.
    """

    label = "projection of the pore pressure"

    def __init__(self, water: WaterInStep) -> None:
        active = water.soil.active
        super().__init__(active.corners(np.asarray(_core.lattice(active.cell_keys))), water)
        side = active.grid.sizes(cell_places(active, active.cell_keys)).max(axis=1)
        volume, conductivity = water.in_cells(water.water.conductivity)
        softness = water.in_cells(water.softness)[1]
        if water.formula.ratio == 0.0:
            flow = 12.0 * water.size * conductivity / side**2
            softness = np.maximum(softness - flow, 0.0)
        self._factor = softness * volume

    def _part(self, blocks: ElementBlocks) -> LinearPart:
        """As `OnElements._part`."""
        line = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
        mass: Floats = np.ones((1, 1))
        while len(mass) < self._node.shape[1]:
            mass = np.asarray(np.kron(mass, line), dtype=np.float64)
        covariance = np.broadcast_to(mass - 1.0 / len(mass) ** 2, (len(self._factor), *mass.shape))
        matrix = -self._factor[:, None, None] * covariance
        return LinearPart(self._node, blocks, of_change=matrix)


class GhostPressure(Term):
    """Ghost stabilisation of the pressure in partly filled cells at the edge of the soil.

    On the faces that hold the displacement (`terms/ghost.py`), with the same share e of them,

        0.25 e l int [dp/dn] [dq/dn] over the face, of h kappa p + tau0 l^2 / 12 (p - p_n),

    l the size of the cells across the face, kappa the conductivity along its normal, tau0 =
    max(1/(2G), 3/M) (Pretti et al. 2024 for the idea). It vanishes for pressures that are linear
    across the face, and moves water between its nodes only.

    Args:
        water: of the step.
        faces: of the ghost stabilisation of the step.
    """

    def __init__(self, water: WaterInStep, faces: Sequence[Faces]) -> None:
        self._faces, self._water = faces, water
        self._volume = water.nodal_volume
        self._soft = water.nodal_sums(water.softness)
        volume = np.maximum(self._volume, 1e-300)
        across = np.moveaxis(np.diagonal(water.ratios, axis1=1, axis2=2), 1, 0)
        flows = [water.nodal_sums(water.water.conductivity * ratio) for ratio in across]
        self._conductivity = [np.where(self._volume > 0.0, each / volume, np.inf) for each in flows]
        self._coupled = [
            Coupled(same_starts(each.node), each.node.ravel(), PORE_PRESSURE) for each in faces
        ]

    @property
    def coupled(self) -> Sequence[Coupled]:
        """As `Term.coupled`."""
        return self._coupled

    def assembled(self, space: Space, elements: Sequence[Elements]) -> AssembledTerm:
        """As `Term.assembled`."""
        before = self._water.pressure_before(space.fields[PORE_PRESSURE])
        parts = []
        for faces, coupled in zip(self._faces, self._coupled, strict=True):
            (blocks,) = space.blocks_of(coupled)
            unit = faces.unit if len(faces.unit) == 1 else faces.unit[faces.which]
            volume = np.maximum(self._volume[faces.node].sum(axis=1), 1e-300)
            softness = self._soft[faces.node].sum(axis=1) / volume
            conductivity = self._conductivity[faces.axis][faces.node].min(axis=1)
            stored = softness * faces.size[:, faces.axis] ** 2 / 12.0
            share = -GHOST * faces.emptiness
            parts.append(
                LinearPart(
                    faces.node, blocks,
                    of_value=(share * self._water.size * conductivity)[:, None, None] * unit,
                    of_change=(share * stored)[:, None, None] * unit,
                )
            )  # fmt: skip
        label = "ghost stabilisation of the pore pressure"
        return LinearInPressure(Role.STABILISATION, label, parts, before)


class TiedPressure(OnElements):
    """Ties the pressures of nodes that hardly any wet soil reaches to those around.

    Domains that reach a hair into soil without water in its pores would have a free pressure there.
    In each cell with such nodes, which no ghost term holds,

        0.001 int grad p . grad q over the cell, of h kappa p + tau0 l^2 / 12 (p - p_n)

    acts as `GhostPressure` does; it moves water between the nodes of the cell only.

    Args:
        water: of the step.
        stabilised: nodes that the ghost term holds, shape (nodes,).
    """

    label = "tied pore pressures"

    def __init__(self, water: WaterInStep, stabilised: Flags) -> None:
        active = water.soil.active
        node = active.corners(np.asarray(_core.lattice(active.cell_keys)))
        size = active.grid.sizes(cell_places(active, active.cell_keys))
        ones = np.ones(len(water.before))
        sums = [water.nodal_sums(each) for each in (ones, water.conductivity, water.softness)]
        volume, flow, soft = (active.updated(each)[node] for each in sums)
        cell = size.prod(axis=1)
        if water.soil.kind == "axisymmetric":
            cell = cell * 2.0 * np.pi * centre_radii(active, active.cell_keys)
        hardly = (volume > 0.0) & (volume < HARDLY_WET * cell[:, None]) & ~stabilised[node]
        tied = hardly.any(axis=1) & (volume >= HARDLY_WET * cell[:, None]).any(axis=1)
        whole = TIE * cell[tied] / volume[tied].sum(axis=1)
        super().__init__(node[tied], water)
        self._sides = size[tied]
        self._flow, self._soft = whole * flow[tied].sum(axis=1), whole * soft[tied].sum(axis=1)

    def _part(self, blocks: ElementBlocks) -> LinearPart:
        """As `OnElements._part`."""
        mass, slope = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0, np.array([[1.0, -1.0], [-1.0, 1.0]])
        dim = self._sides.shape[1]
        unit: Floats = np.zeros((len(self._node), 2**dim, 2**dim))
        for k in range(dim):
            product: Floats = np.ones((1, 1))
            for axis in range(dim):  # x fastest
                product = np.asarray(np.kron(slope if axis == k else mass, product))
            unit += product / self._sides[:, k, None, None] ** 2
        stored = self._soft * self._sides.max(axis=1) ** 2 / 12.0
        return LinearPart(
            self._node, blocks,
            of_value=-(self._water.size * self._flow)[:, None, None] * unit,
            of_change=-stored[:, None, None] * unit,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LinearPart:
    """Elements whose part of the water's balance is linear in their nodes' pressures.

    Attributes:
        node: their nodes, shape (elements, k).
        blocks: their places in the matrix.
        of_value, of_change: matrices of the pressure and of its change, shape (elements, k, k); 0
            if a number.
        constant: without pressure, shape (elements, k, 1); 0 if a number.
    """

    node: Shorts
    blocks: ElementBlocks
    of_value: Floats | float = 0.0
    of_change: Floats | float = 0.0
    constant: Floats | float = 0.0


class LinearInPressure(AssembledTerm):
    """The sum of such elements.

    Args:
        role, label: as those of a term.
        parts: the elements.
        before: what nodal pressures change from, see `WaterInStep.pressure_before`, (nodes, 1).
        boundary: name of the flow boundary through which it is the flow, if it is one.
    """

    def __init__(
        self, role: Role, label: str, parts: Sequence[LinearPart], before: Floats,
        boundary: str = "",
    ) -> None:  # fmt: skip
        self.role, self.label = role, label
        self._parts, self._before, self._boundary = parts, before, boundary

    def evaluate(self, x: Unknowns) -> Unknowns:
        """As `AssembledTerm.evaluate`."""
        total = np.zeros_like(self._before)
        for each in self._parts:
            value = x[PORE_PRESSURE][each.node]
            change = value - self._before[each.node]
            own = _product(each.of_change, change) + _product(each.of_value, value)
            np.add.at(total, each.node, own + each.constant)
        return Unknowns({PORE_PRESSURE: total})

    def assemble(self, x: Unknowns, matrix: BlockMatrix) -> None:
        """As `AssembledTerm.assemble`."""
        for each in self._parts:
            values = each.of_change + each.of_value
            if not isinstance(values, float):
                each.blocks.add(matrix, values.reshape(-1, 1, 1))

    def outcome(self, x: Unknowns) -> Outcome | None:
        """As `AssembledTerm.outcome`: a part of the balance is less what leaves the soil there."""
        if not self._boundary:
            return None
        return Outcome(outflow={self._boundary: -self.evaluate(x)[PORE_PRESSURE]})


def _product(matrix: Floats | float, vector: Floats) -> Floats | float:
    return matrix if isinstance(matrix, float) else matrix @ vector
