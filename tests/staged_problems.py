# SPDX-License-Identifier: BSD-3-Clause
"""Small problems with stages: soil that is removed and placed, boundaries, materials, grids."""

from __future__ import annotations

from typing import Any

from small_problems import material_entries

KINDS = ("plane_strain", "axisymmetric", "3d")


def box(name: str, lower: list[float], upper: list[float], dim: int, **more: Any) -> dict[str, Any]:
    """A body between two corners in the plane; one unit thick along z in 3D, where z is up."""
    if dim == 3:
        lower, upper = [lower[0], 0.0, lower[1]], [upper[0], 0.5, upper[1]]
    return {
        "name": name, "material": "soil", "basis": "gimp", "points_per_cell": 2,
        "shape": {"type": "box", "lower": lower, "upper": upper}, **more,
    }  # fmt: skip


def roller(axis: str, at: float, name: str = "") -> dict[str, Any]:
    return {
        "name": name or f"{axis} at {at:g}", "type": "plane", "axis": axis, "at": at,
        "condition": "roller",
    }  # fmt: skip


def staged_entries(kind: str = "plane_strain") -> dict[str, Any]:
    """Ground with a pit that is dug, filled again, loaded, and pressed by a wall that is removed.

    The stages are "weight", "dig", "fill", "press" and "wall away".
    """
    dim = 3 if kind == "3d" else 2
    up = "z" if dim == 3 else "y"
    gravity = [0.0] * (dim - 1) + [-10.0]
    boundaries = [roller(up, 0.0, "base"), roller("x", 3.0, "side")]
    if kind != "axisymmetric":
        boundaries.append(roller("x", 0.0, "left"))
    if dim == 3:
        boundaries += [roller("y", 0.0), roller("y", 0.5)]
    point = [2.5, 0.25, 2.0] if dim == 3 else [2.5, 2.0]
    plate = {
        "name": "plate", "type": "implicit", "condition": "roller", "displacement": {up: -0.04},
        "geometry": {
            "type": "plane", "point": point, "normal": [0.0] * (dim - 1) + [-1.0],
        },
    }  # fmt: skip
    boundaries.append(plate)
    load = {"name": "footing", "type": "surface", "body": "fill", "pressure": 4.0}
    where = {"part": "z+"} if dim == 3 else {"start": [1.0, 2.0], "end": [0.0, 2.0]}
    return {
        "title": "stages",
        "analysis": {"kind": kind},
        "grid": {"cell_size": 0.5},
        "materials": {
            "soil": material_entries("von_mises", density=1.0, yield_stress=20.0),
            "firm": material_entries("mohr_coulomb", density=1.0),
        },
        "bodies": [
            box("ground", [0.0, 0.0], [3.0, 1.5], dim),
            box("pit", [0.0, 1.5], [1.0, 2.0], dim),
            box("bank", [1.0, 1.5], [3.0, 2.0], dim, basis="cpdi2"),
            box("fill", [0.0, 1.5], [1.0, 2.0], dim, surface={}, material="firm"),
        ],
        "boundaries": boundaries,
        "loads": [
            {"name": "gravity", "type": "body_force", "acceleration": gravity},
            {**load, **where},
        ],
        "stages": [
            {"name": "weight", "schedule": {"steps": 2}},
            {
                "name": "dig", "schedule": {"steps": 2, "end": 2.0}, "deactivate": ["pit"],
                "reset": ["displacement"],
            },
            {"name": "fill", "schedule": {"steps": 2}, "activate": ["fill"]},
            {
                "name": "press", "schedule": {"steps": 2}, "activate": ["plate", "footing"],
                "materials": {"soil": "firm"},
            },
            {
                "name": "wall away", "schedule": {"steps": 2, "outputs": 1},
                "deactivate": ["side", "plate", "footing"],
                "grid": {"cell_size": 0.25},
            },
        ],
        "output": {"report": False},
        "track": [
            {"name": "base", "quantity": "reaction", "boundary": "base", "component": up},
            {"name": "side", "quantity": "reaction", "boundary": "side", "component": "x"},
            {
                "name": "fill", "quantity": "displacement", "body": "fill", "component": up,
                "at": [0.5, 0.25, 1.75] if dim == 3 else [0.5, 1.75],
            },
            {"name": "work", "quantity": "energy", "kind": "external_work"},
        ],
    }  # fmt: skip
