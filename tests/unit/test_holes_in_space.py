# SPDX-License-Identifier: BSD-3-Clause
"""Holes in shapes in space: points, volume, surface, thickness, size, wrong ones."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from tilth.bodies.discretise import discretise, inside_body
from tilth.bodies.forms import form_of
from tilth.bodies.request import BodyPoints, Request
from tilth.bodies.size import body_size
from tilth.bodies.thickness import crossings_of
from tilth.case import load_case
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Box, Cylinder, Mesh, Sphere, Stl, Terrain
from tilth.model.shapes import DeclaredShape
from tilth.report.amounts import shape_text
from tilth.surface.outline_3d import outline_3d

SPACE = Grid(np.zeros(3), np.full(3, 0.5))
SHIFTED = Grid(np.array([0.13, -0.21, 0.07]), np.array([0.4, 0.5, 0.45]))
BALL = {"type": "sphere", "centre": [2.0, 2.0, 2.0], "radius": 1.0}
TUNNEL = {"type": "cylinder", "centre": [0.0, 2.0, 1.5], "radius": 1.0, "axis": "x", "height": 4.0}
CUBE = {"type": "box", "lower": [1.0, 1.0, 1.0], "upper": [2.0, 3.0, 2.5]}
TURNED = {**CUBE, "angle": 20.0, "axis": "z"}
BLOCK = {"lower": [0.0, 0.0, 0.0], "upper": [4.0, 4.0, 4.0]}


def block(*holes: Any, **entries: Any) -> Box:
    return Box(**{**BLOCK, "holes": holes, **entries})


def body(shape: DeclaredShape, **entries: Any) -> Body:
    whole = {"basis": "gimp", "points_per_cell": 2, **entries}
    return Body(name="soil", material="soil", shape=shape, **whole)


def points(shape: DeclaredShape, grid: Grid = SPACE, **entries: Any) -> BodyPoints:
    return discretise(body(shape, **entries), "3d", grid)


CASES: dict[str, tuple[DeclaredShape, float]] = {
    "tunnel": (block(TUNNEL), 64.0 - 4.0 * math.pi),
    "ball": (block(BALL), 64.0 - 4.0 / 3.0 * math.pi),
    "cube": (block(CUBE), 61.0),
    "turned cube": (block(TURNED), 61.0),
    "turned block": (block({**BALL, "centre": [0.4, 2.2, 2]}, angle=30.0, axis="z"),
                     64.0 - 4.0 / 3.0 * math.pi),
    "horseshoe": (  # half a cylinder on a box, which have a face in common
        block({**TUNNEL, "sides": ["z+"]},
              {"type": "box", "lower": [0, 1, 0.5], "upper": [4, 3, 1.5]}),
        64.0 - 2.0 * math.pi - 8.0,
    ),
    "ball in a ball": (
        Sphere(centre=[2, 2, 2], radius=2, holes=[{**BALL, "centre": [2.5, 2, 2]}]),
        4.0 / 3.0 * math.pi * 7.0,
    ),
    "box in a cylinder": (
        Cylinder(centre=[2, 2, 0], radius=2, axis="z", height=3, holes=[CUBE]),
        12.0 * math.pi - 3.0,
    ),
}  # fmt: skip
EACH = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


@EACH
@pytest.mark.parametrize("grid", [SPACE, SHIFTED], ids=["aligned", "shifted"])
def test_the_points_are_those_of_the_whole_outside_the_holes(
    case: tuple[DeclaredShape, float], grid: Grid
) -> None:
    shape, volume = case
    found = points(shape, grid)
    assert shape.measure() == pytest.approx(volume, rel=1e-14)
    assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-13)
    whole = points(shape.model_copy(update={"holes": ()}), grid)
    inside = inside_body(body(shape), "3d", grid)(whole.position)
    left = {tuple(place) for place in found.position.tolist()}
    kept = np.array([tuple(place) in left for place in whole.position.tolist()])
    assert kept[inside].all()
    assert (kept != inside).mean() <= 0.02  # points on the surface of a hole, which stay
    assert body_size(body(shape), "3d", grid).points == pytest.approx(len(found.position), rel=0.05)


def test_a_block_less_a_block_on_grid_lines_is_exact() -> None:
    """Each point keeps the volume of its sub-cell, and no other is missing."""
    found = points(block(CUBE))
    np.testing.assert_allclose(found.volume, 0.25**3, rtol=1e-13)
    side = np.arange(16) * 0.25 + 0.125
    lattice = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    inner = ((lattice > [1, 1, 1]) & (lattice < [2, 3, 2.5])).all(axis=1)
    assert {tuple(p) for p in found.position} == {tuple(p) for p in lattice[~inner]}


def test_a_point_on_the_surface_of_a_hole_stays() -> None:
    """On all sides: a hole from centre to centre of the sub-cells holds those between only."""
    hole = {"type": "box", "lower": [1.125] * 3, "upper": [2.125] * 3}
    found = points(block(hole)).position
    inner = (np.abs(found - 1.625) < 0.5 + 1e-9).all(axis=1)
    assert inner.sum() == 5**3 - 3**3
    np.testing.assert_allclose(found[inner].mean(axis=0), 1.625)


@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1", "cpdi2"])
def test_the_points_approach_a_round_hole(basis: str) -> None:
    """The share of points left is that of the volume, the nearer the finer: to 1e-2, then 2e-3."""
    for number, error in ((2, 1e-2), (6, 2e-3)):
        found = points(block(BALL), basis=basis, points_per_cell=number)
        share = len(found.position) / (8 * number) ** 3
        assert share == pytest.approx(1.0 - math.pi / 48.0, rel=error)


@EACH
def test_lines_through_it_and_places_in_it(case: tuple[DeclaredShape, float]) -> None:
    """The thickness along vertical lines, and the places inside, add up to the volume."""
    shape, volume = case
    form = form_of(shape, Request("", False, SPACE))
    low, high = np.array(form.bounds())
    n = 120
    axes = [low[k] + (np.arange(n) + 0.5) / n * (high - low)[k] for k in range(3)]
    place = np.stack(np.meshgrid(*axes[:2], indexing="ij"), axis=-1).reshape(-1, 2)
    lines = crossings_of(form, place)
    thickness = lines.thickness(np.full(n * n, -9.0), np.full(n * n, 99.0))
    area = float(np.prod((high - low)[:2])) / n**2
    assert thickness.sum() * area == pytest.approx(volume, rel=5e-3)
    some = place[:: n + 7]
    column = np.column_stack([np.repeat(some, n, axis=0), np.tile(axes[2], len(some))])
    within = inside_body(body(shape), "3d", SPACE)(column).reshape(len(some), n).sum(axis=1)
    step = (high - low)[2] / n
    np.testing.assert_allclose(within * step, thickness[:: n + 7], atol=4.1 * step)


def test_the_surface_goes_around_holes_inside() -> None:
    """By the divergence theorem; the volume of a ball of triangles is a little less."""
    surface = outline_3d(body(block(CUBE)), [0.5] * 3)
    assert surface.closed
    assert -np.linalg.det(surface.corner).sum() / 6.0 == pytest.approx(61.0, rel=1e-13)
    assert surface.part[6:] == tuple(f"hole 1 {axis}{side}" for axis in "xyz" for side in "-+")
    surface = outline_3d(body(block(BALL)), [0.5] * 3, spacing=0.1)
    assert surface.closed
    enclosed = -np.linalg.det(surface.corner).sum() / 6.0
    assert enclosed == pytest.approx(64.0 - 4.0 / 3.0 * math.pi, rel=5e-4)
    assert surface.part[6:] == ("hole 1 surface",)


@pytest.mark.parametrize("name", ["tunnel", "horseshoe"])
def test_a_hole_that_ends_at_the_surface_has_no_tracked_surface(name: str) -> None:
    with pytest.raises(BadInput, match=r"(?s)shape.holes\[0\]: a hole that touches.*`surface` out"):
        outline_3d(body(CASES[name][0]), [0.5] * 3)


def test_holes_that_touch_have_no_tracked_surface() -> None:
    beside = {**CUBE, "lower": [2.0, 1.0, 1.0], "upper": [3.0, 3.0, 2.5]}
    shape = block(CUBE, beside)
    assert math.fsum(points(shape).volume) == pytest.approx(58.0, rel=1e-13)
    with pytest.raises(BadInput, match=r"shape.holes\[1\]: a hole that touches"):
        outline_3d(body(shape), [0.5] * 3)


def octahedron(folder: Path, centre: Any, radius: float) -> dict[str, Any]:
    corner = np.array(
        [
            [[sx, 0, 0], [0, sy, 0], [0, 0, sz]][:: sx * sy * sz]
            for sx in (1, -1) for sy in (1, -1) for sz in (1, -1)
        ]
    ) * radius + np.asarray(centre)  # fmt: skip
    cells = [("triangle", np.arange(24).reshape(-1, 3))]
    file = f"{folder}/octahedron_{radius}.stl"
    meshio.write_points_cells(file, corner.reshape(-1, 3), cells, binary=True)
    return {"type": "stl", "file": file, "scale": 1.0}


def test_a_hole_from_a_file_and_a_hole_in_a_file(tmp_path: Path) -> None:
    boulder = octahedron(tmp_path, [2, 2, 2], 1.5)
    shape = block(boulder)
    assert shape.measure() is None  # before the file is read
    found = points(shape)
    assert math.fsum(found.volume) == pytest.approx(64.0 - 4.5, rel=1e-6)  # single precision
    assert (np.abs(found.position - 2.0).sum(axis=1) > 1.5 - 1e-5).all()
    assert outline_3d(body(shape), [0.5] * 3).closed
    whole = Stl(file=octahedron(tmp_path, [2, 2, 2], 3.0)["file"], scale=1.0,
                holes=[{**BALL, "radius": 0.5}])  # fmt: skip
    assert math.fsum(points(whole).volume) == pytest.approx(36.0 - math.pi / 6.0, rel=1e-6)
    far = octahedron(tmp_path, [2, 2, 2], 4.5)
    found_error = refusal(block(far))
    assert 'bodies "soil".shape.holes[0]: is not inside the shape' in found_error


def test_a_tunnel_through_a_hill(tmp_path: Path) -> None:
    (tmp_path / "hill.csv").write_text("x,y,z\n0,0,3\n2,0,5\n4,0,3\n0,4,3\n2,4,5\n4,4,3\n")
    hill = {"surface": {"file": f"{tmp_path}/hill.csv"}, "base": 0.0, "lower": [0, 0]}
    hill["upper"] = [4, 4]
    tunnel = {"type": "cylinder", "centre": [2, 0, 1.5], "radius": 1.0, "axis": "y", "height": 4.0}
    found = points(Terrain(**hill, holes=[tunnel]))
    assert math.fsum(found.volume) == pytest.approx(64.0 - 4.0 * math.pi, rel=1e-13)
    high = refusal(Terrain(**hill, holes=[{**tunnel, "centre": [2, 0, 3.7]}]))
    assert 'bodies "soil".shape.holes[0]: is not inside the shape, but reaches beyond it' in high
    flat = Terrain(surface=4.0, base=0.0, lower=[0, 0], upper=[4, 4],
                   holes=[{"type": "box", **BLOCK}])  # fmt: skip
    assert "shape.holes: are as large as the shape: nothing is left of it" in refusal(flat)
    with pytest.raises(BadInput, match=r"(?s)holes: are for a terrain in 3D.*polygon with holes"):
        Terrain(surface=3.0, base=0.0, lower=[0], upper=[4],
                holes=[{"type": "circle", "centre": [2, 1], "radius": 0.5}])  # fmt: skip


def refusal(shape: DeclaredShape) -> str:
    with pytest.raises(BadInput) as error:
        points(shape)
    return str(error.value)


DECLARED: list[tuple[list[Any], str, str]] = [
    ([{**BALL, "centre": [9, 2, 2]}], "holes[0]", "is not inside the shape, but reaches from (8, "),
    ([{**TUNNEL, "height": 4.1}], "holes[0]", "to (4.1, 3, 2.5)"),
    ([{**CUBE, "lower": [-1, -1, -1], "upper": [5, 5, 5]}], "holes[0]", "is not inside the shape"),
    ([{"type": "box", **BLOCK}], "holes", "are as large as the shape: nothing is left"),
    ([{**BALL, "holes": [{**BALL, "radius": 0.5}]}], "holes[0].holes", "a hole has no holes"),
    ([{**CUBE, "lower": [1, 1], "upper": [2, 2]}], "holes[0].lower", "must have three coordinates"),
    ([{**CUBE, "angle": 20.0}], "holes[0].axis", "missing"),
    ([{"type": "circle", "centre": [2, 2], "radius": 1}], "holes[0].type", "is no hole in 3D"),
    ([{"type": "mesh", "file": "a.msh"}], "holes[0].type", "mesh"),
]


@pytest.mark.parametrize(("holes", "key", "problem"), DECLARED)
def test_what_a_declaration_alone_tells(holes: list[Any], key: str, problem: str) -> None:
    with pytest.raises(BadInput) as error:
        block(*holes)
    assert f"Box.{key}" in str(error.value)
    assert problem in str(error.value)


def test_a_shape_that_has_no_holes() -> None:
    with pytest.raises(BadInput, match=r"Mesh.holes = .*: unknown key"):
        Mesh(file="a.msh", holes=[BALL])  # type: ignore[call-arg]


ROUND: list[tuple[DeclaredShape, str, str]] = [
    (Sphere(centre=[2, 2, 2], radius=2, holes=[{**CUBE, "lower": [0.5, 0.5, 0.5]}]),
     "holes[0]", "is not inside the shape, but reaches beyond it at ("),
    (Cylinder(centre=[2, 2, 0], radius=2, axis="z", height=4,
              holes=[{**BALL, "centre": [2.9, 2.9, 2.0]}]),
     "holes[0]", "is not inside the shape, but reaches beyond it at ("),
    (block(CUBE, angle=45.0, axis="z"),
     "holes[0]", "is not inside the shape, but reaches beyond it at ("),
    (block(BALL, CUBE), "holes[1]", "overlaps holes[0] at ("),
    (block(BALL, {**BALL, "radius": 0.5}), "holes[1]", "overlaps holes[0] at ("),
    (block(TUNNEL, {**TUNNEL, "centre": [2, 0, 1.5], "axis": "y"}), "holes[1]", "overlaps holes"),
    (block({**BALL, "radius": 0.01}), "holes[0]", "no material point lies in this hole"),
]  # fmt: skip


@pytest.mark.parametrize(("shape", "key", "problem"), ROUND)
def test_a_misplaced_hole_is_refused(shape: DeclaredShape, key: str, problem: str) -> None:
    found = refusal(shape)
    assert f'bodies "soil".shape.{key}: {problem}' in found


def test_balls_are_inside_or_not_to_the_last_part_in_a_thousand() -> None:
    """One that touches the round surface from inside is accepted, one that is larger is not."""
    for radius, inside in ((0.5, True), (0.501, False)):
        hole = {**BALL, "radius": radius, "centre": [3.0, 2.0 + math.sqrt(1.25), 2.0]}
        shape = Sphere(centre=[2, 2, 2], radius=2, holes=[hole])
        if inside:
            assert math.fsum(points(shape).volume) == pytest.approx(math.pi * (32 / 3 - 1 / 6))
        else:
            assert "reaches beyond it" in refusal(shape)


def test_a_rotated_block_divided_along_its_own_axes() -> None:
    shape = block({**BALL, "centre": [0.4, 2.2, 2]}, angle=30.0, axis="z")
    found = points(shape, points_per_cell=None, points=[16, 16, 16])
    assert math.fsum(found.volume) == pytest.approx(64.0 - 4.0 / 3.0 * math.pi, rel=1e-13)
    size = body_size(body(shape, points_per_cell=None, points=[16, 16, 16]), "3d", SPACE)
    assert size.points == pytest.approx(len(found.position), rel=0.02)


def test_the_summary_counts_holes_and_paths_are_relative_to_the_case(tmp_path: Path) -> None:
    assert shape_text(block(BALL)) == "box with 1 hole"
    assert shape_text(CASES["horseshoe"][0]) == "box with 2 holes"
    assert shape_text(block()) == "box"
    hole = '{ type = "stl", file = "none.stl", scale = 1 }'
    (tmp_path / "case.toml").write_text(
        f'format = 1\nbodies = [{{ shape = {{ type = "box", holes = [{hole}] }} }}]\n'
    )
    with pytest.raises(BadInput, match=r'bodies\[0\].shape.holes\[0\].file = "none.stl": there is'):
        load_case(tmp_path / "case.toml")
