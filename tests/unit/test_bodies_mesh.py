# SPDX-License-Identifier: BSD-3-Clause
"""Material points of Gmsh meshes."""

import importlib
import math

import numpy as np
import pytest
from gmsh_session import gmsh_session
from mesh_bodies import write

from tilth.bodies import discretise
from tilth.bodies.elements import ELEMENTS, simplex_weights
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Mesh

pytest.importorskip("meshio")

CORNERS = {
    "triangle": [[0.2, 0.1], [1.3, 0.3], [0.5, 1.4]],
    "quad": [[0.2, 0.1], [1.3, 0.3], [1.1, 1.4], [0.1, 0.9]],
    "tetra": [[0, 0, 0], [1.1, 0.1, 0], [0.2, 1.2, 0.1], [0.3, 0.2, 0.9]],
    "hexahedron": [
        [0, 0, 0],
        [1.1, 0.1, 0],
        [1.2, 1.3, 0.2],
        [0, 0.9, 0.1],
        [0.1, 0, 1],
        [1, 0, 1.2],
        [1, 1, 1.4],
        [0.2, 1, 0.8],
    ],
}


def points_of(path, kind="plane_strain", **resolution):
    dimension = 3 if kind == "3d" else 2
    body = Body(name="dam", material="clay", shape=Mesh(file=str(path)), basis="gimp", **resolution)
    return discretise(body, kind, Grid(np.zeros(dimension), np.full(dimension, 0.5)))


def monomial_integrals(name, corners):
    """Volume and first moments of an element by 6 Gauss points a direction on its own map."""
    x, w = np.polynomial.legendre.leggauss(6)
    corners = np.asarray(corners, dtype=float)
    dimension = corners.shape[1]
    total = np.zeros(dimension + 1)
    for index in np.ndindex(*(len(x),) * dimension):
        at = (1.0 + x[list(index)]) / 2.0
        weight = np.prod(w[list(index)]) / 2.0**dimension
        place = mapped(name, corners, at)
        step = 1e-6
        columns = [
            (mapped(name, corners, at + step * e) - mapped(name, corners, at - step * e)) / 2 / step
            for e in np.eye(dimension)
        ]
        total += weight * np.linalg.det(np.transpose(columns)) * np.array([1.0, *place])
    return total


def mapped(name, c, at):
    """The element's map from the unit square or cube (collapsed for simplices)."""
    if name == "triangle":
        r, s = at[0] * (1 - at[1]), at[1]
        return c[0] + r * (c[1] - c[0]) + s * (c[2] - c[0])
    if name == "tetra":
        r, s, t = at[0] * (1 - at[1]) * (1 - at[2]), at[1] * (1 - at[2]), at[2]
        return c[0] + r * (c[1] - c[0]) + s * (c[2] - c[0]) + t * (c[3] - c[0])
    r, s = at[:2]
    face = (1 - r) * (1 - s) * c[0] + r * (1 - s) * c[1] + r * s * c[2] + (1 - r) * s * c[3]
    if name == "quad":
        return face
    top = (1 - r) * (1 - s) * c[4] + r * (1 - s) * c[5] + r * s * c[6] + (1 - r) * s * c[7]
    return (1 - at[2]) * face + at[2] * top


@pytest.mark.parametrize("name", list(ELEMENTS))
@pytest.mark.parametrize("cuts", [1, 2, 5])
def test_pieces_keep_volume_and_centroid_of_every_element(name, cuts):
    corners = np.array([CORNERS[name]], dtype=float)
    centroid, volume = ELEMENTS[name].pieces(corners, cuts)
    assert volume.shape == (1, cuts ** corners.shape[2])
    assert (volume > 0.0).all()
    moments = np.concatenate([[volume.sum()], volume[0] @ centroid[0]])
    np.testing.assert_allclose(moments, monomial_integrals(name, CORNERS[name]), rtol=1e-8)
    if name in ("triangle", "tetra"):
        np.testing.assert_allclose(volume, volume[0, 0], rtol=1e-15)


@pytest.mark.parametrize("dimension", [2, 3])
def test_pieces_of_a_simplex_cover_it_evenly(dimension):
    weight = simplex_weights(dimension, 12)
    assert weight.shape == (12**dimension, dimension + 1)
    np.testing.assert_allclose(weight.sum(axis=1), 1.0, rtol=1e-14)
    assert weight.min() > 0.0
    # second moments of a simplex: mean of w_i^2 is 2/((d+1)(d+2)), of w_i w_j half of it
    second = weight.T @ weight / len(weight)
    exact = (1.0 + np.eye(dimension + 1)) / ((dimension + 1) * (dimension + 2))
    np.testing.assert_allclose(second, exact, atol=0.6 / 12**2 / (dimension + 1))
    # no two pieces share a centroid
    assert len(np.unique(np.round(weight * 12 * (dimension + 1)), axis=0)) == len(weight)


@pytest.mark.parametrize("kind", ["plane_strain", "axisymmetric"])
def test_mesh_in_2d_sums_to_the_area_or_ring(tmp_path, kind):
    points = [[0, 0], [1, 0.1], [2, 0], [2.2, 1], [1.1, 0.8], [0, 1], [1, 2]]
    cells = [
        ("line", [[0, 1], [1, 2]]),
        ("quad", [[0, 1, 4, 5], [1, 2, 3, 4]]),
        ("triangle", [[4, 3, 6], [5, 4, 6]]),
    ]
    outline = np.array([points[i] for i in (0, 1, 2, 3, 6, 5)])
    following = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1]
    area = cross.sum() / 2
    moment = ((outline + following)[:, 0] * cross).sum() / 6
    result = points_of(write(tmp_path / "a.msh", points, cells), kind=kind, points_per_cell=4)
    expected = 2.0 * math.pi * moment if kind == "axisymmetric" else area
    assert math.fsum(result.volume) == pytest.approx(expected, rel=1e-13)
    assert 0.5 * area / 0.125**2 < len(result.volume) < 2.0 * area / 0.125**2
    if kind == "plane_strain":
        np.testing.assert_allclose(4.0 * result.half_length.prod(axis=1), result.volume)
    assert (result.half_length[:, 0] <= result.position[:, 0]).all()


def test_points_come_in_the_order_of_the_elements_whatever_their_size(tmp_path):
    side = [0.0, 3.0, 3.2, 5.0, 5.1]
    points = [[x, y] for y in (0.0, 1.0) for x in side]
    cells = [("quad", [[i, i + 1, i + 6, i + 5] for i in range(4)])]
    result = points_of(write(tmp_path / "a.msh", points, cells), spacing=0.4)
    element = np.searchsorted(side, result.position[:, 0]) - 1
    assert (np.diff(element) >= 0).all()
    assert np.bincount(element).tolist() == [16, 1, 9, 1]
    assert math.fsum(result.volume) == pytest.approx(5.1, rel=1e-14)


def test_clockwise_mesh_is_the_same_body(tmp_path):
    cells = [("triangle", [[0, 2, 1]])]
    clockwise = points_of(write(tmp_path / "a.msh", CORNERS["triangle"], cells), spacing=0.2)
    assert (clockwise.volume > 0.0).all()
    area = 0.5 * np.linalg.det(np.array(CORNERS["triangle"])[1:] - CORNERS["triangle"][0])
    assert math.fsum(clockwise.volume) == pytest.approx(area, rel=1e-13)


def test_mesh_in_3d_made_by_gmsh(tmp_path):
    with gmsh_session() as gmsh:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
        gmsh.model.occ.addBox(0, 0, 0, 2, 1, 1.5)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(3)
        gmsh.write(str(tmp_path / "body.msh"))
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "surface.msh"))
    result = points_of(tmp_path / "body.msh", kind="3d", spacing=0.2)
    assert math.fsum(result.volume) == pytest.approx(3.0, rel=1e-13)
    np.testing.assert_allclose(result.volume @ result.position / 3.0, [1.0, 0.5, 0.75], rtol=1e-12)
    np.testing.assert_allclose(8.0 * result.half_length.prod(axis=1), result.volume)
    with pytest.raises(BadInput, match=r"bodies \"dam\".*contains no tetrahedra.*triangle"):
        points_of(tmp_path / "surface.msh", kind="3d", spacing=0.2)


HEXAHEDRON = np.array(CORNERS["hexahedron"], dtype=float)


@pytest.mark.parametrize(
    ("kind", "points", "cells", "words"),
    [
        (
            "plane_strain",
            [[0, 0], [1, 0], [2, 0]],
            [("triangle", [[0, 1, 2]])],
            "triangle 1.*degen",
        ),
        (
            "plane_strain",
            [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0.5]],
            [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 2, 4]])],
            "triangle 1.*inverted",
        ),
        (
            "plane_strain",
            [[0, 0], [1, 0], [0.2, 0.2], [0, 1]],
            [("quad", [[0, 1, 2, 3]])],
            "quadrilateral 1.*degenerate",
        ),
        (
            "3d",
            HEXAHEDRON[[0, 1, 6, 3, 4, 5, 2, 7]],
            [("hexahedron", [list(range(8))])],
            "hexahedron 1.*degenerate",
        ),
        (
            "plane_strain",
            [[0, 0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]],
            [("triangle6", [list(range(6))])],
            "triangle6",
        ),
        ("plane_strain", CORNERS["tetra"], [("tetra", [[0, 1, 2, 3]])], "tetra"),
        ("plane_strain", CORNERS["tetra"], [("triangle", [[0, 1, 2], [0, 2, 3]])], "not flat"),
        (
            "axisymmetric",
            [[-1, 0], [1, 0], [0, 1]],
            [("triangle", [[0, 1, 2]])],
            "axis of symmetry",
        ),
    ],
)
def test_unusable_meshes_are_refused(tmp_path, kind, points, cells, words):
    path = write(tmp_path / "a.msh", points, cells)
    with pytest.raises(BadInput, match=f'(?s)bodies "dam".*{words}'):
        points_of(path, kind=kind, spacing=0.2)


@pytest.mark.parametrize("text", ["", "not a mesh\n", "$MeshFormat\n9.9 0 8\n$EndMeshFormat\n"])
def test_unreadable_files_are_refused_with_a_reason(tmp_path, text):
    (tmp_path / "a.msh").write_text(text)
    with pytest.raises(BadInput, match=r"cannot be read as a Gmsh mesh: \w") as caught:
        points_of(tmp_path / "a.msh", spacing=0.2)
    assert caught.value.key == 'bodies "dam".shape.file'
    assert caught.value.value == str(tmp_path / "a.msh")
    with pytest.raises(BadInput, match="there is no such file"):
        points_of(tmp_path / "b.msh", spacing=0.2)


def test_elements_listed_twice_are_refused_by_number(tmp_path):
    square = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]]
    once = [("triangle", [[0, 1, 2], [0, 2, 3]]), ("quad", [[1, 4, 5, 2]])]
    twice = [("triangle", [[2, 0, 1], [1, 4, 2]])]
    good = points_of(write(tmp_path / "a.msh", square, once), spacing=0.5)
    assert math.fsum(good.volume) == pytest.approx(2.0, rel=1e-14)
    path = write(tmp_path / "b.msh", square, once + twice)
    with pytest.raises(BadInput, match="listed twice: triangles 1 and 3 have") as caught:
        points_of(path, spacing=0.5)
    assert caught.value.key == 'bodies "dam".shape.file'


def test_bad_elements_are_counted_through_the_mesh(tmp_path):
    points = [[0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]]
    cells = [("triangle", [[0, 1, 2]]), ("quad", [[1, 4, 5, 2]]), ("triangle", [[0, 3, 2]])]
    with pytest.raises(BadInput, match=r"triangle 2 of the mesh .* inverted"):
        points_of(write(tmp_path / "a.msh", points, cells), spacing=0.5)


def test_elements_are_cut_until_no_cell_is_left_without_points(tmp_path):
    path = write(tmp_path / "a.msh", [[0, 0], [3, 0], [3, 3], [0, 3]], [("quad", [[0, 1, 2, 3]])])
    assert len(points_of(path, points_per_cell=1).position) == 36
    with pytest.raises(
        BadInput, match=r"1\.5 apart along x in cells of 0\.5.*cells without points"
    ):
        points_of(path, spacing=1.5)


def test_without_meshio_the_remedy_is_to_install_it(tmp_path, monkeypatch):
    path = write(tmp_path / "a.msh", CORNERS["triangle"], [("triangle", [[0, 1, 2]])])

    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(BadInput, match="pip install meshio"):
        points_of(path, spacing=0.2)
