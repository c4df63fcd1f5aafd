# SPDX-License-Identifier: BSD-3-Clause
"""Gaps at the quadrature points of a surface, and how much of their parts is opposite soil."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers

SAMPLES = {2: 16, 3: 4}
"""Positions along each edge of a tributary part at the edge of the soil, by dimension."""

NEIGHBOURS = {2: 2, 3: 8}
"""Number of nearest points that decide whether a point is at the edge of the soil."""

Measure = Callable[[Floats, Floats], tuple[Floats, Integers]]
"""Returns gaps and material points at positions with normals, see `measure_gap`."""


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


def measure(position: Floats, normal: Floats, tributary: Floats, measure_gap: Measure) -> Measured:
    """Returns the soil opposite to quadrature points of a surface.

    Where a point is opposite soil and a neighbour is not, or the reverse, its share is measured at
    several positions of its tributary part. Of a point that is not opposite soil itself, but in
    part, gap and material point are those of the nearest soil.

    Args:
        position: of the points [length], shape (n, dim).
        normal: unit, into the soil, shape (n, dim).
        tributary: parts of the points [length], see `QuadraturePoints`, shape (n, dim, dim).
        measure_gap: measures gaps.
    """
    gap, point = measure_gap(position, normal)
    found = point >= 0
    share = found.astype(np.float64)
    edge = at_edge(position, found)
    if len(edge) == 0:
        return Measured(gap, point, share)
    places = part_samples(position[edge], tributary[edge])
    count, samples, dim = places.shape
    normals = np.repeat(normal[edge], samples, axis=0)
    of_samples, owner = measure_gap(places.reshape(-1, dim), normals)
    of_samples, owner = of_samples.reshape(count, samples), owner.reshape(count, samples)
    share[edge] = (owner >= 0).mean(axis=1)
    nearest = np.where(owner >= 0, of_samples, np.inf).argmin(axis=1)
    rows = np.arange(count)
    partly = ~found[edge] & (share[edge] > 0.0)
    gap[edge[partly]] = of_samples[rows, nearest][partly]
    point[edge[partly]] = owner[rows, nearest][partly]
    nothing = found[edge] & (share[edge] == 0.0)
    gap[edge[nothing]], point[edge[nothing]] = np.inf, -1
    return Measured(gap, point, share)


def at_edge(position: Floats, found: npt.NDArray[np.bool_]) -> Integers:
    """Returns the points with a neighbour of the other kind, shape (k,).

    position: [length], shape (n, dim). found: kind of each point, shape (n,).
    """
    if found.all() or not found.any():
        return np.zeros(0, dtype=np.int64)
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS[position.shape[1]] + 1, len(position))
    _, neighbour = cKDTree(position).query(position, k=count)
    return np.flatnonzero((found[neighbour] != found[:, None]).any(axis=1))


def part_samples(position: Floats, tributary: Floats) -> Floats:
    """Returns evenly distributed positions on tributary parts, shape (n, samples, dim)."""
    dim = position.shape[1]
    count = SAMPLES[dim]
    along = (np.arange(count) + 0.5) / count
    grid = np.stack(np.meshgrid(*[along] * (dim - 1), indexing="ij"), axis=-1).reshape(-1, dim - 1)
    corner = position + tributary[:, 0]
    return np.asarray(corner[:, None] + np.einsum("sk,nki->nsi", grid, tributary[:, 1:]))
