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

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.corners import corner_signs
from tilth.mpm.grid import ActiveGrid
from tilth.mpm.keys import find_keys
from tilth.mpm.owned_places import OwnedPlaces
from tilth.mpm.points import MaterialPoints
from tilth.mpm.quadrature import PointsInCells, locate_in_cells

FARTHEST = 1.5
"""Largest local coordinate, 1 on the faces of a domain, that still belongs to the domain: a tracked
surface is not exactly the domains' boundary."""

ITERATIONS = 12
"""Newton's iterations for local coordinates; four are enough in a domain that is not degenerate."""

FLAT = 1e-9
"""Least volume of a domain over that of a cube of its extent for which coordinates are sought."""

ROUND_OFF = 1e-12
"""Weight of a corner that is round-off."""


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
    for body in points.bodies:
        found[body.points] = body.has_corners
    return found


def domain_weights(corner: Floats, offset: Floats) -> tuple[Floats, Flags]:
    """Returns the weights of a domain's corners at places, and which places belong to it.

    Args:
        corner: of the domains relative to their points [length], shape (n, 2^dim, dim).
        offset: of the places from the points [length], shape (n, dim).

    Returns:
        w_c [-], shape (n, 2^dim), with sum_c w_c = 1 and sum_c w_c x_c the place, and whether the
        local coordinates are within `FARTHEST`, shape (n,).
    """
    dim = offset.shape[1]
    signs = corner_signs(dim)
    xi = np.zeros_like(offset)
    size = np.abs(corner).max(axis=(1, 2), initial=0.0)
    left = np.arange(len(offset))  # those whose coordinates are not found yet
    for _ in range(ITERATIONS):
        hat = 0.5 * (1.0 + signs * xi[left, None])  # (left, corners, dim)
        error = offset[left] - np.einsum("nc,nci->ni", _product(hat), corner[left])
        wrong = np.abs(error).max(axis=1, initial=0.0) > 1e-14 * size[left]
        left, hat, error = left[wrong], hat[wrong], error[wrong]
        if len(left) == 0:
            break
        slope = np.stack(
            [
                0.5 * signs[:, k] * _product(hat[..., [i for i in range(dim) if i != k]])
                for k in range(dim)
            ],
            axis=2,
        )
        jacobian = corner[left].transpose(0, 2, 1) @ slope
        flat = np.abs(np.linalg.det(jacobian)) <= FLAT * size[left] ** dim
        jacobian[flat] = np.eye(dim)
        change = np.linalg.solve(jacobian, error[:, :, None])[:, :, 0]
        xi[left] = (xi[left] + np.where(flat[:, None], FARTHEST, change)).clip(-4.0, 4.0)
    weight = _product(0.5 * (1.0 + signs * xi[:, None]))
    weight[np.abs(weight) < ROUND_OFF] = 0.0
    error = np.einsum("nc,nci->ni", weight, corner) - offset
    inside = (np.abs(xi) <= FARTHEST).all(axis=1)
    return weight, inside & (np.abs(error).max(axis=1, initial=0.0) <= 1e-9 * size)


def _product(factors: Floats) -> Floats:
    """Returns the products over the last axis, which is short."""
    result = factors[..., 0]
    for k in range(1, factors.shape[-1]):
        result = result * factors[..., k]
    return np.asarray(result)


def trace_of_domains(
    active: ActiveGrid,
    points: MaterialPoints,
    at: PointsInCells,
    place: Integers,
    position: Floats,
    owner: Integers,
) -> Trace:
    """Returns the mean trace over samples of the places' parts, on domains with corners.

    Places without samples within their domains have that of `trace_in_cells`.

    Args:
        active: the grid of the step.
        points: the material points.
        at: the n places in the cells.
        place: whose part each of the s samples is on, shape (s,).
        position: of the samples on the soil's surface [length], shape (s, dim).
        owner: material point of each sample, shape (s,).
    """
    whole = trace_in_cells(at)
    if len(place) == 0:
        return whole
    weight, inside = domain_weights(points.corner[owner], position - points.position[owner])
    place, owner, weight = place[inside], owner[inside], weight[inside]
    number = np.bincount(place, minlength=whole.count)
    # samples of one place in one domain together
    pair, first, sample = np.unique(
        place * np.int64(len(points)) + owner, return_index=True, return_inverse=True
    )
    place, owner = place[first], owner[first]
    columns = [np.bincount(sample, each, len(pair)) for each in weight.T]
    weight = np.stack(columns, axis=1)
    sample, corner = np.nonzero(weight)
    found = points.position[owner[sample]] + points.corner[owner[sample], corner]
    field = points.fields_of(owner[sample])
    order, in_cells = locate_in_cells(active, found, field)
    node = in_cells.node[in_cells.cell]
    summand = order.repeat(node.shape[1])
    share = weight[sample, corner][summand] * in_cells.value.ravel()
    of = place[sample[summand]]
    kept = number[whole.place] == 0
    entries = np.concatenate([whole.place[kept], of])
    code = entries * np.int64(active.nodes) + np.concatenate([whole.node[kept], node.ravel()])
    unique, entry = np.unique(code, return_inverse=True)
    summed = np.bincount(entry, np.concatenate([whole.value[kept], share / number[of]]))
    value = np.asarray(summed, dtype=np.float64)
    return Trace(whole.count, unique // active.nodes, unique % active.nodes, value)
