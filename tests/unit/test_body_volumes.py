# SPDX-License-Identifier: BSD-3-Clause
"""Volumes of points against those of their shapes; shells and elements that count places twice."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from test_stl_bodies import box, octahedron, refusal, stl

from tilth.bodies.discretise import discretise, requested
from tilth.bodies.filling import require_filled
from tilth.bodies.inside import inside_of
from tilth.bodies.request import BodyPoints
from tilth.bodies.stl_file import closed_surface
from tilth.errors import BadInput
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.grid.background import Grid
from tilth.model import Body, Box, Circle, Cylinder, Mesh, Outline, Polygon, Sphere, Terrain
from tilth.model.shapes import DeclaredShape
from tilth.mpm.layers import by_layer

PLANE, SPACE = (Grid(np.zeros(d), np.full(d, 0.5)) for d in (2, 3))
LINE = np.array([0.0, 0.1, 0.25, 0.6, 1.2, 2.0, 2.4, 3.0, 4.0, 6.0])
NONE = np.zeros(0)
GRADED = {
    2: Grid(np.zeros(2), np.array([0.1, 0.5]), lines=(LINE, NONE)),
    3: Grid(np.zeros(3), np.array([0.5, 0.5, 0.1]), lines=(NONE, NONE, LINE)),
}


def body(shape: Any, points_per_cell: int = 2, basis: str = "gimp") -> Body:
    return Body(name="s", material="m", basis=basis, points_per_cell=points_per_cell, shape=shape)  # type: ignore[arg-type]


def mesh(folder: Path, points: Any, elements: Any, kind: str = "triangle") -> Mesh:
    file = folder / "body.msh"
    points = np.asarray(points, dtype=float)
    points = np.pad(points, ((0, 0), (0, 3 - points.shape[1])))
    meshio.write_points_cells(
        file, points, [(kind, np.asarray(elements))], file_format="gmsh22", binary=False
    )
    return Mesh(file=str(file))


CENTRES = np.stack(np.meshgrid(*2 * [np.arange(16) * 0.25 - 0.875]), axis=-1).reshape(-1, 2)
ROUND = {"type": "circle", "centre": [4.0, 3.0], "radius": 1.0}
IN_PLANE: list[tuple[DeclaredShape, float, float]] = [
    (Box(lower=[1, 1], upper=[4.3, 2.7]), 3.3 * 1.7, 2.65),
    (Box(lower=[2, 1], upper=[4, 2], angle=30.0), 2.0, 2 + math.sqrt(0.75) - 0.25),
    (Box(lower=[1, 0], upper=[11, 6], holes=[ROUND]), 60 - math.pi, 0.0),  # type: ignore[list-item]
    (Polygon(vertices=[[1, 1], [5, 1], [1, 4.1]]), 6.2, 1 + 4 / 3),
    (Circle(centre=[3, 2], radius=1.6), 1.6**2 * math.pi, 3.0),
]


@pytest.mark.parametrize("grid", [PLANE, GRADED[2]], ids=["equal", "graded"])
@pytest.mark.parametrize(
    ("shape", "area", "radius"), IN_PLANE, ids=lambda each: type(each).__name__
)
def test_points_in_the_plane_have_the_volume(
    shape: Any, area: float, radius: float, grid: Grid
) -> None:
    """Per unit thickness, and per full circle by Pappus with the centroid's radius."""
    found = discretise(body(shape), "plane_strain", grid)
    assert math.fsum(found.volume) == pytest.approx(area, rel=1e-13)
    if radius:
        found = discretise(body(shape), "axisymmetric", grid)
        assert math.fsum(found.volume) == pytest.approx(2 * math.pi * radius * area, rel=1e-12)


@pytest.mark.parametrize("grid", [SPACE, GRADED[3]], ids=["equal", "graded"])
@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (Box(lower=[0, 0, 0], upper=[2.1, 1, 1.3]), 2.73),
        (Cylinder(centre=[2, 2, 1], radius=1.4, height=2.0, axis="z"), 3.92 * math.pi),
        (Sphere(centre=[2, 2, 2], radius=1.7, inner_radius=0.7), 4 / 3 * math.pi * 4.57),
    ],
)
def test_points_in_space_have_the_volume(shape: Any, volume: float, grid: Grid) -> None:
    found = discretise(body(shape), "3d", grid)
    assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-12)


@pytest.mark.parametrize("grid", [SPACE, GRADED[3]], ids=["equal", "graded"])
def test_terrain_and_what_is_cut_out_of_it_have_the_volume(grid: Grid, tmp_path: Path) -> None:
    """A plane surface over 4 x 3, less a ball and a cellar."""
    rows = [f"{x},{y},{2 + 0.1 * x + 0.05 * y}" for y in (0, 3) for x in (0, 4)]
    (tmp_path / "h.csv").write_text("\n".join(["x,y,z", *rows]))
    surface = {"file": f"{tmp_path}/h.csv"}
    ground = Terrain(lower=[0, 0], upper=[4, 3], base=0.0, surface=surface)  # type: ignore[arg-type]
    whole = 12.0 * (2.0 + 0.2 + 0.075)
    assert math.fsum(discretise(body(ground), "3d", grid).volume) == pytest.approx(whole, rel=1e-12)
    holes = [
        {"type": "sphere", "centre": [1.2, 1.2, 1.0], "radius": 0.7},
        {"type": "box", "lower": [2.5, 1.0, 0.5], "upper": [3.5, 2.0, 1.5]},
    ]
    cut = Terrain(lower=[0, 0], upper=[4, 3], base=0.0, surface=surface, holes=holes)  # type: ignore[arg-type]
    left = whole - 4 / 3 * math.pi * 0.343 - 1.0
    assert math.fsum(discretise(body(cut), "3d", grid).volume) == pytest.approx(left, rel=1e-12)


def test_an_outline_with_a_hole_and_its_layers_have_the_volume(tmp_path: Path) -> None:
    """Each layer within half a sub-cell of its own area, and all of them exactly."""
    ring = [[0, 0], [6, 0], [6, 3], [0, 4], [0, 0]]
    hole = [[2, 1], [2, 2], [4, 2], [4, 1], [2, 1]]
    entry = {"type": "Polygon", "coordinates": [ring, hole]}
    (tmp_path / "a.geojson").write_text(json.dumps(entry))
    layers = [{"material": "m", "bottom": 1.5}, {"material": "n"}]
    given = Body(
        name="s", basis="gimp", points_per_cell=4, layers=layers,  # type: ignore[arg-type]
        shape=Outline(file=f"{tmp_path}/a.geojson", scale=1.0),
    )  # fmt: skip
    points = discretise(given, "plane_strain", PLANE)
    assert math.fsum(points.volume) == pytest.approx(21.0 - 2.0, rel=1e-13)
    ordered, counts = by_layer(given, points, "bodies[0]")
    lower = math.fsum(ordered.volume[counts[0] :])
    assert lower == pytest.approx(9.0 - 1.0, abs=0.0625 * (6 + 2))
    assert math.fsum(ordered.volume) == pytest.approx(19.0, rel=1e-13)


def test_parts_between_the_points_are_not_made_up_for_in_silence() -> None:
    """A comb of 20 fins of 0.1 x 6 that no centre is in, on a base of 12 x 1.8 of four rows."""
    outline = [[0.0, 0.0], [12.0, 0.0], [12.0, 1.8]]
    for x in 0.45 * np.arange(20, 0, -1):
        outline += [[x + 0.05, 1.8], [x + 0.05, 7.8], [x - 0.05, 7.8], [x - 0.05, 1.8]]
    comb = Polygon(vertices=[*outline, [0.0, 1.8]])  # type: ignore[list-item]
    assert comb.measure() == pytest.approx(33.6)
    cells = Grid(np.zeros(2), np.full(2, 0.45))
    with pytest.raises(BadInput) as error:
        discretise(body(comb, 1), "plane_strain", cells)
    for part in ('bodies "s".points_per_cell', "of the volume 33.6 of the shape", "finer grid"):
        assert part in str(error.value)
    found = discretise(body(comb, 8), "plane_strain", cells)
    assert math.fsum(found.volume) == pytest.approx(33.6, rel=1e-13)


@pytest.mark.parametrize("seed", range(8))
def test_the_bound_holds_for_bodies_of_few_points(seed: int) -> None:
    """Random triangles, discs and boxes about as large as a cell are never refused."""
    random = np.random.default_rng(seed)
    for _ in range(40):
        corner = random.uniform(0.0, 2.0, (3, 2))
        shapes = [Circle(centre=corner[0].tolist(), radius=float(random.uniform(0.2, 1.0)))]
        if abs(np.linalg.det(corner[1:] - corner[0])) > 0.4:
            shapes.append(Polygon(vertices=corner.tolist()))  # type: ignore[arg-type]
        for shape in shapes:
            if not inside_of(shape)(CENTRES).any():
                continue  # no material point
            points = discretise(body(shape), "plane_strain", PLANE)
            assert math.fsum(points.volume) == pytest.approx(shape.measure(), rel=1e-12)


def test_filling_counts_open_sides() -> None:
    """Half a row of sub-cells less on one side of a box is allowed, more is not."""
    request = requested(body(Box(lower=[0, 0], upper=[2, 1])), "plane_strain", PLANE)
    x, y = np.meshgrid(np.arange(8) * 0.25 + 0.125, np.arange(4) * 0.25 + 0.125)
    position = np.column_stack([x.ravel(), y.ravel()])
    sides = 0.5 * 0.0625 * (2 * 8 + 2 * 4)
    for difference, refused in ((0.99 * sides, False), (1.01 * sides, True)):
        volume = np.full(32, (2.0 + difference) / 32)
        points = BodyPoints(position, volume, np.full((32, 2), 0.125))
        if refused:
            with pytest.raises(BadInput, match=r"a difference of 0\.75 at most"):
                require_filled(points, request)
        else:
            require_filled(points, request)


CUBE = box((0, 0, 0), (2, 2, 2))


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([CUBE, box((3, 3, 0), (4, 4, 1), True)], ["shell 2 of 2", "turned inwards"]),
        ([CUBE, box((1.5, 1.5, 1.5), (2.5, 2.5, 2.5), True)], ["turned inwards", "shell 2"]),
        ([CUBE, box((0.5, 0.5, 0.5), (1.5, 1.5, 1.5))], ["shell 2", "outwards", "cavity"]),
        ([octahedron((2, 2, 2), 0.6), octahedron((2, 2, 2), 1.9)], ["shell 1 of 2", "cavity"]),
        ([CUBE, box((1, 1, 1), (3, 3, 3))], ["shell 1", "overlaps shell 2", "unite"]),
        ([CUBE, octahedron((2.4, 1, 1), 0.5)], ["overlaps", "count 2 times"]),
    ],
)
def test_shells_that_are_nested_wrongly(parts: Any, words: list[str], tmp_path: Path) -> None:
    with np.errstate(over="raise", invalid="raise", divide="raise"):
        found = refusal(stl(tmp_path, *parts))
    for word in words:
        assert word in found, found
    assert 'bodies "s".shape.file' in found
    with pytest.raises(BadInput) as error:
        TriangleMesh(np.concatenate(parts), inside=False, key="boundaries.geometry.file")
    assert "boundaries.geometry.file" in str(error.value)


def test_shells_that_are_nested_rightly() -> None:
    """A body in the cavity of another, bodies apart, and bodies whose faces touch in part."""
    shell = [CUBE, box((0.5, 0.5, 0.5), (1.5, 1.5, 1.5), True), box((0.7, 0.7, 0.7), (1, 1, 1))]
    for parts, volume in (
        (shell, 8 - 1 + 0.027),
        ([CUBE, box((3, 0, 0), (4, 1, 1))], 9.0),
        ([CUBE, box((2, 0.5, 0.5), (3, 1.5, 1.5))], 9.0),
        ([CUBE, box((0.5, 0.5, 2), (1.5, 1.5, 3))], 9.0),
    ):
        assert closed_surface(np.concatenate(parts))[2] == pytest.approx(volume)
        turned = np.concatenate(parts)[:, ::-1]  # the whole the other way round is the same body
        assert closed_surface(turned)[2] == pytest.approx(volume)


def test_a_surface_that_passes_through_itself() -> None:
    """A prism on a bow-tie whose one half is larger."""
    bow = np.array([[0, 0], [3, 3], [3, 0], [0, 1.0]])
    low, high = (np.column_stack([bow, np.full(4, z)]) for z in (0.0, 1.0))
    triangles = [[low[0], low[2], low[1]], [low[0], low[3], low[2]]]
    triangles += [[high[0], high[1], high[2]], [high[0], high[2], high[3]]]
    for i in range(4):
        j = (i + 1) % 4
        triangles += [[low[i], low[j], high[j]], [low[i], high[j], high[i]]]
    with pytest.raises(BadInput, match="passes through itself"):
        closed_surface(np.array(triangles))


SQUARE = [[0, 0], [4, 0], [4, 2], [0, 2]]


@pytest.mark.parametrize(
    ("points", "elements", "kind", "words"),
    [
        (SQUARE, [[0, 1, 2], [0, 1, 3]], "triangle", "triangle 1 and triangle 2"),
        (
            [*SQUARE, [3, 1], [6, 1], [6, 3], [3, 3]],
            [[0, 1, 2, 3], [4, 5, 6, 7]],
            "quad",
            "quadrilateral 1 and quadrilateral 2",
        ),
        (
            [[0, 0], [4, 0], [4, 1], [0, 1], [1, -1], [2, -1], [2, 3], [1, 3]],
            [[0, 1, 2, 3], [4, 5, 6, 7]],  # crossing, no corner in the other
            "quad",
            "quadrilateral 1 and quadrilateral 2",
        ),
        (
            [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 2]],
            [[0, 1, 2, 3], [0, 1, 2, 4]],
            "tetra",
            "tetrahedron 1 and tetrahedron 2",
        ),
    ],
)
def test_elements_that_overlap(
    points: Any, elements: Any, kind: str, words: str, tmp_path: Path
) -> None:
    shape = mesh(tmp_path, points, elements, kind)
    found = refusal(shape, len(points[0]))
    for part in (words, "which would count 2 times", 'shape.file = "', "body.msh"):
        assert part in found


def test_elements_side_by_side_are_apart(tmp_path: Path) -> None:
    """Also with nodes of their own, hanging nodes, a hole, and warped faces in common."""
    hanging = [*SQUARE, [4, 1], [8, 0], [8, 2], [4, 0], [4, 2]]
    quads = [[0, 1, 2, 3], [7, 5, 6, 8]]
    assert discretise(
        body(mesh(tmp_path, hanging, quads, "quad")), "plane_strain", PLANE
    ).volume.sum() == pytest.approx(16.0)
    triangles = [[0, 1, 2], [0, 2, 3], [7, 5, 4], [4, 5, 6], [4, 6, 8]]
    found = discretise(body(mesh(tmp_path, hanging, triangles)), "plane_strain", PLANE)
    assert found.volume.sum() == pytest.approx(16.0)
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1, 2)], dtype=float)
    cube[[4, 10]] += [[0.2, 0.1, 0.15], [-0.15, 0.1, 0.2]]  # the face in common is not plane
    bricks = [[i, i + 1, i + 4, i + 3, i + 6, i + 7, i + 10, i + 9] for i in (0, 1)]
    found = discretise(body(mesh(tmp_path, cube, bricks, "hexahedron")), "3d", SPACE)
    assert 1.5 < found.volume.sum() < 2.5


@pytest.mark.parametrize("version", ["2.2", "4.1"])
def test_nodes_that_the_file_does_not_have(version: str, tmp_path: Path) -> None:
    file = tmp_path / "body.msh"
    nodes = ["1 0 0 0", "2 4 0 0", "3 4 2 0", "4 0 2 0"]
    if version == "2.2":
        lines = ["$Nodes", "4", *nodes, "$EndNodes", "$Elements", "2"]
        lines += ["1 2 2 0 1 {} 2 3", "2 2 2 0 1 1 3 4", "$EndElements"]
    else:
        lines = ["$Nodes", "1 4 1 4", "2 1 0 4", *"1234"]
        lines += [node[2:] for node in nodes] + ["$EndNodes", "$Elements", "1 2 1 2"]
        lines += ["2 1 2 2", "1 {} 2 3", "2 1 3 4", "$EndElements"]
    text = "\n".join([f"$MeshFormat\n{version} 0 8\n$EndMeshFormat", *lines]) + "\n"
    file.write_text(text.format(1))
    found = discretise(body(Mesh(file=str(file))), "plane_strain", PLANE)
    assert found.volume.sum() == pytest.approx(8.0)
    file.write_text(text.format(0))
    found_text = refusal(Mesh(file=str(file)), 2)
    assert "element 1 has a node that the file does not have" in found_text
    assert 'bodies "s".shape.file' in found_text
