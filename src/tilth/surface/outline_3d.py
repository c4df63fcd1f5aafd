# SPDX-License-Identifier: BSD-3-Clause
"""Surface of a body in space as triangles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.bodies.block import Block
from tilth.bodies.forms import WithHoles, form_of
from tilth.bodies.holes_in_space import deep_inside
from tilth.bodies.inside import inside_of
from tilth.bodies.mesh import Elements
from tilth.bodies.polyhedron import Polyhedron
from tilth.bodies.request import Request
from tilth.bodies.terrain import HeightField
from tilth.grid.background import Grid
from tilth.model import Body, Box, Cylinder, Sphere
from tilth.model.shapes import side_signs
from tilth.surface.panels import (
    Panel,
    arc,
    chords_of_quarter,
    joined,
    number_of_parts,
    octant,
    quarter_ring,
    rectangle,
    triangulate_rows,
)
from tilth.surface.subdivide import subdivide
from tilth.surface.triangles import Triangles

# Largest ratio of an edge, such as the diagonal of a square, to the spacing along rows of vertices.
LONGEST_EDGE_RATIO = 1.5
# A hole nearer to another surface than this, over the spacing, touches it.
TOUCH = 1e-6
# Corners of the faces of a tetrahedron and of a hexahedron, anticlockwise seen from inside.
FACES = {
    "tetrahedron": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]],
    "hexahedron": [
        *([0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1]),
        *([3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]),
    ],
}


def outline_3d(
    body: Body,
    cell_size: npt.ArrayLike,
    spacing: float | None = None,
    origin: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Triangles:
    """Returns the closed surface of a body; its normals point into the soil.

    Vertices of round surfaces lie on them. The parts have names: of a box "x-" to "z+", along its
    own axes; of a cylinder "side", "low" and "high", of a tube "inner" as well; of a sphere
    "surface", of a shell "outer" and "inner"; of a mesh or an STL file "surface"; of a terrain
    "top", "base", and "x-" to "y+"; of the first hole the same with "hole 1 " before. Where `sides`
    cuts a cylinder or sphere at a plane through its centre normal to x, y or z, the part is
    "cut x", "cut y" or "cut z": a plane of symmetry, which is no surface of the soil.

    Args:
        body: a body in space.
        cell_size: sides of a cell [length], shape (3,).
        spacing: largest distance of vertices along their rows [length]; half of a cell's smallest
            side if not given. Edges between rows are at most 1.5 times as long.
        origin: of the grid [length], shape (3,).

    Raises:
        BadInput: the body has no such surface, or its mesh cannot be read.
    """
    cell = np.asarray(cell_size, dtype=float)
    request = Request(body.name, False, Grid(np.asarray(origin, dtype=float), cell))
    if 3 not in body.shape.dimensions or body.shape.dimension == 2 or len(cell) != 3:
        raise request.refused(
            f"a {body.shape.type} has no surface in space",
            "surfaces of this kind are for shapes in 3D",
            "shape.type",
        )
    size = 0.5 * float(cell.min()) if spacing is None else spacing
    form = form_of(body.shape, request)
    return FORMS[type(form)](form, request, size)


def _with_holes(form: WithHoles, request: Request, spacing: float) -> Triangles:
    """Returns the surface of a form and those of the holes in it, turned over."""
    outer = FORMS[type(form.whole)](form.whole, request, spacing)
    shifts = TOUCH * spacing * np.vstack([np.eye(3), -np.eye(3)])
    surfaces, parts, numbers = [outer], list(outer.part), [outer.part_number]
    for i, hole in enumerate(form.holes):
        inner = FORMS[type(hole)](hole, request, spacing)
        touches = not deep_inside(form.whole, inner.vertices, TOUCH * spacing).all()
        for other in form.holes[:i]:
            inside = inside_of(other)
            touches |= any(inside(inner.vertices + shift).any() for shift in shifts)
        if touches:
            raise request.refused(
                "a hole that touches the surface of its body or another hole has no surface",
                "keep it apart from them, or leave `surface` out of the body",
                f"shape.holes[{i}]",
            )
        numbers.append(inner.part_number + len(parts))
        parts += [f"hole {i + 1} {part}" for part in inner.part]
        surfaces.append(Triangles(inner.vertices, inner.triangle[:, ::-1]))
    first = np.cumsum([0, *(len(each.vertices) for each in surfaces[:-1])])
    return Triangles(
        np.concatenate([each.vertices for each in surfaces]),
        np.concatenate([each.triangle + f for each, f in zip(surfaces, first, strict=True)]),
        parts,
        np.concatenate(numbers),
    )


def _box(shape: Box, _: Request, spacing: float) -> Triangles:
    lower, axes = np.asarray(shape.lower, dtype=float), np.array(shape.axes)
    edge = np.diag(np.asarray(shape.upper, dtype=float) - lower)
    panels = []
    for i, name in enumerate("xyz"):
        j, k = (i + 1) % 3, (i + 2) % 3
        low = rectangle(f"{name}-", np.zeros(3), edge[j], edge[k], spacing)
        high = rectangle(f"{name}+", edge[i], edge[j], edge[k], spacing)
        panels += [low, high.flipped()]
    return joined([panel.transformed(axes.T, lower) for panel in panels])


def _sphere(shape: Sphere, _: Request, spacing: float) -> Triangles:
    outer, inner, signs = shape.radius, shape.inner_radius or 0.0, side_signs(shape.sides)
    panels = [octant("outer" if inner else "surface", outer, spacing)]
    if inner:
        panels.append(octant("inner", inner, spacing).flipped())
    ring = quarter_ring("", inner, outer, spacing)
    for i in np.flatnonzero(signs):
        cut = replace(ring, part=f"cut {'xyz'[i]}")
        panels.append(cut.transformed(_cycle(int(i)), np.zeros(3)))
    return _mirrored(panels, signs, np.asarray(shape.centre, dtype=float))


def _cylinder(shape: Cylinder, _: Request, spacing: float) -> Triangles:
    """Returns the surface, by rotation and reflection of the quarter x, y >= 0 along z."""
    outer, inner = shape.radius, shape.inner_radius or 0.0
    along = "xyz".index(shape.axis)
    rise = np.array([0.0, 0.0, shape.height])
    low = quarter_ring("low", inner, outer, spacing)
    high = quarter_ring("high", inner, outer, spacing).transformed(np.eye(3), rise).flipped()
    panels = [_round_side("side", outer, rise, spacing).flipped(), low, high]
    if inner:
        panels.append(_round_side("inner", inner, rise, spacing))
    rotation, signs = _cycle(along), side_signs(shape.sides)
    for own in range(2):  # the axes of the quarter
        axis = (along + 1 + own) % 3
        if signs[axis]:
            other, part = np.eye(3)[1 - own], f"cut {'xyz'[axis]}"
            wall = rectangle(part, inner * other, (outer - inner) * other, rise, spacing)
            panels.append(wall.flipped() if own else wall)
    panels = [panel.transformed(rotation, np.zeros(3)) for panel in panels]
    ends = tuple(1 if i == along else sign for i, sign in enumerate(signs))
    return _mirrored(panels, ends, np.asarray(shape.centre, dtype=float))


def _round_side(part: str, radius: float, rise: Floats, spacing: float) -> Panel:
    """Returns a quarter of a cylinder's side; its normals point away from the axis."""
    rows = number_of_parts(float(rise.max()), spacing)
    row = arc(radius, chords_of_quarter(radius, spacing))
    return triangulate_rows(part, [row + k / rows * rise for k in range(rows + 1)])


def _cycle(axis: int) -> Floats:
    """Returns the rotation matrix that maps z to this axis and keeps the cyclic order."""
    return np.roll(np.eye(3), axis - 2, axis=0)


def _mirrored(panels: list[Panel], signs: tuple[int, ...], centre: Floats) -> Triangles:
    """Returns panels at x, y, z >= 0 reflected to all sides; one side where a sign is not 0."""
    all_signs = product(*((sign,) if sign else (1, -1) for sign in signs))
    return joined(
        [
            panel.transformed(np.diag(combination), centre)
            for combination in all_signs
            for panel in panels
        ]
    )


def _mesh(form: Elements, request: Request, spacing: float) -> Triangles:
    """Returns the triangles of the faces that belong to one element only.

    Quadrilaterals are cut along the shorter diagonal; long edges are halved.
    """
    position: dict[int, Floats] = {}
    faces: dict[tuple[int, ...], list[int]] = {}
    for block in form.blocks:
        position.update(
            zip(block.nodes.ravel().tolist(), block.corners.reshape(-1, 3), strict=True)
        )
        for face in _faces_of(block):
            key = tuple(sorted(face))
            if faces.pop(key, None) is None:
                faces[key] = face
    nodes = sorted({node for face in faces for node in face})
    number = {node: i for i, node in enumerate(nodes)}
    vertices = np.array([position[node] for node in nodes])
    triangle = [t for face in faces.values() for t in _cut([number[n] for n in face], vertices)]
    surface = Triangles(vertices, triangle)
    if not surface.closed:
        raise request.refused(
            "the surface of the mesh is not closed, or touches itself along an edge",
            "join the elements by whole faces; part those that meet in an edge only",
            "shape.file",
        )
    return subdivide(surface, LONGEST_EDGE_RATIO * spacing).triangles


def _faces_of(block: Block) -> list[list[int]]:
    """Returns the nodes of the faces of all elements, anticlockwise seen from inside."""
    _, volume = block.element.pieces(block.corners, 1)
    nodes = np.where(volume < 0.0, block.nodes[:, block.element.mirror], block.nodes)
    faces: Integers = nodes[:, FACES[block.element.name]]
    return [face for element in faces.tolist() for face in element]


def _cut(face: list[int], vertices: Floats) -> list[list[int]]:
    """Returns the triangles of a face; a quadrilateral is cut along its shorter diagonal."""
    if len(face) == 3:
        return [face]
    a, b, c, d = face
    first, second = (np.linalg.norm(vertices[p] - vertices[q]) for p, q in ((a, c), (b, d)))
    return [[a, b, c], [a, c, d]] if first <= second else [[a, b, d], [b, c, d]]


def _height_field(form: HeightField, _: Request, spacing: float) -> Triangles:
    """Returns the triangles between rows of vertices on both surfaces and on the vertical sides."""
    axes = [
        np.linspace(low, high, number_of_parts(high - low, spacing) + 1)
        for low, high in zip(form.lower.tolist(), form.upper.tolist(), strict=True)
    ]
    place = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    base, top = (
        np.concatenate([place, z.reshape(*place.shape[:2], 1)], axis=2)
        for z in form.heights(place.reshape(-1, 2))
    )
    rows = number_of_parts(float((top - base)[..., 2].max()), spacing)
    panels = [
        triangulate_rows("base", list(base.swapaxes(0, 1))),
        triangulate_rows("top", list(top.swapaxes(0, 1))).flipped(),
    ]
    for name, at, turned in (
        ("x-", (0,), True), ("x+", (-1,), False),
        ("y-", (slice(None), 0), False), ("y+", (slice(None), -1), True),
    ):  # fmt: skip
        low, high = base[at], top[at]
        wall = triangulate_rows(name, [low + k / rows * (high - low) for k in range(rows + 1)])
        panels.append(wall if turned else wall.flipped())
    return joined(panels)


def _polyhedron(form: Polyhedron, _: Request, spacing: float) -> Triangles:
    surface = Triangles(form.vertices, form.triangle[:, ::-1])
    return subdivide(surface, LONGEST_EDGE_RATIO * spacing).triangles


FORMS: dict[type, Callable[[Any, Request, float], Triangles]] = {
    Box: _box,
    Cylinder: _cylinder,
    Sphere: _sphere,
    Elements: _mesh,
    HeightField: _height_field,
    Polyhedron: _polyhedron,
    WithHoles: _with_holes,
}
