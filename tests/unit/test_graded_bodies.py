# SPDX-License-Identifier: BSD-3-Clause
"""Material points of bodies on graded grids: their number in each cell, domains and volume."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from tilth import BadInput
from tilth.arrays import Floats, Integers
from tilth.bodies import BodyPoints, discretise
from tilth.bodies.request import smallest_cells
from tilth.bodies.size import body_size
from tilth.grid.background import Grid
from tilth.model import Body
from tilth.model.grading import line_of

X = line_of(((0.0, 0.1), (1.0, 0.1), (4.0, 0.6)))
Y = line_of(((0.0, 0.5), (2.0, 0.125), (3.0, 0.125)))
NONE = np.zeros(0)
Z_SIZE = 0.25


def grid(dim: int = 2, axes: str = "xy") -> Grid:
    """Fine at x below 1 and at y above 2, its origin at (0.5, -1, 0)."""
    lines = [X if "x" in axes else NONE, Y if "y" in axes else NONE, NONE][:dim]
    size = [
        0.1 if k == 2 or len(line) == 0 else np.diff(line).min() for k, line in enumerate(lines)
    ]
    size[2:] = [Z_SIZE][: dim - 2]
    return Grid(np.array([0.5, -1.0, 0.0][:dim]), np.array(size), lines=tuple(lines))


def points_of(
    shape: dict[str, Any], kind: str = "plane_strain", on: Grid | None = None, **resolution: Any
) -> BodyPoints:
    own = on or grid(3 if kind == "3d" else 2)
    given = {"basis": "gimp", **resolution}
    body = Body.model_validate({"name": "soil", "material": "clay", "shape": shape, **given})
    return discretise(body, kind, own)


def in_cells(points: BodyPoints, on: Grid) -> tuple[Integers, Integers]:
    """Lattice indices of the cells with points, and the number of points in each."""
    cell = np.floor(on.in_cells(points.position)).astype(np.int64)
    return tuple(np.unique(cell, axis=0, return_counts=True))  # type: ignore[return-value]


def assert_sum(points: BodyPoints, volume: float) -> None:
    assert (points.volume > 0.0).all()
    assert math.fsum(points.volume) == pytest.approx(volume, rel=1e-13)


def box(*corners: list[float], **more: Any) -> dict[str, Any]:
    return {"type": "box", "lower": corners[0], "upper": corners[1], **more}


@pytest.mark.parametrize("per_cell", [1, 2, [3, 2]])
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_a_box_on_grid_lines_has_as_many_points_in_each_cell(kind: str, per_cell: Any) -> None:
    own = grid()
    lower, upper = own.position(np.array([[2.0, 1.0], [17.0, 12.0]]))
    points = points_of(box(lower, upper), kind, points_per_cell=per_cell)
    cell, count = in_cells(points, own)
    number = np.broadcast_to(per_cell, 2)
    assert len(cell) == 15 * 11
    assert (count == number.prod()).all()
    np.testing.assert_allclose(
        points.half_length, 0.5 * own.sizes_at(points.position) / number, rtol=1e-12
    )
    share = own.in_cells(points.position) % 1.0 * number
    np.testing.assert_allclose(share % 1.0, 0.5, atol=1e-10)
    sides = upper - lower
    around = math.pi * (upper[0] + lower[0]) if kind == "axisymmetric" else 1.0
    assert_sum(points, sides.prod() * around)


def assert_tiled(points: BodyPoints, lower: Floats, upper: Floats) -> None:
    """The domains of a box fill it, row after row."""
    for k in range(len(lower)):
        place, first = np.unique(points.position[:, k], return_index=True)
        half = points.half_length[first, k]
        np.testing.assert_allclose((place + half)[:-1], (place - half)[1:], atol=1e-12)
        assert (place[0] - half[0], place[-1] + half[-1]) == pytest.approx((lower[k], upper[k]))


@pytest.mark.parametrize("per_cell", [1, 2, 3])
def test_a_box_off_the_lines_is_tiled_cell_by_cell(per_cell: int) -> None:
    """Of the cells that it cuts as many points as their share; whole cells have all of them."""
    own = grid()
    for low, high in ([2.3, 1.8], [17.45, 11.2]), ([2.9, 1.05], [16.1, 11.96]):
        lower, upper = own.position(np.array([low, high]))
        points = points_of(box(lower, upper), points_per_cell=per_cell)
        assert_tiled(points, lower, upper)
        assert_sum(points, (upper - lower).prod())
        cell, count = in_cells(points, own)
        whole = ((cell >= np.ceil(low)) & (cell + 1 <= np.floor(high))).all(axis=1)
        assert whole.sum() == np.prod(np.floor(high) - np.ceil(low))
        beside_none = per_cell * (np.ceil(low) - low) >= 0.5
        if beside_none.all() and (per_cell * (high - np.floor(high)) >= 0.5).all():
            assert (count[whole] == per_cell**2).all()
        spacing = 2.0 * points.half_length / own.sizes_at(points.position)
        assert spacing.max() <= 1.5 / per_cell
        assert spacing.min() > 0.5 / 1.5 / per_cell


def test_a_box_within_a_cell_has_one_point() -> None:
    lower, upper = grid().position(np.array([[14.1, 3.2], [14.3, 3.3]]))
    points = points_of(box(lower, upper), points_per_cell=2)
    assert points.position == pytest.approx(0.5 * (lower + upper)[None])
    assert_sum(points, (upper - lower).prod())


def test_only_the_graded_axis_is_divided_unevenly() -> None:
    own = grid(axes="x")
    points = points_of(box([0.6, -1.0], [3.5, 1.0]), on=own, points_per_cell=2)
    np.testing.assert_allclose(points.half_length[:, 1], 0.025, rtol=1e-12)
    assert len(np.unique(points.half_length[:, 0].round(12))) > 5


def test_a_box_in_space() -> None:
    own = grid(3)
    lower, upper = own.position(np.array([[5.0, 0.0, 1.0], [14.0, 7.0, 4.0]]))
    points = points_of(box(lower, upper), "3d", points_per_cell=2)
    cell, count = in_cells(points, own)
    assert len(cell) == 9 * 7 * 3
    assert (count == 8).all()
    assert_sum(points, (upper - lower).prod())


def test_spacing_and_points_keep_their_meaning() -> None:
    shape = box([0.5, 1.0], [1.5, 2.0])
    for resolution in ({"spacing": 0.05}, {"points": [20, 20]}):
        points = points_of(shape, **resolution)
        assert len(points.position) == 400
        np.testing.assert_allclose(points.half_length, 0.025, rtol=1e-12)


def test_a_spacing_too_wide_for_the_fine_cells_is_refused() -> None:
    points_of(box([3.5, -1.0], [4.5, -0.5]), spacing=0.25)
    with pytest.raises(BadInput, match=r"points 0.25 apart along x in cells of 0.1:") as caught:
        points_of(box([0.5, -1.0], [4.5, -0.5]), spacing=0.25)
    assert caught.value.key == 'bodies "soil".spacing'


def test_a_turned_box_has_the_spacing_of_the_smallest_cells_in_it() -> None:
    own = grid()
    shape = box([2.0, 0.0], [3.0, 1.0], angle=30.0)
    points = points_of(shape, points_per_cell=2)
    body = Body.model_validate(
        {"name": "s", "material": "m", "basis": "gimp", "spacing": 1.0} | {"shape": shape}
    )
    lower, upper = (np.array([corner]) for corner in body.shape.bounds() or ())
    finest = smallest_cells(own, lower, upper)[0]
    np.testing.assert_allclose(points.half_length[0], 0.25 * finest, rtol=0.1)
    assert_sum(points, 1.0)


ROUND: list[tuple[dict[str, Any], str, float]] = [
    ({"type": "circle", "centre": [2.5, 0.9], "radius": 0.8}, "plane_strain", math.pi * 0.64),
    (
        {"type": "circle", "centre": [2.5, 0.9], "radius": 0.8},
        "axisymmetric",
        math.pi * 0.64 * 2.0 * math.pi * 2.5,
    ),
    ({"type": "polygon", "vertices": [[0.5, -1.0], [3.5, -1.0], [2.0, 1.5]]}, "plane_strain", 3.75),
    (
        {"type": "polygon", "vertices": [[0.5, -1.0], [3.5, -1.0], [2.0, 1.5]]},
        "axisymmetric",
        3.75 * 2.0 * math.pi * 2.0,
    ),
    (
        {"type": "sphere", "centre": [1.5, 0.7, 1.0], "radius": 0.75, "inner_radius": 0.2},
        "3d",
        4.0 / 3.0 * math.pi * (0.75**3 - 0.2**3),
    ),
    (
        {"type": "cylinder", "centre": [1.5, 0.7, 0.5], "radius": 0.6, "height": 1.2, "axis": "x"},
        "3d",
        math.pi * 0.36 * 1.2,
    ),
]


@pytest.mark.parametrize(("shape", "kind", "volume"), ROUND)
def test_other_shapes_consist_of_the_sub_cells_of_each_cell(
    shape: dict[str, Any], kind: str, volume: float
) -> None:
    own = grid(3 if kind == "3d" else 2)
    points = points_of(shape, kind, points_per_cell=3)
    assert_sum(points, volume)
    share = own.in_cells(points.position) % 1.0 * 3.0
    np.testing.assert_allclose(share % 1.0, 0.5, atol=1e-9)
    np.testing.assert_allclose(points.half_length, own.sizes_at(points.position) / 6.0, rtol=1e-12)
    around = 2.0 * math.pi * points.position[:, 0] if kind == "axisymmetric" else 1.0
    scale = points.volume / (around * np.prod(2.0 * points.half_length, axis=1))
    np.testing.assert_allclose(scale, scale[0], rtol=1e-12)
    assert scale[0] == pytest.approx(1.0, abs=0.06)
    _, count = in_cells(points, own)
    assert (count == 3**own.dim).mean() > 0.4


def mesh_file(folder: Path, dim: int) -> Path:
    """Quadrilaterals or hexahedra, of which each side is 0.5 long, from (0.5, -1, 0) on."""
    number = np.array([6, 4, 2][:dim])
    node = np.indices(number + 1).reshape(dim, -1).T
    place = np.zeros((len(node), 3))
    place[:, :dim] = 0.5 * node + np.array([0.5, -1.0, 0.0])[:dim]
    corner = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    name = "quad"
    if dim == 3:
        corner = np.array([[*c, z] for z in (0, 1) for c in corner])
        name = "hexahedron"
    first = np.indices(number).reshape(dim, -1).T
    cells = np.ravel_multi_index(tuple((first[:, None] + corner).T), tuple(number + 1)).T
    meshio.Mesh(place, [(name, cells)]).write(folder / "m.msh", file_format="gmsh22", binary=False)
    return folder / "m.msh"


@pytest.mark.parametrize("basis", ["gimp", "cpdi2", "cpdi1"])
@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric", "3d"])
def test_elements_of_a_mesh_are_divided_by_the_smallest_cells_in_them(
    kind: str, basis: str, tmp_path: Path
) -> None:
    dim = 3 if kind == "3d" else 2
    own = grid(dim)
    file = mesh_file(tmp_path, dim)
    points = points_of({"type": "mesh", "file": str(file)}, kind, basis=basis, points_per_cell=2)
    around = 2.0 * math.pi * (0.5 + 1.5) if kind == "axisymmetric" else 1.0
    assert_sum(points, 3.0 * 2.0 * around)
    along = points.half_length[:, 0]
    if basis != "gimp":  # its domains are squares or cubes
        coarse = smallest_cells(own, np.full((1, dim), 3.0), np.full((1, dim), 3.5))[0, 0]
        assert along[points.position[:, 0] < 1.5] == pytest.approx(0.025)
        assert along[points.position[:, 0] > 3.0] == pytest.approx(0.25 / round(1.0 / coarse))
        assert coarse > 0.24
    assert (along < 0.5 * own.sizes_at(points.position)[:, 0]).all()
    cell, count = in_cells(points, own)
    inside = (own.position(cell.astype(float)) >= [0.5, -1.0, 0.0][:dim]).all(axis=1)
    inside &= (own.position(cell + 1.0) <= [3.5, 1.0, 1.0][:dim]).all(axis=1)
    assert (count[inside] >= (1 if basis == "gimp" else 2**dim - 2)).all()


def test_smallest_cells_within_boxes() -> None:
    own = grid()
    size = np.diff(X)
    low, high = (
        np.array([0.55, 1.2, 1.5, 3.9, -4.0, 20.0]),
        np.array([9.0, 1.9, 1.6, 4.0, -3.0, 30.0]),
    )
    rows = [np.column_stack([x, np.zeros(6)]) for x in (low, high)]
    found = smallest_cells(own, *rows)[:, 0]
    assert found[0] == pytest.approx(0.1)
    cells = [
        np.clip(np.floor(own.in_cells(np.array([x, 0.0]))[0]), 0, len(size) - 1)
        for x in (1.2, 1.5, 3.9)
    ]
    assert found[1:4] == pytest.approx([size[int(c)] for c in cells])
    assert found[4:] == pytest.approx([size[0], size[-1]])


@pytest.mark.parametrize(
    "shape",
    [box([0.7, -0.9], [3.8, 1.7]), *(each for each, kind, _ in ROUND if kind == "plane_strain")],
)
def test_the_size_of_a_body_before_its_points_are_made(shape: dict[str, Any]) -> None:
    own = grid()
    body = Body.model_validate(
        {"name": "s", "material": "m", "basis": "gimp", "points_per_cell": 2, "shape": shape}
    )
    size = body_size(body, "plane_strain", own)
    points = discretise(body, "plane_strain", own)
    cell, _ = in_cells(points, own)
    assert size.points == pytest.approx(len(points.position), rel=0.1)
    assert size.cells == pytest.approx(len(cell), rel=0.12)
    assert (size.lower <= cell.min(axis=0)).all()
    assert (size.upper >= cell.max(axis=0) + 1).all()


@pytest.mark.parametrize("per_cell", [2, 3])
def test_equal_cells_given_by_places_have_the_points_of_a_uniform_grid(per_cell: int) -> None:
    uniform = Grid(np.array([0.5, -1.0]), np.array([0.25, 0.5]))
    line = line_of(((0.0, 0.25), (4.0, 0.25)))
    places = Grid(uniform.origin, uniform.cell_size, lines=(line, NONE))
    shapes = [box([0.5, -1.0], [3.5, 2.0]), ROUND[0][0], ROUND[2][0]]
    for shape in shapes:
        one, other = (
            points_of(shape, on=each, points_per_cell=per_cell) for each in (uniform, places)
        )
        np.testing.assert_allclose(one.position, other.position, atol=1e-13)
        np.testing.assert_allclose(one.volume, other.volume, rtol=1e-12)
        np.testing.assert_allclose(one.half_length, other.half_length, rtol=1e-12)
