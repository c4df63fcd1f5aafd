# SPDX-License-Identifier: BSD-3-Clause
"""What is probably not meant in a model: each warning fires where it should, and only there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from mesh_bodies import distorted_mesh
from small_problems import affine, block_entries, material_entries, plane, rollers, weight
from turned_blocks import turned_block

import tilth
from tilth import BadInput, Model, run
from tilth.bodies.inside import inside_of
from tilth.model import Box, Cylinder, Polygon, Sphere

BOX = {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 2.0]}


def entries(kind: str = "plane_strain", **changed: Any) -> dict[str, Any]:
    """A block with nothing to warn of."""
    given = {"boundaries": rollers(kind), "loads": [weight(kind, 0.1)], **changed}
    return block_entries(kind, "gimp", **given)


def warnings_of(given: dict[str, Any]) -> list[str]:
    return tilth.check(Model.from_dict(given)).warnings


def two_bodies(first: dict[str, Any], second: dict[str, Any], kind: str) -> dict[str, Any]:
    given = entries(kind)
    body = given["bodies"][0]
    given["bodies"] = [{**body, "shape": first}, {**body, "name": "second", "shape": second}]
    dim = 3 if kind == "3d" else 2
    # all nodes are held, so that only the overlap matters
    given["boundaries"] = [affine(1.1 * np.eye(dim))]
    return given


def moved(shape: dict[str, Any], by: float) -> dict[str, Any]:
    return {**shape, **{key: [shape[key][0] + by, *shape[key][1:]] for key in ("lower", "upper")}}


CUBE = {"type": "box", "lower": [0.0] * 3, "upper": [2.0] * 3}
DISC = {"type": "circle", "centre": [2.0, 2.0], "radius": 2.0}
BALL = {"type": "sphere", "centre": [2.0, 2.0, 2.0], "radius": 2.0}


def ring(sides: int) -> dict[str, Any]:
    """Half a square ring around the disc, its hole approximated by chords."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, sides + 1)
    arc = 2.0 + 2.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = [[2.0, 5.0], [5.0, 5.0], [5.0, -1.0], [2.0, -1.0]]
    return {"type": "polygon", "vertices": [*arc.tolist(), *corners]}


@pytest.mark.parametrize(
    ("kind", "first", "second", "overlap"),
    [
        ("plane_strain", BOX, moved(BOX, 2.0), False),
        ("plane_strain", BOX, moved(BOX, 1.5), True),
        ("plane_strain", {**BOX, "angle": 30.0}, {**BOX, "angle": -60.0}, False),
        ("plane_strain", {**BOX, "angle": 30.0}, {**BOX, "angle": -45.0}, True),
        ("plane_strain", DISC, ring(24), False),
        ("plane_strain", DISC, moved(BOX, 2.0), True),
        ("3d", CUBE, moved(CUBE, 2.0), False),
        ("3d", CUBE, moved(CUBE, 1.5), True),
        ("3d", BALL, moved(CUBE, -2.0), False),
        ("3d", BALL, CUBE, True),
    ],
)
def test_bodies_that_overlap_are_named(
    kind: str, first: dict[str, Any], second: dict[str, Any], overlap: bool
) -> None:
    found = warnings_of(two_bodies(first, second, kind))
    assert (
        any(
            "'block' and 'second' overlap" in text or "'second' and 'block' overlap" in text
            for text in found
        )
        == overlap
    )


@pytest.mark.parametrize(
    ("element", "kind"),
    [
        ("triangle", "plane_strain"),
        ("quad", "plane_strain"),
        ("tetra", "3d"),
        ("hexahedron", "3d"),
    ],
)
@pytest.mark.parametrize(("by", "overlap"), [(2.0, False), (1.5, True)])
def test_meshes_that_overlap_are_named(
    element: str, kind: str, by: float, overlap: bool, tmp_path: Path
) -> None:
    file = distorted_mesh(tmp_path / "mesh.msh", element, 3, 0.0, 2.0, (0.0, 2.0))
    box = moved(CUBE if kind == "3d" else BOX, by)
    found = warnings_of(two_bodies({"type": "mesh", "file": str(file)}, box, kind))
    assert any("overlap: " in text for text in found) == overlap


@pytest.mark.parametrize(
    "shape",
    [
        Box(lower=(0.1, 0.2), upper=(1.3, 0.9), angle=25.0),
        Polygon(vertices=((0, 0), (2, 0), (2, 2), (1, 0.5), (0, 2))),
        Cylinder(centre=(0, 0, 0), radius=1.0, inner_radius=0.4, axis="y", height=2.0),
        Sphere(centre=(0, 0, 0), radius=1.0, sides=("x+", "z-")),
    ],
)
def test_the_volume_inside_a_shape_is_that_of_the_shape(shape: Any) -> None:
    exact = {
        "box": 1.2 * 0.7,
        "polygon": 2.5,
        "cylinder": np.pi * (1.0 - 0.16) * 2.0,
        "sphere": np.pi / 3.0,
    }[shape.type]
    lower, upper = (np.array(corner) for corner in shape.bounds())
    n, dim = (400, 2) if shape.dimension == 2 else (80, 3)
    axes = np.meshgrid(*[(np.arange(n) + 0.5) / n] * dim, indexing="ij")
    lattice = lower + (upper - lower) * np.stack(axes, axis=-1).reshape(-1, dim)
    share = inside_of(shape)(lattice).mean()
    assert share * np.prod(upper - lower) == pytest.approx(exact, rel=0.01)


def test_a_sound_model_has_no_warning() -> None:
    assert warnings_of(entries()) == []


@pytest.mark.parametrize(
    "changed",
    [
        {"loads": []},
        {"loads": [weight("plane_strain", 0.0)]},
        {"loads": [{**weight("plane_strain", 1.0), "factor": [[0.0, 0.0], [1.0, 0.0]]}]},
        {"loads": [], "boundaries": [affine(np.eye(2))]},
    ],
)
def test_neither_load_nor_motion_is_named(changed: dict[str, Any]) -> None:
    found = warnings_of(entries(**changed))
    assert any("all displacements and stresses stay zero" in text for text in found)


@pytest.mark.parametrize(
    "boundary",
    [
        plane("top", "y", 2.0, condition="prescribed", displacement={"y": -0.1}),
        implicit("top", flat([0.0, 2.0], [0.0, -1.0]), "roller", displacement={"y": -0.1}),
    ],
)
def test_a_motion_alone_is_enough(boundary: dict[str, Any]) -> None:
    given = entries(loads=[], boundaries=[*rollers("plane_strain"), boundary])
    assert warnings_of(given) == []


def test_soil_that_begins_behind_a_boundary_is_named() -> None:
    wall = implicit("wall", flat([0.5, 0.0], [1.0, 0.0]), "roller")
    found = warnings_of(entries(boundaries=[plane("low y", "y", 0.0), wall]))
    # points at x = 0.25, 0.75, ...: the first of four columns is behind
    assert len(found) == 1
    assert found[0].startswith("boundaries[1].geometry: 4 of 16 material points (25 %) are behind")
    assert "up to 0.25 deep" in found[0]


def test_soil_deep_inside_a_rigid_shape_is_named() -> None:
    circle = {"type": "circle", "centre": [6.0, 6.0], "radius": 4.5, "soil": "outside"}
    given = entries(boundaries=[*rollers("plane_strain"), implicit("pipe", circle, "roller")])
    given["bodies"][0]["shape"] = {**BOX, "upper": [12.0, 12.0]}
    assert any(
        "up to 4.15 deep" in text and "behind the boundary 'pipe'" in text
        for text in warnings_of(given)
    )


def test_positions_without_soil_are_named() -> None:
    force = {"type": "point_force", "body": "block", "at": [2.0, 0.25], "force": [1.0, 0.0]}
    track = {"name": "tip", "quantity": "displacement", "at": [2.0, 2.0], "component": "y"}
    away = {**track, "name": "away", "at": [1.75, 7.75]}
    found = warnings_of(entries(loads=[force], track=[track, away]))
    assert len(found) == 1
    assert found[0].startswith("track[1].at: no soil is at (1.75, 7.75): 'away' is that of")
    assert "6 (6.0 cells) away" in found[0]


@pytest.mark.parametrize(
    ("ratio", "remedy", "named"),
    [(0.3, "none", False), (0.46, "none", True), (0.46, "f_bar", False)],
)
def test_locking_is_named(ratio: float, remedy: str, named: bool) -> None:
    given = entries()
    given["materials"]["soil"] = material_entries("von_mises", poisson_ratio=ratio)
    given["schedule"] = {"steps": 2}
    given["bodies"][0]["anti_locking"] = remedy
    assert any("bodies[0].anti_locking" in text for text in warnings_of(given)) == named


@pytest.mark.parametrize(
    ("radius", "change", "named"),
    [
        (4.0, 0.0, False),
        (3.0, 0.0, True),
        (4.5, -1.0, True),
    ],
)
def test_a_radius_of_a_few_cells_is_named(radius: float, change: float, named: bool) -> None:
    circle = {"type": "circle", "centre": [2.0 + radius, 1.0], "radius": radius, "soil": "outside"}
    pipe = implicit("pipe", circle, "roller", radius_change=change)
    given = entries(boundaries=[*rollers("plane_strain", sides=False), pipe])
    found = [text for text in warnings_of(given) if "geometry.radius" in text]
    assert bool(found) == named


def test_thin_bodies_and_sparse_points_are_named() -> None:
    given = entries(boundaries=[plane("base", "y", 0.0, condition="fixed")])
    given["bodies"][0]["shape"] = {**BOX, "upper": [6.0, 0.5]}
    given["bodies"][0]["basis"] = "linear"
    del given["bodies"][0]["points_per_cell"]
    given["bodies"][0]["spacing"] = [1.2, 0.25]
    found = warnings_of(given)
    assert any("only 0.5 of a cell thick along y" in text for text in found)
    assert any("1.2 cells apart along x" in text for text in found)


def test_a_plastic_load_in_one_step_is_named() -> None:
    given = entries()
    given["materials"]["soil"] = material_entries("von_mises")
    assert any(text.startswith("schedule.steps = 1") for text in warnings_of(given))


def test_check_and_run_say_the_same(tmp_path: Path) -> None:
    model = Model.from_dict(entries(loads=[], output={"report": False}))
    checked = tilth.check(model)
    assert (checked.points, checked.active_cells, checked.unknowns) == (16, 4, 18)
    assert repr(checked).startswith("<CheckResult: 16 points, 4 active cells, 18 unknowns, 1 warn")
    run(model, tmp_path / "out", quiet=True)
    log = (tmp_path / "out" / "log.txt").read_text(encoding="utf-8")
    assert [f"warning: {text}" in log for text in checked.warnings] == [True]


def test_check_refuses_what_a_run_refuses() -> None:
    model = Model.from_dict(entries(boundaries=[plane("base", "y", 0.0), plane("m", "x", 9.0)]))
    with pytest.raises(BadInput, match="not constrained against translation along x"):
        tilth.check(model)


@pytest.mark.parametrize(("basis", "angle", "warned"), [
    ("gimp", 25.0, True), ("gimp", 20.0, False), ("cpdi2", 25.0, False),
])  # fmt: skip
@pytest.mark.parametrize("holder", ["held", "bonded"])
def test_soil_in_boxes_that_is_turned(holder: str, basis: str, angle: float, warned: bool) -> None:
    checked = tilth.check(turned_block(basis, holder, angle, 10))
    assert any("the boxes of GIMP" in text for text in checked.warnings) == warned
