# SPDX-License-Identifier: BSD-3-Clause
"""Gaps at the quadrature points of a surface, and how much of their parts is opposite soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.gap import WIDENING
from tilth.comm import SERIAL
from tilth.mpm.owned_places import OwnedPlaces

ROUND_OFF = 1e-6
"""Share by which domains are wider across lines that measure where the soil ends: the widening with
which no line slips between two domains would make the soil longer."""

NEIGHBOURS = {2: 7, 3: 12}
"""Number of nearest points that decide whether a point is at the edge of the soil. Pieces of a
surface that the grid has cut differ in size: all of the nearest points may lie on one side."""

Measure = Callable[[Floats, Floats, float], tuple[Floats, Integers]]
"""Returns gaps and material points at positions with normals for a widening, see `measure_gap`."""

Coordinates = Mapping[str, Floats]
"""Coordinates along the edges of a part by its shape, shape (variants, samples, dim - 1). Each
sample stands for the same area. The parts have the variants in turn."""


def _intervals(count: int) -> Floats:
    """Returns the middles of intervals of a segment, shape (1, count, 1)."""
    return np.asarray((np.arange(count) + 0.5)[None, :, None] / count)


def _triangles(share: Floats) -> Floats:
    """Returns places in the part of a triangle that belongs to one of its corners, (v, 2 k, 2).

    It is the quadrangle between the corner, the ends of the part's edges and the centroid, two
    triangles of equal area. share: barycentric coordinates in each of them, shape (v, k, 2).
    """
    centroid = np.array([2.0, 2.0]) / 3.0
    one, two = np.array([[1.0, 0.0], centroid]), np.array([centroid, [0.0, 1.0]])
    return np.concatenate([share @ one, share @ two], axis=1)


def _folded(place: Floats) -> Floats:
    """Returns places in a unit square, (v, k, 2), folded into the triangle below its diagonal."""
    return np.where(place.sum(axis=2, keepdims=True) > 1.0, 1.0 - place, place)


def _scattered(variants: int, count: int) -> Floats:
    """Returns places that fill a unit square, shape (variants, count, 2).

    Successive parts of one sequence of low discrepancy, the multiples of 1/g and 1/g^2 with g^3 =
    g + 1: a line divides them as it does the area, however it runs, and the errors of the variants
    cancel.
    """
    number = np.arange(variants * count).reshape(variants, count, 1)
    return np.asarray((0.5 + number / PLASTIC_NUMBER ** np.array([1.0, 2.0])) % 1.0)


PLASTIC_NUMBER = 1.32471795724474602596
"""The root g of g^3 = g + 1."""

_CONGRUENT = np.array([[[1.0, 1.0], [4.0, 1.0], [1.0, 4.0], [2.0, 2.0]]]) / 6.0
"""Barycentric coordinates of the centroids of four congruent parts of a triangle."""

_SQUARES = np.array([[[1.0, 1.0], [3.0, 1.0], [1.0, 3.0], [3.0, 3.0]]]) / 4.0
"""The middles of four equal parts of a parallelogram."""

EVEN: Coordinates = {
    "segment": _intervals(4), "triangle": _triangles(_CONGRUENT), "parallelogram": _SQUARES
}  # fmt: skip
"""Samples over which the soil's displacement is averaged: linear functions are exact."""

DENSE: Coordinates = {
    "segment": _intervals(256),
    "triangle": _triangles(_folded(_scattered(16, 128))),
    "parallelogram": _scattered(16, 256),
}
"""Samples at the edge of the soil."""


@dataclass(frozen=True)
class SurfaceParts:
    """n quadrature points of a surface and the parts of it that they stand for.

    Attributes:
        position: [length], shape (n, dim).
        normal: unit, into the soil, shape (n, dim).
        tributary: parts [length], see `QuadraturePoints`, shape (n, dim, dim).
        whole: whether in space the parts are the parallelograms of their edges, and not the parts
            of triangles.
    """

    position: Floats
    normal: Floats
    tributary: Floats
    whole: bool = False

    @property
    def shape(self) -> str:
        """Of the parts, as in `Coordinates`."""
        if self.position.shape[1] == 2:
            return "segment"
        return "parallelogram" if self.whole else "triangle"

    def of(self, chosen: Integers) -> SurfaceParts:
        """Returns the chosen points, shape (k,)."""
        position, normal = self.position[chosen], self.normal[chosen]
        return SurfaceParts(position, normal, self.tributary[chosen], self.whole)


@dataclass(frozen=True)
class Measured:
    """The soil opposite to n quadrature points of a surface.

    Attributes:
        gap: [length], shape (n,), see `measure_gap`.
        point: material point that owns the soil's surface there, -1 without soil, shape (n,); its
            index in the process that owns the place.
        share: of the point's tributary part that is opposite soil [-], 0 to 1, shape (n,).
        shift: from the point to the middle of this share [length], shape (n, dim); 0 where it is
            the whole part, or nothing.
    """

    gap: Floats
    point: Integers
    share: Floats
    shift: Floats

    def of(self, chosen: Integers) -> Measured:
        """Returns that of the chosen points, shape (k,)."""
        gap, point = self.gap[chosen], self.point[chosen]
        return Measured(gap, point, self.share[chosen], self.shift[chosen])


@dataclass(frozen=True)
class Samples:
    """s positions on the parts of a surface: whose part, where, and the soil opposite to them.

    Attributes:
        part: number of the part, shape (s,).
        position: [length], shape (s, dim).
        gap: [length], shape (s,), see `measure_gap`.
        point: material point, -1 without soil, shape (s,).
    """

    part: Integers
    position: Floats
    gap: Floats
    point: Integers


def sampled(
    parts: SurfaceParts, coordinates: Coordinates, measure_gap: Measure, turn: Integers
) -> Samples:
    """Returns samples of each part, the same number on each: `EVEN` or `DENSE` ones.

    turn: number of each part, shape (n,), which says what variant it has.
    """
    places = part_samples(parts, coordinates, turn)
    count, samples, dim = places.shape
    normal = np.repeat(parts.normal, samples, axis=0)
    place = places.reshape(-1, dim)
    return Samples(
        np.repeat(np.arange(count), samples), place, *measure_gap(place, normal, ROUND_OFF)
    )


def measure(
    parts: SurfaceParts, measure_gap: Measure, places: OwnedPlaces | None = None
) -> Measured:
    """Returns the soil opposite to quadrature points of a surface.

    Where a point is opposite soil and a point near is not, or the reverse, its share is measured at
    several positions of its tributary part. A point that is opposite soil only with a part of
    it has the gap and the material point of the nearest soil.

    places: the points' owners, each of which measures; this process alone if not given.
    """
    if places is None:
        places = OwnedPlaces(SERIAL, np.zeros(len(parts.position), dtype=np.int64))
    here = parts.of(places.own)
    gap, point = places.of_all(*measure_gap(here.position, here.normal, WIDENING))
    found = point >= 0
    share = found.astype(np.float64)
    edge = at_edge(parts.position, found)
    if len(edge) == 0:
        return Measured(gap, point, share, np.zeros_like(parts.position))
    at_edges = places.of(edge)
    turn = at_edges.own
    own = edge[turn]
    samples = sampled(parts.of(own), DENSE, measure_gap, turn)
    shape = (len(own), DENSE[parts.shape].shape[1])
    of_samples, sampled_point = (each.reshape(shape) for each in (samples.gap, samples.point))
    opposite = covered(sampled_point >= 0, parts.position.shape[1])
    own_share = opposite.mean(axis=1)
    away = samples.position.reshape(*shape, parts.position.shape[1]) - parts.position[own, None]
    own_shift = np.einsum("ns,nsi->ni", opposite, away)
    own_shift /= np.maximum(opposite.sum(axis=1), 1)[:, None]
    own_shift[own_share == 1.0] = 0.0
    nearest = np.where(sampled_point >= 0, of_samples, np.inf).argmin(axis=1)
    rows = np.arange(len(own))
    partly = ~found[own] & (own_share > 0.0)
    nothing = found[own] & (own_share == 0.0)
    own_gap = np.where(partly, of_samples[rows, nearest], np.where(nothing, np.inf, gap[own]))
    own_point = np.where(partly, sampled_point[rows, nearest], np.where(nothing, -1, point[own]))
    shift = np.zeros_like(parts.position)
    of_edge = at_edges.of_all(own_share, own_gap, own_point, own_shift)
    share[edge], gap[edge], point[edge], shift[edge] = of_edge
    return Measured(gap, point, share, shift)


def at_edge(position: Floats, found: Flags) -> Integers:
    """Returns the points with a neighbour of the other kind, shape (k,).

    position: [length], shape (n, dim). found: kind of each point, shape (n,).
    """
    if found.all() or not found.any():
        return np.zeros(0, dtype=np.int64)
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS[position.shape[1]] + 1, len(position))
    _, neighbour = cKDTree(position).query(position, k=count)
    return np.flatnonzero((found[neighbour] != found[:, None]).any(axis=1))


def covered(found: Flags, dim: int) -> Flags:
    """Returns which samples of parts are opposite soil, (n, samples), from which have found any.

    In the plane those between two that have: what is between them is a crack.
    """
    if dim == 3:
        return found
    before = np.maximum.accumulate(found, axis=1)
    return np.asarray(before & np.maximum.accumulate(found[:, ::-1], axis=1)[:, ::-1])


def part_samples(
    parts: SurfaceParts, coordinates: Coordinates, turn: Integers | None = None
) -> Floats:
    """Returns positions on tributary parts, shape (n, samples, dim); see `sampled`."""
    corner = parts.position + parts.tributary[:, 0]
    variants = coordinates[parts.shape]
    number = np.arange(len(corner)) if turn is None else turn
    along = variants[number % len(variants)]
    return np.asarray(corner[:, None] + along @ parts.tributary[:, 1:])
