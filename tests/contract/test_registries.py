# SPDX-License-Identifier: BSD-3-Clause
"""Every shape and every geometry that can be declared can be computed, and keeps its contract."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from implicit_entries import (
    BLADE,
    BOX,
    CIRCLE,
    CONE,
    CUBE,
    CYLINDER,
    FOOTING,
    FUNCTION,
    MESH,
    PLANE,
    PLATE,
    POLYLINE,
    SLAB,
    SPHERE,
    SPLINE,
    STL,
    TERRAIN,
    WEDGE,
    boundary,
    entries,
)

from tilth.bodies.discretise import FORMS, discretise
from tilth.bodies.forms import READERS
from tilth.geometry.make import GEOMETRIES, Geometry, make_geometry
from tilth.grid.background import Grid
from tilth.model import Body, Model, shapes
from tilth.model import geometry as geometries
from tilth.model.base import Declared

# --- geometries ------------------------------------------------------------------------------

CAVITY = "import numpy as np\ndef distance(x):\n    return np.hypot(x[:, 0] - 0.2, x[:, 1]) - 0.7\n"
TETRAHEDRON = [[[0, 0, 0], [0, 1, 0], [1, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
               [[0, 0, 0], [0, 0, 1], [0, 1, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]]  # fmt: skip
DECLARED = {
    "plane": PLANE, "circle": CIRCLE, "cylinder": CYLINDER, "sphere": SPHERE, "polyline": POLYLINE,
    "spline": SPLINE, "box": BOX, "cuboid": CUBE, "footing": FOOTING, "slab": SLAB,
    "function": FUNCTION, "stl": STL, "plate": PLATE, "blade": BLADE, "wedge": WEDGE, "cone": CONE,
    "mesh": MESH, "terrain": TERRAIN,
}  # fmt: skip
"""At least one of each type, as a case file declares them."""


def made(given: dict[str, Any], folder: Path) -> Geometry:
    """A geometry of the table, with the files that it needs in the folder."""
    (folder / "shape.py").write_text(CAVITY, encoding="utf-8")
    points = np.unique(np.reshape(TETRAHEDRON, (-1, 3)), axis=0)
    number = {tuple(point): i for i, point in enumerate(points.tolist())}
    cells = [[number[tuple(corner)] for corner in triangle] for triangle in TETRAHEDRON]
    meshio.write_points_cells(folder / "blade.stl", points, [("triangle", np.array(cells))])
    line = meshio.Mesh(
        np.array([[-1.0, 0, 0], [0.2, 0.3, 0], [1.2, 0, 0]]),
        [("line", np.array([[1, 0], [1, 2]]))],
        cell_data={"gmsh:physical": [np.ones(2, int)], "gmsh:geometrical": [np.ones(2, int)]},
        field_data={"wall": np.array([1, 1])},
    )
    line.write(folder / "wall.msh", file_format="gmsh22", binary=False)
    for key in ("file", "function"):
        if key in given:
            given = {**given, key: f"{folder}/{given[key]}"}
    wide = len(
        given.get("centre", given.get("lower", given.get("point", given.get("tip", [0, 0]))))
    )
    kind = "3d" if wide == 3 or given["type"] == "stl" else "plane_strain"
    model = Model.from_dict(entries(boundary(given), kind=kind))
    return make_geometry(model.boundaries[0], model)


def covered(geometry: Geometry, size: float) -> Any:
    """Facets about the origin."""
    reach = np.full(geometry.dim, 1.5)
    return geometry.facets(-reach, reach, size)


def test_every_declared_geometry_can_be_made_and_is_tested() -> None:
    assert tuple(GEOMETRIES) == geometries.GEOMETRIES
    types = [cls.model_fields["type"].default for cls in GEOMETRIES]
    assert set(types) == {given["type"] for given in DECLARED.values()}
    assert len(set(types)) == len(types)


@pytest.mark.parametrize("cls", [*geometries.GEOMETRIES, *shapes.SHAPES], ids=lambda c: c.__name__)
def test_a_declaration_says_where_it_exists(cls: type[Declared]) -> None:
    assert cls.dimensions in ((2,), (3,), (2, 3))
    assert "dimensions" not in cls.model_fields


@pytest.mark.parametrize("name", DECLARED)
def test_a_geometry_has_the_dimension_that_it_declares(name: str, tmp_path: Path) -> None:
    geometry = made(DECLARED[name], tmp_path)
    cls = next(c for c in GEOMETRIES if c.model_fields["type"].default == DECLARED[name]["type"])
    assert geometry.dim in cls.dimensions


@pytest.mark.parametrize("name", DECLARED)
def test_the_normal_is_the_gradient_of_the_distance(name: str, tmp_path: Path) -> None:
    """It has length one, by central differences beside the middles of the facets."""
    geometry, step = made(DECLARED[name], tmp_path), 1e-6
    facets = covered(geometry, 0.2)
    middle = geometry.project(facets.corner.mean(axis=1), facets.normal)[0]
    for away in (0.01, -0.01):
        x = middle + away * facets.normal
        slope = np.stack(
            [
                (geometry.distance(x + step * e) - geometry.distance(x - step * e)) / (2.0 * step)
                for e in np.eye(geometry.dim)
            ],
            axis=1,
        )
        unit = slope / np.linalg.norm(slope, axis=1)[:, None]
        np.testing.assert_allclose(geometry.gradient(x), unit, atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(slope, axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("name", DECLARED)
def test_facets_lie_on_the_boundary(name: str, tmp_path: Path) -> None:
    """Those of flat pieces to round-off, of others at second order; their normals are its own."""
    geometry = made(DECLARED[name], tmp_path)
    farthest = []
    for size in (0.04, 0.02):
        facets = covered(geometry, size)
        corners = facets.corner.reshape(-1, geometry.dim)
        normal = np.repeat(facets.normal, geometry.dim, axis=0)
        on_it = geometry.project(corners, normal)[0]
        np.testing.assert_allclose(geometry.distance(on_it), 0.0, atol=1e-9)
        middle = facets.corner.mean(axis=1)
        farthest.append(np.abs(geometry.distance(middle)).max())
        beside = geometry.project(middle, facets.normal)[0] + 1e-3 * facets.normal
        aligned = np.einsum("ni,ni->n", geometry.gradient(beside), facets.normal)
        assert aligned.min() > (1.0 - 1e-12 if geometry.flat else 0.9)
    assert farthest[1] <= (1e-12 if geometry.flat else 0.35 * farthest[0] + 1e-12)


# --- shapes ----------------------------------------------------------------------------------

TRIANGLES = np.array([[0.0, 0], [3, 0], [3, 2], [0.5, 2.5]]), [("triangle", [[0, 1, 2], [0, 2, 3]])]
HALF_CIRCLE = 0.5 * math.pi * 1.5**2
SHAPE_VOLUMES: list[tuple[dict[str, Any], str, float]] = [
    ({"type": "box", "lower": [1, 0], "upper": [3, 1.3], "angle": 20}, "plane_strain", 2.6),
    ({"type": "box", "lower": [0, 0, 0], "upper": [2, 1, 1.3]}, "3d", 2.6),
    ({"type": "polygon", "vertices": [[0, 0], [4, 0], [1, 3]]}, "plane_strain", 6.0),
    ({"type": "circle", "centre": [0, 1], "radius": 1.5}, "plane_strain", 2.0 * HALF_CIRCLE),
    ({"type": "circle", "centre": [0, 1], "radius": 1.5}, "axisymmetric", 4.5 * math.pi),
    (
        {"type": "cylinder", "centre": [0, 0, 0], "radius": 1.5, "axis": "y", "height": 2},
        "3d", 4.0 * HALF_CIRCLE,
    ),
    (
        {
            "type": "sphere", "centre": [0, 0, 0], "radius": 1.5, "inner_radius": 0.5,
            "sides": ["x+"],
        },
        "3d", 2.0 / 3.0 * math.pi * (1.5**3 - 0.5**3),
    ),
    ({"type": "mesh", "file": "soil.msh"}, "plane_strain", 3.0 + 3.25),
    ({"type": "stl", "file": "soil.stl", "scale": 3.0}, "3d", 27.0 / 6.0),
    ({"type": "outline", "file": "soil.json", "scale": 0.5}, "plane_strain", 1.0),
    (
        {
            "type": "terrain", "surface": [[0, 3], [2, 1]], "base": 0, "lower": [0.5],
            "upper": [1.5],
        },
        "axisymmetric", 2.0 * math.pi * (3.0 - (1.5**3 - 0.5**3) / 3.0),
    ),
]  # fmt: skip


def test_every_declared_shape_can_be_divided_and_is_tested() -> None:
    assert set(shapes.SHAPES) == {*READERS, *FORMS} & set(shapes.SHAPES)
    types = [cls.model_fields["type"].default for cls in shapes.SHAPES]
    assert set(types) == {given["type"] for given, *_ in SHAPE_VOLUMES}
    assert len(set(types)) == len(types)


@pytest.mark.parametrize(("given", "kind", "volume"), SHAPE_VOLUMES)
def test_the_volumes_of_the_points_sum_to_that_of_the_shape(
    given: dict[str, Any], kind: str, volume: float, tmp_path: Path
) -> None:
    if given["type"] == "mesh":
        given = {**given, "file": f"{tmp_path}/{given['file']}"}
        points, cells = TRIANGLES
        mesh = meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), [(n, np.array(c)) for n, c in cells])
        mesh.write(given["file"], file_format="gmsh22", binary=False)
    if given["type"] == "stl":
        given = {**given, "file": f"{tmp_path}/{given['file']}"}
        cells = [("triangle", np.arange(12).reshape(4, 3))]
        meshio.write_points_cells(given["file"], np.reshape(TETRAHEDRON, (-1, 3)), cells)
    if given["type"] == "outline":
        given = {**given, "file": f"{tmp_path}/{given['file']}"}
        corners = [[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]]
        polygon = json.dumps({"type": "Polygon", "coordinates": [corners]})
        Path(given["file"]).write_text(polygon, encoding="utf-8")
    body = Body(name="soil", material="soil", shape=given, basis="linear", points_per_cell=2)  # type: ignore[arg-type]
    dimension = 3 if kind == "3d" else 2
    found = discretise(body, kind, Grid(np.zeros(dimension), np.full(dimension, 0.25)))
    assert found.position.shape[1] == dimension
    assert found.volume.min() > 0.0
    assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-13)
