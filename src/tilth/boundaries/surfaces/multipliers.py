# SPDX-License-Identifier: BSD-3-Clause
"""The multiplier space of the implicit boundaries in one step.

A boundary constrains the mean slip over the patch of each multiplier. A patch is the part of
the boundary around a vertex: a cut edge of the grid's cells, selected so that no two vertices have
a common node. There are then no more constraints than the nodes of the cut cells can satisfy
(docs/theory/implicit_boundaries.md). With the quadrature weights a_q, the constrained directions
f_q and the slips w_q of a patch's points,

    A = sum_q a_q,   m = (1/A) sum_q a_q f_q . w_q,   traction f_q P m at each point,

so that the nodal force is P/A B (B u - prescribed), B_a = sum_q a_q N_a(x_q) f_q: one row for each
multiplier, and a matrix that is the product of this row with itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.points import ConstrainedPoints, PointsNearSoil
from tilth.boundaries.surfaces.trace import Trace
from tilth.mpm.active_grid import ActiveGrid
from tilth.terms.linear import RowCoupling


@dataclass(frozen=True)
class Multipliers:
    """The m multipliers of one boundary: n quadrature points with r constrained directions each.

    Attributes:
        multiplier: its number, of each direction of each point, shape (r, n).
        direction: constrained directions, unit vectors, shape (r, n, dim).
        weight: of the points [length^(dim - 1)], shape (n,).
        area: of the patches [length^(dim - 1)], shape (m,).
        penalty: P [stress/length], shape (m,).
        node_start, node: nodes on which each mean depends, ragged, shapes (m + 1,), (entries,).
        row: B [length^(dim - 1)], shape (entries, dim).
        vertex: positions of the vertices, from the grid's origin in cells, shape (m, dim).
    """

    multiplier: Integers
    direction: Floats
    weight: Floats
    area: Floats
    penalty: Floats
    node_start: Integers
    node: npt.NDArray[np.int32]
    row: Floats
    vertex: Floats

    def mean(self, vector: Floats) -> Floats:
        """Returns the means of vectors (n, dim) along the constrained directions, shape (m,)."""
        along = self.weight * np.einsum("rni,ni->rn", self.direction, vector)
        # on the axis of symmetry points have no weight
        return np.asarray(self._sums(along) / np.where(self.area > 0.0, self.area, 1.0))

    def shared(self, vector: Floats, gives: Floats, takes: Floats) -> Floats:
        """Returns the vectors (n, dim) of points that share what they give, shape (n, dim).

        gives, takes: shares of each point, shape (n,). The sum over each patch is that of
        `gives` times the vectors along the constrained directions.
        """
        along = np.einsum("rni,ni->rn", self.direction, vector)
        given = self._sums(self.weight * gives * along)
        taken = self._sums(np.broadcast_to(self.weight * takes, self.multiplier.shape))
        each = given / np.where(taken > 0.0, taken, 1.0)
        return np.asarray(takes[:, None] * self.distribute(each))

    def _sums(self, values: Floats) -> Floats:
        """Returns the sums of values of each direction of each point, (r, n), shape (m,)."""
        found = np.bincount(self.multiplier.ravel(), values.ravel(), minlength=len(self.area))
        return np.asarray(found, dtype=np.float64)

    def distribute(self, traction: Floats) -> Floats:
        """Returns the points' tractions [stress], (n, dim), for those of the multipliers, (m,)."""
        return np.asarray(np.einsum("rn,rni->ni", traction[self.multiplier], self.direction))


def constrained_directions(condition: str, normal: Floats, declared: Floats | None) -> Floats:
    """Returns the r directions that a condition constrains, unit vectors, shape (r, n, dim).

    If all directions are constrained these are the normal and tangents, not the grid's axes: a
    boundary at a right angle to this one then has a common direction with it.

    Args:
        condition: "roller", "fixed" or "tangential".
        normal: unit, shape (n, dim).
        declared: unit vectors to be constrained instead, shape (n, dim), or None.
    """
    if declared is not None:
        return declared[None]
    if condition == "roller":
        return normal[None]
    if normal.shape[1] == 2:
        tangents = np.stack([-normal[:, 1], normal[:, 0]], axis=1)[None]
    else:
        tangents = _tangents(normal)
        closed = normal @ normal[0] < -0.5
        if condition == "fixed" and closed.any():  # tangents are singular opposite the first normal
            return np.broadcast_to(np.eye(3)[:, None], (3, *normal.shape)).copy()
    return tangents if condition == "tangential" else np.concatenate([normal[None], tangents])


def _tangents(normal: Floats) -> Floats:
    """Returns two tangents for each normal in space, (n, 3) -> (2, n, 3).

    They follow from those of the first normal by the smallest rotation onto the other normals.
    """
    first = normal[0]
    one = np.eye(3)[np.abs(first).argmin()]
    one = one - (one @ first) * first
    one /= np.linalg.norm(one)
    tangents = []
    for tangent in (one, np.cross(first, one)):
        # smallest rotation from the first normal to the others
        factor = (normal @ tangent) / np.maximum(1.0 + normal @ first, 1e-12)
        rotated = tangent - factor[:, None] * (first + normal)
        tangents.append(rotated / np.linalg.norm(rotated, axis=1)[:, None])
    return np.stack(tangents)


def choose_multipliers(
    active: ActiveGrid, parts: Sequence[ConstrainedPoints], constrained: Flags
) -> list[Multipliers]:
    """Returns the multipliers of each boundary in contact with soil in a step.

    constrained: components of the displacement that other conditions prescribe, shape (nodes, dim).
    """
    if not parts:
        return []
    dim = active.grid.dim
    directions = [part.constrained_directions for part in parts]
    count = np.array([len(part.chosen) for part in parts])
    rank = np.array([len(direction) for direction in directions])
    cells = concatenated_cells(parts)
    first_cell, end_cell, families = _families(active, parts, rank)
    multiplier, of_family, _, vertex = _core.multiplier_space(
        *cells,
        active.lattice,
        active.grid,
        first_cell,
        end_cell,
        _offsets(cells[0][end_cell] - cells[0][first_cell]),
        np.concatenate([direction.reshape(-1, dim) for direction in directions]),
        constrained,
    )
    multipliers = np.split(np.asarray(multiplier), np.cumsum(rank * count)[:-1])
    first = np.searchsorted(np.asarray(of_family), np.append(_offsets(families), families.sum()))
    found = []
    for number, (part, direction) in enumerate(zip(parts, directions, strict=True)):
        own = slice(first[number], first[number + 1])
        of_points = (multipliers[number] - own.start).reshape(len(direction), -1)
        own_vertex = np.asarray(vertex)[own]
        joined = part.joined(of_points, own_vertex, active)
        if joined is not of_points:
            kept, joined = np.unique(joined, return_inverse=True)
            own_vertex = own_vertex[kept]
        found.append(_multipliers(part, direction, joined.ravel(), own_vertex))
    return found


def _families(
    active: ActiveGrid, parts: Sequence[ConstrainedPoints], rank: Integers
) -> tuple[Integers, Integers, Integers]:
    """Returns first and last cell of each family, and the number of families of each boundary.

    A boundary has one family for each constrained direction, and for each overlay of the
    soil that it touches: the cells of one overlay follow each other.
    """
    firsts, ends, families = [], [], []
    start = 0
    for part, directions in zip(parts, rank, strict=True):
        overlay = active.overlay[part.at.node[:, 0]]
        change = np.flatnonzero(overlay[1:] != overlay[:-1]) + 1
        cell = start + np.concatenate([[0], change, [len(overlay)]])
        firsts.append(np.tile(cell[:-1], directions))
        ends.append(np.tile(cell[1:], directions))
        families.append(directions * (len(cell) - 1))
        start += len(overlay)
    return np.concatenate(firsts), np.concatenate(ends), np.array(families)


def concatenated_cells(
    parts: Sequence[PointsNearSoil],
) -> tuple[Integers, npt.NDArray[np.int32], Floats, Floats]:
    """Returns the cells that boundaries act on and their points, one boundary after the other.

    The first point of each cell (cells + 1,) and its nodes (cells, 2^dim); the points' local
    coordinates and normals, (n, dim) each.
    """
    count = np.array([len(part.chosen) for part in parts])
    starts = [
        part.at.start[:-1] + first for part, first in zip(parts, _offsets(count), strict=True)
    ]
    return (
        np.concatenate([*starts, count.sum(keepdims=True)]),
        np.concatenate([part.at.node for part in parts]),
        np.concatenate([part.at.local for part in parts]),
        np.concatenate([part.pose.normal for part in parts]),
    )


def _multipliers(
    part: ConstrainedPoints,
    direction: Floats,
    multiplier: Integers,
    vertex: Floats,
) -> Multipliers:
    rank, count, dim = direction.shape
    penalty = np.einsum("rni,nij,rnj->rn", direction, part.penalty, direction)
    means = _core.multiplier_means(
        len(vertex), multiplier, np.tile(np.arange(count), rank), part.at.cell, part.at.node,
        part.pose.weight, direction.reshape(-1, dim), penalty.ravel(), part.at.value,
    )  # fmt: skip
    area, mean_penalty, node_start, node, row = map(np.asarray, means)
    if part.trace_of_rows is not None:
        found = _rows_of_trace(part, part.trace_of_rows, direction, multiplier, len(vertex))
        node_start, node, row = found
    return Multipliers(
        multiplier=multiplier.reshape(rank, count),
        direction=direction,
        weight=part.pose.weight,
        area=area,
        penalty=mean_penalty,
        node_start=node_start,
        node=node,
        row=row,
        vertex=vertex,
    )


def _rows_of_trace(
    part: ConstrainedPoints,
    trace: Trace,
    direction: Floats,
    multiplier: Integers,
    count: int,
) -> tuple[Integers, npt.NDArray[np.int32], Floats]:
    """Returns node_start, node and row of `Multipliers` for the trace of domains with corners.

    multiplier: of each direction of each point, shape (r n,). count: number of multipliers.
    """
    multiplier = multiplier.reshape(len(direction), -1)
    nodes = int(trace.node.max(initial=0)) + 1
    found, entry = np.unique(multiplier[:, trace.place] * nodes + trace.node, return_inverse=True)
    share = (part.pose.weight[trace.place] * trace.value)[:, None] * direction[:, trace.place]
    columns = [
        np.bincount(entry.ravel(), each.ravel(), len(found)) for each in share.transpose(2, 0, 1)
    ]
    start = np.searchsorted(found, nodes * np.arange(count + 1))
    return start, (found % nodes).astype(np.int32), np.stack(columns, axis=1)


def multiplier_coupling(multipliers: Sequence[Multipliers], slip: Sequence[Floats]) -> RowCoupling:
    """Returns the force of all multipliers, linear in the nodal displacement.

    slip: mean slips at zero nodal displacement [length], of each boundary, shape (m,).
    """
    area = np.concatenate([each.area for each in multipliers])
    penalty = np.concatenate([each.penalty for each in multipliers])
    scale = np.sqrt(penalty / np.where(area > 0.0, area, 1.0))
    starts = np.concatenate([each.node_start[:-1] for each in multipliers])
    entries = np.array([len(each.node) for each in multipliers])
    count = [len(each.area) for each in multipliers]
    node_start = np.append(starts + np.repeat(_offsets(entries), count), entries.sum())
    return RowCoupling(
        node_start=node_start,
        node=np.concatenate([each.node for each in multipliers]),
        row=np.concatenate([each.row for each in multipliers])
        * np.repeat(scale, np.diff(node_start))[:, None],
        constant=scale * area * np.concatenate(slip),
    )


def _offsets(count: Integers) -> Integers:
    """Returns the sum of the entries before each entry, same shape."""
    return np.cumsum(count) - count
