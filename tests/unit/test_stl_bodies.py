# SPDX-License-Identifier: BSD-3-Clause
"""Bodies within STL surfaces and of physical groups: volumes in closed form, points, refusals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from tilth.bodies.discretise import discretise, inside_body
from tilth.bodies.forms import form_of
from tilth.bodies.request import Request
from tilth.bodies.size import body_size
from tilth.bodies.thickness import crossings_of
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Box, Mesh, Stl
from tilth.surface.outline_3d import outline_3d

SPACE = Grid(np.zeros(3), np.full(3, 0.5))
FACES = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
"""Of a box with corners x fastest, anticlockwise from outside."""


def box(lower: Any, upper: Any, inwards: bool = False) -> np.ndarray:
    """Triangles (12, 3, 3) of a box."""
    corner = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    corner = np.asarray(lower) + corner * np.subtract(upper, lower)
    triangles = [[f[0], f[k], f[k + 1]] for f in FACES for k in (1, 2)]
    return corner[np.array(triangles)[:, ::-1] if inwards else triangles]


def octahedron(centre: Any, radius: float) -> np.ndarray:
    return np.array(
        [
            [[sx, 0, 0], [0, sy, 0], [0, 0, sz]][:: int(sx * sy * sz)]
            for sx in (1, -1)
            for sy in (1, -1)
            for sz in (1, -1)
        ]
    ) * radius + np.asarray(centre)


def stl(folder: Path, *parts: np.ndarray, scale: float = 1.0) -> Stl:
    corner = np.concatenate(parts) / scale
    cells = [("triangle", np.arange(3 * len(corner)).reshape(-1, 3))]
    meshio.write_points_cells(folder / "body.stl", corner.reshape(-1, 3), cells, binary=True)
    return Stl(file=f"{folder}/body.stl", scale=scale)


def body(shape: Any, **entries: Any) -> Body:
    return Body(name="s", material="m", basis="gimp", points_per_cell=2, shape=shape, **entries)


def test_a_box_has_the_points_of_the_shape(tmp_path: Path) -> None:
    """Its faces are on lattice lines, and others in the middle of sub-cells, on all sides."""
    for lower, upper in (((0, 0, 0), (2, 1, 1.5)), ((0.125, 0.125, 0), (1.375, 1.125, 1))):
        found = discretise(body(stl(tmp_path, box(lower, upper))), "3d", SPACE)
        side = np.arange(8) * 0.25 + 0.125
        inner = [
            side[(side >= a - 1e-6) & (side <= b + 1e-6)] for a, b in zip(lower, upper, strict=True)
        ]
        x, y, z = np.meshgrid(*inner, indexing="ij")
        wanted = np.column_stack([c.transpose(2, 1, 0).ravel() for c in (x, y, z)])
        np.testing.assert_allclose(found.position, wanted)
        volume = float(np.prod(np.subtract(upper, lower)))
        assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-6)
    whole = discretise(body(Box(lower=[0, 0, 0], upper=[2, 1, 1.5])), "3d", SPACE)
    again = discretise(body(stl(tmp_path, box((0, 0, 0), (2, 1, 1.5)))), "3d", SPACE)
    np.testing.assert_allclose(again.position, whole.position)


def test_an_octahedron_with_a_cavity(tmp_path: Path) -> None:
    """4/3 R^3 less the cavity, in a file in mm; inside by its inequality."""
    hole = octahedron((2, 2, 2), 0.6)[:, ::-1]
    shape = stl(tmp_path, octahedron((2, 2, 2), 1.9), hole, scale=0.001)
    found = discretise(body(shape), "3d", SPACE)
    volume = 4.0 / 3.0 * (1.9**3 - 0.6**3)
    assert math.fsum(found.volume) == pytest.approx(volume, rel=1e-6)  # single precision
    side = np.arange(16) * 0.25 + 0.125
    lattice = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 3)
    distance = np.abs(lattice - 2.0).sum(axis=1)
    wanted = lattice[(distance <= 1.9) & (distance >= 0.6)]
    assert {tuple(p) for p in found.position.round(6)} == {tuple(p) for p in wanted.round(6)}
    rng = np.random.default_rng(1).uniform(0.0, 4.0, (4000, 3))
    distance = np.abs(rng - 2.0).sum(axis=1)
    inside = inside_body(body(shape), "3d", SPACE)(rng)
    np.testing.assert_array_equal(inside, (distance <= 1.9) & (distance >= 0.6))
    crossings = crossings_of(form_of(shape, Request("", False, SPACE)), rng[:, :2])
    thickness = crossings.thickness(np.full(4000, -9.0), np.full(4000, 9.0))
    away = np.abs(rng[:, :2] - 2.0).sum(axis=1)
    expected = 2.0 * (np.maximum(1.9 - away, 0.0) - np.maximum(0.6 - away, 0.0))
    np.testing.assert_allclose(thickness, expected, atol=1e-6)
    surface = outline_3d(body(shape), [0.5] * 3)
    assert surface.closed
    assert -np.linalg.det(surface.corner).sum() / 6.0 == pytest.approx(volume, rel=1e-6)
    assert body_size(body(shape), "3d", SPACE).points == pytest.approx(volume * 64.0, rel=1e-6)


def refusal(shape: Any, dimension: int = 3) -> str:
    grid = Grid(np.zeros(dimension), np.full(dimension, 0.5))
    with pytest.raises(BadInput) as error:
        discretise(body(shape), "3d" if dimension == 3 else "plane_strain", grid)
    return str(error.value)


def test_wrong_surfaces(tmp_path: Path) -> None:
    found = refusal(stl(tmp_path, box((0, 0, 0), (1, 1, 1))[1:]))
    for part in ('bodies "s".shape.file', "body.stl", "the surface is not closed", "close its"):
        assert part in found
    (tmp_path / "body.stl").write_bytes(b"solid nothing")
    assert "body.stl" in refusal(Stl(file=f"{tmp_path}/body.stl", scale=1.0))


def test_a_physical_group_of_a_mesh_is_a_body(tmp_path: Path) -> None:
    points = np.array([[0.0, 0, 0], [3, 0, 0], [3, 2, 0], [0, 2, 0], [5, 0, 0]])
    mesh = meshio.Mesh(
        points, [("triangle", np.array([[0, 1, 2], [0, 2, 3], [1, 4, 2]]))],
        cell_data={"gmsh:physical": [np.array([7, 7, 8])],
                   "gmsh:geometrical": [np.array([1, 1, 2])]},
        field_data={"clay": np.array([7, 2]), "sand": np.array([8, 2])},
    )  # fmt: skip
    mesh.write(tmp_path / "soil.msh", file_format="gmsh22", binary=False)
    file, plane = f"{tmp_path}/soil.msh", Grid(np.zeros(2), np.full(2, 0.5))
    for group, area in (("clay", 6.0), ("sand", 2.0), (None, 8.0)):
        found = discretise(body(Mesh(file=file, group=group)), "plane_strain", plane)
        assert math.fsum(found.volume) == pytest.approx(area, rel=1e-13)
    found = refusal(Mesh(file=file, group="caly"), 2)
    assert 'bodies "s".shape.group' in found
    assert "did you mean `clay`?" in found
