# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: where the cells' centres of material are, and how much the cells stretch there.

The volumetric part of a step's deformation gradient is that at the centre of the material points
in the cell, not that at the point (de Souza Neto et al. 1996; Coombs et al. 2018;
docs/theory/f_bar.md). What the points make of it is in `cpp/tilth/kernel/f_bar.hpp`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.grid import ActiveGrid, Stencil, shape_functions
from tilth.points import MaterialPoints

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

FLOW = 0.03
"""Plastic strain in which points of a cell forget by a factor e how their volumes differ [-]."""


@dataclass
class Centres:
    """The cells of one body's points in one step, and their stretch in the current iteration.

    Attributes:
        group_start: first point of each group of the stencil, shape (groups + 1,).
        count, cell_start, cell, share_start, share: which cells each group covers, and each
            point's shares of them (kernel/f_bar.hpp).
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        value: shape functions at the centres [-], shape (cells, 2^dim).
        gradient: [1/length], shape (cells, 2^dim, dim).
        radius: of the centres [length], in axisymmetry; None otherwise.
        before, after: det F / det F_bar of the points, at the start of the step and for the trial
            displacement, shape (n,).
        jacobian: J0 of the points in the step, shape (n,).
        ratio: J0 - 1 of the cells, shape (cells,).
        trace: derivative of ln J0 by the corners' displacement [1/length], (cells, 2^dim, dim).
    """

    group_start: Integers
    count: npt.NDArray[np.int32]
    cell_start: Integers
    cell: npt.NDArray[np.int32]
    share_start: Integers
    share: Floats
    node: npt.NDArray[np.int32]
    value: Floats
    gradient: Floats
    radius: Floats | None
    before: Floats
    after: Floats
    jacobian: Floats
    ratio: Floats = field(init=False)
    trace: Floats = field(init=False)

    @classmethod
    def of(cls, points: MaterialPoints, stencil: Stencil, active: ActiveGrid, kind: str) -> Centres:
        """Finds the centres of one body's points (`points` holds no others).

        The centre is that of the points in a cell, whatever their volume, as Coombs et al. (2018)
        take it; of domains, that of their parts in the cell, by volume.
        """
        grid, n = active.grid, len(points)
        weight = np.ones(n) if points.bodies[0].basis == "linear" else points.volume
        cell_start, cell, share_start, share, moment = _core.share_among_cells(
            stencil, points.position, points.half_length, weight, grid.origin, grid.cell_size,
            active.cell_keys,
        )  # fmt: skip
        lattice = np.asarray(_core.lattice(active.cell_keys))
        own = moment[:, 0] > 0.0
        middle = lattice[:, : grid.dim] + 0.5  # of cells without a part of this body
        centre = np.where(
            own[:, None], moment[:, 1:] / np.where(own, moment[:, 0], 1.0)[:, None], middle
        )
        value, gradient = shape_functions(centre - lattice[:, : grid.dim], grid.cell_size)
        radius = None
        if kind == "axisymmetric":
            radius = grid.origin[0] + centre[:, 0] * grid.cell_size[0]  # domains may pass the axis
        return cls(
            group_start=stencil.start,
            count=stencil.count,
            cell_start=np.asarray(cell_start),
            cell=np.asarray(cell),
            share_start=np.asarray(share_start),
            share=np.asarray(share),
            node=active.corners(lattice),
            value=value,
            gradient=gradient,
            radius=radius,
            before=points.volume / (points.initial_volume * points.assumed_jacobian),
            after=np.ones(n),
            jacobian=np.ones(n),
        )

    def update(self, displacement: Floats) -> None:
        """Fills `ratio` and `trace` for the nodal displacement of the step, (nodes, dim)."""
        nodal = displacement[self.node]
        h = np.einsum("cai,caj->cij", nodal, self.gradient)
        dim = h.shape[1]
        trace_of = np.trace(h, axis1=1, axis2=2)
        determinant = np.linalg.det(h)
        if dim == 2:
            in_plane = trace_of + determinant
        else:
            squares = np.einsum("cij,cji->c", h, h)
            in_plane = trace_of + 0.5 * (trace_of**2 - squares) + determinant
        inverse = np.linalg.inv(h + np.eye(dim))
        self.trace = np.ascontiguousarray(np.einsum("caj,cjk->cak", self.gradient, inverse))
        if self.radius is None:
            self.ratio = in_plane
            return
        hoop = np.einsum("ca,ca->c", nodal[:, :, 0], self.value) / self.radius
        self.ratio = in_plane + hoop + in_plane * hoop
        self.trace[:, :, 0] += self.value / (self.radius * (1.0 + hoop))[:, None]

    def level(self, strain: Floats, volume: Floats, flow: Floats) -> Floats:
        """Returns by how much the flow of a step lets the points' volumetric strain change, (n,).

        A cell's motion tells its points' volumes apart, F-bar strains them alike: differences of
        their elastic volumetric strain meet no resistance, and none of them would ever leave.
        Points that flow go towards their cells' mean, by 1 - exp(-flow / FLOW) of the way; the
        sum of strain times volume stays in each cell. Without plastic flow nothing changes.

        Args:
            strain: elastic volumetric strain [-], shape (n,).
            volume: current volume, shape (n,).
            flow: plastic strain in the step [-], >= 0, shape (n,).
        """
        cells = np.diff(self.cell_start)
        group = np.repeat(np.arange(len(cells)), np.diff(self.group_start))
        point = np.repeat(np.arange(len(group)), cells[group])
        first = np.cumsum(cells[group]) - cells[group]
        place = np.arange(len(point)) - first[point]
        cell = self.cell[self.cell_start[group][point] + place]
        forget = -np.expm1(-flow / FLOW)
        weight = self.share * (volume * forget)[point]
        size = len(self.node)
        total = np.bincount(cell, weight, size)
        mean = np.bincount(cell, weight * strain[point], size) / np.where(total > 0.0, total, 1.0)
        target = np.bincount(point, self.share * mean[cell], len(strain))
        return np.asarray(np.where(forget > 0.0, forget * (target - strain), 0.0))
