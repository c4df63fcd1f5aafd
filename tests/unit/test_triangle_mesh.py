# SPDX-License-Identifier: BSD-3-Clause
"""Closed surfaces of triangles: distance, direction, facets, and files that are wrong."""

import importlib

import numpy as np
import pytest

from tilth.errors import BadInput
from tilth.geometry import triangle_mesh
from tilth.geometry.triangle_mesh import TriangleMesh

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_FACES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)
LOWER = UPPER = np.zeros(3)


def cube():
    return CUBE[CUBE_FACES]


def sphere(levels):
    """Triangles on the unit sphere, from an octahedron cut `levels` times."""
    axes = np.eye(3)
    triangles = [
        [sx * axes[0], sy * axes[1], sz * axes[2]] if sx * sy * sz > 0 else
        [sx * axes[0], sz * axes[2], sy * axes[1]]
        for sx in (1, -1) for sy in (1, -1) for sz in (1, -1)
    ]  # fmt: skip
    t = np.array(triangles)
    for _ in range(levels):
        m = t + np.roll(t, -1, axis=1)
        m /= np.linalg.norm(m, axis=2)[..., None]
        pieces = [np.stack([t[:, i], m[:, i], m[:, i - 1]], axis=1) for i in range(3)]
        t = np.concatenate([*pieces, m])
    return t


def star():
    """A solid with sharp spikes: every face of an octahedron raised to a far, skew point."""
    triangles = []
    for a, b, c in sphere(0):
        tip = 1.5 * (a + b + c) + 0.3 * (b - a)
        triangles += [[a, b, tip], [b, c, tip], [c, a, tip]]
    return np.array(triangles)


def write_text(path, triangles):
    lines = ["solid body"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", " outer loop"]
        lines += [f"  vertex {x!r} {y!r} {z!r}" for x, y, z in triangle.tolist()]
        lines += [" endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid body\n"]))


def write_binary(path, triangles):
    rows = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    rows["c"] = triangles
    path.write_bytes(
        b"solid, but binary".ljust(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()
    )


def distance_by_segments(x, triangle):
    """Distance of one place from one triangle by solving for its coordinates in the plane."""
    a, b, c = triangle
    n = np.cross(b - a, c - a)
    n /= np.linalg.norm(n)
    weights = np.linalg.solve(np.array([b - a, c - a, n]).T, x - a)
    if weights[0] >= 0 and weights[1] >= 0 and weights[0] + weights[1] <= 1:
        return abs(weights[2])
    least = np.inf
    for p, q in ((a, b), (b, c), (c, a)):
        t = min(max((x - p) @ (q - p) / ((q - p) @ (q - p)), 0.0), 1.0)
        least = min(least, np.linalg.norm(x - p - t * (q - p)))
    return least


def winding(x, triangles):
    """How many times the surface winds round each place: sum of the solid angles / 4 pi."""
    r = triangles[None] - x[:, None, None]
    length = np.linalg.norm(r, axis=3)
    a, b, c = r[:, :, 0], r[:, :, 1], r[:, :, 2]
    la, lb, lc = length[..., 0], length[..., 1], length[..., 2]
    det = np.sum(a * np.cross(b, c), axis=2)
    dot = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.arctan2(det, dot).sum(axis=1) / (2.0 * np.pi)


def box_distance(x):
    """Signed distance from the unit cube, positive outside."""
    q = np.abs(x - 0.5) - 0.5
    return np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0)


@pytest.mark.parametrize("triangles", [star(), sphere(1) * [1.0, 0.3, 2.0], cube()])
def test_distance_is_that_of_brute_force_with_the_sign_of_the_winding_number(triangles):
    x = np.random.default_rng(1).uniform(-2.5, 2.5, (150, 3))
    expected = np.array([min(distance_by_segments(p, t) for t in triangles) for p in x])
    inside = winding(x, triangles) > 0.5
    assert 0 < inside.sum() < len(x)
    mesh = TriangleMesh(triangles, inside=True)
    np.testing.assert_allclose(mesh.distance(x), np.where(inside, expected, -expected), rtol=1e-12)
    np.testing.assert_array_equal(
        TriangleMesh(triangles, inside=False).distance(x), -mesh.distance(x)
    )


def test_sign_near_sharp_corners_and_edges():
    """The nearest place is a corner or an edge, where one face's normal can give a wrong sign."""
    triangles = star()
    mesh = TriangleMesh(triangles, inside=False)
    random = np.random.default_rng(2)
    corner = np.unique(triangles.reshape(-1, 3), axis=0)
    middle = 0.5 * (triangles + np.roll(triangles, 1, axis=1)).reshape(-1, 3)
    for near in (corner, middle):
        x = np.repeat(near, 40, axis=0) + random.normal(0.0, 1e-2, (40 * len(near), 3))
        outside = winding(x, triangles) < 0.5
        assert outside.any()
        assert not outside.all()
        np.testing.assert_array_equal(mesh.distance(x) > 0.0, outside)


def test_sign_at_a_corner_with_many_triangles_on_one_side():
    """A spike, one of whose three sides is a fan of 30 triangles: they count by their angles."""
    a, b, c = np.array([[0.2, 0.0, 0.0], [-0.1, 0.17, 0.0], [-0.1, -0.17, 0.0]])
    tip = np.array([0.0, 0.0, 1.0])
    p = a + np.linspace(0.0, 1.0, 31)[:, None] * (b - a)
    fan = [[[p[i], p[i + 1], tip], [p[i + 1], p[i], c]] for i in range(30)]
    triangles = np.array([t for pair in fan for t in pair] + [[b, c, tip], [c, a, tip]])
    x = tip + np.random.default_rng(7).normal(0.0, 0.05, (500, 3))
    outside = winding(x, triangles) < 0.5
    assert 0.5 < outside.mean() < 1.0
    np.testing.assert_array_equal(TriangleMesh(triangles, False).distance(x) > 0.0, outside)


def test_the_search_in_small_batches_is_the_same(monkeypatch):
    triangles = np.concatenate([sphere(3) * 0.1 + 3.0, cube()])  # very different sizes
    x = np.random.default_rng(3).uniform(-1.0, 4.0, (400, 3))
    mesh = TriangleMesh(triangles, inside=False)
    whole = mesh.distance(x)
    expected = np.minimum(box_distance(x), TriangleMesh(sphere(3) * 0.1 + 3.0, False).distance(x))
    np.testing.assert_allclose(whole, expected, atol=1e-14)
    monkeypatch.setattr(triangle_mesh, "PAIRS_PER_BATCH", 50)
    monkeypatch.setattr(triangle_mesh, "POINTS_PER_BATCH", 37)
    np.testing.assert_array_equal(mesh.distance(x), whole)


def test_distance_and_direction_of_a_cube():
    x = np.random.default_rng(4).uniform(-1.0, 2.0, (2000, 3))
    mesh = TriangleMesh(cube(), inside=False)
    np.testing.assert_allclose(mesh.distance(x), box_distance(x), atol=1e-14)
    step = 1e-6
    by_difference = np.stack(
        [(mesh.distance(x + d) - mesh.distance(x - d)) / (2 * step) for d in step * np.eye(3)],
        axis=1,
    )
    smooth = np.abs(np.linalg.norm(by_difference, axis=1) - 1.0) < 1e-6  # not in the middle
    assert smooth.mean() > 0.99
    direction = mesh.gradient(x)
    np.testing.assert_allclose(direction[smooth], by_difference[smooth], atol=1e-6)
    np.testing.assert_allclose(TriangleMesh(cube(), inside=True).gradient(x), -direction)


def test_direction_on_the_surface():
    mesh = TriangleMesh(cube(), inside=False)
    x = np.array([[0.3, 0.2, 1.0], [0.5, 0.5, 0.0], [1.0, 0.5, 1.0], [0.0, 0.0, 0.0]])
    expected = np.array([[0, 0, 1], [0, 0, -1], [0.5**0.5, 0, 0.5**0.5], -(3**-0.5) * np.ones(3)])
    np.testing.assert_allclose(mesh.gradient(x), expected, atol=1e-15)
    np.testing.assert_array_equal(mesh.distance(x), 0.0)
    on = TriangleMesh(sphere(2), inside=True).corner.mean(axis=1)
    assert np.isfinite(mesh.gradient(on)).all()


@pytest.mark.parametrize("inside", [True, False])
def test_facets(inside):
    triangles = star()
    mesh = TriangleMesh(triangles[:, ::-1], inside=inside)  # turned inwards in the file
    facets = mesh.facets(LOWER, UPPER, 0.4)
    a, b, c = np.moveaxis(facets.corner, 1, 0)
    area_vector = 0.5 * np.cross(b - a, c - a)
    area = np.linalg.norm(area_vector, axis=1)
    np.testing.assert_allclose(area_vector / area[:, None], facets.normal, atol=1e-13)
    np.testing.assert_allclose(area_vector.sum(axis=0), 0.0, atol=1e-13)
    original = 0.5 * np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )
    np.testing.assert_allclose(np.bincount(facets.group, area), original, rtol=1e-13)
    assert max(np.linalg.norm(p - q, axis=1).max() for p, q in ((a, b), (b, c), (c, a))) <= 0.4
    middle = facets.corner.mean(axis=1)
    ahead = mesh.distance(middle + 1e-6 * facets.normal)
    np.testing.assert_allclose(ahead, 1e-6, atol=1e-13)
    place, ratio = mesh.project(middle, facets.normal)
    np.testing.assert_array_equal(place, middle)
    np.testing.assert_array_equal(ratio, 1.0)
    assert len(mesh.facets(LOWER, UPPER, 100.0).group) == len(triangles)


def test_enclosed_volume_of_a_body_with_a_hollow():
    hollow = TriangleMesh(np.concatenate([3.0 * cube() - 1.0, cube()[:, ::-1]]), inside=True)
    assert hollow.volume == pytest.approx(26.0, rel=1e-14)
    np.testing.assert_allclose(
        hollow.distance(np.array([[0.5, 0.5, 0.5], [1.75, 0.5, 0.5]])), [-0.5, 0.25]
    )


def test_corners_that_differ_by_round_off_are_the_same():
    shaken = cube() + np.random.default_rng(8).uniform(-1e-9, 1e-9, (12, 3, 3))
    assert TriangleMesh(shaken, inside=True).volume == pytest.approx(1.0, rel=1e-8)
    with pytest.raises(BadInput, match="not closed: 36 edges with a triangle on one side only"):
        TriangleMesh(cube() + np.linspace(0.0, 1e-3, 108).reshape(12, 3, 3), inside=True)


def test_triangles_without_area_are_left_out():
    """One on an edge that its neighbour has in two parts, and one with two equal corners."""
    a, b, m = CUBE[0], CUBE[1], 0.5 * (CUBE[0] + CUBE[1])
    triangles = [t for t in cube() if not (np.array_equal(t[0], a) and np.array_equal(t[1], b))]
    triangles += [np.array([a, m, CUBE[3]]), np.array([m, b, CUBE[3]]), np.array([a, b, m])]
    triangles += [np.array([a, a, b])]
    mesh = TriangleMesh(np.array(triangles), inside=False)
    assert len(mesh.corner) == 13
    x = np.random.default_rng(5).uniform(-1.0, 2.0, (500, 3))
    np.testing.assert_allclose(mesh.distance(x), box_distance(x), atol=1e-14)


@pytest.mark.parametrize("write", [write_text, write_binary])
def test_a_file_as_text_or_binary(tmp_path, write):
    pytest.importorskip("meshio")
    triangles = sphere(3)
    write(tmp_path / "ball.stl", triangles)
    mesh = TriangleMesh.from_file(tmp_path / "ball.stl", "outside")
    assert len(mesh.corner) == len(triangles) == 512
    # The inscribed polyhedron: its area and volume are below the sphere's, with an error of h^2.
    assert 0.97 * 4 / 3 * np.pi < mesh.volume < 4 / 3 * np.pi
    exact = TriangleMesh(triangles, inside=False)
    x = np.random.default_rng(6).uniform(-2.0, 2.0, (300, 3))
    atol = 1e-15 if write is write_text else 1e-7  # a binary file holds single precision
    np.testing.assert_allclose(mesh.distance(x), exact.distance(x), atol=atol)
    assert (
        TriangleMesh.from_file(tmp_path / "ball.stl", "inside").distance(np.zeros((1, 3)))[0] > 0.9
    )


def refused(path, triangles=None):
    pytest.importorskip("meshio")
    if triangles is not None:
        write_text(path, np.asarray(triangles))
    with pytest.raises(BadInput) as raised:
        TriangleMesh.from_file(path, "inside", key="boundaries[0].geometry.file")
    assert raised.value.key == "boundaries[0].geometry.file"
    assert raised.value.value == str(path)
    return raised.value


def test_surfaces_that_are_not_closed_are_refused(tmp_path):
    path = tmp_path / "body.stl"
    assert "3 edges with a triangle on one side only" in refused(path, cube()[:-1]).problem
    turned = cube()
    turned[0] = turned[0, ::-1]
    assert (
        "3 edges whose two triangles are turned to opposite sides" in refused(path, turned).problem
    )
    two = np.concatenate(
        [cube(), cube() + np.array([1.0, 1.0, 0.0])]
    )  # they share the edge x = y = 1
    problem = refused(path, two).problem
    assert "1 edges with more than two triangles (the first near 1, 1, 0.5)" in problem
    flat = np.array([cube()[0], cube()[0, ::-1]])
    assert "encloses no volume" in refused(path, flat).problem


def test_files_that_cannot_be_read_are_refused(tmp_path):
    assert refused(tmp_path / "none.stl").problem == "there is no such file"
    path = tmp_path / "body.stl"
    path.write_text("this is no STL file\n" * 10)
    assert "cannot be read as an STL file" in refused(path).problem
    path.write_bytes(bytes(range(256)))
    assert "cannot be read as an STL file" in refused(path).problem
    path.write_text("solid nothing\nendsolid nothing\n")
    assert refused(path).problem == "contains no triangles"
    bad = cube()
    bad[0, 0, 0] = np.nan
    assert refused(path, bad).problem == "has coordinates that are not finite numbers"


def test_without_meshio_the_package_is_named(tmp_path, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(name)

    monkeypatch.setattr(importlib, "import_module", missing)
    with pytest.raises(BadInput) as raised:
        TriangleMesh.from_file(tmp_path / "body.stl", "inside")
    assert raised.value.remedy == "install it with `pip install meshio`"
