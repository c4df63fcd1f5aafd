# SPDX-License-Identifier: BSD-3-Clause
"""Material points whose domains tile the elements of a mesh."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.block import Block
from tilth.bodies.corners import corner_signs, mean_half_edges, parallelepiped
from tilth.bodies.elements import Brick
from tilth.bodies.request import BodyPoints, Request

# Tiles per batch, to bound the memory.
TILES_PER_BATCH = 250_000


def tile_points(blocks: Sequence[Block], volumes: Sequence[Floats], request: Request) -> BodyPoints:
    """Returns the points of a mesh, with quadrilateral or hexahedral tiles of elements as domains.

    Quadrilaterals and hexahedra are divided into equal parts along their edges. Triangles and
    tetrahedra are divided into pieces of equal volume, and each piece between the centres of its
    edges and faces into three quadrilaterals or four hexahedra. Edges in the same row of elements
    get the same number of segments, so that the tiles of neighbours have common corners. This
    number is the mean of what the requested spacing requires in their elements, at least 1 (2 with
    triangles and tetrahedra). A point is the centroid of its tile. With "cpdi1" its domain is the
    parallelepiped (2D: parallelogram) with the directions of the tile's mean edges and its volume.

    volumes: volumes (2D: areas) of the elements of each block, shape (n,), > 0.
    Raises BadInput for too many points, and for a hexahedron with folded tiles.
    """
    dimension = len(request.cell_size)
    segments = _segments(blocks, volumes, request)
    numbers = [b.element.number_of_tiles(s) for b, s in zip(blocks, segments, strict=True)]
    request.check_number(float(sum(number.sum() for number in numbers)))
    total = int(sum(number.sum() for number in numbers))
    position, volume = np.empty((total, dimension)), np.empty(total)
    corner, half_length = np.empty((total, 2**dimension, dimension)), np.empty((total, dimension))
    start = 0
    for block, own, number in zip(blocks, segments, numbers, strict=True):
        first = start + (np.cumsum(number) - number).astype(np.int64)
        start += int(number.sum())
        for element, tiles in _tiles(block, own):
            where = (first[element][:, None] + np.arange(tiles.shape[1])).ravel()
            tile_corners = tiles.reshape(-1, 2**dimension, dimension)
            _check_folding(block, element, tile_corners, request)
            centroid, tile_volume = _domain(dimension).pieces(tile_corners, 1)
            position[where], volume[where] = centroid[:, 0], tile_volume[:, 0]
            tile_corners -= centroid
            edge = mean_half_edges(tile_corners)
            if request.basis == "cpdi1":
                edge *= (tile_volume / _box_volumes(edge)[:, None])[..., None] ** (1.0 / dimension)
                tile_corners = parallelepiped(edge)
            corner[where], half_length[where] = tile_corners, np.linalg.norm(edge, axis=2)
    group = np.concatenate(
        [np.repeat(b.group, own.astype(np.int64)) for b, own in zip(blocks, numbers, strict=True)]
    )
    volume *= request.circumference(position)
    return BodyPoints(position, volume, half_length, None, corner, group)


def _tiles(block: Block, segments: Floats) -> Iterator[tuple[Integers, Floats]]:
    """Yields batches of elements (m,) and corners of their tiles (m, tiles, 2^d, d), x fastest."""
    for cuts in np.unique(segments, axis=0):
        weight = block.element.tiles(tuple(int(cut) for cut in cuts))
        chosen = np.flatnonzero((segments == cuts).all(axis=1))
        for batch in np.array_split(chosen, math.ceil(len(chosen) * len(weight) / TILES_PER_BATCH)):
            yield batch, np.einsum("qcv,nvi->nqci", weight, block.corners[batch])


def _domain(dimension: int) -> Brick:
    """Returns the element whose corners are those of a domain, x fastest."""
    return Brick("domain", [], corner_signs(dimension).astype(np.int64))


def _check_folding(block: Block, element: Integers, tile_corners: Floats, request: Request) -> None:
    """Refuses domains that are folded at a corner or in the middle.

    element: rows in the block of the domains' elements; each has equally many domains.
    tile_corners: corners of the domains, shape (n, 2^d, d).
    """
    least = np.minimum(
        _domain(tile_corners.shape[2]).corner_jacobians(tile_corners).min(axis=1),
        _box_volumes(mean_half_edges(tile_corners)),
    )
    folded = np.flatnonzero(least <= 0.0)
    if len(folded):
        row = int(element[folded[0] * len(element) // len(tile_corners)])
        raise block.refused(row, "is degenerate: it folds between its corners", request)


def _box_volumes(half_edge: Floats) -> Floats:
    """Returns the volumes (n,) of parallelepipeds with these half edges (n, d, d)."""
    return np.asarray(2.0 ** half_edge.shape[2] * np.linalg.det(half_edge))


def spacing_of(block: Block, request: Request) -> Floats:
    """Returns the requested spacing in each element, the least within it, shape (n, d).

    Pieces with equal sides are not wider than a cell of a graded grid, which may be long.
    """
    spacing = request.spacing_within(block.corners.min(axis=1), block.corners.max(axis=1))
    if request.points_per_cell is None or not request.grid.graded:
        return spacing
    if request.has_corners and isinstance(block.element, Brick):
        return spacing
    shortest = (spacing * request.points_per_cell).min(axis=1, keepdims=True)
    return np.asarray(np.minimum(spacing, shortest))


def _segments(blocks: Sequence[Block], volumes: Sequence[Floats], request: Request) -> list[Floats]:
    """Returns the numbers of segments along each row of edges, (n, rows) for each block."""
    classes = _edge_classes(blocks)
    every = np.concatenate([own.ravel() for own in classes])
    # The mean of the power d, so that the number of tiles corresponds to their volume.
    power = len(request.cell_size)
    required = np.concatenate(
        [
            b.element.required_segments(b.corners, volume, spacing_of(b, request)).ravel()
            for b, volume in zip(blocks, volumes, strict=True)
        ]
    )
    mean = (np.bincount(every, required**power) / np.bincount(every)) ** (1.0 / power)
    step = np.ones(len(mean))
    for block, own in zip(blocks, classes, strict=True):
        np.maximum.at(step, own, block.element.least_segments)
    segments = step * np.maximum(np.rint(mean / step), 1.0)
    return [segments[own] for own in classes]


def _edge_classes(blocks: Sequence[Block]) -> list[Integers]:
    """Returns classes of edges with the same number of segments, (n, rows) for each block.

    Edges in the same row of an element are of one class, also through rows of other elements.
    """
    from scipy.sparse import coo_array  # take 0.2 s: only where there is such a mesh
    from scipy.sparse.csgraph import connected_components

    ends = [np.sort(block.nodes[:, block.element.edges], axis=-1) for block in blocks]
    pair = np.concatenate([end.reshape(-1, 2) for end in ends])
    different, number = np.unique(pair[:, 0] * (pair.max() + 1) + pair[:, 1], return_inverse=True)
    parts = np.split(number, np.cumsum([len(end.reshape(-1, 2)) for end in ends])[:-1])
    edges = [part.reshape(end.shape[:3]) for part, end in zip(parts, ends, strict=True)]
    links = np.concatenate(
        [
            np.stack(np.broadcast_arrays(edge[..., :1], edge[..., 1:]), axis=-1).reshape(-1, 2)
            for edge in edges
        ]
    )
    graph = coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), 2 * (len(different),))
    _, label = connected_components(graph, directed=False)
    return [label[edge[..., 0]].astype(np.int64) for edge in edges]
