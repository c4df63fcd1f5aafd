# SPDX-License-Identifier: BSD-3-Clause
"""Distorted meshes of boxes for tests, written as Gmsh files."""

from __future__ import annotations

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from tilth.arrays import Floats

DIMENSION = {"triangle": 2, "quad": 2, "tetra": 3, "hexahedron": 3}
"""Types of elements, as meshio calls them, and the number of directions of their meshes."""


def write(path: Path, points: Floats, cells: list[tuple[str, Floats]]) -> Path:
    """Writes a mesh with points (n, 2 or 3) in Gmsh's format."""
    meshio = pytest.importorskip("meshio")
    points = np.asarray(points, dtype=float)
    if points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points))])
    meshio.Mesh(points, cells).write(path, file_format="gmsh22", binary=False)
    return path


def distorted_mesh(
    path: Path,
    element: str,
    number: int,
    lower: float,
    upper: float,
    planes: tuple[float, ...] | None = None,
) -> Path:
    """Writes a mesh of the square or cube from `lower` to `upper` in every direction.

    number: of squares or cubes per direction, two triangles or six tetrahedra each. Nodes are
        moved by up to a fifth of their sides.
    planes: coordinates of planes normal to every direction in which nodes stay; those of the
        body's faces if not given.
    """
    dim = DIMENSION[element]
    axis = np.linspace(lower, upper, number + 1)
    points = np.stack(np.meshgrid(*[axis] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    random = np.random.default_rng(7)
    move = 0.2 * (upper - lower) / number * random.uniform(-1.0, 1.0, points.shape)
    stays = np.isin(points, (lower, upper) if planes is None else planes)
    points = points + np.where(stays, 0.0, move)
    step = (number + 1) ** np.arange(dim)[::-1]
    first = np.indices((number,) * dim).reshape(dim, -1).T @ step
    if element == "quad":
        offsets = [[0, step[0], step[0] + step[1], step[1]]]
    elif element == "hexahedron":
        face = np.array([0, step[0], step[0] + step[1], step[1]])
        offsets = [[*face, *(face + step[2])]]
    else:  # one simplex for each order in which the axes lead from a corner to the opposite one
        offsets = []
        for order in permutations(range(dim)):
            nodes = [0, *np.cumsum(step[list(order)])]
            if np.linalg.det(np.eye(dim)[list(order)]) < 0.0:
                nodes[-2:] = nodes[:-3:-1]
            offsets.append(nodes)
    cells = (first[:, None, None] + np.array(offsets)).reshape(-1, len(offsets[0]))
    return write(path, points, [(element, cells)])
