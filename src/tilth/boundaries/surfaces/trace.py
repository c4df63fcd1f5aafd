# SPDX-License-Identifier: BSD-3-Clause
"""Where soil meets a surface: the soil's displacement there in terms of the nodes'.

On soil of GIMP or linear points it is interpolated by the grid's own functions N at one place for
each quadrature point of the surface. The displacement of a domain with corners (CPDI) is by
definition interpolated between these,

    u(y) = sum_c w_c(xi) u(x_c),    w_c multilinear, xi the coordinates of y in the domain,

also on its faces; with anything else the tractions on a face would not be in balance with the
stresses of the domains behind it. Along a face this trace has kinks where domains meet, so that it
is averaged over the part of the surface for which a quadrature point stands.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tilth import _core
from tilth.arrays import Flags, Floats, Integers
from tilth.grid.keys import find_keys, overlay_shift
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.owned_places import OwnedPlaces
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells


@dataclass(frozen=True)
class Trace:
    """The displacement at n places as sums over nodes; m summands, ordered by place.

    Attributes:
        count: number of places n.
        place: place of each summand, shape (m,).
        node: its node, shape (m,).
        value: its share of the node's displacement [-], shape (m,).
    """

    count: int
    place: Integers
    node: Integers
    value: Floats

    def at_keys(self, active: ActiveGrid, places: OwnedPlaces) -> Trace:
        """Returns the trace at the places of all processes, with the nodes' keys for numbers.

        places: their owners; this one is at the owned places.
        """
        key = active.key[self.node]
        place, (node, value) = places.rows_of_all(self.place, key, self.value)
        return Trace(places.count, place, node, value)

    def on(self, active: ActiveGrid) -> Trace:
        """Returns a trace whose nodes are keys, see `at_keys`, with their numbers on a grid."""
        return replace(self, node=find_keys(active.key, self.node))

    def of(self, kept: Flags) -> Trace:
        """Returns that of the places `kept`, shape (n,)."""
        number = np.cumsum(kept) - 1
        own = kept[self.place]
        return Trace(int(kept.sum()), number[self.place[own]], self.node[own], self.value[own])

    def renumbered(self, number: Integers) -> Trace:
        """Returns the same with the new number of each place, shape (n,)."""
        place = number[self.place]
        order = np.argsort(place, kind="stable")
        return Trace(self.count, place[order], self.node[order], self.value[order])

    def less(self, other: Trace) -> Trace:
        """Returns the difference of two traces at the same places, on other nodes."""
        place = np.concatenate([self.place, other.place])
        order = np.argsort(place, kind="stable")
        node = np.concatenate([self.node, other.node])
        value = np.concatenate([self.value, -other.value])
        return Trace(self.count, place[order], node[order], value[order])

    def interpolate(self, nodal: Floats) -> Floats:
        """Returns the values at the places, (n, k), of nodal values (nodes, k)."""
        part = self.value[:, None] * nodal[self.node]
        columns = [np.bincount(self.place, each, self.count) for each in part.T]
        return np.stack(columns, axis=1)

    def scatter(self, vector: Floats, nodes: int) -> Floats:
        """Returns the sums at all nodes, (nodes, k), of vectors at the places, (n, k)."""
        part = self.value[:, None] * vector[self.place]
        return np.stack([np.bincount(self.node, each, nodes) for each in part.T], axis=1)


def trace_in_cells(at: PointsInCells) -> Trace:
    """Returns the trace by the functions of the cells, of places ordered by cell."""
    count, corners = at.value.shape
    node = at.node[at.cell].astype(np.int64)
    return Trace(count, np.repeat(np.arange(count), corners), node.ravel(), at.value.ravel())


def with_corners(points: MaterialPoints) -> Flags:
    """Returns which points have domains with corners, shape (n,)."""
    found = np.zeros(len(points), dtype=bool)
    for range_ in points.ranges:
        found[range_.points] = range_.has_corners
    return found


def trace_of_domains(
    active: ActiveGrid,
    points: MaterialPoints,
    at: PointsInCells,
    place: Integers,
    position: Floats,
    point: Integers,
) -> Trace:
    """Returns the mean trace over samples of the places' parts, on domains with corners.

    Places without samples within their domains have that of `trace_in_cells`.

    Args:
        active: the grid of the step.
        points: the material points.
        at: the n places in the cells.
        place: whose part each of the s samples is on, shape (s,).
        position: of the samples on the soil's surface [length], shape (s, dim).
        point: material point of each sample, shape (s,).
    """
    order = np.argsort(place, kind="stable")
    start = np.searchsorted(place[order], np.arange(len(at.local) + 1))
    point = point[order]
    shift = np.broadcast_to(overlay_shift(points.overlays_of(point)), len(point))
    count, node, value = _core.trace_of_domains(
        start, position[order], point, np.ascontiguousarray(shift, dtype=np.int64), points.position,
        points.corner, active.grid, active.cell_keys, active.key, at.start, at.node, at.value,
    )  # fmt: skip
    return Trace(len(count), np.repeat(np.arange(len(count)), count), node, value)
