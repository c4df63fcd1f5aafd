# SPDX-License-Identifier: BSD-3-Clause
"""Domains with corners that tile the elements of a mesh."""

from __future__ import annotations

import math
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_bodies import DIMENSION, distorted_mesh, write
from small_problems import CORNER_BASES, assert_same_bits, block_entries, plane, rollers, weight

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.bodies import BodyPoints, discretise
from tilth.bodies.corners import corner_signs, mean_half_edges
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Body, Mesh

pytest.importorskip("meshio")

every_element = pytest.mark.parametrize("element", list(DIMENSION))
every_basis = pytest.mark.parametrize("basis", CORNER_BASES)

TWO_QUADS_TWO_TRIANGLES = (
    np.array([[0, 0], [1, 0.1], [2, 0], [2.2, 1], [1.1, 0.8], [0, 1], [1, 2]]),
    [
        ("quad", np.array([[0, 1, 4, 5], [1, 2, 3, 4]])),
        ("triangle", np.array([[4, 3, 6], [5, 4, 6]])),
    ],
)


def points_of(
    path: Path, basis: str = "cpdi2", kind: str = "plane_strain", cell: float = 1.0, **more: Any
) -> BodyPoints:
    dim = 3 if kind == "3d" else 2
    body = Body(name="dam", material="clay", shape=Mesh(file=str(path)), basis=basis, **more)
    return discretise(body, kind, Grid(np.zeros(dim), np.full(dim, cell)))


def kind_of(element: str) -> str:
    return "3d" if DIMENSION[element] == 3 else "plane_strain"


def places(points: BodyPoints) -> Floats:
    """Where the corners of the domains are, shape (n, 2^d, d)."""
    return points.position[:, None] + points.corners()


def faces(points: BodyPoints) -> Floats:
    """Corners of the faces of all domains, in order around each, (faces, 2 or 4, d)."""
    corner = places(points)
    signs = corner_signs(corner.shape[2])
    found = []
    for axis, side in product(range(corner.shape[2]), (-1.0, 1.0)):
        own = np.flatnonzero(signs[:, axis] == side)
        found.append(corner[:, own if len(own) == 2 else own[[0, 1, 3, 2]]])
    return np.concatenate(found)


def size(face: Floats) -> float:
    """Length of an edge; area of a plane face."""
    if len(face) == 2:
        return float(np.linalg.norm(face[1] - face[0]))
    return 0.5 * float(np.linalg.norm(np.cross(face[2] - face[0], face[3] - face[1])))


def surface_left(points: BodyPoints) -> float:
    """Size of the faces that no second domain has; none may have three."""
    every = faces(points)
    names = [tuple(sorted(map(tuple, face))) for face in (every + 1e-7).round(6).tolist()]
    times = Counter(names)
    assert set(times.values()) <= {1, 2}
    return math.fsum(size(f) for f, name in zip(every, names, strict=True) if times[name] == 1)


def volumes_and_centroids(corner: Floats) -> tuple[Floats, Floats]:
    """Volumes (n,) of domains and their centroids (n, d), from the divergence theorem.

    Faces are the bilinear sheets between their corners, on which the integrands are cubic in each
    direction: four Gauss points integrate them exactly.
    """
    dim = corner.shape[2]
    signs = corner_signs(dim)
    x, w = np.polynomial.legendre.leggauss(4)
    volume, moment = np.zeros(len(corner)), np.zeros((len(corner), dim))
    for axis, side in product(range(dim), (-1.0, 1.0)):
        along = [k for k in range(dim) if k != axis]
        own = np.flatnonzero(signs[:, axis] == side)
        for q in product(range(len(x)), repeat=dim - 1):
            hat = 0.5 * (1.0 + signs[np.ix_(own, along)] * x[list(q)])
            place = np.einsum("c,nci->ni", hat.prod(axis=1), corner[:, own])
            tangent = []
            for m in range(dim - 1):
                slope = 0.5 * signs[own, along[m]] * np.delete(hat, m, axis=1).prod(axis=1)
                tangent.append(np.einsum("c,nci->ni", slope, corner[:, own]))
            if dim == 2:
                normal = np.stack([tangent[0][:, 1], -tangent[0][:, 0]], axis=1)
                normal *= side if axis == 0 else -side
            else:
                normal = np.cross(*tangent) * (side if axis != 1 else -side)
            flux = (place * normal).sum(axis=1) * np.prod(w[list(q)])
            volume += flux / dim
            moment += place * flux[:, None] / (dim + 1)
    return volume, moment / volume[:, None]


@every_element
@pytest.mark.parametrize("spacing", [0.5, 0.2])
def test_domains_fill_the_body_without_gaps_or_overlaps(
    tmp_path: Path, element: str, spacing: float
) -> None:
    """All faces but those of the body belong to two domains, and the volumes sum to the body's."""
    dim = DIMENSION[element]
    path = distorted_mesh(tmp_path / "a.msh", element, 3, 1.0, 3.0)
    points = points_of(path, kind=kind_of(element), spacing=spacing)
    assert math.fsum(points.volume) == pytest.approx(2.0**dim, rel=1e-14)
    assert surface_left(points) == pytest.approx(2 * dim * 2.0 ** (dim - 1), rel=1e-12)
    volume, centroid = volumes_and_centroids(points.corners())
    assert points.volume.min() > 0.0
    np.testing.assert_allclose(points.volume, volume, rtol=1e-12)
    np.testing.assert_allclose(centroid, 0.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        points.half_length, np.linalg.norm(mean_half_edges(points.corners()), axis=2), rtol=1e-12
    )


def test_number_of_points_is_what_the_spacing_asks_for(tmp_path: Path) -> None:
    """In the mean of the edges of a direction, or of triangles; at least one, or three."""
    for element, spacing, number in (
        ("quad", 2.0 / 9.0, 9 * 9),
        ("quad", 2.0 / 3.0, 9),
        ("quad", 1.0, 9),
        ("hexahedron", 2.0 / 6.0, 6**3),
        ("triangle", 1.0, 18 * 3),
        ("triangle", math.sqrt(2.0 / 9.0 / 12.0), 18 * 12),
        ("tetra", (8.0 / 27.0 / 6.0 / 32.0) ** (1.0 / 3.0), 27 * 6 * 32),
    ):
        path = distorted_mesh(tmp_path / "a.msh", element, 3, 1.0, 3.0)
        assert len(points_of(path, kind=kind_of(element), spacing=spacing).volume) == number
    slab = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [0.0, 1.0]])
    path = write(tmp_path / "b.msh", slab, [("quad", np.array([[0, 1, 2, 3]]))])
    points = points_of(path, spacing=[0.5, 0.25])
    np.testing.assert_allclose(points.half_length, [[0.25, 0.125]] * 32, rtol=1e-14)


def test_triangles_and_quadrilaterals_share_the_corners_of_their_domains(tmp_path: Path) -> None:
    path = write(tmp_path / "a.msh", *TWO_QUADS_TWO_TRIANGLES)
    nodes = TWO_QUADS_TWO_TRIANGLES[0][[0, 1, 2, 3, 6, 5, 0]]
    outline = float(np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum())
    for spacing in (1.0, 0.4, 0.17, 0.1):
        points = points_of(path, spacing=spacing)
        assert surface_left(points) == pytest.approx(outline, rel=1e-12)


def test_clockwise_meshes_have_the_same_tiles(tmp_path: Path) -> None:
    nodes, cells = TWO_QUADS_TWO_TRIANGLES
    found = []
    for order in (slice(None), slice(None, None, -1)):
        turned = [(name, element[:, order]) for name, element in cells]
        corner = places(points_of(write(tmp_path / "a.msh", nodes, turned), spacing=0.2))
        tiles = [sorted(map(tuple, tile)) for tile in (corner + 1e-7).round(6).tolist()]
        found.append(sorted(tiles))
    assert found[0] == found[1]


@every_basis
def test_a_turned_mesh_of_a_square_has_turned_squares(tmp_path: Path, basis: str) -> None:
    angle = math.radians(30.0)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    axis = np.linspace(0.0, 1.0, 3)
    nodes = np.array([[x, y] for y in axis for x in axis]) @ turn
    quads = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])
    points = points_of(write(tmp_path / "a.msh", nodes, [("quad", quads)]), basis, spacing=0.25)
    assert len(points.volume) == 16
    expected = 0.125 * corner_signs(2) @ turn
    np.testing.assert_allclose(points.corners(), np.tile(expected, (16, 1, 1)), atol=1e-15)


@every_element
def test_parallelepipeds_have_the_volume_and_the_middle_of_their_tiles(
    tmp_path: Path, element: str
) -> None:
    dim = DIMENSION[element]
    path = distorted_mesh(tmp_path / "a.msh", element, 3, 1.0, 3.0)
    tiles = points_of(path, "cpdi2", kind_of(element), spacing=0.3)
    points = points_of(path, "cpdi1", kind_of(element), spacing=0.3)
    np.testing.assert_array_equal(points.position, tiles.position)
    np.testing.assert_array_equal(points.volume, tiles.volume)
    corner, edge = points.corners(), mean_half_edges(points.corners())
    np.testing.assert_allclose(corner, -corner[:, ::-1], rtol=0, atol=1e-15)
    for k in range(dim):
        low = corner_signs(dim)[:, k] < 0.0
        each = 0.5 * (corner[:, ~low] - corner[:, low])
        np.testing.assert_allclose(each, np.repeat(edge[:, None, k], 2 ** (dim - 1), 1), atol=1e-15)
    np.testing.assert_allclose(2**dim * np.linalg.det(edge), points.volume, rtol=1e-12)
    ratio = edge / mean_half_edges(tiles.corners())
    np.testing.assert_allclose(ratio, np.broadcast_to(ratio[:, :1, :1], ratio.shape), rtol=1e-9)
    assert np.abs(ratio - 1.0).max() < (1e-12 if dim == 2 else 0.05)


@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_other_bases_have_boxes(tmp_path: Path, basis: str) -> None:
    path = distorted_mesh(tmp_path / "a.msh", "triangle", 3, 1.0, 3.0)
    points = points_of(path, basis, spacing=0.5)
    assert points.corner is None
    np.testing.assert_allclose(4.0 * points.half_length.prod(axis=1), points.volume, rtol=1e-14)


@every_basis
@pytest.mark.parametrize("element", ["triangle", "quad"])
def test_rings_at_the_axis(tmp_path: Path, basis: str, element: str) -> None:
    """Volumes are those of Pappus, and no domain reaches across the axis."""
    path = distorted_mesh(tmp_path / "a.msh", element, 3, 0.0, 2.0)
    points = points_of(path, basis, "axisymmetric", spacing=0.3)
    assert math.fsum(points.volume) == pytest.approx(8.0 * math.pi, rel=1e-14)
    entries = block_entries("axisymmetric", basis)
    entries["bodies"][0]["shape"] = {"type": "mesh", "file": str(path)}
    at_rest = Simulation(Model.from_dict(entries)).state.points
    radius = at_rest.position[:, None, 0] + at_rest.corner[..., 0]
    assert radius.min() == pytest.approx(0.0, abs=1e-15)


def test_unusable_meshes_are_refused(tmp_path: Path) -> None:
    quad = np.array([[0, 1, 2, 3]])
    square = np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]])
    path = write(tmp_path / "a.msh", square, [("quad", quad)])
    with pytest.raises(BadInput, match=r'bodies "dam"\.spacing: needs 1e\+06 points, more than'):
        points_of(path, spacing=1e-6)
    with pytest.raises(BadInput, match="points 3 apart in cells of 1: cells without points"):
        points_of(path, spacing=3.0)
    folded = np.array(  # its Jacobian is positive at all corners, but not between them
        [
            [0.6, 0.0, 0.6],
            [0.4, 0.6, 0.0],
            [0.8, 0.8, 0.4],
            [-0.2, 1.0, -0.6],
            [-0.6, -0.6, 0.8],
            [1.0, -0.6, 0.4],
            [1.0, 0.6, 1.6],
            [-0.6, 1.0, 1.2],
        ]
    )
    path = write(tmp_path / "b.msh", folded, [("hexahedron", np.arange(8)[None])])
    with pytest.raises(BadInput, match=r"hexahedron 1 .* it folds between its corners"):
        points_of(path, kind="3d", spacing=0.6)


# --- the grid's functions ----------------------------------------------------------------------


@every_element
def test_nodal_volumes_of_a_distorted_mesh_are_exact_column_by_column(
    tmp_path: Path, element: str
) -> None:
    """Nodes with the same x have together the integral of one hat function of x.

    It is linear in every domain that no grid line cuts, and so it is for y and z.
    """
    dim, side = DIMENSION[element], 3
    lines = tuple(float(x) for x in range(side + 1))
    path = distorted_mesh(tmp_path / "a.msh", element, 2 * side, 0.0, float(side), lines)
    entries = block_entries(kind_of(element), "cpdi2")
    entries["bodies"][0]["shape"] = {"type": "mesh", "file": str(path)}
    simulation = Simulation(Model.from_dict(entries))
    active, points = simulation.check(), simulation.state.points
    assert active.nodes == (side + 1) ** dim
    nodal = simulation.soil_on(active).scatter(np.tile(points.initial_volume[:, None], dim))[:, 0]
    for k in range(dim):
        for x in lines:
            found = nodal[np.abs(active.position[:, k] - x) < 1e-9].sum()
            hat = 1.0 if 0.0 < x < side else 0.5
            assert found == pytest.approx(hat * side ** (dim - 1), rel=1e-13)


@every_element
def test_nodal_volumes_have_the_volume_and_the_first_moment_of_the_body(
    tmp_path: Path, element: str
) -> None:
    """However grid lines cut the domains: all bases reproduce linear functions at centroids."""
    dim = DIMENSION[element]
    path = distorted_mesh(tmp_path / "a.msh", element, 3, 0.13, 2.4)
    entries = block_entries(kind_of(element), "cpdi2")
    entries["bodies"][0]["shape"] = {"type": "mesh", "file": str(path)}
    simulation = Simulation(Model.from_dict(entries))
    active, volume = simulation.check(), simulation.state.points.initial_volume
    nodal = simulation.soil_on(active).scatter(np.tile(volume[:, None], dim))[:, 0]
    assert nodal.sum() == pytest.approx(2.27**dim, rel=1e-13)
    moment = nodal @ active.position
    np.testing.assert_allclose(moment, 2.27**dim * 0.5 * (0.13 + 2.4), rtol=1e-13)


# --- runs --------------------------------------------------------------------------------------


@every_basis
@pytest.mark.parametrize("element", ["triangle", "hexahedron"])
def test_restored_domains_go_on_as_they_were(tmp_path: Path, basis: str, element: str) -> None:
    kind = kind_of(element)
    path = distorted_mesh(tmp_path / "a.msh", element, 2, 0.0, 2.0)
    up = "xyz"[DIMENSION[element] - 1]
    base = plane("base", up, 0.0, condition="fixed")
    entries = block_entries(
        kind, basis, boundaries=[*rollers(kind)[:-1], base], loads=[weight(kind, 20.0)],
        schedule={"steps": 4},
    )  # fmt: skip
    entries["bodies"][0]["shape"] = {"type": "mesh", "file": str(path)}
    model = Model.from_dict(entries)
    whole = Simulation(model)
    start = whole.state.points.corner.copy()
    whole.advance(0.0, 0.25)
    whole.advance(0.25, 0.5)
    assert np.abs(whole.state.points.corner - start).max() > 1e-3
    arrays = {name: np.array(array) for name, array in whole.state.arrays().items()}
    resumed = Simulation.restored(model, arrays)
    for simulation in (whole, resumed):
        simulation.advance(0.5, 0.75)
    assert_same_bits(whole.state.points, resumed.state.points)
