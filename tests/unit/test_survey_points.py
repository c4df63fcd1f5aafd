# SPDX-License-Identifier: BSD-3-Clause
"""Terrain from survey points at any places: planes in closed form, map coordinates, refusals."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_problems import block_entries

from tilth.bodies.discretise import discretise, inside_body
from tilth.bodies.forms import form_of
from tilth.bodies.request import BodyPoints, Request
from tilth.bodies.size import body_size
from tilth.bodies.thickness import crossings_of
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, HeightFile, Model, Outline, Terrain
from tilth.surface.outline import outline
from tilth.surface.outline_3d import outline_3d
from tilth.variation.level import elevation
from tilth.variation.survey import read_survey

SPACE = Grid(np.zeros(3), np.full(3, 0.5))
MAP = np.array([500_000.0, 5_800_000.0])
"""Such as coordinates of UTM."""


def at_map(width: float, depth: float) -> dict[str, Any]:
    """The rectangle of a terrain of this size there."""
    return {"lower": MAP.tolist(), "upper": np.add(MAP, [width, depth]).tolist()}


def plane(x: Any, y: Any) -> Any:
    return 3.0 + 0.2 * x - 0.1 * y


def scattered(number: int = 200, seed: int = 1) -> np.ndarray:
    """Places around the rectangle from (0, 0) to (4, 6), and its corners."""
    corners = [[0.0, 0.0], [4.0, 0.0], [0.0, 6.0], [4.0, 6.0]]
    return np.vstack([np.random.default_rng(seed).uniform(-1.0, 8.0, (number, 2)), corners])


def survey(folder: Path, place: np.ndarray, height: Any, head: str = "x,y,z") -> str:
    rows = [f"{x!r},{y!r},{z!r}" for (x, y), z in zip(place.tolist(), list(height), strict=True)]
    (folder / "survey.csv").write_text("\n".join([head, *rows]).replace("np.float64", ""))
    return str(folder / "survey.csv")


def tilted(folder: Path, place: np.ndarray | None = None) -> str:
    at = scattered() if place is None else place
    return survey(folder, at, [float(z) for z in plane(*at.T)])


def terrain(file: str, base: Any = 0.5, **entries: Any) -> Terrain:
    surface = {"file": file, "places": "scattered"}
    return Terrain(
        **{"surface": surface, "base": base, "lower": [0, 0], "upper": [4, 6], **entries}
    )


def body(shape: Any, **entries: Any) -> Body:
    whole = {"basis": "gimp", "points_per_cell": 2, **entries}
    return Body(name="ground", material="soil", shape=shape, **whole)


def points(shape: Terrain, grid: Grid = SPACE) -> BodyPoints:
    return discretise(body(shape), "3d", grid)


@pytest.mark.parametrize("slope", [0.0, 1.0], ids=["level", "tilted"])
def test_a_plane_is_the_body_of_a_grid_of_the_same_plane(slope: float, tmp_path: Path) -> None:
    place = scattered()
    heights = [3.0 + slope * (float(plane(x, y)) - 3.0) for x, y in place]
    found = points(terrain(survey(tmp_path, place, heights)))
    volume = 24.0 * (2.5 + slope * (0.2 * 2.0 - 0.1 * 3.0))
    assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-13)
    rows = [f"{x},{y},{3.0 + slope * (plane(x, y) - 3.0)!r}" for x in (0, 4) for y in (0.0, 6.0)]
    (tmp_path / "grid.csv").write_text("\n".join(["x,y,z", *rows]))
    same = points(terrain("", surface={"file": f"{tmp_path}/grid.csv"}))
    np.testing.assert_array_equal(found.position, same.position)
    np.testing.assert_allclose(found.volume, same.volume, rtol=1e-13)
    np.testing.assert_array_equal(found.half_length, same.half_length)


def test_a_pyramid_between_survey_points(tmp_path: Path) -> None:
    """Heights of a surface with edges: a third of the base times its height, above a block."""
    place = np.array([[0, 0], [4, 0], [4, 4], [0, 4], [2, 2], [-1, -1], [5, -1], [5, 5], [-1, 5.0]])
    ground = terrain(survey(tmp_path, place, [2.0] * 4 + [5.0] + [2.0] * 4), upper=[4, 4])
    found = points(ground)
    assert math.fsum(found.volume) == pytest.approx(16.0 * 1.5 + 16.0, rel=1e-13)
    assert body_size(body(ground), "3d", SPACE).points == pytest.approx(40.0 / 0.25**3)
    x, y, z = found.position.T
    top = 5.0 - 1.5 * np.maximum(abs(x - 2.0), abs(y - 2.0))
    assert (z <= top + 1e-6).all()
    assert inside_body(body(ground), "3d", SPACE)(found.position - [0.0, 0.0, 1e-6]).all()
    at = np.array([[1.1, 3.3], [2.0, 2.0], [-0.1, 1.0]])
    crossings = crossings_of(form_of(ground, Request("", False, SPACE)), at)
    thickness = crossings.thickness(np.full(3, -9.0), np.full(3, 99.0))
    np.testing.assert_allclose(thickness, [5.0 - 1.5 * 1.3 - 0.5, 4.5, 0.0], rtol=1e-13)
    surface = outline_3d(body(ground), [0.5] * 3, spacing=0.25)
    assert surface.closed
    enclosed = -np.linalg.det(surface.corner).sum() / 6.0
    assert enclosed == pytest.approx(40.0, rel=2e-3)  # drawn by triangles of its own


def test_the_rectangle_cuts_triangles_off(tmp_path: Path) -> None:
    """Three points around it: one triangle, cut at all four sides."""
    place = np.array([[-9.0, -2.0], [20.0, -1.0], [0.0, 30.0]])
    found = points(terrain(tilted(tmp_path, place)))
    assert math.fsum(found.volume) == pytest.approx(24.0 * 2.5 + 24.0 * 0.1, rel=1e-13)


def test_a_base_of_survey_points_and_a_surface_on_a_grid(tmp_path: Path) -> None:
    rock = {"file": tilted(tmp_path), "places": "scattered"}
    (tmp_path / "grid.csv").write_text("x,y,z\n0,0,5\n0,6,6\n4,0,5\n4,6,7\n")
    found = points(terrain("", rock, surface={"file": f"{tmp_path}/grid.csv"}))
    assert math.fsum(found.volume) == pytest.approx(24.0 * (23.0 / 4.0 - 3.1), rel=1e-13)


def test_map_coordinates_lose_nothing(tmp_path: Path) -> None:
    """A body of 40 m at 5800 km: the places are rounded there to 1e-9 m, and no more is lost."""
    place = 10.0 * scattered() + MAP
    heights = [float(z) for z in plane(*((place - MAP) / 10.0).T)]
    grid = Grid(np.append(MAP, 0.0), np.full(3, 2.0))
    corners = at_map(40.0, 60.0)
    shape = terrain(survey(tmp_path, place, heights), **corners)
    found = points(shape, grid)
    assert math.fsum(found.volume) == pytest.approx(2400.0 * 2.6, rel=1e-11)
    level = {"surface": {"file": survey(tmp_path, place, [3.25] * len(place))}}
    level["surface"]["places"] = "scattered"
    flat = points(terrain("", **level, **corners), grid)
    assert math.fsum(flat.volume) == pytest.approx(2400.0 * 2.75, rel=1e-14)


def test_a_surface_at_map_coordinates_with_the_grid_beside_it(tmp_path: Path) -> None:
    """Which is more cells from zero than are possible from the origin of the grid."""
    place = scattered() + MAP
    shape = terrain(survey(tmp_path, place, [2.0] * len(place)), **at_map(4.0, 6.0))
    surface = outline_3d(body(shape), [0.5] * 3, origin=[*MAP, 0.0])
    enclosed = -np.linalg.det(surface.corner - [*MAP, 0.0]).sum() / 6.0
    assert enclosed == pytest.approx(24.0 * 1.5, rel=1e-8)
    rows = [[0, 0], [4, 0], [4, 2], [0, 0]]
    ring = {"type": "Polygon", "coordinates": [np.add(MAP, rows).tolist()]}
    (tmp_path / "plan.geojson").write_text(json.dumps(ring))
    drawn = Outline(file=f"{tmp_path}/plan.geojson", scale=1.0)
    (chain,) = outline(body(drawn), "plane_strain", [0.5, 0.5], origin=MAP)
    assert chain.points.min(axis=0).tolist() == MAP.tolist()


@pytest.mark.parametrize("unit", [1e-3, 1e3])
def test_the_unit_of_length_changes_nothing(unit: float, tmp_path: Path) -> None:
    place = scattered()
    height = [float(z) for z in np.sin(place[:, 0]) + 3.0]
    whole = points(terrain(survey(tmp_path, place, height)))
    other = points(
        terrain(
            survey(tmp_path, unit * place, [unit * z for z in height]),
            0.5 * unit, lower=[0, 0], upper=[4 * unit, 6 * unit],
        ),
        Grid(np.zeros(3), np.full(3, 0.5 * unit)),
    )  # fmt: skip
    np.testing.assert_allclose(other.position, unit * whole.position, rtol=1e-12)
    np.testing.assert_allclose(other.volume, unit**3 * whole.volume, rtol=1e-11)


def test_points_on_a_grid_cover_its_rectangle_once(tmp_path: Path) -> None:
    """Four points of a cell lie on one circle: either diagonal, but no triangle twice."""
    x, y = np.meshgrid(np.linspace(-1, 5, 13), np.linspace(0, 6, 9))
    place = np.column_stack([x.ravel(), y.ravel()])
    found = points(terrain(tilted(tmp_path, place)))
    assert math.fsum(found.volume) == pytest.approx(24.0 * 2.6, rel=1e-13)


def test_repeated_rows_and_names_in_another_order(tmp_path: Path) -> None:
    place = scattered()[:, ::-1]
    twice = np.vstack([place, place[:5]])
    heights = [float(z) for z in plane(twice[:, 1], twice[:, 0])]
    found = points(terrain(survey(tmp_path, twice, heights, "y,x,elevation")))
    assert math.fsum(found.volume) == pytest.approx(24.0 * 2.6, rel=1e-13)


def test_a_horizon_and_a_depth_from_survey_points(tmp_path: Path) -> None:
    """Everywhere a level may be given; beyond its hull by round-off the height is that of it."""
    level = HeightFile(file=tilted(tmp_path, np.array([[0, 0], [4, 0], [4, 6], [0, 6.0]])),
                       places="scattered")  # fmt: skip
    at = np.array([[1.0, 2.0, 0.0], [4.0 + 1e-10, 3.0, 0.0], [-1e-10, -1e-10, 0.0]])
    np.testing.assert_allclose(elevation(level, at, "key"), [3.0, 3.5, 3.0], atol=1e-9)


def refusal(shape: Terrain, grid: Grid = SPACE) -> str:
    with pytest.raises(BadInput) as error:
        discretise(body(shape), "3d" if grid.dim == 3 else "plane_strain", grid)
    return str(error.value)


def test_a_body_beyond_the_survey(tmp_path: Path) -> None:
    place = MAP + scattered()
    file = survey(tmp_path, place, [1.0] * len(place))
    found = refusal(terrain(file, **at_map(4.0, 9.0)), Grid(np.append(MAP, 0.0), np.full(3, 0.5)))
    assert 'bodies "ground".shape.surface.file' in found
    assert "survey.csv" in found
    assert "(500000, 5800009) is outside the survey, 1." in found
    assert "add survey points around the soil" in found


def test_a_base_above_the_surface_between_its_vertices(tmp_path: Path) -> None:
    """A valley of the surface between the vertices of the base, which is a ridge."""
    place = np.array([[-1, -1], [9, -1], [9, 9], [-1, 9], [2, 3.0]])
    file = survey(tmp_path, place, [5.0] * 4 + [1.0])
    assert "the base is not below the surface at (2, 3)" in refusal(terrain(file, 1.5))


def test_surfaces_that_cross_between_their_vertices(tmp_path: Path) -> None:
    """A valley along x = 2 in the surface at 1, and a ridge of the base along y = 3 at 1.5."""
    valley = survey(tmp_path, np.array([[2, -3], [2, 9], [-5, 3], [9, 3.0]]), [1.0, 1.0, 5.0, 5.0])
    (tmp_path / "ridge").mkdir()
    ridge = survey(
        tmp_path / "ridge", np.array([[-3, 3], [7, 3], [2, -5], [2, 11.0]]), [1.5, 1.5, 0.0, 0.0]
    )
    found = refusal(terrain(valley, {"file": ridge, "places": "scattered"}))
    thick = 1.0 + 4.0 * 0.125 / 7.0 - 1.5 * (1.0 - 0.125 / 8.0)  # in the column beside (2, 3)
    assert "the base is not below the surface at (" in found
    assert f"the ground would be {thick:.6g} thick" in found


@pytest.mark.parametrize(
    ("rows", "part"),
    [
        ("0,0,1\n9,0,1\n0,9,1\n9,0,2", "has two heights, 1 and 2, at (9, 0) (rows 2 and"),
        ("0,0,1\n9,0,1", "has no three points that are not on one line"),
        ("0,0,1\n9,0,1\n9,0,1", "has no three points that are not on one line"),
        ("1,1,1", "has no three points"),
        ("0,0,1\n3,3.3,1\n6,6.6,2\n10,11,3", "has no three points that are not on one line"),
        ("0,0,1\n9,0,nan\n0,9,1", "row 2 below the names has a number that is not finite"),
        ("0,0,1\n9,0,inf\n0,9,1", "row 2 below the names has a number that is not finite"),
        ("0,0,1\n9,0\n0,9,1", "has a row that cannot be read"),
    ],
)
def test_wrong_survey_points(rows: str, part: str, tmp_path: Path) -> None:
    (tmp_path / "survey.csv").write_text(f"x,y,z\n{rows}\n")
    found = refusal(terrain(f"{tmp_path}/survey.csv"))
    assert part in found
    assert 'bodies "ground".shape.surface.file' in found
    assert "survey.csv" in found


def test_points_too_close_for_triangles(tmp_path: Path) -> None:
    """Nine of them within 1e-8 of the extent, which Qhull leaves out in part, are not lost."""
    near = 0.5 + 2e-9 * np.array([[i, j] for i in range(3) for j in range(3)])
    place = 10.0 * np.vstack([scattered() / 10.0, near])
    found = refusal(terrain(tilted(tmp_path, place)))
    assert "has points too close to each other for triangles: (5" in found
    assert "below the names" in found
    assert "keep one of them" in found


def test_scattered_rows_without_the_key_name_it(tmp_path: Path) -> None:
    found = refusal(terrain("", surface={"file": tilted(tmp_path)}))
    assert "is no regular grid" in found
    assert 'or places = "scattered" for survey points' in found


def test_survey_points_where_none_may_be(tmp_path: Path) -> None:
    for file, axes, part in (("a.asc", 2, "no scattered heights"), ("a.csv", 1, "are for 3D")):
        with pytest.raises(BadInput, match=part):
            read_survey(file, axes, "key")
    level = {"file": tilted(tmp_path), "places": "scattered"}
    entries = block_entries("3d", "gimp", "hencky_elastic")
    entries["water"] = {"level": level, "unit_weight": 1e4}
    with pytest.raises(BadInput, match=r"(?s)water.level.places.*survey points give no level"):
        Model.from_dict(entries)
    entries = block_entries("plane_strain", "gimp", "hencky_elastic")
    entries["bodies"][0]["shape"] = {
        "type": "terrain", "surface": level, "base": 0.0, "lower": [0], "upper": [1],
    }  # fmt: skip
    with pytest.raises(BadInput, match=r"(?s)shape.surface.places.*is for 3D.*need no order"):
        Model.from_dict(entries)
    with pytest.raises(BadInput, match=r"surface.places"):
        terrain("", surface={"file": level["file"], "places": "scatterd"})


def test_rows_of_a_section_need_no_order(tmp_path: Path) -> None:
    grid = Grid(np.zeros(2), np.full(2, 0.5))
    (tmp_path / "line.csv").write_text("x,z\n9,2\n1,4\n-5,1\n5,2\n3,4\n")
    shape = Terrain(surface={"file": f"{tmp_path}/line.csv"}, base=0.0, lower=[0.0], upper=[8.0])  # type: ignore[arg-type]
    rows = Terrain(surface=[[-5, 1], [1, 4], [3, 4], [5, 2], [9, 2]], base=0.0, lower=[0.0],
                   upper=[8.0])  # fmt: skip
    read, typed = (discretise(body(s), "plane_strain", grid) for s in (shape, rows))
    np.testing.assert_array_equal(read.position, typed.position)
    np.testing.assert_array_equal(read.volume, typed.volume)
