# SPDX-License-Identifier: BSD-3-Clause
"""Outline of a body in the plane as chains of boundary points."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.forms import form_of
from tilth.bodies.mesh import Elements
from tilth.bodies.request import Request
from tilth.curves.chain import Chain, sharp_corners
from tilth.grid.background import Grid
from tilth.model import Body, Box, Circle, Polygon
from tilth.model.shapes import DeclaredShape

# Points with a radius below this [cell sizes] are on the axis of symmetry.
AXIS_TOLERANCE = 1e-9
# Default turning angle [degrees] above which a vertex of a polygon or a mesh is a corner: a circle
# of more than 18 edges is smooth.
CORNER_ANGLE = 20.0
# Least number of points of a full circle.
MINIMUM_CIRCLE_POINTS = 16


def outline(
    body: Body,
    kind: str,
    cell_size: npt.ArrayLike,
    spacing: float | None = None,
    corner_angle: float = CORNER_ANGLE,
    origin: npt.ArrayLike = (0.0, 0.0),
) -> list[Chain]:
    """Returns the chains of points along a body's outline, outer ones first, then holes.

    The soil is on their left. Corners of boxes and polygons are corners of the chains; straight
    sides are divided evenly. In axisymmetry a body with points on the axis has open chains that end
    there, since the axis is no surface.

    Args:
        body: a body in the plane.
        kind: "plane_strain" or "axisymmetric".
        cell_size: sides of a cell [length], shape (2,).
        spacing: largest distance of neighbouring points [length]; half of a cell's smaller side if
            not given.
        corner_angle: turning angle [degrees] above which a vertex of a polygon or a mesh is a
            corner.
        origin: of the grid [length], shape (2,).

    Raises:
        BadInput: the body has no outline in the plane, or its mesh cannot be read.
    """
    cell = np.asarray(cell_size, dtype=float)
    grid = Grid(np.asarray(origin, dtype=float), cell)
    request = Request(body.name, kind == "axisymmetric", grid)
    if 2 not in body.shape.dimensions or len(cell) != 2:
        raise request.refused(
            f"a {body.shape.type} has no outline in the plane",
            "boundary points of this kind are for shapes in 2D",
            "shape.type",
        )
    size = 0.5 * float(cell.min()) if spacing is None else spacing
    form = form_of(body.shape, request)
    chains = FORMS[type(form)](form, request, size, corner_angle)
    for hole in form.cavities() if isinstance(form, DeclaredShape) else ():
        for chain in FORMS[type(hole)](hole, request, size, corner_angle):
            chains.append(Chain(chain.points[::-1], chain.closed, chain.corner[::-1]))
    return chains


def _box(shape: Box, request: Request, spacing: float, _: float) -> list[Chain]:
    side = np.asarray(shape.upper, dtype=float) - np.asarray(shape.lower, dtype=float)
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]) * side
    vertices = np.asarray(shape.lower, dtype=float) + corners @ np.array(shape.axes)
    return _divided(vertices, np.ones(4, dtype=bool), request, spacing)


def _polygon(shape: Polygon, request: Request, spacing: float, corner_angle: float) -> list[Chain]:
    vertices = np.asarray(shape.vertices, dtype=float)
    if _signed_area(vertices) < 0.0:
        vertices = vertices[::-1]
    return _divided(vertices, sharp_corners(vertices, True, corner_angle), request, spacing)


def _circle(shape: Circle, request: Request, spacing: float, _: float) -> list[Chain]:
    centre, radius = np.asarray(shape.centre, dtype=float), float(shape.radius)
    half = request.axisymmetric and centre[0] == 0.0
    full_angle = math.pi if half else 2.0 * math.pi
    chords = max(
        math.ceil(full_angle * radius / spacing), MINIMUM_CIRCLE_POINTS // (2 if half else 1)
    )
    # Half a circle goes from the lower end of the axis to the upper one.
    angle = (-0.5 * math.pi if half else 0.0) + full_angle * np.arange(chords + half) / chords
    points = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    if half:
        points[[0, -1], 0] = 0.0
    return [Chain(points, closed=not half)]


def _mesh(form: Elements, request: Request, spacing: float, corner_angle: float) -> list[Chain]:
    """Returns the chains of the edges that belong to one element only."""
    position: dict[int, Floats] = {}
    edges = []
    for block in form.blocks:
        ahead = np.roll(block.corners, -1, axis=1)
        signed_area = block.corners[..., 0] * ahead[..., 1] - ahead[..., 0] * block.corners[..., 1]
        nodes = np.where(signed_area.sum(axis=1)[:, None] < 0.0, block.nodes[:, ::-1], block.nodes)
        edges.append(np.stack([nodes, np.roll(nodes, -1, axis=1)], axis=2).reshape(-1, 2))
        position.update(
            zip(block.nodes.ravel().tolist(), block.corners.reshape(-1, 2), strict=True)
        )
    loops = _loops(np.concatenate(edges), position, request)
    outlines = [np.array([position[node] for node in loop]) for loop in loops]
    outlines.sort(key=_signed_area, reverse=True)
    return [
        chain
        for vertices in outlines
        for chain in _divided(
            vertices, sharp_corners(vertices, True, corner_angle), request, spacing
        )
    ]


def _loops(edges: Integers, position: dict[int, Floats], request: Request) -> list[list[int]]:
    """Returns closed loops of nodes along directed edges (n, 2) without an opposite edge."""
    count = int(edges.max()) + 1
    opposite = edges[:, 1] * count + edges[:, 0]
    outer = edges[~np.isin(edges[:, 0] * count + edges[:, 1], opposite)]
    following = dict(outer.tolist())
    if len(following) < len(outer):
        nodes, times = np.unique(outer[:, 0], return_counts=True)
        x, y = position[int(nodes[times > 1][0])]
        raise request.refused(
            f"the outline of the mesh touches itself at ({x:.6g}, {y:.6g})",
            "join its parts by an edge there, or part them",
            "shape.file",
        )
    loops = []
    while following:
        node, ahead = following.popitem()
        loop = [node]
        while ahead != loop[0]:
            loop.append(ahead)
            ahead = following.pop(ahead)
        loops.append(loop)
    return loops


def _divided(vertices: Floats, corner: Flags, request: Request, spacing: float) -> list[Chain]:
    """Returns chains along the closed polygon of vertices (n, 2), its edges divided evenly.

    Edges on the axis of symmetry are left out, which gives open chains.
    """
    n = len(vertices)
    on_axis = np.zeros(n, dtype=bool)
    if request.axisymmetric:
        on_axis = np.abs(vertices[:, 0]) <= AXIS_TOLERANCE * float(request.cell_size[0])
    skipped = np.flatnonzero(on_axis & np.roll(on_axis, -1))
    if not len(skipped):
        return [_chain(np.arange(n + 1) % n, vertices, corner, spacing, True)]
    chains = []
    for edge, following in zip(skipped, [*skipped[1:], skipped[0] + n], strict=True):
        if following > edge + 1:
            number = np.arange(edge + 1, following + 1) % n
            chains.append(_chain(number, vertices, corner, spacing, False))
    return chains


def _chain(
    number: Integers, vertices: Floats, corner: Flags, spacing: float, closed: bool
) -> Chain:
    """Returns the chain through numbered vertices; a closed one repeats the first at the end."""
    vertex = vertices[number]
    ahead = np.diff(vertex, axis=0)
    length = np.linalg.norm(ahead, axis=1)
    parts = np.maximum(np.ceil(length / spacing * (1.0 - 1e-12)), 1.0).astype(np.int64)
    edge = np.repeat(np.arange(len(ahead)), parts)
    fraction = (np.arange(len(edge)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[edge]
    points = vertex[edge] + fraction[:, None] * ahead[edge]
    flag = corner[number][edge] & (fraction == 0.0)
    if closed:
        return Chain(points, True, flag)
    flag[0] = False  # an end of the chain
    return Chain(np.append(points, vertex[-1:], axis=0), False, np.append(flag, False))


def _signed_area(vertices: Floats) -> float:
    """Returns the area of a closed polygon [length^2], > 0 if it is anticlockwise."""
    relative = vertices - vertices[0]
    ahead = np.roll(relative, -1, axis=0)
    return 0.5 * float((relative[:, 0] * ahead[:, 1] - ahead[:, 0] * relative[:, 1]).sum())


FORMS: dict[type, Callable[[Any, Request, float, float], list[Chain]]] = {
    Box: _box,
    Polygon: _polygon,
    Circle: _circle,
    Elements: _mesh,
}
