# SPDX-License-Identifier: BSD-3-Clause
"""Elements of a mesh that overlap, so that the sum of their volumes counts material twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.block import Block, simplices
from tilth.bodies.covering import MOST_LINES, fault_along, lines_in_space
from tilth.bodies.request import Request
from tilth.bodies.stl_file import merged
from tilth.bodies.vertical_lines import crossed_by_lines
from tilth.variation.tables import place_text

SAME_NODE = 1e-10
"""Nodes nearer than this, over the largest extent or coordinate, are one."""

FACES: dict[str, list[list[int]]] = {
    "triangle": [[0, 1], [1, 2], [2, 0]],
    "quadrilateral": [[0, 1], [1, 2], [2, 3], [3, 0]],
    "tetrahedron": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    "hexahedron": [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ],
}
"""Corners of the faces (2D: edges) of elements, outwards (anticlockwise) for a positive volume."""


def require_elements_apart(blocks: Sequence[Block], file: str, request: Request) -> None:
    """Refuses a mesh whose elements overlap.

    Args:
        blocks: the elements, of positive volume.
        file: with the mesh.
        request: names the body.

    Raises:
        BadInput: names elements at a place that several of them cover.
    """
    facets, vertex = _outer_facets(blocks)
    extent = float(np.ptp(vertex, axis=0).max())
    if vertex.shape[1] == 2:
        start, end = np.swapaxes(vertex[facets], 0, 1)
        x = _lines_in_plane(np.unique(vertex[facets.ravel(), 0]))
        crossing = _crossed_edges(start, end, x)
        fault = fault_along(*crossing, x[:, None], extent)
    else:
        corner = vertex[facets]
        at = lines_in_space(corner)
        line, _, height, sign = crossed_by_lines(corner, at)
        fault = fault_along(line, height, sign, at, extent)
    if fault is None:
        return
    names = list(_elements_at(blocks, fault.place))
    more = f" and {len(names) - 2} more" if len(names) > 2 else ""
    cover = f"{' and '.join(names[:2])}{more} cover the same material"
    if len(names) < 2:
        cover = "one folds over itself"
    raise request.refused(
        f"elements of the mesh overlap: {cover} at {place_text(fault.place)}, which would count "
        f"{fault.times} times",
        "mesh the body without overlaps (in Gmsh `Coherence;` or BooleanFragments cut parts where "
        "they meet), or give `group`, and the other part as a body of its own",
        "shape.file",
        file,
    )


def _lines_in_plane(x: Floats) -> Floats:
    """Returns places of lines between the distinct coordinates x of nodes, and close to these."""
    low, high = x[:-1], x[1:]
    step = -(-len(low) // MOST_LINES) or 1
    low, high = low[::step], high[::step]
    return np.unique(np.concatenate([low + share * (high - low) for share in (0.01, 0.41, 0.99)]))


def _crossed_edges(start: Floats, end: Floats, x: Floats) -> tuple[Integers, Floats, Floats]:
    """Returns where vertical lines at increasing x (m,) cross edges, anticlockwise, (n, 2) each.

    Numbers of the lines, heights, and signs as of `crossed_by_lines`.
    """
    low, high = np.minimum(start[:, 0], end[:, 0]), np.maximum(start[:, 0], end[:, 0])
    first, stop = np.searchsorted(x, low, side="right"), np.searchsorted(x, high, side="left")
    count = np.maximum(stop - first, 0)
    edge = np.repeat(np.arange(len(start)), count)
    line = first[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    run = (end - start)[edge]
    height = start[edge, 1] + (x[line] - start[edge, 0]) * run[:, 1] / run[:, 0]
    return line, height, -np.sign(run[:, 0])


def _outer_facets(blocks: Sequence[Block]) -> tuple[Integers, Floats]:
    """Returns the facets that elements of a mesh do not share back to back, and the vertices.

    Nodes at the same place are one. A facet with two elements on the same side comes twice.

    Returns:
        Numbers of the vertices of edges (2D) or triangles, outwards, shape (n, d); the vertices,
        shape (m, d).
    """
    used, number = np.unique(
        np.concatenate([block.nodes.ravel() for block in blocks]), return_inverse=True
    )
    coordinates = np.empty((len(used), blocks[0].corners.shape[2]))
    coordinates[number] = np.concatenate(
        [block.corners.reshape(-1, coordinates.shape[1]) for block in blocks]
    )
    vertex, own = merged(coordinates[:, None], SAME_NODE)
    number = own[number.ravel(), 0]
    by_size: dict[int, list[Integers]] = {}
    first = 0
    for block in blocks:
        nodes = number[first : first + block.nodes.size].reshape(block.nodes.shape)
        first += block.nodes.size
        for face in FACES[block.element.name]:
            by_size.setdefault(len(face), []).append(nodes[:, face])
    found = []
    for size, parts in by_size.items():
        facet = _unpaired(np.concatenate(parts))
        found += [facet] if size < 4 else [facet[:, [0, 1, 2]], facet[:, [0, 2, 3]]]
    return np.concatenate(found), vertex


def _unpaired(facet: Integers) -> Integers:
    """Returns facets (n, k) less pairs of the same vertices in opposite order."""
    k = facet.shape[1]
    turn = (facet.argmin(axis=1)[:, None] + np.arange(k)) % k
    turned = np.take_along_axis(facet, turn, axis=1)  # the least vertex first
    forward = facet[:, 0] < facet[:, 1] if k == 2 else turned[:, 1] < turned[:, -1]
    alike = turned if k == 2 else np.where(forward[:, None], turned, _opposite(turned))
    vertices = int(facet.max()) + 1
    key = alike[:, 0] * vertices + alike[:, 1]
    if k > 2:  # three vertices tell which facet it is; the numbers of their pairs fit in 64 bits
        key = np.unique(key, return_inverse=True)[1].ravel() * vertices + alike[:, -1]
    _, first, number = np.unique(key, return_index=True, return_inverse=True)
    net = np.bincount(number.ravel(), np.where(forward, 1.0, -1.0)).astype(np.int64)
    left = alike[first]
    return np.repeat(np.where(net[:, None] > 0, left, _opposite(left)), np.abs(net), axis=0)


def _opposite(facet: Integers) -> Integers:
    """Returns facets (n, k) seen from the other side; of three vertices or more the first stays."""
    return facet[:, ::-1] if facet.shape[1] == 2 else np.roll(facet[:, ::-1], 1, axis=1)


def _elements_at(blocks: Sequence[Block], place: Floats) -> Iterator[str]:
    """Yields the names of the elements that cover a place (d,)."""
    for block in blocks:
        parts = simplices(block)
        edges = np.swapaxes(parts[:, 1:] - parts[:, :1], 1, 2)
        share = np.linalg.solve(edges, (place - parts[:, 0])[..., None])[..., 0]
        hit = (share >= 0.0).all(axis=1) & (share.sum(axis=1) <= 1.0)
        for number in np.unique(np.flatnonzero(hit) % len(block.corners)):
            yield block.element_name(int(number))
