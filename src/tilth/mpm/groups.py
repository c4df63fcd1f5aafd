# SPDX-License-Identifier: BSD-3-Clause
"""Groups of points that share all their nodes; a stencil consists of such groups.

The support of most bases is a box of nodes, described by its first node and the number of nodes
per direction. The support of a domain with corners (CPDI) is the nodes of the cells that contain a
corner, stored as a list.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Integers
from tilth.errors import StepFailed
from tilth.grid.keys import overlay_shift
from tilth.mpm.points import MaterialPoints, PointRange

if TYPE_CHECKING:
    from tilth.grid.background import Grid


_OUT_OF_RANGE, _TOO_WIDE = -1, -2  # SupportFailure of kernel/corners.hpp


@dataclass(frozen=True)
class Groups:
    """Groups of one range of points, in the order of the points.

    The keys are those of overlay 0, whatever the overlay of the body.

    Attributes:
        start: first point of each group, shape (groups + 1,).
        first: lattice index of the first node of the bounding box of its nodes, shape (groups, 3).
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

    def active_nodes(self, overlay: int) -> Integers:
        """Returns the sorted keys of all nodes of the groups in an overlay."""
        if self.boxed:
            return _in_overlay(np.asarray(_core.active_nodes(self.first, self.count)), overlay)
        return _in_overlay(np.unique(self.node_key), overlay)

    def active_cells(self, overlay: int) -> Integers:
        """Returns the sorted keys of all cells of the groups in an overlay."""
        if self.boxed:
            cells = np.maximum(self.count - 1, 1)
            return _in_overlay(np.asarray(_core.active_nodes(self.first, cells)), overlay)
        return _in_overlay(np.unique(self.cell), overlay)

    def index_range(self) -> int:
        """Returns the largest magnitude of the lattice indices of nodes along z."""
        if len(self.first) == 0:
            return 0
        last = self.first[:, 2] + self.count[:, 2]
        return int(max(-self.first[:, 2].min(), last.max()))


def _in_overlay(keys: Integers, overlay: int) -> Integers:
    return keys + overlay_shift(overlay) if overlay else keys


def group(points: MaterialPoints, range_: PointRange, grid: Grid) -> Groups:
    """Sorts the points of a range by support and returns their groups.

    Raises:
        StepFailed: if a point is outside the range of the grid's keys, or its domain is too wide.
    """
    if range_.has_corners:
        return _by_corners(points, range_, grid)
    part = points.part(range_)
    keys = np.empty(len(part), dtype=np.int64)
    outside = _core.support_keys(range_.basis, part.position, part.half_length, grid, keys)
    if outside:
        _raise_first_failure(part, keys)
    if not (keys[1:] >= keys[:-1]).all():
        order = np.argsort(keys, kind="stable")
        points.permute(range_, order)
        keys = keys[order]
    none = np.zeros(0, dtype=np.int64)
    return Groups(*_core.group_points(grid.dim, keys), none, none, none, none)


def _by_corners(points: MaterialPoints, range_: PointRange, grid: Grid) -> Groups:
    part = points.part(range_)
    keys, codes, failures = _core.corner_supports(part.position, part.corner, grid)
    keys, codes = np.asarray(keys), np.asarray(codes)
    if failures:
        _raise_first_failure(part, keys)
    order = np.lexsort((*codes.T, keys))  # stable
    if (order[1:] < order[:-1]).any():
        points.permute(range_, order)
        keys, codes = keys[order], codes[order]
    return Groups(*_core.group_corner_points(grid.dim, keys, codes))


def _raise_first_failure(part: MaterialPoints, keys: Integers) -> None:
    first = int((keys < 0).argmax())
    reasons = {
        _OUT_OF_RANGE: "a point is too far from the grid's origin",
        _TOO_WIDE: "the domain of a point extends over more than "
        f"{256 if part.position.shape[1] == 2 else 32} cells",
    }
    raise StepFailed(reasons[int(keys[first])], point=int(part.point_id[first]))
