# SPDX-License-Identifier: BSD-3-Clause
"""Ground below a terrain: volumes and thickness in closed form, its surface, wrong files."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tilth.bodies.discretise import discretise, inside_body
from tilth.bodies.forms import form_of
from tilth.bodies.request import Request
from tilth.bodies.size import body_size
from tilth.bodies.thickness import crossings_of
from tilth.case import load_case
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Polygon, Terrain
from tilth.surface.outline import outline
from tilth.surface.outline_3d import outline_3d

PLANE, SPACE = (Grid(np.zeros(d), np.full(d, 0.5)) for d in (2, 3))


def height(x: Any, y: Any) -> Any:
    """Bilinear, so that a grid of any lines has it exactly."""
    return 3.0 + 0.2 * x - 0.1 * y + 0.05 * x * y


VOLUME = 3.0 * 24.0 + 0.2 * 8.0 * 6.0 - 0.1 * 24.0 * 3.0 + 0.05 * 8.0 * 18.0 - 24.0 * 0.5
"""Between z = 0.5 and the height over x from 0 to 4 and y from 0 to 6, by integration."""


def csv(folder: Path, name: str = "x,y,z") -> str:
    lines = [-1.0, 0.3, 1.7, 4.0], [0.0, 2.0, 7.0]
    rows = [f"{x},{y},{height(x, y)!r}" for x in lines[0] for y in lines[1]]
    (folder / "heights.csv").write_text("\n".join([name, *rows]))
    return str(folder / "heights.csv")


def asc(folder: Path, gap: bool = False, corner: bool = True) -> str:
    """A grid of 6 x 8 cells of 1.25 by 1 from south-west; rows from north to south."""
    x, y = -0.5 + 1.25 * np.arange(6), -0.5 + np.arange(8)
    table = height(x[None, :], y[::-1, None])
    if gap:
        table[3, 2] = -9999.0
    start = (x[0] - 0.625, y[0] - 0.5) if corner else (x[0], y[0])
    word = "corner" if corner else "center"
    head = ["ncols 6", "nrows 8", f"xll{word} {start[0]}", f"yll{word} {start[1]}", "dx 1.25",
            "dy 1", "NODATA_value -9999"]  # fmt: skip
    rows = [" ".join(repr(float(z)) for z in row) for row in table]
    (folder / "heights.asc").write_text("\n".join(head + rows))
    return str(folder / "heights.asc")


def terrain(file: str, base: Any = 0.5, **entries: Any) -> Terrain:
    whole = {"surface": {"file": file}, "base": base, "lower": [0, 0], "upper": [4, 6], **entries}
    return Terrain(**whole)


def body(shape: Terrain | Polygon, **entries: Any) -> Body:
    whole = {"basis": "gimp", "points_per_cell": 2, **entries}
    return Body(name="ground", material="soil", shape=shape, **whole)


@pytest.mark.parametrize("source", ["csv", "asc", "centres"])
def test_volume_thickness_and_points_in_space(source: str, tmp_path: Path) -> None:
    file = csv(tmp_path) if source == "csv" else asc(tmp_path, corner=source == "asc")
    ground = body(terrain(file))
    found = discretise(ground, "3d", SPACE)
    assert math.fsum(found.volume) == pytest.approx(VOLUME, rel=1e-13)
    x, y, z = found.position.T
    assert (z < height(x, y) + 1e-6).all()
    assert inside_body(ground, "3d", SPACE)(found.position).all()
    assert found.volume == pytest.approx(0.25**3, rel=0.03)  # the lattice misses no part
    assert body_size(ground, "3d", SPACE).points == pytest.approx(VOLUME / 0.25**3)
    place = np.array([[1.1, 3.3], [3.9, 0.1], [-0.1, 1.0], [2.0, 6.1]])
    crossings = crossings_of(form_of(ground.shape, Request("", False, SPACE)), place)
    expected = np.where([1, 1, 0, 0], height(*place.T) - 0.5, 0.0)
    thickness = crossings.thickness(np.full(4, -9.0), np.full(4, 99.0))
    np.testing.assert_allclose(thickness, expected, rtol=1e-13)


def test_its_surface_in_space_is_closed_and_has_its_volume(tmp_path: Path) -> None:
    """By the divergence theorem; a bilinear surface is drawn by triangles."""
    surface = outline_3d(body(terrain(csv(tmp_path))), [0.5] * 3, spacing=0.25)
    assert surface.closed
    enclosed = -np.linalg.det(surface.corner).sum() / 6.0  # the normals point inwards
    assert enclosed == pytest.approx(VOLUME, rel=2e-3)
    assert set(surface.part) == {"top", "base", "x-", "x+", "y-", "y+"}


def test_a_base_of_its_own_grid(tmp_path: Path) -> None:
    (tmp_path / "rock.csv").write_text("x,value\n0,1\n1,0.5\n4,1.1\n")
    shape = terrain(csv(tmp_path), {"file": f"{tmp_path}/rock.csv"})
    base = 6.0 * (0.75 + 0.8 * 3.0)
    found = discretise(body(shape), "3d", SPACE)
    assert math.fsum(found.volume) == pytest.approx(VOLUME + 12.0 - base, rel=1e-13)


def test_a_section_is_the_polygon_below_the_polyline(tmp_path: Path) -> None:
    (tmp_path / "line.csv").write_text("x,z\n-5,1\n1,4\n3,4\n5,2\n9,2\n")
    shape = Terrain(surface={"file": f"{tmp_path}/line.csv"}, base=0.0, lower=[0.0], upper=[8.0])  # type: ignore[arg-type]
    same = Polygon(vertices=[(0, 0), (8, 0), (8, 2), (5, 2), (3, 4), (1, 4), (0, 3.5)])
    typed, read = (discretise(body(s), "plane_strain", PLANE) for s in (same, shape))
    np.testing.assert_array_equal(read.position, typed.position)
    np.testing.assert_array_equal(read.volume, typed.volume)
    rows = Terrain(surface=[[-5, 1], [1, 4], [3, 4], [5, 2], [9, 2]], base=0.0, lower=[0.0],
                   upper=[8.0])  # fmt: skip
    assert form_of(rows, Request("", False, PLANE)) == same
    (chain,) = outline(body(shape), "plane_strain", [0.5, 0.5])
    assert chain.closed


def refusal(shape: Terrain, grid: Grid = SPACE) -> str:
    with pytest.raises(BadInput) as error:
        discretise(body(shape), "3d" if grid.dim == 3 else "plane_strain", grid)
    return str(error.value)


def test_a_terrain_that_does_not_cover_the_body(tmp_path: Path) -> None:
    found = refusal(terrain(csv(tmp_path), upper=[4.5, 6]))
    assert 'bodies "ground".shape.surface.file' in found
    assert "heights.csv" in found
    assert "outside the grid, which goes from x = -1 to 4" in found
    rows = Terrain(surface=[[0, 2], [5, 3]], base=0.0, lower=[0.0], upper=[8.0])
    assert "the rows go from 0 to 5" in refusal(rows, PLANE)


def test_a_base_above_the_surface(tmp_path: Path) -> None:
    found = refusal(terrain(csv(tmp_path), 2.9))
    assert 'bodies "ground".shape.base' in found
    assert "the base is not below the surface at (0, 6): the ground would be -0.5 thick" in found


def test_gaps_and_wrong_files(tmp_path: Path) -> None:
    assert "the grid has no height at or next to (" in refusal(terrain(asc(tmp_path, gap=True)))
    good = Path(asc(tmp_path)).read_text()
    for old, new, part in (
        ("ncols 6", "ncols 7", "has 48 heights, not 8 rows of 7"),
        ("ncols 6\n", "", "is no ASCII grid: ncols is missing in its header"),
        ("xllcorner", "xll", "xllcorner is missing"),
        ("dx 1.25", "dx 0", "of a size above 0"),
        ("dx 1.25", "dx wide", "is no ASCII grid: could not convert"),
        ("ncols 6", "ncols 5.9", "is no ASCII grid: ncols = 5.9 is not a whole number"),
        ("nrows 8", "nrows 8.5", "is no ASCII grid: nrows = 8.5 is not a whole number"),
    ):
        (tmp_path / "bad.asc").write_text(good.replace(old, new))
        found = refusal(terrain(str(tmp_path / "bad.asc")))
        assert part in found
        assert "bad.asc" in found
    assert "instead of the names of its columns" in refusal(terrain(csv(tmp_path, "x,y,w")))
    text = Path(csv(tmp_path)).read_text().replace(repr(height(0.3, 2.0)), "nan")
    Path(csv(tmp_path)).write_text(text)
    assert "has a number that is not finite" in refusal(terrain(f"{tmp_path}/heights.csv"))
    flat = Terrain(surface={"file": asc(tmp_path)}, base=0.0, lower=[0.0], upper=[3.0])  # type: ignore[arg-type]
    assert "an ASCII grid is for 3D" in refusal(flat, PLANE)


def test_paths_are_relative_to_the_case_file(tmp_path: Path) -> None:
    shape = (
        '{ type = "terrain", surface = { file = "none.csv" }, base = 0, lower = [0], upper = [1] }'
    )
    other = '{ type = "outline", file = "none.dxf", scale = 1 }'
    (tmp_path / "case.toml").write_text(
        f"format = 1\nbodies = [{{ shape = {shape} }}]\n"
        f'stages = [{{ excavate = [{{ body = "a", shape = {other} }}] }}]\n'
    )
    with pytest.raises(BadInput) as error:
        load_case(tmp_path / "case.toml")
    found = str(error.value)
    assert 'bodies[0].shape.surface.file = "none.csv": there is no such file' in found
    assert 'stages[0].excavate[0].shape.file = "none.dxf": there is no such file' in found
