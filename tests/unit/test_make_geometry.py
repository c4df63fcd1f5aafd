# SPDX-License-Identifier: BSD-3-Clause
"""From a declared geometry to the one that the simulation measures distances with."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_entries import (
    BOX,
    CIRCLE,
    CUBE,
    CYLINDER,
    FOOTING,
    FUNCTION,
    PLANE,
    POLYLINE,
    SLAB,
    SPHERE,
    SPLINE,
    STL,
    boundary,
    entries,
)

from tilth.errors import BadInput
from tilth.geometry.make import make_geometry
from tilth.model import Model

SQUARE_FUNCTION = """
def distance(x):
    return x[:, 1] - 0.25
"""
TETRAHEDRON = [
    [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
    [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
    [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
]


def stl(triangles: list[list[list[float]]]) -> str:
    """An STL file as text."""
    facets = [
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x} {y} {z}\n" for x, y, z in triangle)
        + "endloop\nendfacet\n"
        for triangle in triangles
    ]
    return "solid s\n" + "".join(facets) + "endsolid s\n"


HALF = math.sqrt(0.5)
ANGLE = [[0, 0], [1, 0], [2, 0], [2, 3]]  # turns at vertex 2, the corner of SPLINE
DISTANCES: list[tuple[dict[str, Any], list[float], float]] = [
    ({**PLANE, "normal": [0, 3]}, [7, 0.6], 0.5),
    (CIRCLE, [0.5, 1], 0.2),
    ({**CIRCLE, "soil": "inside"}, [0.5, 1], -0.2),
    (CYLINDER, [0.5, 0, 9], 0.2),
    ({**CYLINDER, "axis": [0, -2, 0], "soil": "inside"}, [0.1, 5, 1], 0.2),
    (SPHERE, [0.1, 0, 1], 0.2),
    ({**SPHERE, "soil": "outside"}, [0.1, 0, 1], -0.2),
    ({**POLYLINE, "vertices": [[0, 0], [2, 0], [4, 0]]}, [1, 0.3], 0.3),
    ({**POLYLINE, "vertices": [[0, 0], [2, 0], [4, 0]], "soil": "right"}, [1, 0.3], -0.3),
    ({**POLYLINE, "vertices": [[0, 0], [4, 0], [0, 4]], "closed": True}, [1, 2.5], 0.5 * HALF),
    ({**SPLINE, "vertices": [[0, 0], [2, 0], [4, 0]]}, [1, 0.3], 0.3),
    ({**SPLINE, "vertices": [[0, 0], [2, 0], [4, 0]], "soil": "right"}, [1, 0.3], -0.3),
    (
        {**SPLINE, "vertices": [[0, 0], [4, 0], [0, 4]], "closed": True, "corners": [0, 1, 2]},
        [1, 2.5], 0.5 * HALF,
    ),
    ({**SPLINE, "vertices": ANGLE}, [5, -4], -5.0),  # 3 and 4 away from the corner at (2, 0)
    ({**SPLINE, "vertices": ANGLE, "soil": "right"}, [5, -4], 5.0),
    (BOX, [0.9, 1], 0.1),
    ({**BOX, "angle": 90}, [-1.5, 0.7], 0.3),
    (CUBE, [0.5, 2.2, 0.5], 0.2),
    (FOOTING, [0.1, 1.9], 0.1),
    (FOOTING, [0.25 + 0.3, 1.6], 0.5),
    (SLAB, [0.25 * HALF, 0.25 * HALF, 1.9], 0.1),  # on the edge along `along`
    (SLAB, [0.2 * HALF, -0.2 * HALF, 2 - 0.1], math.sqrt(0.02)),  # 0.1 beside the shorter one
    (FUNCTION, [3, 0.75], 0.5),
    (STL, [-0.5, 0.2, 0.2], 0.5),
    ({**STL, "soil": "inside"}, [0.1, 0.2, 0.2], 0.1),
]  # fmt: skip


@pytest.mark.parametrize(("geometry", "place", "distance"), DISTANCES)
def test_the_geometry_that_is_made_has_the_declared_distance(
    tmp_path: Path, geometry: dict[str, Any], place: list[float], distance: float
) -> None:
    (tmp_path / "shape.py").write_text(SQUARE_FUNCTION, encoding="utf-8")
    (tmp_path / "blade.stl").write_text(stl(TETRAHEDRON), encoding="utf-8")
    for key in ("file", "function"):
        if key in geometry:
            geometry = {**geometry, key: f"{tmp_path}/{geometry[key]}"}
    kind = "3d" if len(place) == 3 else "plane_strain"
    model = Model.from_dict(entries(boundary(geometry), kind=kind))
    made = make_geometry(model.boundaries[0], model)
    assert made.dim == len(place)
    assert made.distance(np.array([place]))[0] == pytest.approx(distance, abs=1e-12)


def test_faces_of_a_box() -> None:
    model = Model.from_dict(entries(boundary({**BOX, "faces": ["x-", "y+"]})))
    facets = make_geometry(model.boundaries[0], model).facets(np.zeros(2), np.ones(2), 0.5)
    assert {tuple(normal) for normal in facets.normal} == {(1.0, 0.0), (0.0, -1.0)}


def test_a_function_that_cannot_be_loaded_names_its_key(tmp_path: Path) -> None:
    (tmp_path / "shape.py").write_text(SQUARE_FUNCTION, encoding="utf-8")
    given = {**FUNCTION, "function": f"{tmp_path}/shape.py:distanc"}
    model = Model.from_dict(entries(boundary(name="first"), boundary(given)))
    with pytest.raises(BadInput, match="did you mean `distance`") as caught:
        make_geometry(model.boundaries[1], model)
    assert caught.value.key == "boundaries[1].geometry.function"


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"vertices": [[0, 0], [1, 0], [1, 0], [2, 1]]}, "the same point: points 1, 2"),
        ({"vertices": [[0, 0], [1, 0], [1, 1], [0, 0]], "closed": True}, "points 0, 3"),
        ({"vertices": [[0, 0], [2, 0], [2, 2], [1, -1]]}, "crosses itself at (1.333, 0)"),
        ({"vertices": [[0, 0], [1, 1], [1, 0], [0, 1]], "closed": True}, "crosses itself"),
        ({"vertices": [[0, 0]], "corners": []}, "too few for a chain that is open"),
        ({"vertices": [[0, 0], [1, 0]], "closed": True, "corners": []}, "a chain that is closed"),
    ],
)
def test_vertices_that_make_no_spline(wrong: dict[str, Any], words: str) -> None:
    given = boundary({**SPLINE, **wrong})
    model = Model.from_dict(entries(boundary(name="first"), given))
    with pytest.raises(BadInput) as caught:
        make_geometry(model.boundaries[1], model)
    assert caught.value.key == "boundaries[1].geometry.vertices"
    assert words in str(caught.value)
    assert "give" in str(caught.value) or "close" in str(caught.value)
