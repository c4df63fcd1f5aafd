# SPDX-License-Identifier: BSD-3-Clause
"""Random boxes and polyhedra that are pressed, pushed, turned and dropped on blocks of soil."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from random_polygons import STRENGTH, WAYS, YOUNG, law, material
from scipy.spatial import ConvexHull

from tilth.arrays import Floats

CELL = 0.25
STEPS = 4


def random_rotation(random: np.random.Generator) -> Floats:
    """A rotation of space, shape (3, 3)."""
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    return np.asarray(turn * np.sign(np.linalg.det(turn)))


def corners_of(random: np.random.Generator, size: float) -> Floats:
    """Corners of a turned cuboid, or places on a sphere, around the origin, shape (n, 3)."""
    if random.random() < 0.5:
        signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
        return np.asarray((signs * random.uniform(0.3, 0.7, 3) * size) @ random_rotation(random).T)
    place = random.normal(size=(int(random.integers(6, 13)), 3))
    return np.asarray(size * place / np.linalg.norm(place, axis=1)[:, None])


def write_hull(path: Path, corners: Floats) -> None:
    """Writes the convex hull of corners (n, 3) as an STL file, its normals outwards."""
    hull = ConvexHull(corners)
    lines = ["solid hull"]
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        triangle = corners[simplex]
        across = np.cross(triangle[1] - triangle[0], triangle[2] - triangle[0])
        ordered = triangle if across @ equation[:3] > 0.0 else triangle[::-1]
        lines.append("facet normal {:.9g} {:.9g} {:.9g}".format(*equation[:3]))
        lines.append("outer loop")
        lines += ["vertex {:.12g} {:.12g} {:.12g}".format(*corner) for corner in ordered]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid hull", ""]))


def motion(random: np.random.Generator, way: str, depth: float, size: float) -> dict[str, Any]:
    """As that of polygons: down; aside; round; by a force, without turning; free on springs."""
    down = [[0.0, 0.0], [0.5, -depth], [1.0, -depth]]
    aside, angle = random.uniform(-1.0, 1.0, 2) * depth, random.uniform(-20.0, 20.0, 3)
    still = {"x": 0.0, "y": 0.0, "z": 0.0}
    if way == "pressed":
        return {"displacement": {"x": 0.0, "y": 0.0, "z": -depth}, "rotation": still}
    if way == "pushed":
        x, y = ([[0.0, 0.0], [0.5, 0.0], [1.0, each]] for each in aside)
        return {"displacement": {"x": x, "y": y, "z": down}, "rotation": still}
    if way == "turned":
        turn = {
            axis: [[0.0, 0.0], [0.5, 0.0], [1.0, each]]
            for axis, each in zip("xyz", angle, strict=True)
        }
        return {"displacement": {"x": 0.0, "y": 0.0, "z": down}, "rotation": turn}
    force = random.uniform(0.3, 1.5) * STRENGTH * size**2
    if way == "dropped":
        return {
            "displacement": {"x": 0.0, "y": 0.0}, "rotation": still, "force": {"z": -force}
        }  # fmt: skip
    return {
        "force": {"x": 0.1 * force, "y": 0.0, "z": -force},
        "springs": {
            "x": 0.05 * YOUNG * size, "y": 0.05 * YOUNG * size,
            **{f"rotation_{axis}": 0.05 * YOUNG * size**3 for axis in "xyz"},
        },
    }  # fmt: skip


def problem(seed: int, folder: Path) -> dict[str, Any]:
    """The entries of a model, whose STL file is written to the folder."""
    random = np.random.default_rng([1903, seed])
    way = WAYS[seed % len(WAYS)]
    size = random.uniform(1.5, 2.5) * CELL
    corners = corners_of(random, size)
    centre = np.append(random.uniform(-0.5, 0.5, 2) * CELL, -corners[:, 2].min())
    path = folder / f"hull{seed}.stl"
    write_hull(path, corners + centre)
    soil = material(random)
    half, height = 1.0, 0.8
    entries: dict[str, Any] = {
        "title": f"{way} polyhedron {seed}",
        "analysis": {"kind": "3d", "tolerance": 1e-9},
        "grid": {"cell_size": CELL, "origin": (random.uniform(-1.0, 0.0, 3) * CELL).tolist()},
        "materials": {"soil": soil},
        "bodies": [
            {"name": "soil", "material": "soil",
             "basis": str(random.choice(["linear", "gimp", "cpdi2"])), "points_per_cell": 2,
             "shape": {"type": "box", "lower": [-half, -half, -height], "upper": [half, half, 0.0]}}
        ],
        "boundaries": [
            {"name": "base", "type": "implicit", "condition": "fixed",
             "geometry": {"type": "plane", "point": [0.0, 0.0, -height],
                          "normal": [0.0, 0.0, 1.0]}}
        ],
        "rigid_bodies": [
            {"name": "hull", "geometry": {"type": "stl", "file": str(path), "soil": "outside"},
             "centre": centre.tolist(), "contact": law(random, soil["model"]),
             **motion(random, way, random.uniform(0.3, 0.8) * CELL, size)}
        ],
        "schedule": {"steps": STEPS, "outputs": 1},
        "output": {"report": False},
    }  # fmt: skip
    if soil["poisson_ratio"] > 0.4:
        entries["bodies"][0]["anti_locking"] = "f_bar"
    return entries
