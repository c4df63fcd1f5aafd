# SPDX-License-Identifier: BSD-3-Clause
"""Surfaces of bodies in space as triangles."""

import itertools

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tilth.bodies import discretise
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Box, Circle, Cylinder, Mesh, Sphere
from tilth.surface.outline_3d import outline_3d

CENTRE = np.array([1.0, -2.0, 30.0])
ROUND = {"centre": CENTRE, "radius": 1.2}
TUBE = {**ROUND, "axis": "y", "height": 0.9}
SHAPES = {
    "box": Box(lower=(1.0, 2.0, 3.0), upper=(2.0, 4.0, 3.7)),
    "turned box": Box(lower=(1.0, 2.0, 3.0), upper=(2.0, 4.0, 3.7), angle=33.0, axis="y"),
    "ball": Sphere(**ROUND),
    "shell": Sphere(**ROUND, inner_radius=0.6),
    "half ball": Sphere(**ROUND, sides=["y-"]),
    "quarter of a shell": Sphere(**ROUND, inner_radius=0.6, sides=["x-", "z+"]),
    "octant": Sphere(**ROUND, sides=["x+", "y-", "z+"]),
    "octant of a shell": Sphere(**ROUND, inner_radius=0.6, sides=["x-", "y-", "z-"]),
    "cylinder along x": Cylinder(**{**TUBE, "axis": "x"}),
    "cylinder along y": Cylinder(**TUBE),
    "cylinder along z": Cylinder(**{**TUBE, "axis": "z"}),
    "tube": Cylinder(**TUBE, inner_radius=0.6),
    "half cylinder": Cylinder(**TUBE, sides=["z-"]),
    "quarter of a tube": Cylinder(**TUBE, inner_radius=0.6, sides=["z-", "x+"]),
}
SHAPE = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


def body(shape, **resolution):
    resolution = resolution or {"points_per_cell": 2}
    return Body(name="dam", material="clay", shape=shape, basis="linear", **resolution)


def surface(shape, spacing=None, cell=(1.0, 0.8, 1.0)):
    return outline_3d(body(shape), cell, spacing)


def edges(triangles):
    corner = triangles.corner
    return np.linalg.norm(np.roll(corner, -1, axis=1) - corner, axis=2)


def exact_volume(shape):
    points = discretise(body(shape, spacing=0.1), "3d", Grid(np.zeros(3), np.full(3, 0.2)))
    return points.volume.sum()


def area_of(triangles, *names):
    return sum(triangles.area[triangles.in_part(name)].sum() for name in names)


@SHAPE
def test_a_surface_is_closed_and_encloses_its_body(shape):
    exact = exact_volume(shape)
    for spacing in (0.2, 0.1, 0.05):
        found = surface(shape, spacing)
        assert found.closed
        np.testing.assert_allclose(found.area_vector.sum(axis=0), 0.0, atol=1e-12)
        assert edges(found).max() <= 1.5 * spacing
        assert len(np.unique(found.triangle)) == len(found.vertices)
        np.testing.assert_allclose([found.vertices.min(axis=0), found.vertices.max(axis=0)],
                                   shape.bounds(), rtol=1e-13)  # fmt: skip
        error = abs(found.volume / exact - 1.0)
        assert error < (1e-13 if isinstance(shape, Box) else 0.45 * spacing**2)


@SHAPE
def test_normals_point_into_the_soil(shape):
    points = discretise(body(shape, spacing=0.05), "3d", Grid(np.zeros(3), np.full(3, 0.05)))
    found = surface(shape, 0.1)
    inside = found.corner.mean(axis=1) + 0.1 * found.normal
    outside = found.corner.mean(axis=1) - 0.1 * found.normal

    def distance(places):
        return cKDTree(points.position).query(places)[0]

    assert distance(inside).max() < 0.05  # half the diagonal of a cube of 0.05 is 0.043
    assert distance(outside).min() > 0.06


@pytest.mark.parametrize("what", ["ball", "shell", "octant of a shell", "quarter of a shell"])
def test_a_sphere_converges_with_the_square_of_the_spacing(what):
    shape = SHAPES[what]
    inner, share = shape.inner_radius or 0.0, 0.5 ** len(shape.sides or ())
    volume = share * 4.0 / 3.0 * np.pi * (1.2**3 - inner**3)
    names = ["outer", "inner"] if inner else ["surface"]
    area = share * 4.0 * np.pi * (1.2**2 + inner**2)
    errors = []
    for n in (16, 32, 64):  # chords of a quarter; the inner arcs have half as many
        found = surface(shape, 0.5 * np.pi * 1.2 / n * (1.0 + 1e-9))
        radius = np.linalg.norm(found.vertices - CENTRE, axis=1)
        for name, wanted in zip(names, (1.2, inner), strict=False):
            own = radius[found.triangle[found.in_part(name)]]
            np.testing.assert_allclose(own, wanted, rtol=1e-13)
        errors.append([volume - found.volume, area - area_of(found, *names)])
    rate = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
    np.testing.assert_allclose(rate, 2.0, atol=0.02)


@pytest.mark.parametrize("what", ["cylinder along x", "cylinder along z", "quarter of a tube"])
def test_a_cylinder_is_the_prism_of_its_chords(what):
    shape = SHAPES[what]
    along = "xyz".index(shape.axis)
    inner, share = shape.inner_radius or 0.0, 0.5 ** len(shape.sides or ())
    errors = []
    for n in (8, 16, 32):  # chords of a quarter; the inner arcs have half as many
        found = surface(shape, 0.5 * np.pi * 1.2 / n * (1.0 + 1e-9))
        radius = np.linalg.norm(np.delete(found.vertices - CENTRE, along, axis=1), axis=1)
        section = 0.0
        for name, r, chords, sign in (("side", 1.2, n, 1.0), ("inner", inner, n // 2, -1.0)):
            if r == 0.0:
                continue
            np.testing.assert_allclose(radius[found.triangle[found.in_part(name)]], r, rtol=1e-13)
            around = share * 8.0 * chords * r * np.sin(np.pi / 4 / chords)
            np.testing.assert_allclose(area_of(found, name), 0.9 * around, rtol=1e-12)
            section += sign * share * 2.0 * chords * r**2 * np.sin(np.pi / 2 / chords)
        low, high = (found.corner[found.in_part(name)][..., along] for name in ("low", "high"))
        np.testing.assert_array_equal(low, CENTRE[along])
        np.testing.assert_allclose(high, CENTRE[along] + 0.9, rtol=1e-15)
        for name in ("low", "high"):
            np.testing.assert_allclose(area_of(found, name), section, rtol=1e-12)
        np.testing.assert_allclose(found.volume, 0.9 * section, rtol=1e-12)
        errors.append(np.pi * 1.2**2 * 0.9 - found.volume)
    if not inner:  # the errors of a tube's two radii cancel
        rate = np.log2(np.array(errors)[:-1] / np.array(errors)[1:])
        np.testing.assert_allclose(rate, 2.0, atol=0.02)


@pytest.mark.parametrize("what", ["half ball", "octant", "octant of a shell", "quarter of a tube"])
def test_cuts_at_planes_of_symmetry_are_parts_of_their_own(what):
    shape = SHAPES[what]
    found = surface(shape, 0.05)
    inner = shape.inner_radius or 0.0
    for side in shape.sides:
        i, sign = "xyz".index(side[0]), 1.0 if side[1] == "+" else -1.0
        cut = found.in_part(f"cut {side[0]}")
        np.testing.assert_array_equal(found.corner[cut][..., i], CENTRE[i])
        into = np.zeros(3)
        into[i] = sign
        np.testing.assert_allclose(found.normal[cut] @ into, 1.0, rtol=1e-14)
        if isinstance(shape, Sphere):
            area = np.pi * (1.2**2 - inner**2) * 0.5 ** (len(shape.sides) - 1)
            np.testing.assert_allclose(found.area[cut].sum(), area, rtol=1e-3)
        else:
            np.testing.assert_allclose(found.area[cut].sum(), 0.9 * (1.2 - inner), rtol=1e-13)
    assert {name for name in found.part if name.startswith("cut")} == {
        f"cut {side[0]}" for side in shape.sides
    }


def test_the_octant_is_the_same_along_all_axes():
    found = surface(Sphere(centre=(0, 0, 0), radius=1.0, sides=["x+", "y+", "z+"]), 0.1)
    own = np.unique(found.triangle[found.in_part("surface")])
    vertices = found.vertices[own]
    turned = np.roll(vertices, 1, axis=1)

    def ordered(places):
        return places[np.lexsort(np.round(places, 9).T)]

    np.testing.assert_allclose(ordered(turned), ordered(vertices), atol=1e-15)


def test_faces_of_a_box_have_the_names_of_its_own_axes():
    shape = SHAPES["turned box"]
    found = surface(shape, 0.25)
    side = np.array([1.0, 2.0, 0.7])
    for i, name in enumerate("xyz"):
        for sign, end in ((1.0, "-"), (-1.0, "+")):
            own = found.in_part(name + end)
            normal = np.broadcast_to(sign * np.array(shape.axes[i]), (own.sum(), 3))
            np.testing.assert_allclose(found.normal[own], normal, atol=1e-14)
            np.testing.assert_allclose(found.area[own].sum(), side.prod() / side[i], rtol=1e-13)
            place = (found.corner[own] - shape.lower) @ shape.axes[i]
            np.testing.assert_allclose(place, 0.0 if end == "-" else side[i], atol=1e-14)


def test_the_spacing_is_half_a_cell_if_it_is_not_given():
    found = surface(Box(lower=(0, 0, 0), upper=(2.0, 0.8, 1.2)))
    assert len(found) == 4 * (5 * 2 + 2 * 3 + 5 * 3)  # 0.4
    assert len(surface(Sphere(centre=(0, 0, 0), radius=0.01))) == 8 * 4**2


def hexahedra(path, tetrahedra=False, flip=False, stretch=None):
    """Two by one by one cubes, of six tetrahedra each if wanted."""
    meshio = pytest.importorskip("meshio")
    points = np.array(list(itertools.product(range(3), range(2), range(2))), dtype=float)
    number = np.arange(12).reshape(3, 2, 2)
    cubes = np.array([
        [number[i + a, b, c] for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        for i in range(2)
    ])  # fmt: skip
    cells = [("hexahedron", cubes[:, [4, 5, 6, 7, 0, 1, 2, 3]] if flip else cubes)]
    if tetrahedra:
        six = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
        tetra = cubes[:, six].reshape(-1, 4)
        tetra[::2] = tetra[::2, [2, 3, 0, 1]]  # so that each of an element's faces is outside once
        cells = [("tetra", tetra[:, [0, 2, 1, 3]] if flip else tetra)]
    if stretch is not None:
        points = points @ stretch
    meshio.Mesh(points, cells).write(path, file_format="gmsh22", binary=False)
    return Mesh(file=str(path))


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("tetrahedra", [False, True])
def test_a_mesh_has_the_faces_of_one_element_only(tmp_path, tetrahedra, flip):
    stretch = np.array([[2.0, 0.0, 0.3], [0.0, 1.0, 0.0], [0.1, 0.5, 1.0]])
    mesh = hexahedra(tmp_path / "cubes.msh", tetrahedra, flip, stretch)
    found = surface(mesh, 9.0)
    assert len(found) == 2 * 10
    assert found.closed
    np.testing.assert_allclose(found.volume, 2.0 * np.linalg.det(stretch), rtol=1e-13)
    fine = surface(mesh, 0.2)
    assert fine.closed
    assert edges(fine).max() <= 0.3
    np.testing.assert_allclose(fine.volume, found.volume, rtol=1e-13)
    np.testing.assert_allclose(fine.area.sum(), found.area.sum(), rtol=1e-13)


def test_quadrilaterals_are_cut_along_the_short_diagonal(tmp_path):
    shear = np.array([[1.0, 0.0, 0.0], [0.8, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = surface(hexahedra(tmp_path / "cubes.msh", stretch=shear), 9.0)
    level = found.corner[np.ptp(found.corner[..., 2], axis=1) == 0.0]
    longest = np.linalg.norm(np.roll(level, -1, axis=1) - level, axis=2).max()
    np.testing.assert_allclose(longest, np.hypot(1.0, 0.8))  # not hypot(1.8, 1.0)


def test_a_mesh_that_touches_itself_in_an_edge_is_refused(tmp_path):
    meshio = pytest.importorskip("meshio")
    points = np.array([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], float)
    file = tmp_path / "two.msh"
    cells = [("tetra", np.array([[0, 2, 3, 1], [0, 4, 5, 1]]))]
    meshio.Mesh(points, cells).write(file, file_format="gmsh22", binary=False)
    with pytest.raises(BadInput, match=r'"dam".*touches itself along an edge'):
        surface(Mesh(file=str(file)))


@pytest.mark.parametrize(
    ("shape", "cell"),
    [
        (Circle(centre=(0.0, 0.0), radius=1.0), (0.5, 0.5, 0.5)),
        (Box(lower=(0.0, 0.0), upper=(1.0, 1.0)), (0.5, 0.5)),
        (Sphere(centre=(0.0, 0.0, 0.0), radius=1.0), (0.5, 0.5)),
    ],
)
def test_a_body_in_the_plane_has_no_surface_in_space(shape, cell):
    with pytest.raises(BadInput, match=f"a {shape.type} has no surface in space"):
        surface(shape, cell=cell)
