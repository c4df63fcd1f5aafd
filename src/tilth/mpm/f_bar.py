# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: centres of the material in the cells, and the volume change of the cells there.

The volumetric part of a step's deformation gradient is that at the centre of the material points
in the cell, not that at the point (de Souza Neto et al. 1996; Coombs et al. 2018;
docs/theory/f_bar.md). Its use at the points is in `cpp/tilth/kernel/f_bar.hpp`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers, make_read_only
from tilth.mpm.grid import ActiveGrid, Grid, Stencil
from tilth.mpm.points import MaterialPoints

FORGETTING_STRAIN = 0.03
"""Plastic strain that reduces differences of volumetric strain within a cell by a factor e [-]."""

LEAST_RELATIVE_RADIUS = 0.1
"""Least radius of a cell's centre over that of its outer edge [-]: at radius 0 the hoop stretch is
0 / 0."""

AXIS_TOLERANCE = 1e-6
"""A cell lies beyond the axis if its outer edge is less than this from it, in cells."""


def _off_axis(centre: Floats, column: Integers, grid: Grid) -> Floats:
    """Returns the radial coordinates of the centres, in cells from the grid's origin, (n,).

    Centres of cells at or cut by the axis are moved off it; those of cells beyond it are kept.
    """
    axis = -grid.origin[0] / grid.cell_size[0]
    outer = column + 1.0 - axis
    return np.where(
        outer > AXIS_TOLERANCE, np.maximum(centre, axis + LEAST_RELATIVE_RADIUS * outer), centre
    )


@dataclass
class Centres:
    """Cells of one body's points in one step, and their volume change in the current iteration.

    The arrays of indices become read-only.

    Attributes:
        kind: "plane_strain", "axisymmetric" or "3d".
        group_start: first point of each group of the stencil, shape (groups + 1,).
        count, cell_start, cell, share_start, share: the cells of each group, and the shares of
            each point's domain in them (kernel/f_bar.hpp).
        corner_node: positions of the corners of each group's cells in its list of nodes, shape
            (cells of groups, 2^dim); empty where the nodes fill a box.
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        value: shape functions at the centres [-], shape (cells, 2^dim).
        gradient: [1/length], shape (cells, 2^dim, dim).
        radius: of the centres [length], shape (cells,); used in axisymmetry.
        jacobian_ratio_before, jacobian_ratio: det F / det F_bar of the points, at the start of the
            step and for the trial displacement, shape (n,).
        jacobian: J0 of the points in the step, shape (n,).
        volume_change: J0 - 1 of the cells, shape (cells,).
        trace: derivative of ln J0 with respect to the corners' displacement [1/length], shape
            (cells, 2^dim, dim).
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
    jacobian_ratio_before: Floats
    jacobian_ratio: Floats
    jacobian: Floats
    volume_change: Floats
    trace: Floats

    def __post_init__(self) -> None:
        make_read_only(self.count, self.cell_start, self.cell, self.corner_node, self.share_start)

    @classmethod
    def of(cls, points: MaterialPoints, stencil: Stencil, active: ActiveGrid, kind: str) -> Centres:
        """Returns the centres of one body's points (`points` contains only these).

        The centre is the mean position of the points in a cell, not weighted by volume, as in
        Coombs et al. (2018); for domains it is the centroid of their parts in the cell.
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
            jacobian_ratio_before=points.volume / (points.initial_volume * points.assumed_jacobian),
            jacobian_ratio=np.ones(n),
            jacobian=np.ones(n),
            volume_change=np.zeros(len(value)),
            trace=np.zeros_like(gradient),
        )

    def update(self, displacement: Floats) -> None:
        """Updates `volume_change` and `trace` for the step's nodal displacement, (nodes, dim)."""
        _core.update_centres(
            self.kind, self.node, self.value, self.gradient, self.radius, displacement,
            self.volume_change, self.trace,
        )  # fmt: skip

    def smoothing(self, strain: Floats, volume: Floats, plastic_increment: Floats) -> Floats:
        """Returns the step's smoothing increment of the points' volumetric strain [-], shape (n,).

        F-bar gives all points of a cell the same volumetric strain increment. So no stress opposes
        differences of their elastic volumetric strain, and these would persist. The strain of
        yielding points approaches the mean of their cells by the fraction
        1 - exp(-plastic_increment / FORGETTING_STRAIN) of the difference. The sum of strain times
        volume is conserved in each cell. Points that do not yield are not changed.

        Args:
            strain: elastic volumetric strain [-], shape (n,).
            volume: current volume, shape (n,).
            plastic_increment: plastic strain in the step [-], >= 0, shape (n,).
        """
        fraction = -np.expm1(-plastic_increment / FORGETTING_STRAIN)
        return np.asarray(
            _core.smooth_strains(self.group_start, self, len(self.node), strain, volume, fraction)
        )
