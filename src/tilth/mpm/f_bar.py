# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: where the cells' centres of material are, and how much the cells stretch there.

The volumetric part of a step's deformation gradient is that at the centre of the material points
in the cell, not that at the point (de Souza Neto et al. 1996; Coombs et al. 2018;
docs/theory/f_bar.md). What the points make of it is in `cpp/tilth/kernel/f_bar.hpp`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers
from tilth.mpm.grid import ActiveGrid, Grid, Stencil
from tilth.mpm.points import MaterialPoints

FLOW = 0.03
"""Plastic strain in which points of a cell forget by a factor e how their volumes differ [-]."""

LEAST_RADIUS = 0.1
"""Of a cell's centre, in radii of its outer edge: on the axis the hoop stretch would be 0 / 0."""

BEYOND = 1e-6
"""A cell lies beyond the axis if its outer edge is within this share of a cell of it."""


def _off_axis(centre: Floats, column: Integers, grid: Grid) -> Floats:
    """Returns the places of the centres along the radius, in cells from the grid's origin, (n,).

    Moved off the axis in cells that reach it or are cut by it; cells beyond it stay.
    """
    axis = -grid.origin[0] / grid.cell_size[0]
    outer = column + 1.0 - axis
    return np.where(outer > BEYOND, np.maximum(centre, axis + LEAST_RADIUS * outer), centre)


@dataclass
class Centres:
    """The cells of one body's points in one step, and their stretch in the current iteration.

    Attributes:
        kind: "plane_strain", "axisymmetric" or "3d".
        group_start: first point of each group of the stencil, shape (groups + 1,).
        count, cell_start, cell, share_start, share: which cells each group covers, and each
            point's shares of them (kernel/f_bar.hpp).
        corner_node: places of the corners of each group's cells in its list of nodes, shape
            (cells of groups, 2^dim); empty where the nodes fill a box.
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        value: shape functions at the centres [-], shape (cells, 2^dim).
        gradient: [1/length], shape (cells, 2^dim, dim).
        radius: of the centres [length], shape (cells,); used in axisymmetry.
        before, after: det F / det F_bar of the points, at the start of the step and for the trial
            displacement, shape (n,).
        jacobian: J0 of the points in the step, shape (n,).
        ratio: J0 - 1 of the cells, shape (cells,).
        trace: derivative of ln J0 by the corners' displacement [1/length], (cells, 2^dim, dim).
    """

    kind: str
    group_start: Integers
    count: npt.NDArray[np.int32]
    cell_start: Integers
    cell: npt.NDArray[np.int32]
    corner_node: npt.NDArray[np.int32]
    share_start: Integers
    share: Floats
    node: npt.NDArray[np.int32]
    value: Floats
    gradient: Floats
    radius: Floats
    before: Floats
    after: Floats
    jacobian: Floats
    ratio: Floats
    trace: Floats

    @classmethod
    def of(cls, points: MaterialPoints, stencil: Stencil, active: ActiveGrid, kind: str) -> Centres:
        """Finds the centres of one body's points (`points` holds no others).

        The centre is that of the points in a cell, whatever their volume, as Coombs et al. (2018)
        take it; of domains, that of their parts in the cell, by volume.
        """
        grid, n = active.grid, len(points)
        weight = np.ones(n) if points.bodies[0].basis == "linear" else points.volume
        if points.bodies[0].has_corners:
            cell_start = stencil.cell_start
            cell, corner_node, share_start, share, moment = _core.share_corner_domains(
                stencil, points.position, points.corner, weight, grid.origin, grid.cell_size,
                active.cell_keys,
            )  # fmt: skip
        else:
            cell_start, cell, share_start, share, moment = _core.share_among_cells(
                stencil, points.position, points.half_length, weight, grid.origin, grid.cell_size,
                active.cell_keys,
            )  # fmt: skip
            corner_node = np.zeros(0, dtype=np.int32)
        lattice = np.asarray(_core.lattice(active.cell_keys))
        own = moment[:, 0] > 0.0
        middle = lattice[:, : grid.dim] + 0.5  # of cells without a part of this body
        centre = np.where(
            own[:, None], moment[:, 1:] / np.where(own, moment[:, 0], 1.0)[:, None], middle
        )
        if kind == "axisymmetric":
            centre[:, 0] = _off_axis(centre[:, 0], lattice[:, 0], grid)
        local: Floats = centre - lattice[:, : grid.dim]
        value, gradient = _core.shape_functions(local, grid.cell_size)
        return cls(
            kind=kind,
            group_start=stencil.start,
            count=stencil.count,
            cell_start=np.asarray(cell_start),
            cell=np.asarray(cell),
            corner_node=np.asarray(corner_node),
            share_start=np.asarray(share_start),
            share=np.asarray(share),
            node=active.corners(lattice),
            value=np.asarray(value),
            gradient=np.asarray(gradient),
            radius=grid.origin[0] + centre[:, 0] * grid.cell_size[0],
            before=points.volume / (points.initial_volume * points.assumed_jacobian),
            after=np.ones(n),
            jacobian=np.ones(n),
            ratio=np.zeros(len(value)),
            trace=np.zeros_like(gradient),
        )

    def update(self, displacement: Floats) -> None:
        """Fills `ratio` and `trace` for the nodal displacement of the step, (nodes, dim)."""
        _core.update_centres(
            self.kind, self.node, self.value, self.gradient, self.radius, displacement,
            self.ratio, self.trace,
        )  # fmt: skip

    def smoothing(self, strain: Floats, volume: Floats, flow: Floats) -> Floats:
        """Returns the change of the points' volumetric strain by the flow of a step, shape (n,).

        A cell's motion tells its points' volumes apart, F-bar strains them alike: differences of
        their elastic volumetric strain meet no resistance, and none of them would ever leave.
        Points that flow go towards their cells' mean, by 1 - exp(-flow / FLOW) of the way; the
        sum of strain times volume stays in each cell. Without plastic flow nothing changes.

        Args:
            strain: elastic volumetric strain [-], shape (n,).
            volume: current volume, shape (n,).
            flow: plastic strain in the step [-], >= 0, shape (n,).
        """
        forget = -np.expm1(-flow / FLOW)
        return np.asarray(
            _core.smooth_strains(self.group_start, self, len(self.node), strain, volume, forget)
        )
