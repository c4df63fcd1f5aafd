# SPDX-License-Identifier: BSD-3-Clause
"""Where a boundary that holds soil ends and the soil goes on: the end of a footing inside a cell.

There the span of its constraints would jump while the end moves through the cell: a vertex beyond
the end, on the next line of the grid, held the soil as far as there as soon as the end had passed
the middle of the cell. If the boundary moves little, vertices beyond the end or just before it have
no patch of their own (docs/decisions/0047-ends-inside-a-cell.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.boundaries.surfaces.patches import FARTHEST, LEAST_COSINE
from tilth.geometry.protocol import Facets, Geometry

BEYOND = 0.25
"""Distance in cells beyond the end at which there is soil if the soil goes on."""

BENT = 0.8
"""Least distance of the place beyond from the boundary, over that from the end: where a boundary
only bends it is less. The sine of 53 degrees."""

INSIDE = 0.3
"""Least distance in cells of a vertex before the end for a patch of its own. At 0.25 to 0.35 the
load of a footing hardly depends on whether it has one: there it may come in."""

FARTHEST_MOTION = 0.5
"""Greatest motion of a boundary in cells with which vertices at its ends have no patch of their
own: after a longer one, soil that these do not hold has flowed past the boundary."""

LEAST_WIDTH = 3.0
"""Least width of such a boundary in cells: then two vertices at least are inside its ends. With one
nothing would keep the soil under it from turning."""


@dataclass(frozen=True)
class Ends:
    """k ends of a boundary: points in the plane, lines in space.

    Attributes:
        corner: their corners [length], shape (k, dim - 1, dim).
        beyond: places beyond their middles, where the boundary would go on [length], (k, dim).
        normal: of the boundary, unit, shape (k, dim).
    """

    corner: Floats
    beyond: Floats
    normal: Floats

    def of(self, kept: Flags) -> Ends:
        """Returns those with the flags `kept`, shape (k,)."""
        return Ends(self.corner[kept], self.beyond[kept], self.normal[kept])

    @property
    def outward(self) -> Floats:
        """Vectors from the middles to the places beyond [length], shape (k, dim)."""
        return np.asarray(self.beyond - self.corner.mean(axis=1))

    def parts(self) -> Floats:
        """Returns small parts of the boundary beyond, as in `QuadraturePoints`, (k, dim, dim)."""
        outward = self.outward
        edges = [outward] if outward.shape[1] == 2 else [outward, np.cross(self.normal, outward)]
        edge = 0.5 * np.stack(edges, axis=1)
        return np.concatenate([-0.5 * edge.sum(axis=1, keepdims=True), edge], axis=1)

    def distance(self, position: Floats, normal: Floats) -> Floats:
        """Returns how far places (m, dim) are beyond the nearest end [length], shape (m,).

        Negative before it; ends of parts with other normals than `normal`, (m, dim), do not count.
        """
        first, along = self.corner[:, 0], self.corner[:, -1] - self.corner[:, 0]
        squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
        unit = self.outward / np.linalg.norm(self.outward, axis=1)[:, None]
        offset = position[:, None] - first
        share = np.clip((offset * along).sum(axis=2) / squared, 0.0, 1.0)
        offset = offset - share[:, :, None] * along
        away = np.linalg.norm(offset, axis=2)
        away[normal @ self.normal.T < LEAST_COSINE] = np.inf
        nearest = away.argmin(axis=1)
        number = np.arange(len(position))
        across = (offset[number, nearest] * unit[nearest]).sum(axis=1)
        return np.where(np.isfinite(away[number, nearest]), across, -np.inf)


def find_ends(geometry: Geometry, facets: Facets, cell: float) -> Ends:
    """Returns where a boundary ends: sides of its facets beyond which it does not go on.

    Args:
        geometry: bounded.
        facets: all of it.
        cell: edge of a cell [length].
    """
    dim = geometry.dim
    # the sides of the facets, each opposite the corner of the same number
    others = np.array([[j for j in range(dim) if j != i] for i in range(dim)])
    side = facets.corner[:, others]
    outward = side.mean(axis=2) - facets.corner
    along = side[:, :, -1] - side[:, :, 0]
    squared = np.maximum((along**2).sum(axis=2, keepdims=True), np.finfo(float).tiny)
    outward = outward - (outward * along).sum(axis=2, keepdims=True) / squared * along
    outward = outward / np.linalg.norm(outward, axis=2, keepdims=True)
    beyond = side.mean(axis=2) + BEYOND * cell * outward
    normal = np.broadcast_to(facets.normal[:, None], beyond.shape)
    found = Ends(side.reshape(-1, dim - 1, dim), beyond.reshape(-1, dim), normal.reshape(-1, dim))
    return found.of(np.abs(geometry.distance(found.beyond)) >= BENT * BEYOND * cell)


def width_of(facets: Facets) -> float:
    """Returns the extent of a boundary, in space the second one, along its own axes [length]."""
    corner = facets.corner - facets.corner.mean(axis=(0, 1))
    count = corner.shape[1]
    edge = corner[:, 1:] - corner[:, :1]
    # of segments, twice that of triangles
    area = np.sqrt(np.abs(np.linalg.det(edge @ np.swapaxes(edge, 1, 2))))
    middle = corner.mean(axis=1)
    # the second moments are exact, so that the axes do not depend on how the boundary is divided
    moment = np.einsum("f,fci,fcj->ij", area, corner, corner)
    moment += count**2 * np.einsum("f,fi,fj->ij", area, middle, middle)
    first = area @ middle
    moment -= count * (count + 1) * np.outer(first, first) / area.sum()
    axes = np.linalg.eigh(moment)[1]
    extent = np.sort(np.ptp(corner.reshape(-1, count) @ axes, axis=0))[::-1]
    return float(extent[count - 2])


def without_vertices_near_ends(
    multiplier: Integers,
    gone: Flags,
    position: Floats,
    normal: Floats,
    overlay: Integers,
    cell: float,
) -> Integers:
    """Returns the multiplier of each point, (n,), without those that are `gone`, (m,).

    Their points join those of the nearest others.

    Args:
        multiplier: of each point, shape (n,).
        gone: of the m multipliers.
        position: [length], shape (n, dim).
        normal: unit, shape (n, dim).
        overlay: of the soil of each point, shape (n,).
        cell: the largest edge of a cell [length].
    """
    from scipy.spatial import cKDTree

    # points with other normals are farther apart
    place = np.concatenate([position, cell * normal], axis=1)
    joined, leaves = multiplier.copy(), gone[multiplier]
    for number in np.unique(overlay[leaves]):
        own, others = (np.flatnonzero((overlay == number) & of) for of in (leaves, ~leaves))
        if len(others):
            far, nearest = cKDTree(place[others]).query(place[own])
            near = far <= FARTHEST * cell
            joined[own[near]] = multiplier[others[nearest[near]]]
    return joined
