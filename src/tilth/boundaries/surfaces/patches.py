# SPDX-License-Identifier: BSD-3-Clause
"""Patches of the multipliers that are hardly covered by soil join their neighbours."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Flags, Floats, Integers

LEAST_AREA = 0.3
"""Least area of a patch in faces of a cell: the traction of a smaller one would oscillate."""

EQUAL_AREA = 1.0 / 64.0
"""Difference of the areas of two patches in faces of a cell below which they count as equal: what
joins what must depend neither on round-off nor on soil that ends a hair beyond a line of the grid.
The areas of points placed regularly, such as a quarter of a face, are multiples of it."""

EQUAL_DISTANCE = 1e-6
"""The same of two distances between points, in cells."""

SLIVER = 0.02
"""Area of a patch in faces of a cell below which it has no contact: soil that stands out beyond
the edge of a body by as little, as beside an indented part of its surface, would be held there by
a stress that is not soil's."""

LEAST_COSINE = 0.5
"""Least cosine between the normals of points in one patch, as in `vertices.hpp`."""

FARTHEST = 1.5
"""Greatest distance in cells of the point through which a patch joins another one."""


def is_sliver(multiplier: Integers, weight: Floats, size: Floats) -> Flags:
    """Returns which points belong to a sliver, shape (n,); arguments as in `without_small`."""
    area = np.bincount(multiplier, weight)
    return np.asarray((area < SLIVER * _least_face(multiplier, size, len(area)))[multiplier])


def _least_face(multiplier: Integers, size: Floats, count: int) -> Floats:
    """Returns the smallest face of a cell at each of `count` patches [length^(dim - 1)]."""
    edge = np.full(count, np.inf)
    np.minimum.at(edge, multiplier, size.min(axis=1))
    return np.asarray(edge ** (size.shape[1] - 1))


def surrounded(position: Floats, others: Floats, reach: float) -> Flags:
    """Returns which positions (n, dim) have others (m, dim) within reach on all sides, shape (n,).

    The unit vectors to them cancel at least by half.
    """
    from scipy.spatial import cKDTree

    found = np.zeros(len(position), dtype=bool)
    for number, near in enumerate(cKDTree(others).query_ball_point(position, reach)):
        vectors = others[near] - position[number]
        length = np.linalg.norm(vectors, axis=1)
        units = vectors[length > 0.0] / length[length > 0.0, None]
        found[number] = len(units) > 1 and np.linalg.norm(units.sum(axis=0)) <= 0.5 * len(units)
    return found


def without_small(
    multiplier: Integers,
    position: Floats,
    normal: Floats,
    weight: Floats,
    size: Floats,
    apart: Flags | None = None,
) -> Integers:
    """Returns the multiplier of each point, without those of small patches, numbered anew, (n,).

    A small patch joins that of the nearest point beyond it with a similar normal; it stays if
    there is none near. The smallest ones come first, of those alike the first by its number.

    Args:
        multiplier: of each point, shape (n,).
        position: [length], shape (n, dim).
        normal: unit, shape (n, dim).
        weight: area of each point's part opposite soil [length^(dim - 1)], shape (n,).
        size: of the points' cells [length], shape (n, dim).
        apart: whether the point's patch joins no other one, nor is joined, shape (n,).
    """
    if len(multiplier) == 0:
        return multiplier
    from scipy.spatial import cKDTree

    multiplier = multiplier.copy()
    area = np.bincount(multiplier, weight)
    face = _least_face(multiplier, size, len(area))
    least = LEAST_AREA * face
    if apart is None:
        apart = np.zeros(len(multiplier), dtype=bool)
    least[multiplier[apart]] = 0.0
    small = np.argsort(np.round(area / (EQUAL_AREA * face)), kind="stable")
    for number in small[area[small] < least[small]]:
        if area[number] >= least[number]:  # it has grown
            continue
        own, others = (
            np.flatnonzero(multiplier == number),
            np.flatnonzero((multiplier != number) & ~apart),
        )
        if len(own) == 0 or len(others) == 0:
            continue
        cell = float(size[own].max())
        reach = FARTHEST * cell
        near = cKDTree(position[others]).query_ball_point(position[own], reach)
        best, nearest = -1, np.inf
        for point, found in zip(own, near, strict=True):
            candidates = others[found]
            alike = candidates[normal[candidates] @ normal[point] >= LEAST_COSINE]
            if len(alike) == 0:
                continue
            distance = np.linalg.norm(position[alike] - position[point], axis=1)
            as_near = alike[distance <= distance.min() + EQUAL_DISTANCE * cell]
            if distance.min() < nearest - EQUAL_DISTANCE * cell:
                nearest, best = float(distance.min()), int(multiplier[as_near].min())
        if best >= 0:
            multiplier[own] = best
            area[best] += area[number]
    return np.asarray(np.unique(multiplier, return_inverse=True)[1])
