# SPDX-License-Identifier: BSD-3-Clause
"""Gaps at the quadrature points of a surface, and how much of their parts is opposite soil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.contact.gap import WIDENING

SAMPLES_AT_EDGE = {2: 64, 3: 6}
"""Samples along each edge of a part at the edge of the soil, by dimension."""

SAMPLES_OF_TRACE = {2: 4, 3: 2}
"""Samples along each edge of a part over which the soil's displacement is averaged."""

ROUND_OFF = 1e-6
"""Share by which domains are wider across lines that measure where the soil ends: the widening with
which no line slips between two domains would make the soil longer."""

NEIGHBOURS = {2: 7, 3: 12}
"""Number of nearest points that decide whether a point is at the edge of the soil. Pieces of a
surface that the grid has cut differ in size: all of the nearest points may lie on one side."""

Measure = Callable[[Floats, Floats, float], tuple[Floats, Integers]]
"""Returns gaps and material points at positions with normals for a widening, see `measure_gap`."""


@dataclass(frozen=True)
class SurfaceParts:
    """n quadrature points of a surface and the parts of it that they stand for.

    Attributes:
        position: [length], shape (n, dim).
        normal: unit, into the soil, shape (n, dim).
        tributary: parts [length], see `QuadraturePoints`, shape (n, dim, dim).
    """

    position: Floats
    normal: Floats
    tributary: Floats

    def of(self, chosen: Integers) -> SurfaceParts:
        """Returns the chosen points, shape (k,)."""
        return SurfaceParts(self.position[chosen], self.normal[chosen], self.tributary[chosen])


@dataclass(frozen=True)
class Measured:
    """The soil opposite to n quadrature points of a surface.

    Attributes:
        gap: [length], shape (n,), see `measure_gap`.
        point: material point that owns the soil's surface there, -1 without soil, shape (n,).
        share: of the point's tributary part that is opposite soil [-], 0 to 1, shape (n,).
    """

    gap: Floats
    point: Integers
    share: Floats

    def of(self, chosen: Integers) -> Measured:
        """Returns that of the chosen points, shape (k,)."""
        return Measured(self.gap[chosen], self.point[chosen], self.share[chosen])


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


def sampled(parts: SurfaceParts, per_edge: Mapping[int, int], measure_gap: Measure) -> Samples:
    """Returns samples evenly distributed on each part, the same number on each.

    per_edge: along each edge of a part, by dimension.
    """
    places = part_samples(parts.position, parts.tributary, per_edge)
    count, samples, dim = places.shape
    normal = np.repeat(parts.normal, samples, axis=0)
    place = places.reshape(-1, dim)
    return Samples(
        np.repeat(np.arange(count), samples), place, *measure_gap(place, normal, ROUND_OFF)
    )


def measure(parts: SurfaceParts, measure_gap: Measure) -> Measured:
    """Returns the soil opposite to quadrature points of a surface.

    Where a point is opposite soil and a point near is not, or the reverse, its share is measured at
    several positions of its tributary part. Of a point that is not opposite soil itself, but in
    part, gap and material point are those of the nearest soil.
    """
    gap, point = measure_gap(parts.position, parts.normal, WIDENING)
    found = point >= 0
    share = found.astype(np.float64)
    edge = at_edge(parts.position, found)
    if len(edge) == 0:
        return Measured(gap, point, share)
    samples = sampled(parts.of(edge), SAMPLES_AT_EDGE, measure_gap)
    of_samples, owner = (each.reshape(len(edge), -1) for each in (samples.gap, samples.point))
    share[edge] = covered(owner >= 0, parts.position.shape[1]).mean(axis=1)
    nearest = np.where(owner >= 0, of_samples, np.inf).argmin(axis=1)
    rows = np.arange(len(edge))
    partly = ~found[edge] & (share[edge] > 0.0)
    gap[edge[partly]] = of_samples[rows, nearest][partly]
    point[edge[partly]] = owner[rows, nearest][partly]
    nothing = found[edge] & (share[edge] == 0.0)
    gap[edge[nothing]], point[edge[nothing]] = np.inf, -1
    return Measured(gap, point, share)


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


def part_samples(position: Floats, tributary: Floats, per_edge: Mapping[int, int]) -> Floats:
    """Returns positions on tributary parts, shape (n, samples, dim); see `sampled`."""
    dim = position.shape[1]
    count = per_edge[dim]
    along = (np.arange(count) + 0.5) / count
    grid = np.stack(np.meshgrid(*[along] * (dim - 1), indexing="ij"), axis=-1).reshape(-1, dim - 1)
    corner = position + tributary[:, 0]
    return np.asarray(corner[:, None] + np.einsum("sk,nki->nsi", grid, tributary[:, 1:]))
