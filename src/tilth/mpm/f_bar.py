# SPDX-License-Identifier: BSD-3-Clause
"""F-bar: the mean gradients of the material in the cells, and the cells' volume change.

The volumetric part of a step's deformation gradient is that of the material in the cell, not that
at the point (de Souza Neto et al. 1996; Coombs et al. 2018; docs/theory/f_bar.md). Its use at the
points is in `cpp/tilth/kernel/f_bar.hpp`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Floats, Integers, make_read_only
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.stencil import Stencil

FORGETTING_STRAIN = 0.03
"""Plastic strain that reduces differences of volumetric strain within a cell by a factor e [-]."""


def _means(moment: Floats) -> Floats:
    """Returns moments over the first one, shape (cells, k - 1); 0 in cells without a part."""
    total = moment[:, :1]
    return np.divide(moment[:, 1:], total, out=np.zeros_like(moment[:, 1:]), where=total > 0.0)


def _mean_hats(x: Floats, y: Floats, xy: Floats) -> Floats:
    """Means of the products of hat functions in two directions.

    Args:
        x, y, xy: means of the coordinates in the cell, 0 to 1, and of their product, (cells,).

    Returns:
        [cell, side in x, side in y], shape (cells, 2, 2).
    """
    return np.stack([1.0 - x - y + xy, y - xy, x - xy, xy], axis=-1).reshape(-1, 2, 2)


def mean_gradients(moment: Floats, size: Floats) -> Floats:
    """Returns the mean gradients of the cells' functions over the material in them [1/length].

    Args:
        moment: sums over the parts in each cell, shape (cells, 3) in 2D, (cells, 7) in 3D
            (kernel/cell_shares.hpp).
        size: of the cells [length], shape (cells, dim).

    Returns:
        Shape (cells, 2^dim, dim), corners x fastest.
    """
    dim, mean = size.shape[1], _means(moment)
    side = (np.arange(2**dim)[:, None] >> np.arange(dim)) & 1
    gradient = np.empty((len(moment), 2**dim, dim))
    for k in range(dim):
        slope = np.where(side[:, k] == 1, 1.0, -1.0) / size[:, k, None]
        if dim == 2:
            x = mean[:, 1 - k, None]
            gradient[:, :, k] = slope * np.where(side[:, 1 - k] == 1, x, 1.0 - x)
        else:
            i, j = (k + 1) % 3, (k + 2) % 3
            hats = _mean_hats(mean[:, i], mean[:, j], mean[:, 3 + k])
            gradient[:, :, k] = slope * hats[:, side[:, i], side[:, j]]
    return gradient


def hoop_gradients(moment: Floats) -> Floats:
    """Returns the cells' hoop strains per radial displacement of their corners [1/length].

    The mean of each function over the material in the cell, by area, over the mean of the radius.

    Args:
        moment: sums of 1, x, y, xy, r over the parts in each cell, by area, shape (cells, 5).

    Returns:
        Shape (cells, 4); 0 in cells without a part.
    """
    x, y, xy, radius = _means(moment).T
    value = _mean_hats(x, y, xy).transpose(0, 2, 1).reshape(-1, 4)  # x fastest
    return np.asarray(value / np.where(radius != 0.0, radius, np.inf)[:, None])


@dataclass
class Centres:
    """Cells of one range of points in one step, and their volume change in the current iteration.

    The arrays of indices become read-only.

    Those of the hoop are empty unless the analysis is axisymmetric.

    Attributes:
        kind: "plane_strain", "axisymmetric" or "3d".
        group_start: first point of each group of the stencil, shape (groups + 1,).
        count, cell_start, cell, share_start, share, hoop_share: the cells of each group, and the
            shares of each point's domain, and of its radius, in them (kernel/f_bar.hpp).
        corner_node: positions of the corners of each group's cells in its list of nodes, shape
            (cells of groups, 2^dim); empty where the nodes fill a box.
        node: corners of each cell, x fastest, shape (cells, 2^dim).
        gradient: means over the material in the cell [1/length], shape (cells, 2^dim, dim).
        hoop_gradient: hoop strain per radial displacement [1/length], shape (cells, 2^dim).
        pressure: mean Kirchhoff stress of the points' cells at the start of the step, tension
            positive, of the directions that F-bar scales: the part of the points' mean stress that
            acts through their own gradients [stress], shape (n,).
        jacobian_ratio_before, jacobian_ratio: det F / det F_bar of the points, at the start of the
            step and for the trial displacement, shape (n,).
        jacobian: J0 of the points in the step, shape (n,).
        volume_change: J0 - 1 of the cells, of the in-plane part in axisymmetry, shape (cells,).
        trace: derivative of its ln J0 with respect to the corners' displacement [1/length], shape
            (cells, 2^dim, dim).
        hoop_change: hoop stretch of the cells less 1, shape (cells,).
    """

    kind: str
    group_start: Integers
    count: npt.NDArray[np.int32]
    cell_start: Integers
    cell: npt.NDArray[np.int32]
    corner_node: npt.NDArray[np.int32]
    share_start: Integers
    share: Floats
    hoop_share: Floats
    node: npt.NDArray[np.int32]
    gradient: Floats
    hoop_gradient: Floats
    pressure: Floats
    jacobian_ratio_before: Floats
    jacobian_ratio: Floats
    jacobian: Floats
    volume_change: Floats
    trace: Floats
    hoop_change: Floats

    def __post_init__(self) -> None:
        make_read_only(self.count, self.cell_start, self.cell, self.corner_node, self.share_start)

    @classmethod
    def of(cls, points: MaterialPoints, stencil: Stencil, active: ActiveGrid, kind: str) -> Centres:
        """Returns the cells of one range of points (`points` contains only these)."""
        grid, n, axisymmetric = active.grid, len(points), kind == "axisymmetric"
        own = active.of_overlay(points.ranges[0].overlay)
        volume = points.volume
        if points.ranges[0].has_corners:
            cell_start = stencil.cell_start
            cell, corner_node, *shares = _core.share_corner_domains(
                stencil, points.position, points.corner, volume, grid,
                own.cell_keys, axisymmetric,
            )  # fmt: skip
        else:
            cell_start, cell, *shares = _core.share_among_cells(
                stencil, points.position, points.half_length, volume, grid,
                own.cell_keys, axisymmetric,
            )  # fmt: skip
            corner_node = np.zeros(0, dtype=np.int32)
        share_start, share, moment, hoop_share, hoop_moment = shares
        lattice = np.asarray(_core.lattice(own.cell_keys))  # as in the overlay 0
        gradient = mean_gradients(np.asarray(moment), grid.sizes(lattice[:, : grid.dim]))
        hoop_gradient = hoop_gradients(np.asarray(hoop_moment))
        centres = cls(
            kind=kind,
            group_start=stencil.start,
            count=stencil.count,
            cell_start=np.asarray(cell_start),
            cell=np.asarray(cell),
            corner_node=np.asarray(corner_node),
            share_start=np.asarray(share_start),
            share=np.asarray(share),
            hoop_share=np.asarray(hoop_share),
            node=active.corners(np.asarray(_core.lattice(active.cell_keys[own.cells]))),
            gradient=gradient,
            hoop_gradient=hoop_gradient,
            pressure=np.zeros(n),
            jacobian_ratio_before=volume / (points.initial_volume * points.assumed_jacobian),
            jacobian_ratio=np.ones(n),
            jacobian=np.ones(n),
            volume_change=np.zeros(len(gradient)),
            trace=np.zeros_like(gradient),
            hoop_change=np.zeros(len(hoop_gradient)),
        )
        centres.pressure = centres._pressure(points)
        return centres

    def _pressure(self, points: MaterialPoints) -> Floats:
        """Returns `pressure`: the mean of the cells' Cauchy stress times the points' J_bar."""
        scaled = 2 if self.kind == "plane_strain" else 3
        own = points.stress[:, :scaled].mean(axis=1)
        mean = own - self.differences(own, points.volume)
        return np.asarray(mean * points.assumed_jacobian)

    def update(self, displacement: Floats) -> None:
        """Updates the cells' volume changes for the step's nodal displacement, (nodes, dim)."""
        _core.update_centres(
            self.kind, self.node, self.gradient, self.hoop_gradient, displacement,
            self.volume_change, self.trace, self.hoop_change,
        )  # fmt: skip

    def differences(self, value: Floats, volume: Floats) -> Floats:
        """Returns the differences of a value of the points from the means of their cells, (n,).

        value: shape (n,). volume: current volume, shape (n,).
        """
        towards_mean = _core.smooth_strains(
            self.group_start, self, len(self.node), value, volume, np.ones(len(value))
        )
        return -np.asarray(towards_mean)

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
