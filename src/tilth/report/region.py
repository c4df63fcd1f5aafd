# SPDX-License-Identifier: BSD-3-Clause
"""The region that soil takes in the plane, as triangles between the corners of points' domains.

The triangles of each body are those of Delaunay that are as small as a domain (an alpha shape,
H. Edelsbrunner, D. Kirkpatrick, R. Seidel 1983). They close what parts of less than about a
domain's size leave open between them, but neither holes nor gaps that are wider, nor those
between bodies; `bridges.py` has what lies between bodies that stick together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.output.snapshot import SurfaceShape
from tilth.report.domains import outlines
from tilth.report.interpolation import values_at
from tilth.report.outline_surfaces import inside_of, of_bodies, vertices_along

_RADIUS = 1.25
"""Largest circumradius of a triangle over half the diagonal of a domain."""
_NOTCH_DEPTH, _NOTCH_LENGTH, _NOTCH_PASSES = 0.36, 2.4, 4
"""Depth and width of a step in the outline that is filled, over a domain's diagonal."""
_SMALL_HOLE = 2.0
"""Area of a hole that is none of the soil, over that of a domain."""
_SAME = 0.12
"""Distance of corners that count as one, over half the diagonal of a domain."""


@dataclass(frozen=True, eq=False)
class Part:
    """The region of one body."""

    vertex: Floats
    """Positions [length], shape (n, 2): the body's points first, then corners of their domains."""
    points: Integers
    """Numbers of these points, the first ones of the vertices."""
    triangle: Integers
    """Rows of ``vertex``, shape (m, 3), counter-clockwise."""
    mesh: Any
    """The triangulation of scipy, to find positions in it."""
    kept: Flags
    """Which of its triangles are in the region."""

    @property
    def area(self) -> float:
        """Area of the region [length^2]."""
        return float(areas_of(self.vertex[self.triangle]).sum())

    def outline(self) -> list[Floats]:
        """Returns the closed lines around the region and its holes, shapes (k, 2)."""
        edge = self.triangle[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        key = np.sort(edge, axis=1) @ np.array([len(self.vertex), 1])
        _, first, count = np.unique(key, return_index=True, return_counts=True)
        return [self.vertex[line] for line in _closed_lines(edge[first[count == 1]], self.vertex)]

    def values(self, position: Floats, values: Floats) -> Floats:
        """Returns a field's values at the vertices from those of all points, shape (n,)."""
        corner = values_at(position[self.points], values[self.points], self.vertex_beyond)
        return np.concatenate([values[self.points], corner])

    @property
    def vertex_beyond(self) -> Floats:
        """Vertices that are no points."""
        return self.vertex[len(self.points) :]


@dataclass(frozen=True, eq=False)
class Region:
    """The region of all bodies."""

    parts: tuple[Part, ...]
    bridges: tuple[Part, ...] = ()
    """What lies between bodies that stick together, under the parts; see `bridges_of`."""

    @classmethod
    def of(
        cls,
        position: Floats,
        corners: Floats,
        body_id: Integers,
        surfaces: Sequence[SurfaceShape] = (),
    ) -> Region:
        """Returns the region of points with domains.

        Args:
            position: of the points [length], shape (n, 2).
            corners: of their domains, relative to them [length], x fastest, shape (n, 4, 2).
            body_id: of the points, shape (n,); the regions of bodies are not joined.
            surfaces: tracked surfaces; where a body has one, its outline is there.
        """
        own = of_bodies(position, body_id, surfaces)
        bodies = [np.flatnonzero(body_id == body) for body in np.unique(body_id)]
        found = [
            part_of_domains(
                points, position[points], corners[points], own.get(int(body_id[points[0]]), [])
            )
            for points in bodies
        ]
        return cls(tuple(part for part in found if part is not None))

    @property
    def area(self) -> float:
        """Area of the region [length^2]; where bodies overlap it counts twice."""
        return sum(part.area for part in self.parts)

    def values_in(self, position: Floats, values: Floats, places: Floats) -> Floats:
        """Returns a field's values at places, shape (m,), of (m, 2); NaN outside of the region."""
        found = np.full(len(places), np.nan)
        for part in (*self.bridges, *self.parts):
            simplex = part.mesh.find_simplex(places)
            inside = simplex >= 0
            inside[inside] = part.kept[simplex[inside]]
            vertex = part.mesh.simplices[simplex[inside]]
            share = shares_of(part.vertex[vertex], places[inside])
            found[inside] = (share * part.values(position, values)[vertex]).sum(axis=1)
        return found


def _closed_lines(edge: Integers, vertex: Floats) -> list[list[int]]:
    """Returns closed lines that use each edge once; an even number of edges meets in each vertex.

    The direction of single edges, those of triangles without an area, may be wrong: a line has
    the direction of most of its length.
    """
    length = np.linalg.norm(vertex[edge[:, 1]] - vertex[edge[:, 0]], axis=1)
    at: dict[int, list[int]] = {}
    for number, ends in enumerate(edge.tolist()):
        for end in ends:
            at.setdefault(end, []).append(number)
    free = np.ones(len(edge), dtype=bool)
    lines = []
    for begin in range(len(edge)):
        if not free[begin]:
            continue
        line, along = [int(edge[begin, 0])], 0.0
        while going := [number for number in at[line[-1]] if free[number]]:
            chosen = next((number for number in going if edge[number, 0] == line[-1]), going[0])
            free[chosen] = False
            start, end = edge[chosen].tolist()
            forward = start == line[-1]
            line.append(end if forward else start)
            along += length[chosen] if forward else -length[chosen]
        lines.append(line if along >= 0.0 else line[::-1])
    return lines


def shares_of(corner: Floats, place: Floats) -> Floats:
    """Returns the weights of triangles' corners (n, 3, 2) at places (n, 2), shape (n, 3)."""
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    offset = place - corner[:, 0]
    twice = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    twice = np.where(twice == 0.0, 1.0, twice)
    one = (offset[:, 0] * second[:, 1] - offset[:, 1] * second[:, 0]) / twice
    two = (first[:, 0] * offset[:, 1] - first[:, 1] * offset[:, 0]) / twice
    return np.stack([1.0 - one - two, one, two], axis=1)


def areas_of(corner: Floats) -> Floats:
    """Returns the areas of triangles (n, 3, 2), positive if counter-clockwise."""
    first, second = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    return np.asarray(0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))


def part_of_polygons(polygon: Floats) -> Part | None:
    """Returns the region of one body from convex areas around its points, None if it has none.

    ``polygon``: their corners in order [length], shape (n, k, 2), the first or the last one
    repeated where they are fewer. The points of the part are the middles of the areas.
    """
    middle = 0.5 * (polygon.min(axis=1) + polygon.max(axis=1))
    half = np.linalg.norm(polygon - middle[:, None], axis=2).max(axis=1)
    half = np.maximum(half, float(np.median(half)))
    return _part_between(np.arange(len(middle)), middle, polygon, half, ())


def part_of_domains(
    points: Integers,
    position: Floats,
    corners: Floats,
    surfaces: Sequence[SurfaceShape] = (),
) -> Part | None:
    """Returns the region of points with domains as if of one body, None if it has none.

    Args:
        points: their numbers, shape (n,).
        position: of these [length], shape (n, 2).
        corners: of their domains, relative to them [length], x fastest, shape (n, 4, 2).
        surfaces: the body's tracked surfaces.
    """
    half = 0.5 * np.maximum(
        np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1),
        np.linalg.norm(corners[:, 2] - corners[:, 1], axis=1),
    )
    return _part_between(points, position, outlines(position, corners), half, surfaces)


def _part_between(
    points: Integers,
    position: Floats,
    polygon: Floats,
    half: Floats,
    surfaces: Sequence[SurfaceShape],
) -> Part | None:
    """Returns the region of points (n, 2) with areas around them, (n, k, 2), half as wide."""
    from scipy.spatial import Delaunay, QhullError

    typical = float(np.median(half))
    outer = _near_outline(position / typical, half / typical)
    corner = polygon[outer].reshape(-1, 2)
    corner, size = _distinct(corner, np.repeat(half[outer], polygon.shape[1]))
    if surfaces:
        within = inside_of(surfaces, corner, 3.0 * typical, 0.15 * typical)
        line = vertices_along(surfaces, 0.5 * typical)
        corner = np.concatenate([corner[within], line])
        size = np.concatenate([size[within], np.full(len(line), typical)])
    vertex, size = np.concatenate([position, corner]), np.concatenate([half, size])
    try:
        mesh = Delaunay((vertex - vertex.mean(axis=0)) / typical)
    except QhullError:
        return None
    triangle = _turned(vertex, mesh.simplices)
    kept = _kept(vertex[triangle], size[triangle].max(axis=1), mesh.neighbors)
    if surfaces:
        centre = vertex[triangle].mean(axis=1)
        kept &= inside_of(surfaces, centre, 3.0 * typical, 1e-6 * typical)
    return Part(vertex, points, triangle[kept], _Located(mesh, vertex, typical), kept)


def _near_outline(position: Floats, half: Floats) -> Integers:
    """Returns the points at the outline and next to those, by the triangles between points."""
    from scipy.spatial import Delaunay, QhullError

    try:
        mesh = Delaunay(position - position.mean(axis=0))
    except QhullError:  # fewer than three, or on a line
        return np.arange(len(position))
    triangle = mesh.simplices
    radius = _radii(position[triangle])[0]
    wide = (radius > half[triangle].min(axis=1)) | (mesh.neighbors < 0).any(axis=1)
    near = np.zeros(len(position), dtype=bool)
    near[triangle[wide]] = True
    near[triangle[near[triangle].any(axis=1)]] = True
    if len(mesh.coplanar):  # points where others are
        near[mesh.coplanar[:, 0]] = True
    return np.flatnonzero(near)


class _Located:
    """A triangulation in units of the domains, used with positions in those of the user."""

    def __init__(self, mesh: Any, vertex: Floats, scale: float) -> None:
        self._mesh, self._middle, self._scale = mesh, vertex.mean(axis=0), scale
        self.simplices = mesh.simplices

    def find_simplex(self, places: Floats) -> Integers:
        """Returns the triangles in which places lie, -1 where there is none."""
        found = self._mesh.find_simplex((places - self._middle) / self._scale, tol=1e-9)
        return np.asarray(found, dtype=np.int64)


def _distinct(corner: Floats, size: Floats) -> tuple[Floats, Floats]:
    """Returns the means of corners that nearly coincide, and the largest of their sizes."""
    step = _SAME * float(np.median(size))
    cell = np.floor((corner - corner.min(axis=0)) / step + 0.37).astype(np.int64)
    key = cell @ np.array([int(cell[:, 1].max()) + 1, 1])
    _, group, count = np.unique(key, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    mean = np.stack([np.bincount(group, axis) / count for axis in corner.T], axis=1)
    largest = np.zeros(len(count))
    np.maximum.at(largest, group, size)
    return mean, largest


def _turned(vertex: Floats, triangle: Integers) -> Integers:
    """Returns the triangles counter-clockwise."""
    clockwise = areas_of(vertex[triangle]) < 0.0
    return np.where(clockwise[:, None], triangle[:, ::-1], triangle).astype(np.int64)


def _kept(corner: Floats, size: Floats, neighbours: Integers) -> Flags:
    """Returns which triangles (n, 3, 2) are in the region; ``size``: half of a diagonal, (n,)."""
    radius, longest = _radii(corner)
    area = np.abs(areas_of(corner))
    kept = radius <= _RADIUS * size
    depth = 2.0 * area / np.maximum(longest, 1e-300)
    notch = (depth <= 2.0 * _NOTCH_DEPTH * size) & (longest <= 2.0 * _NOTCH_LENGTH * size)
    outside = neighbours < 0
    for _ in range(_NOTCH_PASSES):
        beside = kept[neighbours] & ~outside
        new = ~kept & notch & (beside.sum(axis=1) >= 2)
        if not new.any():
            break
        kept |= new
    return kept | _small_holes(kept, area, size, neighbours)


def _radii(corner: Floats) -> tuple[Floats, Floats]:
    """Returns the circumradii and the longest sides of triangles (n, 3, 2)."""
    side = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
    area = np.abs(areas_of(corner))
    return side.prod(axis=1) / np.maximum(4.0 * area, 1e-300), side.max(axis=1)


def _small_holes(kept: Flags, area: Floats, size: Floats, neighbours: Integers) -> Flags:
    """Returns the triangles of holes that are smaller than the domains around them."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n = len(kept)
    first = np.repeat(np.arange(n), 3)
    second = neighbours.reshape(-1)
    both = (second >= 0) & ~kept[first] & ~kept[second]
    graph = coo_array((np.ones(both.sum()), (first[both], second[both])), shape=(n, n))
    group = connected_components(graph, directed=False)[1]
    count = int(group.max(initial=-1)) + 1
    total = np.bincount(group, area, minlength=count)
    open_ = np.zeros(count, dtype=bool)
    open_[group[(neighbours < 0).any(axis=1)]] = True
    small = ~open_[group] & (total[group] <= _SMALL_HOLE * 2.0 * size**2)
    return np.asarray(small & ~kept)
