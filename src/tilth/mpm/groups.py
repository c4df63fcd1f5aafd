# SPDX-License-Identifier: BSD-3-Clause
"""Groups of points that share all their nodes: what a stencil is made of.

The support of most bases is a box of nodes, described by its first node and the number of nodes
per direction. That of a domain with corners (CPDI) is the nodes of the cells that hold a corner,
kept in lists.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Integers
from tilth.errors import StepFailed
from tilth.mpm.points import MaterialPoints, PointRange

if TYPE_CHECKING:
    from tilth.mpm.grid import Grid


_REACH, _WIDTH = -1, -2  # SupportFailure of kernel/corners.hpp


@dataclass(frozen=True)
class Groups:
    """Groups of one body's points, in the order of the points.

    Attributes:
        start: first point of each group, shape (groups + 1,).
        first: lattice place of the first node of the box around its nodes, shape (groups, 3).
        count: nodes per direction of this box, shape (groups, 3).
        cell_start, cell: keys of the cells of each group; empty where they fill the box.
        node_start, node_key: keys of the nodes of each group; empty where they fill the box.
    """

    start: Integers
    first: Integers
    count: npt.NDArray[np.int32]
    cell_start: Integers
    cell: Integers
    node_start: Integers
    node_key: Integers

    @property
    def boxed(self) -> bool:
        """Whether the groups' nodes fill their boxes."""
        return len(self.node_start) == 0

    def active_nodes(self) -> Integers:
        """Returns the sorted keys of all nodes of the groups."""
        if self.boxed:
            return np.asarray(_core.active_nodes(self.first, self.count))
        return np.unique(self.node_key)

    def active_cells(self) -> Integers:
        """Returns the sorted keys of all cells of the groups."""
        if self.boxed:
            return np.asarray(_core.active_nodes(self.first, np.maximum(self.count - 1, 1)))
        return np.unique(self.cell)


def group(points: MaterialPoints, body: PointRange, grid: Grid) -> Groups:
    """Sorts a body's points by support and returns their groups.

    Raises:
        StepFailed: if a point is beyond the reach of the grid, or its domain reaches too far.
    """
    if body.has_corners:
        return _by_corners(points, body, grid)
    part = points.part(body)
    keys = np.empty(len(part), dtype=np.int64)
    beyond = _core.support_keys(
        body.basis, part.position, part.half_length, grid.origin, grid.cell_size, keys
    )
    if beyond:
        _refuse(part, keys)
    if not (keys[1:] >= keys[:-1]).all():
        order = np.argsort(keys, kind="stable")
        points.permute(body, order)
        keys = keys[order]
    none = np.zeros(0, dtype=np.int64)
    return Groups(*_core.group_points(grid.dim, keys), none, none, none, none)


def _by_corners(points: MaterialPoints, body: PointRange, grid: Grid) -> Groups:
    part = points.part(body)
    keys, words, failures = _core.corner_supports(
        part.position, part.corner, grid.origin, grid.cell_size
    )
    keys, words = np.asarray(keys), np.asarray(words)
    if failures:
        _refuse(part, keys)
    order = np.lexsort((*words.T, keys))  # stable
    if (order[1:] < order[:-1]).any():
        points.permute(body, order)
        keys, words = keys[order], words[order]
    return Groups(*_core.group_corner_points(grid.dim, keys, words))


def _refuse(part: MaterialPoints, keys: Integers) -> None:
    first = int((keys < 0).argmax())
    reasons = {
        _REACH: "a point is too far from the grid's origin",
        _WIDTH: "the domain of a point reaches over more than "
        f"{256 if part.position.shape[1] == 2 else 32} cells",
    }
    raise StepFailed(reasons[int(keys[first])], point=int(part.point_id[first]))
