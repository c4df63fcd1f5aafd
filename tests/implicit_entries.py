# SPDX-License-Identifier: BSD-3-Clause
"""Declared implicit boundaries, and what a wrong one is told."""

from __future__ import annotations

from typing import Any

import pytest

from tilth.errors import BadInput
from tilth.model import Model

PLANE = {"type": "plane", "point": [0, 0.1], "normal": [0, 1]}


CIRCLE = {"type": "circle", "centre": [0, 1], "radius": 0.3, "soil": "outside"}


CYLINDER = {
    "type": "cylinder", "centre": [0, 0, 1], "axis": "z", "radius": 0.3, "soil": "outside",
}  # fmt: skip


SPLINE = {
    "type": "spline", "vertices": [[0, 0], [1, 0.1], [2, 0], [2, 1]], "corners": [2],
    "soil": "left",
}  # fmt: skip


SPHERE = {"type": "sphere", "centre": [0, 0, 1], "radius": 0.3, "soil": "inside"}


POLYLINE = {"type": "polyline", "vertices": [[0, 0], [1, 0.1], [2, 0]], "soil": "left"}


BOX = {"type": "box", "lower": [0, 0], "upper": [1, 2], "soil": "inside"}


CUBE = {"type": "box", "lower": [0, 0, 0], "upper": [1, 2, 1], "soil": "outside"}


FOOTING = {"type": "footing", "centre": [0, 2], "normal": [0, -1], "width": 0.5}


SLAB = {
    "type": "footing", "centre": [0, 0, 2], "normal": [0, 0, -1], "width": [0.5, 0.2],
    "along": [1, 1, 0],
}  # fmt: skip


PLATE = {
    "type": "plate", "centre": [0, 2], "normal": [1, -2], "width": 0.5, "thickness": 0.1,
}  # fmt: skip


BLADE = {
    "type": "plate", "centre": [0, 0, 2], "normal": [1, 0, -1], "width": [0.5, 0.2],
    "along": [1, 1, 0], "thickness": 0.1,
}  # fmt: skip


WEDGE = {
    "type": "cone", "tip": [0, 0.5], "angle": 60, "radius": 0.3, "length": 1, "soil": "outside",
}  # fmt: skip


CONE = {
    "type": "cone", "tip": [0, 0, 0.5], "axis": [0.1, 0, 1], "angle": 60, "radius": 0.3,
    "length": 0.4, "soil": "outside",
}  # fmt: skip


FUNCTION = {"type": "function", "function": "shape.py:distance"}


STL = {"type": "stl", "file": "blade.stl", "soil": "outside"}
TERRAIN = {
    "type": "terrain", "surface": [[-1.5, 0.1], [0.2, 0.4], [1.5, -0.2]], "lower": [-1.5],
    "upper": [1.5], "soil": "above",
}  # fmt: skip


MESH = {"type": "mesh", "file": "wall.msh", "group": "wall", "soil": "right"}


def boundary(geometry: dict[str, Any] = PLANE, **entries: Any) -> dict[str, Any]:
    """An implicit boundary as a case file would declare it."""
    return {
        "type": "implicit", "name": "wall", "geometry": geometry, "condition": "roller", **entries,
    }  # fmt: skip


def entries(
    *boundaries: dict[str, Any], kind: str = "plane_strain", cell_size: Any = 0.5, **replaced: Any
) -> dict[str, Any]:
    """A model as a case file would declare it."""
    dim = 3 if kind == "3d" else 2
    box = {"type": "box", "lower": [0] * dim, "upper": [1] * dim}
    body = {"name": "b", "material": "m", "shape": box, "basis": "linear", "points_per_cell": 2}
    return {
        "analysis": {"kind": kind},
        "grid": {"cell_size": cell_size},
        "materials": {"m": {"model": "hencky_elastic", "young_modulus": 1, "poisson_ratio": 0}},
        "bodies": [body],
        "boundaries": list(boundaries),
        "schedule": {"steps": 1},
        **replaced,
    }


def refused(given: dict[str, Any]) -> BadInput:
    with pytest.raises(BadInput) as caught:
        Model.from_dict(given)
    return caught.value


def taken_or_refused(given: dict[str, Any]) -> tuple[dict[str, Any] | None, str]:
    """Returns the model of `given` as a dictionary, or the message; anything else is raised."""
    try:
        return Model.from_dict(given).to_dict(), ""
    except BadInput as error:
        return None, str(error)
