# SPDX-License-Identifier: BSD-3-Clause
"""Boundaries from physical groups of Gmsh meshes: lines in the plane, closed surfaces in space."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from implicit_entries import boundary, entries, refused

import tilth
from tilth.analysis.contact_warnings import contact_warnings
from tilth.errors import BadInput
from tilth.geometry.make import Geometry, make_geometry, make_shapes
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.polyline import Polyline
from tilth.geometry.round import Circle
from tilth.geometry.triangle_mesh import TriangleMesh
from tilth.model import Model

X = np.random.default_rng(3).uniform(-2.0, 5.0, (300, 3))
GROUND = np.array([[0.0, 1.0], [1.0, 1.3], [2.5, 0.9], [3.0, 1.1], [4.0, 1.0]])
CUBE = np.array([[i, j, k] for i in (0.0, 1.0) for j in (0.0, 1.0) for k in (0.0, 1.0)])
FACES = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
                  [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # fmt: skip


def written(folder: Path, points: Any, *groups: tuple[str, str, Any], **fields: Any) -> str:
    """Writes a mesh; each group is its name, the type of its elements, and their nodes."""
    points = np.asarray(points, dtype=float)
    dimension = {"vertex": 0, "line": 1, "line3": 1, "triangle": 2, "quad": 2}
    mesh = meshio.Mesh(
        np.pad(points, ((0, 0), (0, 3 - points.shape[1]))),
        [(kind, np.asarray(nodes)) for _, kind, nodes in groups],
        cell_data={name: [np.full(len(g[2]), 5 + i) for i, g in enumerate(groups)]
                   for name in ("gmsh:physical", "gmsh:geometrical")},
        field_data={n: np.array([5 + i, dimension[k]]) for i, (n, k, _) in enumerate(groups) if n},
        **fields,
    )  # fmt: skip
    mesh.write(folder / "a.msh", file_format="gmsh22", binary=False)
    return str(folder / "a.msh")


def made(file: str, group: str, soil: str, kind: str = "plane_strain") -> Geometry:
    given = boundary({"type": "mesh", "file": file, "group": group, "soil": soil})
    model = Model.from_dict(entries(given, kind=kind))
    return make_geometry(model.boundaries[0], model)


def refusal(file: str, group: str = "wall", soil: str = "left", kind: str = "plane_strain") -> str:
    with pytest.raises(BadInput) as caught:
        made(file, group, soil, kind)
    assert caught.value.key.startswith("boundaries[0].geometry.")
    return str(caught.value)


def chain(number: int, closed: bool = False) -> np.ndarray:
    """Elements from node to node, in any order and direction."""
    random = np.random.default_rng(number)
    lines = np.stack([np.arange(number), np.roll(np.arange(number), -1)], axis=1)
    lines = random.permutation(lines if closed else lines[:-1])
    return random.permuted(lines, axis=1)


@pytest.mark.parametrize("soil", ["left", "right"])
@pytest.mark.parametrize("back", [False, True])
def test_an_open_line_is_the_polyline_from_its_end_of_least_x(
    soil: str, back: bool, tmp_path: Path
) -> None:
    points = GROUND[::-1] if back else GROUND
    found = made(written(tmp_path, points, ("wall", "line", chain(5))), "wall", soil)
    exact = Polyline(GROUND, closed=False, left=soil == "left")
    np.testing.assert_array_equal(found.distance(X[:, :2]), exact.distance(X[:, :2]))
    np.testing.assert_array_equal(found.gradient(X[:, :2]), exact.gradient(X[:, :2]))
    above = np.array([[1.5, 4.0]])
    assert (found.distance(above)[0] > 0.0) == (soil == "left")


def test_an_upright_line_begins_at_its_lower_end(tmp_path: Path) -> None:
    points = [[1.0 + 1e-13, 3.0], [1.4, 1.0], [1.0, 0.0]]
    found = made(written(tmp_path, points, ("wall", "line", chain(3))), "wall", "left")
    assert found.distance(np.array([[0.0, 1.5], [3.0, 1.5]])).tolist()[0] > 0.0


@pytest.mark.parametrize("turned", [False, True])
def test_a_closed_curve_has_an_inside_whichever_way_it_runs(turned: bool, tmp_path: Path) -> None:
    """Chords of a circle: no farther from it than their sagitta, with the length of a polygon."""
    angle = 2.0 * np.pi * np.arange(64) / 64 * (-1.0 if turned else 1.0) + 0.3
    points = np.array([1.5, 2.0]) + 0.8 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    file = written(tmp_path, points, ("lining", "line", chain(64, closed=True)))
    for soil in ("inside", "outside"):
        found, circle = (
            made(file, "lining", soil),
            Circle(np.array([1.5, 2]), 0.8, soil == "inside"),
        )
        sagitta = 0.8 * (1.0 - np.cos(np.pi / 64))
        error = found.distance(X[:, :2]) - circle.distance(X[:, :2])
        assert np.abs(error).max() <= sagitta * (1.0 + 1e-9)
        corner = found.facets(np.zeros(2), np.ones(2), 1.0).corner
        length = np.linalg.norm(corner[:, 1] - corner[:, 0], axis=1).sum()
        assert length == pytest.approx(64 * 1.6 * np.sin(np.pi / 64), rel=1e-12)
    assert 'give "inside", "outside", "both"' in refusal(file, "lining", "left")


def test_a_group_is_found_among_bodies_and_joined_at_equal_nodes(tmp_path: Path) -> None:
    """A group without a name has its number; nodes at the same place and repeated lines are one."""
    points = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [4.0, 1.0], [2.0, -3.0]]
    lines = [[0, 1], [3, 2], [1, 0], [1, 2]]
    soil, top = ("soil", "triangle", [[0, 4, 1]]), ("", "line", lines)
    found = made(written(tmp_path, points, soil, top), "6", "right")
    exact = Polyline(np.array([[0.0, 0.0], [2.0, 0.0], [4.0, 1.0]]), closed=False, left=False)
    np.testing.assert_array_equal(found.distance(X[:, :2]), exact.distance(X[:, :2]))


@pytest.mark.parametrize("soil", ["inside", "outside"])
def test_triangles_are_a_closed_surface_however_they_are_turned(soil: str, tmp_path: Path) -> None:
    turned = FACES.copy()
    turned[[0, 3, 4, 8, 9]] = turned[[0, 3, 4, 8, 9], ::-1]
    found = made(written(tmp_path, CUBE, ("rock", "triangle", turned)), "rock", soil, "3d")
    exact = TriangleMesh(CUBE[FACES], soil == "inside")
    np.testing.assert_allclose(found.distance(X), exact.distance(X), rtol=1e-14, atol=1e-14)
    sign = 1.0 if soil == "inside" else -1.0
    assert found.distance(np.array([[0.5, 0.5, 0.5]]))[0] == pytest.approx(0.5 * sign)


@pytest.mark.parametrize("soil", ["front", "back"])
def test_triangles_are_an_open_surface(soil: str, tmp_path: Path) -> None:
    """The sides of a box without its lid and floor, whose normals point outwards."""
    sides = FACES[(CUBE[FACES][..., 2] != CUBE[FACES][:, :1, 2]).any(axis=1)]
    found = made(written(tmp_path, CUBE, ("rock", "triangle", sides)), "rock", soil, "3d")
    exact = OpenSurface(CUBE, sides, soil == "front")
    np.testing.assert_allclose(found.distance(X), exact.distance(X), rtol=1e-14, atol=1e-14)
    sign = -1.0 if soil == "front" else 1.0
    assert found.distance(np.array([[0.4, 0.5, 0.5]]))[0] == pytest.approx(0.4 * sign)
    closed = written(tmp_path, CUBE, ("rock", "triangle", FACES))
    assert "the surface is closed" in refusal(closed, "rock", soil, "3d")
    assert "side of a surface, in 3D" in refusal(closed, "rock", soil)


BRANCH = [[0, 0], [1, 0], [2, 0], [1, 1], [5, 5], [6, 5]]
WRONG: dict[str, tuple[Any, list[Any], list[str]]] = {
    "branches": (
        BRANCH, [("wall", "line", [[0, 1], [1, 2], [1, 3]])], ["3 of its lines", "(1, 0)"],
    ),
    "pieces": (
        BRANCH, [("wall", "line", [[0, 1], [4, 5]])],
        ["2 separate lines", "(0, 0) and (5, 5)", "join them"],
    ),
    "crossing": (
        [[0, 0], [2, 2], [2, 0], [0, 2]], [("wall", "line", [[0, 1], [1, 2], [2, 3]])],
        ["crosses itself"],
    ),
    "no length": ([[1, 1], [1, 1]], [("wall", "line", [[0, 1]])], ["no length"]),
    "not flat": ([[0, 0, 0], [1, 0, 1]], [("wall", "line", [[0, 1]])], ["not flat", "z runs from"]),
    "unknown": (BRANCH, [("wall 1", "line", [[0, 1]])], ["did you mean `wall 1`?"]),
    "other dimension": (
        BRANCH, [("wall", "triangle", [[0, 1, 3]])], ["group of surface elements, not of lines"],
    ),
    "second order": (BRANCH, [("wall", "line3", [[0, 2, 1]])], ["line3", "first order"]),
    "closed": (BRANCH, [("wall", "line", [[0, 1], [1, 3], [3, 0]])], ['give "inside"']),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG)
def test_groups_that_are_no_line(name: str, tmp_path: Path) -> None:
    points, groups, parts = WRONG[name]
    found = refusal(written(tmp_path, points, *groups))
    assert all(part in found for part in parts), found


def test_groups_that_are_no_surface(tmp_path: Path) -> None:
    open_one = written(tmp_path, CUBE, ("wall", "triangle", FACES[1:]))
    assert "not closed" in refusal(open_one, soil="inside", kind="3d")
    two = (
        np.concatenate([CUBE, CUBE + 3.0]),
        ("wall", "triangle", np.concatenate([FACES, FACES + 8])),
    )
    assert "2 separate surfaces" in refusal(written(tmp_path, *two), soil="inside", kind="3d")
    quads = written(tmp_path, CUBE, ("wall", "quad", [[0, 1, 3, 2]]))
    assert "mesh it with triangles" in refusal(quads, soil="inside", kind="3d")
    lines = written(tmp_path, CUBE, ("wall", "line", [[0, 1]]))
    assert "give a physical group of triangles" in refusal(lines, soil="inside", kind="3d")
    given = {"type": "mesh", "file": open_one, "group": "wall", "soil": "left"}
    error = refused(entries(boundary(given), kind="3d"))
    assert error.key == "boundaries[0].geometry.soil"


def test_files_that_cannot_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "none.msh"
    assert "there is no such file" in refusal(str(file))
    file.write_text("nonsense", encoding="utf-8")
    assert "cannot be read as a Gmsh mesh" in refusal(str(file))

    entities = "0 2 0 0\n" + "".join(f"{i} 0 0 0 1 0 0 {g} 0\n" for i, g in ((1, "1 5"), (2, "0")))
    file.write_text(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n" + entities + "$EndEntities\n"
        "$Nodes\n1 3 1 3\n1 1 0 3\n1\n2\n3\n0 0 0\n1 0 0\n2 0 0\n$EndNodes\n"
        "$Elements\n2 2 1 2\n1 1 1 1\n1 1 2\n1 2 1 1\n2 2 3\n$EndElements\n",
        encoding="utf-8",
    )
    assert "without Mesh.SaveAll" in refusal(str(file), "5")

    def missing(name: str) -> Any:
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    assert "pip install meshio" in refusal(str(file))


def test_a_rigid_body_may_be_a_group(tmp_path: Path) -> None:
    """One with soil on one side of an open line is warned of, as a polyline is."""
    file = written(tmp_path, GROUND, ("wall", "line", chain(5)))
    shape = {"type": "mesh", "file": file, "group": "wall", "soil": "left"}
    body = {"name": "blade", "geometry": shape, "centre": [0, 1], "rotation": 0,
            "contact": {"normal": "unilateral", "tangential": "smooth"},
            "displacement": {"x": 0, "y": -1}}  # fmt: skip
    for soil, warned in (("left", True), ("both", False)):
        given = {**body, "geometry": {**shape, "soil": soil}}
        model = Model.from_dict(entries(rigid_bodies=[given]))
        distance = make_shapes(model.rigid_bodies[0], model)[0].distance(X[:, :2])
        assert (distance.min() < -1.0) == warned
        found = [name for name, _ in contact_warnings(model) if name.startswith("one side of")]
        assert bool(found) == warned


CASE = """format = 1
title = "Block on an uneven base"
analysis = { kind = "plane_strain" }
grid = { cell_size = 0.5 }
schedule = { steps = 1 }
materials.soil = { model = "hencky_elastic", young_modulus = 1e6, poisson_ratio = 0.3, density = 2e3 }
loads = [{ type = "body_force", acceleration = [0.0, -9.81] }]
boundaries = [{ name = "base", type = "implicit", condition = "fixed", geometry = GEOMETRY }]
bodies = [{ name = "soil", material = "soil", basis = "gimp", points_per_cell = 2, shape = { type = "polygon", vertices = [[0, 1], [1, 1.3], [2.5, 0.9], [3, 1.1], [4, 1], [4, 3], [0, 3]] } }]
"""  # noqa: E501


@pytest.mark.slow
def test_the_run_on_a_group_is_that_on_the_polyline(tmp_path: Path) -> None:
    written(tmp_path, GROUND, ("base", "line", chain(5)))
    ends = []
    for name, geometry in (
        ("typed", f'{{ type = "polyline", vertices = {GROUND.tolist()}, soil = "left" }}'),
        ("meshed", '{ type = "mesh", file = "a.msh", group = "base", soil = "left" }'),
    ):
        case = tmp_path / f"{name}.toml"
        case.write_text(CASE.replace("GEOMETRY", geometry), encoding="utf-8")
        ends.append(tilth.run(tilth.load_case(case), tmp_path / name, quiet=True).points)
    typed, meshed = ends
    np.testing.assert_array_equal(meshed.displacement, typed.displacement)
    np.testing.assert_array_equal(meshed.stress, typed.stress)
    assert typed.displacement[:, 1].min() < -1e-3
