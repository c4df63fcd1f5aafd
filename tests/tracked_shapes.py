# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces whose vertices, normals and arc lengths are known, for tests of the output."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tilth.output import Snapshot, SurfaceShape

OCTAHEDRON = np.array(
    [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
)
"""Triangles with normals outwards; vertices +x -x +y -y +z -z."""


def circle(name: str, points: int, radius: float = 1.0) -> SurfaceShape:
    """A closed chain anticlockwise about the origin, the soil inside."""
    angle = 2.0 * np.pi * np.arange(points) / points
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    number = np.arange(points)
    return SurfaceShape(
        name=name,
        position=radius * out,
        cells=np.column_stack([number, (number + 1) % points]),
        fields={"normal": -out, "arc_length": radius * angle},
    )


def line(name: str, places: np.ndarray) -> SurfaceShape:
    """An open straight chain through ``places``, shape (n, 2), the soil on its left."""
    step = places[-1] - places[0]
    normal = np.array([-step[1], step[0]]) / np.linalg.norm(step)
    number = np.arange(len(places) - 1)
    return SurfaceShape(
        name=name,
        position=places,
        cells=np.column_stack([number, number + 1]),
        fields={
            "normal": np.tile(normal, (len(places), 1)),
            "arc_length": np.linalg.norm(places - places[0], axis=1),
        },
    )


def octahedron(name: str, count: int, size: float = 1.0) -> SurfaceShape:
    """``count`` octahedra side by side along x, the soil inside."""
    corners = np.concatenate([np.eye(3), -np.eye(3)])[[0, 3, 1, 4, 2, 5]]
    shift = 3.0 * np.arange(count)[:, None, None] * np.eye(3)[0]
    numbers = 6 * np.arange(count)[:, None, None]
    return SurfaceShape(
        name=name,
        position=(size * corners + shift).reshape(-1, 3),
        cells=(OCTAHEDRON[:, [0, 2, 1]] + numbers).reshape(-1, 3),
        fields={"normal": np.tile(-corners, (count, 1))},
    )


def with_surfaces(snapshot: Snapshot) -> Snapshot:
    """The snapshot with two surfaces whose sizes depend on the step; none has points in step 0."""
    step = snapshot.step
    if snapshot.dim == 3:
        shapes = [octahedron("cavity", step), octahedron("top & side", step % 2, 0.5)]
    else:
        places = np.linspace([0.0, 2.0], [1.0 + step, 2.0], max(2 * step, 2))
        shapes = [circle("cavity", 5 * step), line("top & side", places)]
    return replace(snapshot, surfaces=tuple(shapes))
