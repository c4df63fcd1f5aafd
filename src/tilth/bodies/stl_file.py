# SPDX-License-Identifier: BSD-3-Clause
"""Triangulated surfaces in STL files: closed ones, and open ones with two sides."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.covering import require_shells_nested
from tilth.errors import BadInput
from tilth.input_files import why_failed, why_no_file
from tilth.memory_errors import is_memory_error

# Corners nearer than this, relative to the largest extent or coordinate, are merged: the precision
# of a binary file.
MERGE_TOLERANCE = 1e-7
# Triangles whose height is below this fraction of their longest edge are dropped; also the least
# volume relative to the cube of the extent.
DEGENERACY_TOLERANCE = 1e-9


def closed_surface(corner: Floats) -> tuple[Floats, Integers, float]:
    """Returns vertices (m, 3), triangles (n, 3) with outward normals, and the volume inside.

    corner: coordinates of the triangles' corners (n, 3, 3) [length].
    Raises BadInput, without key, if the surface is not closed, encloses no volume, or encloses a
    place more than once or less than not at all.
    """
    vertex, node = _merged_triangles(corner)
    problems = [*_border_edges(node, vertex), *_wrong_edges(node, vertex)]
    if problems:
        remedy = "repair the mesh (close its holes, turn its triangles alike), save it again"
        if len(problems) == 1 and _border_edges(node, vertex):
            remedy += '; or, of a boundary, give soil = "front" for an open surface with the soil '
            remedy += 'where the normals point, "back" for the other side'
        raise BadInput(f"the surface is not closed: {'; '.join(problems)}", remedy)
    extent = float(np.ptp(vertex, axis=0).max())
    relative = (vertex - vertex.mean(axis=0))[node]
    volume = np.linalg.det(relative).sum() / 6.0
    if abs(volume) <= DEGENERACY_TOLERANCE * extent**3:
        raise BadInput(
            f"encloses no volume ({volume:.3g})",
            "save the closed surface of a body with a thickness",
        )
    if volume < 0.0:
        node = node[:, ::-1]
    require_shells_nested(vertex, node)
    return vertex, node, abs(float(volume))


def open_surface(corner: Floats) -> tuple[Floats, Integers]:
    """Returns vertices (m, 3) and triangles (n, 3), turned as they are, of an open surface.

    corner: coordinates of the triangles' corners (n, 3, 3) [length].
    Raises BadInput, without key, if triangles are turned to different sides, more than two meet at
    an edge, or the surface is closed.
    """
    vertex, node = _merged_triangles(corner)
    problems, borders = _wrong_edges(node, vertex), _border_edges(node, vertex)
    if problems:
        remedy = "turn all triangles to one side, let at most two meet at an edge, save it again"
        raise BadInput(f"is no surface with two sides: {'; '.join(problems)}", remedy)
    if not borders:
        remedy = 'give soil = "inside" or "outside"; "front" and "back" are sides of an open one'
        raise BadInput("the surface is closed", remedy)
    return vertex, node


def _merged_triangles(corner: Floats) -> tuple[Floats, Integers]:
    """Returns vertices and triangles without those that have two corners at one place."""
    corner = np.asarray(corner, dtype=np.float64)
    if not len(corner) or not np.isfinite(corner).all():
        raise BadInput(
            "contains no triangles"
            if not len(corner)
            else "has coordinates that are not finite numbers",
            "save the surface of a body as triangles",
        )
    vertex, node = merged(corner)
    return vertex, node[(node != np.roll(node, 1, axis=1)).all(axis=1)]


def read_stl(file: Path, key: str) -> Floats:
    """Returns the corners (n, 3, 3) of the triangles in an STL file."""

    def error_for(problem: str, remedy: str) -> BadInput:
        return BadInput(problem, remedy, key=key, value=str(file))

    try:
        meshio = importlib.import_module("meshio")
    except ModuleNotFoundError as error:
        raise error_for(
            "an STL file needs the package meshio, which is not installed",
            "install it with `pip install meshio`",
        ) from error
    if reason := why_no_file(file):
        raise error_for(reason, "check the name and the folder")
    try:
        with np.errstate(over="ignore"):  # meshio may read text as a number of triangles
            mesh = meshio.stl.read(file)
        node = mesh.get_cells_type("triangle")
        vertex = np.asarray(mesh.points, dtype=np.float64).reshape(-1, 3)
        return np.asarray(vertex[node.reshape(-1, 3)])
    except Exception as error:  # meshio raises all kinds for what is no surface
        if is_memory_error(error):
            raise
        problem = f"cannot be read as an STL file: {why_failed(error)}"
        raise error_for(problem, "save the surface as an .stl file") from error


def merged(corner: Floats, relative: float = MERGE_TOLERANCE) -> tuple[Floats, Integers]:
    """Returns the distinct vertices (m, d) of elements (n, k, d), and their numbers (n, k).

    relative: distance below which two are one, relative to the largest extent or coordinate.
    """
    from scipy.sparse import coo_array  # take 0.2 s: only where there is such a surface
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    vertex, node = np.unique(corner.reshape(-1, corner.shape[2]), axis=0, return_inverse=True)
    tolerance = relative * max(float(np.ptp(vertex, axis=0).max()), float(np.abs(vertex).max()))
    pairs = cKDTree(vertex).query_pairs(tolerance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), 2 * (len(vertex),))
    _, group = connected_components(links, directed=False)
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    return vertex[first], number[node].reshape(corner.shape[:2]).astype(np.int64)


def _border_edges(node: Integers, vertex: Floats) -> list[str]:
    """Returns what is wrong with triangles (n, 3) that are to be closed: edges of one triangle."""
    ends, _, uses = _edges(node)
    return _described(uses == 1, "with a triangle on one side only", ends, vertex)


def _wrong_edges(node: Integers, vertex: Floats) -> list[str]:
    """Returns what is wrong with triangles (n, 3) as a surface with two sides."""
    ends, turns, uses = _edges(node)
    more = _described(uses > 2, "with more than two triangles", ends, vertex)
    opposite = (uses == 2) & (turns != 0.0)
    what = "whose two triangles are turned to opposite sides"
    return more + _described(opposite, what, ends, vertex)


def _edges(node: Integers) -> tuple[Integers, Floats, Integers]:
    """Returns the ends of all edges (k, 2), the sum of their directions, and of their triangles."""
    directed = np.stack([node, np.roll(node, -1, axis=1)], axis=2).reshape(-1, 2)
    forward = directed[:, 0] < directed[:, 1]
    ends, edge, uses = np.unique(
        np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    turns = np.bincount(edge.reshape(-1), weights=np.where(forward, 1.0, -1.0))
    return ends.astype(np.int64), np.asarray(turns, dtype=float), uses.astype(np.int64)


def _described(wrong: Flags, what: str, ends: Integers, vertex: Floats) -> list[str]:
    if not wrong.any():
        return []
    first = vertex[ends[np.argmax(wrong)]].mean(axis=0)
    where = ", ".join(f"{c:.6g}" for c in first)
    return [f"{wrong.sum()} edges {what} (the first near {where})"]
