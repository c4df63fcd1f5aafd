# SPDX-License-Identifier: BSD-3-Clause
"""Terms of water that flows through a surface anywhere in the grid, where one condition is given.

Their parts of the balance of water are less what leaves the soil, as in `pore_water.py`. The
geometry is that of the start of the step. Theory: docs/theory/consolidation.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.grid.keys import find_keys
from tilth.mpm.quadrature import PointsInCells
from tilth.terms.pore_water import WaterInStep
from tilth.terms.protocol import Role
from tilth.terms.space import ElementBlocks
from tilth.terms.water_stabilisation import LinearPart, OnElements

LEAST_FILLING = 1e-6
"""Share of a cell with wet soil from which water flows through a surface in it [-]."""

NITSCHE = 20.0
"""Factor of the penalty on a given pressure [-]."""


@dataclass(frozen=True, eq=False)
class FlowSurface:
    """n quadrature points of a surface of the soil at the start of a step.

    Attributes:
        at: the points in cells of the soil.
        normal: outward from the soil, shape (n, dim).
        weight: area of each point's part of the surface, in axisymmetry with 2 pi r, shape (n,).
        position: [length], shape (n, dim).
    """

    at: PointsInCells
    normal: Floats
    weight: Floats
    position: Floats

    def of(self, kept: Flags) -> FlowSurface:
        """Returns the points `kept`, shape (n,)."""
        own = (each[kept] for each in (self.normal, self.weight, self.position))
        return FlowSurface(self.at.of(kept), *own)


@dataclass(frozen=True, eq=False)
class Conductivities:
    """Those of the soil at m points of a surface, at the start of a step.

    Attributes:
        mean, least: of the direction in which soil conducts least: the mean of the soil around the
            nodes of each point's cell, and the least of the harmonic means at these nodes, (m,).
        ratios: of all directions to it, in the mean, shape (m, dim, dim).
    """

    mean: Floats
    least: Floats
    ratios: Floats


def beside_water(water: WaterInStep, surface: FlowSurface) -> tuple[FlowSurface, Conductivities]:
    """Returns the points in cells with wet soil, and the conductivities there.

    All processes call it.
    """
    at, active = surface.at, water.soil.active
    cell = find_keys(active.cell_keys, active.key[at.node[:, 0]])  # key: of its lowest node
    filled = water.in_cells(water.conductivity)[0][cell]
    wet = (filled > LEAST_FILLING * at.size.prod(axis=1))[at.cell]
    resistance = 1.0 / np.maximum(water.conductivity, 1e-300)
    dim = water.ratios.shape[1]
    directed = water.conductivity * water.ratios.reshape(-1, dim * dim).T
    nodal = [water.nodal_sums(each) for each in (water.conductivity, resistance, *directed)]
    sums = active.updated(np.column_stack([water.nodal_volume, *nodal]))
    volume, flow, resisted, *directed = np.moveaxis(sums[at.node[at.cell][wet]], 2, 0)
    least = np.where(volume > 0.0, volume / np.maximum(resisted, 1e-300), np.inf).min(axis=1)
    total = flow.sum(axis=1)
    ratios = np.stack([each.sum(axis=1) for each in directed], axis=1) / total[:, None]
    found = Conductivities(total / volume.sum(axis=1), least, ratios.reshape(-1, dim, dim))
    return surface.of(wet), found


class _ThroughSurface(OnElements):
    """A term on the pressures of the cells of such points.

    Args:
        name: of the flow boundary.
        water: of the step.
        surface: its points.
    """

    role = Role.FLOW

    def __init__(self, name: str, water: WaterInStep, surface: FlowSurface) -> None:
        surface, self._soil = beside_water(water, surface)
        super().__init__(surface.at.node[surface.at.cell], water)
        self.flow_boundary, self._size, self._surface = name, water.size, surface

    def _part(self, blocks: ElementBlocks) -> LinearPart:
        """As `OnElements._part`."""
        matrix, constant = self._balance()
        return LinearPart(self._node, blocks, of_value=matrix, constant=constant[:, :, None])

    def _balance(self) -> tuple[Floats | float, Floats]:
        """Returns what a point adds to the balance: by the pressures (n, k, k), and without."""
        raise NotImplementedError


class GivenPressure(_ThroughSurface):
    """A pressure on a surface, by Nitsche's method (Nitsche 1971).

    With the outward normal n, the conductivity kappa A of the soil at the surface, its cells of
    size l and beta = `NITSCHE`, the balance of water has

        h int [-q kappa An . grad p - kappa An . grad q (p - p0) + beta kappa n . An / l q (p - p0)]

    over the surface,

    what flows out, the same for the test function, and a penalty. The cells that the surface cuts
    need `GhostPressure`. Where soils meet the first two have the least conductivity, which the
    seepage and the ghost term bear in a cell cut anywhere, the penalty the mean.

    Args:
        name: of the flow boundary.
        water: of the step.
        surface: its points.
        pressure: p0 at the end of the step at positions (n, dim) [stress], shape (n,).
    """

    label = "flow through a surface with a given pressure"

    def __init__(
        self, name: str, water: WaterInStep, surface: FlowSurface,
        pressure: Callable[[Floats], Floats],
    ) -> None:  # fmt: skip
        super().__init__(name, water, surface)
        self._pressure = pressure(self._surface.position)

    def _balance(self) -> tuple[Floats | float, Floats]:
        at = self._surface.at
        normal, soil = self._surface.normal, self._soil
        way = np.einsum("nij,nj->ni", soil.ratios, normal)
        value, slope = at.value, np.einsum("nai,ni->na", at.gradient, way)
        slope = soil.least[:, None] * slope
        through = soil.mean * (normal * way).sum(axis=1)
        own = slope - (NITSCHE * through / at.size[at.cell].max(axis=1))[:, None] * value
        factor = self._size * self._surface.weight
        matrix = np.einsum("na,nb->nab", value, slope) + np.einsum("na,nb->nab", own, value)
        return factor[:, None, None] * matrix, -(self._pressure * factor)[:, None] * own


class GivenFlux(_ThroughSurface):
    """A flux through a surface.

    The balance of water has -h int q flux da.

    Args:
        name: of the flow boundary.
        water: of the step.
        surface: its points.
        flux: into the soil at the end of the step [length/time].
    """

    label = "given flux through a surface"

    def __init__(self, name: str, water: WaterInStep, surface: FlowSurface, flux: float) -> None:
        super().__init__(name, water, surface)
        self._flux = flux

    def _balance(self) -> tuple[Floats | float, Floats]:
        weight = self._size * self._flux * self._surface.weight
        return 0.0, weight[:, None] * self._surface.at.value
