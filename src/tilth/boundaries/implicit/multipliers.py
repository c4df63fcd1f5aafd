# SPDX-License-Identifier: BSD-3-Clause
"""The multiplier space of the implicit boundaries in one step.

A boundary holds its directions in the mean over patches, no more of them than the nodes of the cut
cells can bear (docs/theory/implicit_boundaries.md): one around each of some cut edges of the grid's
cells that share no node. With the quadrature weights a_q, the constrained direction f_q and the
slip w_q of the patch's points,

    A = sum_q a_q,   m = (1/A) sum_q a_q f_q . w_q,   traction f_q P m at each of them,

so that the nodal force is P/A B (B u - prescribed), B_a = sum_q a_q N_a(x_q) f_q: one row for each
multiplier, and a matrix that is the product of this row with itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.mpm.grid import ActiveGrid
from tilth.terms.linear import RowCoupling

if TYPE_CHECKING:
    from tilth.boundaries.implicit.constraint import ImplicitConstraint, SurfaceConstraint


@dataclass(frozen=True)
class Multipliers:
    """The m multipliers of one boundary: n quadrature points with r constrained directions each.

    Attributes:
        owner: multiplier that each direction of each point belongs to, shape (r, n).
        direction: unit vectors, shape (r, n, dim).
        weight: of the points [length^(dim - 1)], shape (n,).
        area: of the patches [length^(dim - 1)], shape (m,).
        penalty: P [stress/length], shape (m,).
        node_start, node: nodes that each mean depends on, ragged, shapes (m + 1,), (entries,).
        row: B [length^(dim - 1)], shape (entries, dim).
        place: vertices, from the grid's origin in cells, shape (m, dim).
    """

    owner: Integers
    direction: Floats
    weight: Floats
    area: Floats
    penalty: Floats
    node_start: Integers
    node: npt.NDArray[np.int32]
    row: Floats
    place: Floats

    def mean(self, vector: Floats) -> Floats:
        """Returns the means of vectors (n, dim) along the constrained directions, shape (m,)."""
        along = self.weight * np.einsum("rni,ni->rn", self.direction, vector)
        total = np.bincount(self.owner.ravel(), along.ravel(), minlength=len(self.area))
        # on the axis of symmetry points have no weight
        return np.asarray(total / np.where(self.area > 0.0, self.area, 1.0))

    def spread(self, traction: Floats) -> Floats:
        """Returns the stress vectors at the points [stress], (n, dim), of the patches', (m,)."""
        return np.asarray(np.einsum("rn,rni->ni", traction[self.owner], self.direction))


def constrained_directions(condition: str, normal: Floats, declared: Floats | None) -> Floats:
    """Returns unit vectors along what a condition holds, shape (r, n, dim).

    If all directions are constrained these are the normal and tangents, not the axes: another
    boundary that meets this one at a right angle then shares one of its directions.

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
        if condition == "fixed" and closed.any():  # tangents turn over opposite the first normal
            return np.broadcast_to(np.eye(3)[:, None], (3, *normal.shape)).copy()
    return tangents if condition == "tangential" else np.concatenate([normal[None], tangents])


def _tangents(normal: Floats) -> Floats:
    """Two tangents for each of the normals in space (n, 3), those of the first one turned along."""
    first = normal[0]
    one = np.eye(3)[np.abs(first).argmin()]
    one = one - (one @ first) * first
    one /= np.linalg.norm(one)
    tangents = []
    for tangent in (one, np.cross(first, one)):
        # the rotation that takes the first normal to another one, by the shortest way
        share = (normal @ tangent) / np.maximum(1.0 + normal @ first, 1e-12)
        turned = tangent - share[:, None] * (first + normal)
        tangents.append(turned / np.linalg.norm(turned, axis=1)[:, None])
    return np.stack(tangents)


def choose_multipliers(
    active: ActiveGrid, parts: Sequence[SurfaceConstraint], constrained: Flags
) -> list[Multipliers]:
    """Returns the multipliers of boundaries that touch soil in a step, of each in its turn.

    constrained: components of the displacement that other conditions prescribe, shape (nodes, dim).
    """
    if not parts:
        return []
    dim = active.grid.dim
    directions = [part.constrained_directions for part in parts]
    count = np.array([len(part.chosen) for part in parts])
    cells = np.array([len(part.at.node) for part in parts])
    rank = np.array([len(direction) for direction in directions])
    family = np.repeat(np.arange(len(parts)), rank)
    end_cell = np.cumsum(cells)[family]
    owner, of_family, _, place = _core.multiplier_space(
        *joined_cells(parts),
        active.lattice,
        active.grid.cell_size,
        end_cell - cells[family],
        end_cell,
        _before(count[family]),
        np.concatenate([direction.reshape(-1, dim) for direction in directions]),
        constrained,
    )
    owners = np.split(np.asarray(owner), np.cumsum(rank * count)[:-1])
    first = np.searchsorted(np.asarray(of_family), np.append(_before(rank), rank.sum()))
    found = []
    for number, (part, direction) in enumerate(zip(parts, directions, strict=True)):
        own = slice(first[number], first[number + 1])
        found.append(
            _multipliers(part, direction, owners[number] - own.start, np.asarray(place)[own])
        )
    return found


def joined_cells(
    parts: Sequence[ImplicitConstraint],
) -> tuple[Integers, npt.NDArray[np.int32], Floats, Floats]:
    """Returns the cells that boundaries act on, one after the other, and their points.

    The first point of each cell (cells + 1,) and its nodes (cells, 2^dim); the points' places in
    their cells and normals, (n, dim) each.
    """
    count = np.array([len(part.chosen) for part in parts])
    starts = [part.at.start[:-1] + first for part, first in zip(parts, _before(count), strict=True)]
    return (
        np.concatenate([*starts, count.sum(keepdims=True)]),
        np.concatenate([part.at.node for part in parts]),
        np.concatenate([part.at.local for part in parts]),
        np.concatenate([part.pose.normal for part in parts]),
    )


def _multipliers(
    part: SurfaceConstraint, direction: Floats, owner: Integers, place: Floats
) -> Multipliers:
    rank, count, dim = direction.shape
    penalty = np.einsum("rni,nij,rnj->rn", direction, part.penalty, direction)
    means = _core.multiplier_means(
        len(place), owner, np.tile(np.arange(count), rank), part.at.cell, part.at.node,
        part.pose.weight, direction.reshape(-1, dim), penalty.ravel(), part.at.value,
    )  # fmt: skip
    area, mean_penalty, node_start, node, row = map(np.asarray, means)
    return Multipliers(
        owner=owner.reshape(rank, count),
        direction=direction,
        weight=part.pose.weight,
        area=area,
        penalty=mean_penalty,
        node_start=node_start,
        node=node,
        row=row,
        place=place,
    )


def multiplier_coupling(multipliers: Sequence[Multipliers], slip: Sequence[Floats]) -> RowCoupling:
    """Returns the force of all multipliers, linear in the nodal displacement.

    slip: mean slips of a grid at rest [length], of each boundary, shape (m,).
    """
    area = np.concatenate([each.area for each in multipliers])
    penalty = np.concatenate([each.penalty for each in multipliers])
    scale = np.sqrt(penalty / np.where(area > 0.0, area, 1.0))
    starts = np.concatenate([each.node_start[:-1] for each in multipliers])
    entries = np.array([len(each.node) for each in multipliers])
    count = [len(each.area) for each in multipliers]
    node_start = np.append(starts + np.repeat(_before(entries), count), entries.sum())
    return RowCoupling(
        node_start=node_start,
        node=np.concatenate([each.node for each in multipliers]),
        row=np.concatenate([each.row for each in multipliers])
        * np.repeat(scale, np.diff(node_start))[:, None],
        constant=scale * area * np.concatenate(slip),
    )


def _before(count: Integers) -> Integers:
    """Returns the sum of what comes before each entry."""
    return np.cumsum(count) - count
