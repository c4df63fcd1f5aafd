# SPDX-License-Identifier: BSD-3-Clause
"""Layers of a body: which points they have, and what stays that of the whole body."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_bodies import write
from small_problems import (
    BASES,
    KINDS,
    assert_same_bits,
    block_entries,
    dimension,
    material_entries,
    plane,
    rollers,
    weight,
)

from tilth import BadInput, Model, load_case, run
from tilth.analysis.march import march
from tilth.analysis.setup_picture import setup_of
from tilth.analysis.tracker import Tracker
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.output import read_results
from tilth.terms.loads import nearest_points


def layered(kind: str, basis: str, bottom: Any, **changed: Any) -> dict[str, Any]:
    """A block of 2 cells a side, sand over clay, that sinks under its own weight."""
    loads = [weight(kind, 10.0)]
    entries = block_entries(kind, basis, loads=loads, boundaries=rollers(kind), **changed)
    del entries["bodies"][0]["material"]
    entries["bodies"][0]["layers"] = [
        {"material": "sand", "bottom": bottom},
        {"material": "clay"},
    ]
    entries["materials"] = {
        "sand": material_entries("hencky_elastic", density=2.0, young_modulus=3000.0),
        "clay": material_entries("hencky_elastic", density=1.5),
    }
    return entries


def points_of(entries: dict[str, Any]) -> MaterialPoints:
    return initial_points(Model.from_dict(entries))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_two_layers_of_one_material_are_that_material(kind: str, basis: str) -> None:
    """On a grid line and off it: only the order of the sums differs."""
    entries = layered(kind, basis, 1.0)
    entries["materials"]["sand"] = entries["materials"]["clay"]
    whole = {**entries, "bodies": [{**entries["bodies"][0], "material": "clay"}]}
    del whole["bodies"][0]["layers"]
    reference = march(Model.from_dict(whole)).state.points
    for bottom in (1.0, 0.6):
        entries["bodies"][0]["layers"][0]["bottom"] = bottom
        points = march(Model.from_dict(entries)).state.points
        first, second = by_place(points), by_place(reference)
        for name in ("position", "stress", "deformation_gradient"):
            scale = np.abs(getattr(reference, name)).max()
            one, other = getattr(points, name)[first], getattr(reference, name)[second]
            np.testing.assert_allclose(one, other, atol=1e-8 * scale)


def by_place(points: MaterialPoints) -> Any:
    """Order of the points by where they were at the start."""
    return np.lexsort(np.round(points.position - points.displacement, 9).T)


@pytest.mark.parametrize("kind", KINDS)
def test_stress_under_the_weight_of_the_layers(kind: str) -> None:
    """With horizon at 1 and nu 0: sigma = -g (rho_1 (2 - z) or rho_1 + rho_2 (1 - z)), small g."""
    entries = layered(kind, "linear", 1.0, schedule={"steps": 1})
    for material in entries["materials"].values():
        material["poisson_ratio"] = 0.0
    entries["loads"] = [weight(kind, 1e-3)]
    points = march(Model.from_dict(entries)).state.points
    up = dimension(kind) - 1
    z = (points.position - points.displacement)[:, up]
    exact = -1e-3 * np.where(z > 1.0, 2.0 * (2.0 - z), 2.0 + 1.5 * (1.0 - z))
    # the linear basis has a constant stress in each cell: that at its centre
    centre = np.floor(z) + 0.5
    in_cell = -1e-3 * np.where(centre > 1.0, 2.0 * (2.0 - centre), 2.0 + 1.5 * (1.0 - centre))
    np.testing.assert_allclose(points.stress[:, up], in_cell, rtol=1e-5)
    assert np.abs(in_cell - exact).max() <= 1e-3 * 2.0 * 0.25 * (1.0 + 1e-9)
    total = 4.0 * (2.0 + 1.5) / 2.0  # mass of the block in plane strain
    if kind == "plane_strain":
        assert points.mass.sum() == pytest.approx(total, rel=1e-14)


def test_a_horizon_from_a_polyline_and_from_a_grid(tmp_path: Path) -> None:
    points = points_of(layered("plane_strain", "gimp", [[0, 0.5], [2, 1.5]]))
    assert {range_.layer for range_ in points.ranges} == {0, 1}
    above = points.position[:, 1] >= 0.5 + 0.5 * points.position[:, 0]
    np.testing.assert_array_equal(points.layer, np.where(above, 0, 1))
    np.testing.assert_array_equal(points.body_id, 0)
    density = np.where(above, 2.0, 1.5)
    np.testing.assert_allclose(points.mass, density * points.initial_volume, rtol=1e-15)
    file = tmp_path / "horizon.csv"
    file.write_text("x,value\n0,0.5\n2,1.5\n", encoding="utf-8")
    assert_same_bits(points_of(layered("plane_strain", "gimp", {"file": str(file)})), points)
    file.write_text("x,y,value\n0,0,0.5\n2,0,1\n0,2,1\n2,2,1.5\n", encoding="utf-8")
    points = points_of(layered("3d", "gimp", {"file": str(file)}))
    x, y, z = points.position.T
    np.testing.assert_array_equal(points.layer, np.where(z >= 0.5 + 0.25 * (x + y), 0, 1))


def test_a_layer_that_ends_inside_the_body() -> None:
    """Three layers; the second ends where its horizon meets that of the first."""
    entries = layered("plane_strain", "gimp", 1.0)
    lens = {"material": "clay", "bottom": [[0, 0.4], [1, 1.0], [2, 1.0]]}
    entries["bodies"][0]["layers"].insert(1, lens)
    points = points_of(entries)
    x, y = points.position.T
    second = (y < 1.0) & (y >= np.interp(x, [0, 1, 2], [0.4, 1.0, 1.0]))
    np.testing.assert_array_equal(points.layer, np.where(y >= 1.0, 0, np.where(second, 1, 2)))
    assert second.any()
    lens["bottom"] = [[0, 0.4], [1, 1.3], [2, 1.3]]
    with pytest.raises(BadInput, match=r"layers\[1\].bottom: lies at .* above the horizon over it"):
        points_of(entries)


@pytest.mark.parametrize("bottom", [2.5, 2.0, 1.99, -1.0, 0.1])
def test_a_layer_without_points(bottom: float) -> None:
    empty = 0 if bottom > 1.0 else 1
    with pytest.raises(BadInput, match=rf"bodies\[0\].layers\[{empty}\]: no material point") as one:
        points_of(layered("plane_strain", "gimp", bottom))
    assert "'block'" in str(one.value)


def test_what_belongs_to_the_body_belongs_to_all_its_layers(tmp_path: Path) -> None:
    entries = layered("plane_strain", "gimp", 1.0)
    other = {**entries["bodies"][0], "name": "next", "material": "clay"}
    del other["layers"]
    other["shape"] = {"type": "box", "lower": [4.0, 0.0], "upper": [6.0, 2.0]}
    entries["bodies"].append(other)
    entries["bodies"][0]["surface"] = {}
    entries["boundaries"] = [plane("base", "y", 0.0, condition="fixed")]
    track: dict[str, Any] = {
        "quantity": "top_height",
        "of": "domains",
        "body": "block",
        "name": "top",
    }
    low = {"quantity": "displacement", "component": "y", "body": "block", "at": [1.0, 0.0]}
    entries["track"] = [track, {**low, "name": "low"}]
    entries["loads"] = [
        *entries["loads"],
        {"type": "surface", "body": "block", "start": [2, 2], "end": [0, 2], "pressure": 5.0},
    ]
    model = Model.from_dict(entries)
    points = initial_points(model)
    assert [own for _, own in points.whole_bodies()] == [slice(0, 16), slice(16, 32)]
    assert len(points.ranges) == 3
    assert points.of_body("block") == slice(0, 16)
    in_both = nearest_points(points, [1.0, 1.0], 1.0, "block")
    assert set(points.layer[points.index_of(in_both)]) == {0, 1}
    Tracker(model, points)
    assert setup_of(model).body_names == ["block", "next"]
    folder = run(model, tmp_path / "out", quiet=True).folder
    last = read_results(folder / "results.vtkhdf").snapshot(-1)
    np.testing.assert_array_equal(last.body_id, np.repeat([0, 1], 16))
    np.testing.assert_array_equal(last.point_fields["layer"], np.repeat([0, 1, 0], [8, 8, 16]))
    own = last.position[:16] + last.point_fields["domain"][:16]
    history = (folder / "history.csv").read_text(encoding="utf-8").splitlines()
    assert float(history[-1].split(",")[3]) == pytest.approx(own[:, 1].max(), rel=1e-12)
    assert "layer at the start: start" in (folder / "report.html").read_text(encoding="utf-8")


def mesh_with_groups(folder: Path, tags: list[int], names: dict[str, list[int]]) -> str:
    """Four squares in a row from the bottom up, x 0 to 1, y 0 to 4, each in a physical group."""
    meshio = pytest.importorskip("meshio")
    points = np.array([[x, y, 0.0] for y in range(5) for x in range(2)], dtype=float)
    quads = np.array([[2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2] for i in range(4)])
    mesh = meshio.Mesh(
        points,
        [("quad", quads)],
        cell_data={"gmsh:physical": [np.array(tags)], "gmsh:geometrical": [np.array(tags)]},
        field_data={name: np.array(entry) for name, entry in names.items()},
    )
    file = folder / "ground.msh"
    mesh.write(file, file_format="gmsh22", binary=False)
    return str(file)


def grouped(file: str, groups: list[str], basis: str = "gimp") -> dict[str, Any]:
    entries = layered("plane_strain", basis, 1.0)
    body = entries["bodies"][0]
    body["shape"] = {"type": "mesh", "file": file}
    materials = ("sand", "clay")
    body["layers"] = [{"material": m, "group": g} for m, g in zip(materials, groups, strict=True)]
    return entries


@pytest.mark.parametrize("basis", BASES)
def test_layers_by_the_physical_groups_of_a_mesh(basis: str, tmp_path: Path) -> None:
    file = mesh_with_groups(tmp_path, [5, 7, 5, 7], {"soft": [5, 2], "stiff": [7, 2]})
    points = points_of(grouped(file, ["stiff", "soft"], basis))
    stiff = np.isin(np.floor(points.position[:, 1]), [1, 3])
    np.testing.assert_array_equal(points.layer, np.where(stiff, 0, 1))
    for range_, share in zip(points.ranges, (2.0, 2.0), strict=True):
        assert points.initial_volume[range_.points].sum() == pytest.approx(share, rel=1e-13)


def test_wrong_groups(tmp_path: Path) -> None:
    file = mesh_with_groups(tmp_path, [5, 7, 5, 8], {"soft": [5, 2], "stiff": [7, 2]})
    with pytest.raises(BadInput, match=r"layers\[0\].group = \"stif\"") as caught:
        points_of(grouped(file, ["stif", "soft"]))
    assert "did you mean `stiff`?" in str(caught.value)
    with pytest.raises(BadInput, match=r"layers: the element .* in the physical group '8', which"):
        points_of(grouped(file, ["stiff", "soft"]))
    points = np.array([[x, y] for y in range(2) for x in range(2)], dtype=float)
    plain = write(tmp_path / "plain.msh", points, [("quad", np.array([[0, 1, 3, 2]]))])
    with pytest.raises(BadInput, match="no physical group of this name"):
        points_of(grouped(str(plain), ["stiff", "soft"]))


@pytest.mark.parametrize(
    ("layers", "problem"),
    [
        ([{"group": "a"}, {}], r"layers\[1\].group: missing, but another layer has one"),
        (
            [{"group": "a"}, {"group": "a"}],
            r"layers\[1\].group = \"a\": is already that of a layer",
        ),
        ([{"group": "a", "bottom": 2}, {"group": "b"}], r"layers\[0\].bottom: has no meaning"),
    ],
)
def test_groups_that_do_not_fit_together(layers: list[dict[str, Any]], problem: str) -> None:
    entries = grouped("ground.msh", ["a", "b"])
    entries["bodies"][0]["layers"] = [{"material": "clay", **each} for each in layers]
    with pytest.raises(BadInput, match=problem):
        Model.from_dict(entries)


def test_earth_pressure_at_rest_under_layers() -> None:
    """sigma_v at y is g times the sum of density times thickness, below an inclined horizon too."""
    horizon = [[0, 0.5], [2, 1.5]]
    entries = layered("plane_strain", "gimp", horizon)
    entries["loads"][0]["factor"] = [[0, 1], [1, 1]]
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", "K0": 0.5, "ground": 2.0}]}
    points = points_of(entries)
    x, y = points.position.T
    level = 0.5 + 0.5 * x
    mass = np.where(y >= level, 2.0 * (2.0 - y), 2.0 * (2.0 - level) + 1.5 * (level - y))
    np.testing.assert_allclose(points.stress[:, 1], -10.0 * mass, rtol=1e-13)
    np.testing.assert_allclose(points.stress[:, 0], -5.0 * mass, rtol=1e-13)
    np.testing.assert_allclose(points.stress[:, 2], -5.0 * mass, rtol=1e-13)


def test_earth_pressure_at_rest_under_groups_of_other_density(tmp_path: Path) -> None:
    file = mesh_with_groups(tmp_path, [5, 7, 5, 7], {"soft": [5, 2], "stiff": [7, 2]})
    entries = grouped(file, ["stiff", "soft"])
    entries["loads"][0]["factor"] = [[0, 1], [1, 1]]
    entries["initial"] = {"stress": [{"type": "k0", "body": "block", "K0": 0.5, "ground": 4.0}]}
    with pytest.raises(BadInput, match="groups of a mesh have no horizons"):
        points_of(entries)
    below_mesh = entries["initial"]["stress"][0]
    del below_mesh["ground"]
    points = points_of(entries)
    y = points.position[:, 1]
    squares = [
        density * np.clip(k + 1.0 - y, 0.0, 1.0) for k, density in enumerate((1.5, 2.0, 1.5, 2.0))
    ]
    np.testing.assert_allclose(points.stress[:, 1], -10.0 * sum(squares), rtol=1e-13)
    below_mesh["ground"] = 4.0
    entries["materials"]["sand"]["density"] = entries["materials"]["clay"]["density"]
    points = points_of(entries)
    np.testing.assert_allclose(points.stress[:, 1], -15.0 * (4.0 - points.position[:, 1]))


def test_layers_in_a_case_file_with_paths_relative_to_it(tmp_path: Path) -> None:
    (tmp_path / "horizon.csv").write_text("x,value\n0,0.5\n2,1.5\n", encoding="utf-8")
    case = tmp_path / "case.toml"
    case.write_text(CASE, encoding="utf-8")
    points = initial_points(load_case(case))
    above = points.position[:, 1] >= 0.5 + 0.5 * points.position[:, 0]
    np.testing.assert_array_equal(points.layer, np.where(above, 0, 1))


CASE = """
format = 1
[analysis]
kind = "plane_strain"
[grid]
cell_size = 1.0
[materials.sand]
model = "hencky_elastic"
young_modulus = 1e6
poisson_ratio = 0.3
[[bodies]]
name = "ground"
shape = { type = "box", lower = [0, 0], upper = [2, 2] }
basis = "linear"
points_per_cell = 2
[[bodies.layers]]
material = "sand"
bottom = { file = "horizon.csv" }
[[bodies.layers]]
material = "sand"
[[boundaries]]
name = "base"
type = "plane"
axis = "y"
at = 0
condition = "fixed"
[schedule]
steps = 1
"""
