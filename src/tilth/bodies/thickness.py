# SPDX-License-Identifier: BSD-3-Clause
"""Thickness of a declared shape along vertical lines.

Where a vertical line crosses the outline of a shape, it enters or leaves it. With the heights z of
these crossings, each with a sign s (+1 where a line that goes up leaves, -1 where it enters), the
thickness between the heights a and b is the sum of s clip(z, a, b).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.block import Block, simplices
from tilth.bodies.forms import Form, WithHoles
from tilth.bodies.mesh import Elements
from tilth.bodies.polyhedron import Polyhedron
from tilth.bodies.terrain import HeightField
from tilth.model import Box, Circle, Cylinder, Polygon, Sphere
from tilth.model.shapes import DeclaredShape, side_signs

Crossing = tuple[float, Integers, Floats]
"""Sign [-], which lines cross, shape (k,), and the heights there [length], shape (k,)."""

SHIFT = (1e-9, 0.7e-9)
"""Shift of vertical lines through a mesh in 3D, over its extent, off the edges of its elements."""


@dataclass(frozen=True)
class Crossings:
    """Where vertical lines cross the outline of a shape.

    Attributes:
        lines: number of lines n.
        found: the crossings.
    """

    lines: int
    found: list[Crossing]

    def thickness(self, low: Floats, high: Floats) -> Floats:
        """Returns the thickness between two heights, low <= high [length], shape (n,) each."""
        total = np.zeros(self.lines)
        for sign, line, height in self.found:
            np.add.at(total, line, sign * np.clip(height, low[line], high[line]))
        return np.maximum(total, 0.0)

    def hit(self) -> Integers:
        """Returns which lines cross the outline, ascending."""
        lines = [line for _, line, _ in self.found]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *lines]))


def crossings_of(form: Form, place: Floats) -> Crossings:
    """Returns the crossings of vertical lines with a form.

    place: horizontal coordinates of the lines [length], shape (n, dim - 1).
    """
    functions: dict[type, Callable[[Any, Floats], Iterable[Crossing]]] = {
        Box: _of_box,
        Polygon: _of_polygon,
        Circle: _of_circle,
        Cylinder: _of_cylinder,
        Sphere: _of_sphere,
        Elements: lambda form, place: mesh_crossings(form.blocks, place).found,
        HeightField: _of_height_field,
        Polyhedron: _of_polyhedron,
        WithHoles: lambda form, place: crossings_of(form.whole, place).found,
    }
    found = list(functions[type(form)](form, place))
    holes = form.cavities() if isinstance(form, DeclaredShape) else ()
    for hole in form.holes if isinstance(form, WithHoles) else holes:
        inner = crossings_of(hole, place).found
        found += [(-sign, line, height) for sign, line, height in inner]
    return Crossings(len(place), found)


def mesh_crossings(blocks: list[Block], place: Floats) -> Crossings:
    """Returns the crossings with elements of a mesh; place as of `crossings_of`.

    Exact for elements with plane faces; a curved face counts as two triangles.
    """
    corners = np.concatenate([simplices(block) for block in blocks])
    of = _of_triangles if corners.shape[2] == 2 else _of_tetrahedra
    return Crossings(len(place), list(of(corners, place)))


def _between(low: Floats, high: Floats) -> Iterator[Crossing]:
    """Yields the crossings of a convex shape: where `high` exceeds `low`."""
    line = np.flatnonzero(high > low)
    yield -1.0, line, low[line]
    yield 1.0, line, high[line]


def _of_box(shape: Box, place: Floats) -> Iterator[Crossing]:
    """The line is inside where its coordinates along the box's axes are between 0 and the edges."""
    axes, lower = np.array(shape.axes), np.asarray(shape.lower)
    edge = np.asarray(shape.upper) - lower
    low, high = np.full(len(place), -np.inf), np.full(len(place), np.inf)
    foot = np.column_stack([place, np.zeros(len(place))]) - lower
    for axis, length in zip(axes, edge, strict=True):
        start, slope = foot @ axis, axis[-1]
        if slope == 0.0:
            outside = (start < 0.0) | (start > length)
            low, high = np.where(outside, np.inf, low), np.where(outside, -np.inf, high)
            continue
        ends = np.stack([-start / slope, (length - start) / slope])
        low, high = np.maximum(low, ends.min(axis=0)), np.minimum(high, ends.max(axis=0))
    yield from _between(low, high)


def _of_polygon(shape: Polygon, place: Floats) -> Iterator[Crossing]:
    start = np.asarray(shape.vertices, dtype=float)
    end = np.roll(start, -1, axis=0)
    x, y = (start - start[0]).T
    double_area = float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    for one, other in zip(start, end, strict=True):
        yield from _of_edge(one, other, np.sign(double_area), place[:, 0])


def _of_edge(one: Floats, other: Floats, turn: float, x: Floats) -> Iterator[Crossing]:
    """Yields the crossing with an edge; turn: 1 if the edges go anticlockwise, -1 if clockwise."""
    (x0, y0), (x1, y1) = one, other
    if x0 == x1:
        return
    line = np.flatnonzero((x0 <= x) != (x1 <= x))
    height = y0 + (x[line] - x0) * ((y1 - y0) / (x1 - x0))
    yield (turn if x1 < x0 else -turn), line, height


def _of_circle(shape: Circle, place: Floats) -> Iterator[Crossing]:
    half = _half_chord(shape.radius, place[:, 0] - shape.centre[0])
    yield from _between(shape.centre[1] - half, shape.centre[1] + half)


def _of_cylinder(shape: Cylinder, place: Floats) -> Iterator[Crossing]:
    along, centre = "xyz".index(shape.axis), np.asarray(shape.centre)
    offset = place - centre[:2]
    signs = np.asarray(side_signs(shape.sides))
    if along == 2:
        radius = np.linalg.norm(offset, axis=1)
        ring = (radius <= shape.radius) & (radius >= (shape.inner_radius or 0.0))
        inside = ring & (offset * signs[:2] >= 0.0).all(axis=1)
        low = np.where(inside, centre[2], np.inf)
        yield from _between(low, low + shape.height)
        return
    across = offset[:, 1 - along]
    inside = (offset[:, along] >= 0.0) & (offset[:, along] <= shape.height)
    inside &= across * signs[1 - along] >= 0.0
    yield from _of_rings(shape, np.abs(across), inside, centre[2], int(signs[2]))


def _of_sphere(shape: Sphere, place: Floats) -> Iterator[Crossing]:
    centre, signs = np.asarray(shape.centre), np.asarray(side_signs(shape.sides))
    offset = place - centre[:2]
    inside = (offset * signs[:2] >= 0.0).all(axis=1)
    radius = np.linalg.norm(offset, axis=1)
    yield from _of_rings(shape, radius, inside, centre[2], int(signs[2]))


def _of_height_field(form: HeightField, place: Floats) -> Iterator[Crossing]:
    base, top = form.heights(place)
    yield from _between(np.where(form.over(place), base, top), top)


def _of_polyhedron(form: Polyhedron, place: Floats) -> Iterator[Crossing]:
    line, height, sign = form.crossings(place)
    for each in (-1.0, 1.0):
        yield each, line[sign == each], height[sign == each]


def _of_rings(
    shape: Cylinder | Sphere, distance: Floats, inside: Any, centre: float, side: int
) -> Iterator[Crossing]:
    """Yields the crossings of a circle, less those of an inner one, at a distance from the centre.

    side: 1 or -1 if only what is above or below the centre belongs to the shape.
    """
    for radius, sign in ((shape.radius, 1.0), (shape.inner_radius, -1.0)):
        if radius is None:
            continue
        half = np.where(inside, _half_chord(radius, distance), 0.0)
        low, high = centre - half * (side <= 0), centre + half * (side >= 0)
        for each, line, height in _between(low, high):
            yield sign * each, line, height


def _half_chord(radius: float, distance: Floats) -> Floats:
    return np.asarray(np.sqrt(np.maximum(radius**2 - distance**2, 0.0)))


def _of_triangles(corners: Floats, place: Floats) -> Iterator[Crossing]:
    """Yields the crossings of the edges that belong to one triangle only, corners (m, 3, 2)."""
    order = np.argsort(place[:, 0], kind="stable")
    x = place[order, 0]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    turn = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    start = corners.reshape(-1, 2)
    end = np.roll(corners, -1, axis=1).reshape(-1, 2)
    outline = _outline(np.stack([start, end], axis=1))
    for edge in outline:
        one, other = start[edge], end[edge]
        least, most = np.searchsorted(x, sorted((one[0], other[0])), side="left")
        near = slice(least, most + 1)
        for sign, line, height in _of_edge(one, other, float(turn[edge // 3]), x[near]):
            yield sign, order[near][line], height


def _of_tetrahedra(corners: Floats, place: Floats) -> Iterator[Crossing]:
    """Yields the crossings of the faces that belong to one tetrahedron only, corners (m, 4, 3)."""
    extent = np.ptp(corners.reshape(-1, 3), axis=0)[:2].max()
    shifted = place + extent * np.asarray(SHIFT)
    order = np.argsort(shifted[:, 0], kind="stable")
    sorted_place = shifted[order]
    opposite = corners.reshape(-1, 3)
    faces = np.stack([np.delete(corners, k, axis=1) for k in range(4)], axis=1).reshape(-1, 3, 3)
    low = np.searchsorted(sorted_place[:, 0], faces[:, :, 0].min(axis=1), side="left")
    high = np.searchsorted(sorted_place[:, 0], faces[:, :, 0].max(axis=1), side="right")
    for face in _outline(faces):
        near = slice(low[face], high[face])
        if near.start >= near.stop:
            continue
        a, b, c = faces[face]
        plan = np.stack([b - a, c - a], axis=1)
        if abs(np.linalg.det(plan[:2])) <= 1e-14 * np.abs(plan[:2]).max() ** 2:
            continue  # a vertical face
        share = np.linalg.solve(plan[:2], (sorted_place[near] - a[:2]).T)
        line = np.flatnonzero((share >= 0.0).all(axis=0) & (share.sum(axis=0) <= 1.0))
        top = opposite[face] - a
        above = top[2] - plan[2] @ np.linalg.solve(plan[:2], top[:2]) > 0.0
        yield (-1.0 if above else 1.0), order[near][line], a[2] + plan[2] @ share[:, line]


def _outline(facets: Floats) -> Integers:
    """Returns the facets that occur once, by their corners (m, k, d)."""
    m, k, d = facets.shape
    flat = facets.reshape(m * k, d)
    _, vertex = np.unique(flat, axis=0, return_inverse=True)
    _, facet, count = np.unique(
        np.sort(vertex.reshape(m, k), axis=1), axis=0, return_inverse=True, return_counts=True
    )
    return np.flatnonzero(count[facet.ravel()] == 1)
