# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries in a Gmsh file: a line (2D) or a closed surface (3D) from a physical group."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.gmsh_file import FLATNESS_TOLERANCE, group_names, group_tags, read_gmsh
from tilth.bodies.stl_file import merged
from tilth.errors import BadInput
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.model.crossings import crosses_itself
from tilth.model.problems import unknown_name

# Nodes nearer than this, relative to the largest extent or coordinate, are one.
SAME_NODE = 1e-10
# Ends of a line count as equally far along x if they differ by less, relative to its extent.
SAME_X = 1e-9
KINDS = ("points", "lines", "surface elements", "volume elements")
ELEMENT = {1: "line", 2: "triangle"}


def group_line(file: str, group: str, key: str) -> tuple[Floats, bool]:
    """Returns the vertices (n, 2) of the line that a group's elements form, and if it is closed.

    An open line begins at its end of least x (least y, where both ends have the same x); a closed
    one runs anticlockwise. The directions of the elements do not matter.
    key: of the geometry in the case file, for messages.
    Raises BadInput for a file that cannot be read, an unknown group, and elements that do not form
    one line in the x-y plane that neither branches nor crosses itself.
    """
    corner = group_corners(file, group, 2, key)
    vertex, node = merged(corner, SAME_NODE)
    node = node[node[:, 0] != node[:, 1]]
    _, first = np.unique(np.sort(node, axis=1), axis=0, return_index=True)
    node = node[np.sort(first)]  # once each, in the order of the file

    def refused(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=f"{key}.group", value=group)

    ends = np.bincount(node.ravel(), minlength=len(vertex))
    if (ends > 2).any():
        where = _place(vertex[np.argmax(ends > 2)])
        raise refused(
            f"branches: {ends[ends > 2][0]} of its lines meet at {where}",
            "give a group of one line without branches",
        )
    pieces = [vertex[order] for order in _pieces(node)]
    if len(pieces) != 1:
        begin = " and ".join(_place(piece[0]) for piece in pieces[:2])
        what = f"is {len(pieces)} separate lines, of which two begin at {begin}"
        remedy = "join them, or give each its own group and boundary"
        raise refused(what if pieces else "has only lines of no length", remedy)
    line = pieces[0]
    closed = not (ends == 1).any()
    if crosses_itself(line.tolist(), closed):
        raise refused(
            "is a line that crosses itself", "mesh the curves with a node where they meet"
        )
    return (line[::-1] if _runs_back(line, closed) else line), closed


def group_surface(file: str, group: str, soil: str, key: str) -> TriangleMesh:
    """Returns the surface that a group's triangles form, with the soil on a side.

    It is closed with the sides "inside" and "outside"; then those to which the triangles are turned
    in the file do not matter. With "front" and "back" it is open: in front their normals point.
    key: of the geometry in the case file, for messages.
    Raises BadInput for a file that cannot be read, an unknown group, and triangles that are not one
    closed surface.
    """
    corner = group_corners(file, group, 3, key)
    if soil in ("front", "back"):
        where = f"{key}.group"
        return OpenSurface.from_corners(corner, soil == "front", key=where, value=group)
    vertex, node = merged(corner, SAME_NODE)
    node, pieces = _turned_alike(node)
    if pieces > 1:
        raise BadInput(
            f"is {pieces} separate surfaces",
            "give each its own group and boundary",
            key=f"{key}.group",
            value=group,
        )
    return TriangleMesh(vertex[node], soil == "inside", key=f"{key}.group", value=group)


def group_corners(file: str, group: str, dimension: int, key: str) -> Floats:
    """Returns the corners of the lines (n, 2, 2) or triangles (n, 3, 3) of a physical group.

    Raises BadInput for a file that cannot be read, an unknown group, and one of other elements.
    """

    def refused(problem: str, remedy: str, entry: str = "group") -> BadInput:
        value = group if entry == "group" else file
        return BadInput(problem, remedy, key=f"{key}.{entry}", value=value)

    mesh = read_gmsh(Path(file), lambda problem, remedy: refused(problem, remedy, "file"))
    wanted = ELEMENT[dimension - 1]
    blocks = [(c, own) for c, own in _members(mesh, group, dimension - 1) if own.any()]
    if not blocks:
        for other in range(4):
            if any(own.any() for _, own in _members(mesh, group, other)):
                raise refused(
                    f"is a group of {KINDS[other]}, not of {wanted}s",
                    f"in {dimension}D give a physical group of {wanted}s",
                )
        names = sorted(_names(mesh, dimension - 1))
        raise refused(*unknown_name(f"physical group of {wanted}s", group, names))
    kinds = sorted({c.type for c, _ in blocks} - {wanted})
    if kinds:
        remedy = f"mesh it with {wanted}s of first order"
        raise refused(f"has elements of type {', '.join(kinds)}", remedy)
    points = np.asarray(mesh.points, dtype=float) + 0.0
    corner = points[np.concatenate([np.asarray(c.data, dtype=np.int64)[own] for c, own in blocks])]
    if not np.isfinite(corner).all():
        raise refused("has coordinates that are not finite numbers", "mesh it again")
    height = corner[..., 2:]
    if dimension == 2 and height.size and np.ptp(height) > FLATNESS_TOLERANCE * np.ptp(corner):
        low, high = height.min(), height.max()
        raise refused(
            f"is not flat: z runs from {low:.6g} to {high:.6g}", "draw it in the x-y plane"
        )
    return np.asarray(corner[..., :dimension])


def _members(mesh: Any, group: str, dimension: int) -> Iterator[tuple[Any, Flags]]:
    """Yields blocks of elements of a dimension, and which of them are in the group, shape (n,).

    An element in several groups has the tag of the first; the file's sets of elements know all.
    """
    tags = [tag for tag, name in group_names(mesh, dimension).items() if name == group]
    named = int(mesh.field_data[group][1]) == dimension if group in mesh.field_data else False
    sets = mesh.cell_sets.get(group) if named else None
    for i, (c, tag) in enumerate(zip(mesh.cells, group_tags(mesh), strict=True)):
        if c.dim == dimension and len(c.data):
            own = np.isin(tag, tags)
            if sets is not None and sets[i] is not None:
                own[np.asarray(sets[i], dtype=np.int64)] = True
            yield c, own


def _names(mesh: Any, dimension: int) -> set[str]:
    """Returns the names of the groups that have elements of this dimension."""
    names = group_names(mesh, dimension).values()
    return {n for n in names if any(own.any() for _, own in _members(mesh, n, dimension))}


def _pieces(node: Integers) -> list[list[int]]:
    """Returns the nodes of each line in order along it, from elements (n, 2) that do not branch."""
    beside: dict[int, list[int]] = {}
    for a, b in node.tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    ends = [n for n, others in beside.items() if len(others) == 1]
    pieces, seen = [], set[int]()
    for start in [*ends, *beside]:  # what the open lines leave is closed
        if start in seen:
            continue
        order, ahead = [start], beside[start][:1]
        seen.add(start)
        while ahead:
            order.append(ahead[0])
            seen.add(ahead[0])
            ahead = [n for n in beside[ahead[0]] if n not in seen]
        pieces.append(order)
    return pieces


def _runs_back(line: Floats, closed: bool) -> bool:
    """Whether a line (n, 2) runs clockwise, or an open one from its end of greater x."""
    if closed:
        x, y = (line - line.mean(axis=0)).T
        return bool((x * np.roll(y, -1) - y * np.roll(x, -1)).sum() < 0.0)
    x, y = line[-1] - line[0]
    upright = abs(x) <= SAME_X * np.ptp(line, axis=0).max()
    return bool((y if upright else x) < 0.0)


def _turned_alike(node: Integers) -> tuple[Integers, int]:
    """Returns triangles (n, 3) turned as the first of each surface, and the number of surfaces.

    Surfaces go on across edges of two triangles only; others are found not to be closed later.
    """
    node = node.copy()
    uses: dict[tuple[int, int], list[int]] = {}
    for i, (a, b, c) in enumerate(node.tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            uses.setdefault((min(edge), max(edge)), []).append(i)
    seen = np.zeros(len(node), dtype=bool)
    pieces = 0
    for first in range(len(node)):
        if seen[first]:
            continue
        pieces += 1
        seen[first], front = True, [first]
        while front:
            i = front.pop()
            a, b, c = node[i].tolist()
            for edge in ((a, b), (b, c), (c, a)):
                for j in uses[min(edge), max(edge)]:
                    if len(uses[min(edge), max(edge)]) == 2 and not seen[j]:
                        seen[j] = True
                        ahead = node[j].tolist()
                        if edge in ((ahead[k - 1], ahead[k]) for k in range(3)):
                            node[j] = node[j, ::-1]
                        front.append(j)
    closed = all(len(triangles) == 2 for triangles in uses.values())
    return node, pieces if closed else 1


def _place(x: Floats) -> str:
    """Returns a place for a message."""
    return f"({', '.join(f'{c:.6g}' for c in x)})"
