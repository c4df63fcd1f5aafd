# SPDX-License-Identifier: BSD-3-Clause
"""How smooth the soil's surface is opposite to a body that moves with inertia, and its normal.

A body that rolls or slides over soil goes along the soil's surface, not along its own. Where gaps g
are measured along the body's normals n, the soil's surface has the points x + g n. Near each other
they lie on a quadratic surface, which tells the soil's normal; points that scatter about it, as on
a stair-case of domains, do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.grid.background import Grid

SMOOTH = 2e-3
"""Scatter in cells up to which the soil's normal is used; from twice of it on it is not."""

MARGIN = 4.0
"""Height of a stair-case over the scatter of gaps: gaps are known to a half of it."""


@dataclass(frozen=True)
class Smoothness:
    """The soil's surface opposite to n points of a body.

    Attributes:
        scatter: greatest distance of its points from the smooth one near a point [length], (n,);
            infinite where there are too few points.
        normal: unit normals of the smooth one, into the soil, shape (n, dim).
    """

    scatter: Floats
    normal: Floats

    def of(self, chosen: Integers) -> Smoothness:
        """Returns that of the chosen points, shape (k,)."""
        return Smoothness(self.scatter[chosen], self.normal[chosen])

    @property
    def inexact(self) -> Floats:
        """How inexact measured gaps are, as `Touch.scatter` [length], shape (n,)."""
        return MARGIN * self.scatter

    def normals(self, otherwise: Floats, cell: float) -> Floats:
        """Returns unit normals of the soil where it is smooth, into it, shape (n, dim).

        otherwise: where it is not. cell: the smallest edge of a cell [length].
        """
        share = np.clip(2.0 - self.scatter / (SMOOTH * cell), 0.0, 1.0)[:, None]
        found = share * self.normal + (1.0 - share) * otherwise
        return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


def smoothness(position: Floats, normal: Floats, gap: Floats, grid: Grid) -> Smoothness:
    """Returns scatter and normals of the soil's surface from measured gaps.

    The points in each cell are fitted by one surface.

    Args:
        position: of the body's points [length], shape (n, dim).
        normal: unit normals of the body, into the soil, shape (n, dim).
        gap: [length], shape (n,); infinite where there is no soil.
        grid: the background grid.
    """
    cell = float(grid.cell_size.min())
    scatter, found = np.full(len(gap), np.inf), normal.copy()
    cells = np.floor(grid.in_cells(position)).astype(np.int64)
    group = np.unique(cells, axis=0, return_inverse=True)[1].ravel()
    group[~np.isfinite(gap)] = -1
    for number in np.unique(group[group >= 0]):
        own = np.flatnonzero(group == number)
        frame = np.linalg.svd(normal[own].mean(axis=0)[None])[2]
        inward = frame[0] * np.sign(frame[0] @ normal[own].mean(axis=0))
        foot = position[own] + gap[own, None] * normal[own]
        foot = (foot - foot.mean(axis=0)) / cell
        along, height = foot @ frame[1:].T, foot @ inward
        pairs = [(i, j) for i in range(along.shape[1]) for j in range(i + 1)]
        columns = [np.ones(len(own)), *along.T, *(along[:, i] * along[:, j] for i, j in pairs)]
        matrix = np.stack(columns, axis=1)
        if len(own) < 2 * matrix.shape[1]:
            continue
        factor = np.linalg.lstsq(matrix, height, rcond=None)[0]
        scatter[own] = cell * np.abs(height - matrix @ factor).max()
        slope = np.tile(factor[1 : 1 + along.shape[1]], (len(own), 1))
        for (i, j), value in zip(pairs, factor[1 + along.shape[1] :], strict=True):
            slope[:, i] += value * along[:, j]
            slope[:, j] += value * along[:, i]
        upright = inward - slope @ frame[1:]
        found[own] = upright / np.linalg.norm(upright, axis=1)[:, None]
    return Smoothness(scatter, found)
