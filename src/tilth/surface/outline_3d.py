# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a body in space as triangles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.bodies.block import Block
from tilth.bodies.mesh import read_mesh
from tilth.bodies.request import Request
from tilth.model import Body, Box, Cylinder, Mesh, Sphere
from tilth.model.shapes import side_signs
from tilth.surface.patches import (
    Patch,
    arc,
    between_rows,
    chords_of_quarter,
    joined,
    octant,
    parts_of,
    quarter_ring,
    rectangle,
)
from tilth.surface.subdivide import subdivide
from tilth.surface.triangles import Triangles

# Longest edge, such as the diagonal of a square, over the distance along the rows of vertices.
ACROSS = 1.5
# Corners of the faces of a tetrahedron and of a hexahedron, anticlockwise seen from inside.
FACES = {
    "tetrahedron": [[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]],
    "hexahedron": [
        *([0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1]),
        *([3, 2, 6, 7], [0, 3, 7, 4], [1, 5, 6, 2]),
    ],
}


def outline_3d(body: Body, cell_size: npt.ArrayLike, spacing: float | None = None) -> Triangles:
    """Returns the closed surface of a body; its normals point into the soil.

    Vertices of round surfaces lie on them. The parts have names: of a box "x-" to "z+", along its
    own axes; of a cylinder "side", "low" and "high", of a tube "inner" as well; of a sphere
    "surface", of a shell "outer" and "inner"; of a mesh "surface". Where `sides` cuts a cylinder or
    sphere at the plane of its centre that is normal to x, the part is "cut x", and so on: a plane
    of symmetry, which is no surface of the soil.

    Args:
        body: a body in space.
        cell_size: sides of a cell [length], shape (3,).
        spacing: largest distance of vertices along their rows [length], half of a cell's smallest
            side if not given. Edges across, such as diagonals, are at most 1.5 times as long.

    Raises:
        BadInput: the body has no such surface, or its mesh cannot be read.
    """
    cell = np.asarray(cell_size, dtype=float)
    request = Request(body.name, False, np.zeros_like(cell), cell)
    if type(body.shape) not in SHAPES or body.shape.dimension == 2 or len(cell) != 3:
        raise request.refused(
            f"a {body.shape.type} has no surface in space",
            "surfaces of this kind are for boxes, cylinders, spheres and meshes in 3D",
            "shape.type",
        )
    size = 0.5 * float(cell.min()) if spacing is None else spacing
    return SHAPES[type(body.shape)](body.shape, request, size)


def _box(shape: Box, _: Request, spacing: float) -> Triangles:
    lower, axes = np.asarray(shape.lower, dtype=float), np.array(shape.axes)
    edge = np.diag(np.asarray(shape.upper, dtype=float) - lower)
    patches = []
    for i, name in enumerate("xyz"):
        j, k = (i + 1) % 3, (i + 2) % 3
        low = rectangle(f"{name}-", np.zeros(3), edge[j], edge[k], spacing)
        high = rectangle(f"{name}+", edge[i], edge[j], edge[k], spacing)
        patches += [low, high.turned()]
    return joined([patch.mapped(axes.T, lower) for patch in patches])


def _sphere(shape: Sphere, _: Request, spacing: float) -> Triangles:
    outer, inner, signs = shape.radius, shape.inner_radius or 0.0, side_signs(shape.sides)
    patches = [octant("outer" if inner else "surface", outer, spacing)]
    if inner:
        patches.append(octant("inner", inner, spacing).turned())
    ring = quarter_ring("", inner, outer, spacing)
    for i in np.flatnonzero(signs):
        cut = replace(ring, part=f"cut {'xyz'[i]}")
        patches.append(cut.mapped(_cycle(int(i)), np.zeros(3)))
    return _mirrored(patches, signs, np.asarray(shape.centre, dtype=float))


def _cylinder(shape: Cylinder, _: Request, spacing: float) -> Triangles:
    """The quarter at x, y >= 0 of a cylinder along z, then turned and mirrored."""
    outer, inner = shape.radius, shape.inner_radius or 0.0
    along = "xyz".index(shape.axis)
    rise = np.array([0.0, 0.0, shape.height])
    low = quarter_ring("low", inner, outer, spacing)
    high = quarter_ring("high", inner, outer, spacing).mapped(np.eye(3), rise).turned()
    patches = [_round_side("side", outer, rise, spacing).turned(), low, high]
    if inner:
        patches.append(_round_side("inner", inner, rise, spacing))
    turn, signs = _cycle(along), side_signs(shape.sides)
    for own in range(2):  # the axes of the quarter
        axis = (along + 1 + own) % 3
        if signs[axis]:
            other, part = np.eye(3)[1 - own], f"cut {'xyz'[axis]}"
            wall = rectangle(part, inner * other, (outer - inner) * other, rise, spacing)
            patches.append(wall.turned() if own else wall)
    patches = [patch.mapped(turn, np.zeros(3)) for patch in patches]
    ends = tuple(1 if i == along else sign for i, sign in enumerate(signs))
    return _mirrored(patches, ends, np.asarray(shape.centre, dtype=float))


def _round_side(part: str, radius: float, rise: Floats, spacing: float) -> Patch:
    """A quarter of a cylinder's side; its normals point away from the axis."""
    rows = parts_of(float(rise.max()), spacing)
    row = arc(radius, chords_of_quarter(radius, spacing))
    return between_rows(part, [row + k / rows * rise for k in range(rows + 1)])


def _cycle(axis: int) -> Floats:
    """The rotation that puts z on this axis and keeps the order of the axes."""
    return np.roll(np.eye(3), axis - 2, axis=0)


def _mirrored(patches: list[Patch], signs: tuple[int, ...], centre: Floats) -> Triangles:
    """Patches at x, y, z >= 0 on both sides of the centre, on one where the sign is not 0."""
    ways = product(*((sign,) if sign else (1, -1) for sign in signs))
    return joined([patch.mapped(np.diag(way), centre) for way in ways for patch in patches])


def _mesh(shape: Mesh, request: Request, spacing: float) -> Triangles:
    """The faces that belong to one element only; quadrilaterals are cut along the short diagonal.

    Long edges are halved.
    """
    blocks = read_mesh(Path(shape.file), 3, request)
    place: dict[int, Floats] = {}
    faces: dict[tuple[int, ...], list[int]] = {}
    for block in blocks:
        place.update(zip(block.nodes.ravel().tolist(), block.corners.reshape(-1, 3), strict=True))
        for face in _faces_of(block):
            key = tuple(sorted(face))
            if faces.pop(key, None) is None:
                faces[key] = face
    nodes = sorted({node for face in faces for node in face})
    number = {node: i for i, node in enumerate(nodes)}
    vertices = np.array([place[node] for node in nodes])
    triangle = [t for face in faces.values() for t in _cut([number[n] for n in face], vertices)]
    surface = Triangles(vertices, triangle)
    if not surface.closed:
        raise request.refused(
            "the surface of the mesh is not closed, or touches itself along an edge",
            "join the elements by whole faces; part those that meet in an edge only",
            "shape.file",
        )
    return subdivide(surface, ACROSS * spacing).triangles


def _faces_of(block: Block) -> list[list[int]]:
    """Nodes of the faces of all elements, anticlockwise seen from inside."""
    _, volume = block.element.pieces(block.corners, 1)
    nodes = np.where(volume < 0.0, block.nodes[:, block.element.mirror], block.nodes)
    faces: Integers = nodes[:, FACES[block.element.name]]
    return [face for element in faces.tolist() for face in element]


def _cut(face: list[int], vertices: Floats) -> list[list[int]]:
    if len(face) == 3:
        return [face]
    a, b, c, d = face
    first, second = (np.linalg.norm(vertices[p] - vertices[q]) for p, q in ((a, c), (b, d)))
    return [[a, b, c], [a, c, d]] if first <= second else [[a, b, d], [b, c, d]]


SHAPES: dict[type, Callable[[Any, Request, float], Triangles]] = {
    Box: _box,
    Cylinder: _cylinder,
    Sphere: _sphere,
    Mesh: _mesh,
}
