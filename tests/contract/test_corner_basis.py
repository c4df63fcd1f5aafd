# SPDX-License-Identifier: BSD-3-Clause
"""CPDI: domain averages by independent quadrature, supports, and the motion of domains."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import scipy.linalg
from small_problems import (
    CORNER_BASES,
    KINDS,
    Laboratory,
    assert_same_bits,
    block_entries,
    by_number,
    dimension,
    plane,
    rollers,
    weight,
)

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.errors import StepFailed
from tilth.grid.background import Grid
from tilth.model.laws import laws
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints, PointRange

every_basis = pytest.mark.parametrize("basis", CORNER_BASES)
every_dim = pytest.mark.parametrize("dim", [2, 3])

ORIGIN = np.array([-3.7, 11.3, 0.21])
SIZE = np.array([0.3, 2.0, 0.7])


def lattice(dim: int) -> Grid:
    return Grid(ORIGIN[:dim].copy(), SIZE[:dim].copy())


def sides(dim: int) -> Floats:
    """Corners of [-1, 1]^dim, x fastest."""
    return np.array([corner[::-1] for corner in product((-1.0, 1.0), repeat=dim)])


def random_domains(dim: int, grid: Grid, warp: float, n: int = 60) -> tuple[Floats, Floats]:
    """Points, and corners of boxes after a random affine map, each then moved by `warp` sides."""
    random = np.random.default_rng(10 + dim)
    position = grid.origin + random.uniform(-4, 4, (n, dim)) * grid.cell_size
    half = 10.0 ** random.uniform(-2, np.log10(1.3), (n, 1, 1))
    turn = np.array([scipy.linalg.expm(random.uniform(-1, 1, (dim, dim))) for _ in range(n)])
    corner = sides(dim) + 2.0 * warp * random.uniform(-1, 1, (n, 2**dim, dim))
    corner = np.einsum("nij,ncj->nci", turn, corner) * half * grid.cell_size
    return position, corner


def located(grid: Grid, position: Floats, corner: Floats) -> tuple[Floats, Floats, Floats]:
    """Dense values (n, nodes), gradients (n, nodes, dim) and node positions of given domains."""
    n, dim = position.shape
    body = PointRange(
        "body", 0, n, "cpdi2", None, laws()["hencky_elastic"], np.array([1.0, 0.0]), 0.0
    )
    points = MaterialPoints.undeformed([body], position, np.ones(n), np.ones((n, dim)))
    points.corner[:] = corner
    active = locate(points, grid, Buffers())
    stencil = active.stencils[0]
    value, gradient = np.zeros((n, active.nodes)), np.zeros((n, active.nodes, dim))
    all_values, all_gradients = stencil.basis()
    at = 0
    for g in range(len(stencil.start) - 1):
        nodes = stencil.node[stencil.node_start[g] : stencil.node_start[g + 1]]
        for p in range(stencil.start[g], stencil.start[g + 1]):
            value[points.point_id[p], nodes] = all_values[at : at + len(nodes)]
            flat = all_gradients[dim * at : dim * (at + len(nodes))]
            gradient[points.point_id[p], nodes] = flat.reshape(dim, -1).T
            at += len(nodes)
    return value, gradient, active.position


def hats(grid: Grid, place: Floats, node: Floats) -> Floats:
    """The grid's functions of all nodes at a place, shape (nodes,)."""
    return np.asarray(np.maximum(0.0, 1.0 - np.abs(place - node) / grid.cell_size).prod(axis=1))


def faces_of(dim: int) -> list[tuple[int, ...]]:
    """Faces of the box as corner numbers: pairs of a direction and its side, 2^(dim-1) each."""
    side = sides(dim)
    return [tuple(np.flatnonzero(side[:, k] == end)) for k in range(dim) for end in (-1.0, 1.0)]


@pytest.mark.slow
@every_dim
@pytest.mark.parametrize("warp", [0.0, 0.12])
def test_gradient_is_the_contour_integral_over_the_domain(dim: int, warp: float) -> None:
    """Of the function interpolated between the corners, by Gauss points on the deformed faces.

    The volume is that of the same faces by the divergence theorem, so that nothing here uses an
    integral over the inside.
    """
    grid = lattice(dim)
    position, corner = random_domains(dim, grid, warp)
    _, gradient, node = located(grid, position, corner)
    gauss, weight = np.polynomial.legendre.leggauss(4)
    side = sides(dim)
    for p in range(len(position)):
        place = position[p] + corner[p]
        nodal = np.array([hats(grid, x, node) for x in place])  # (corners, nodes)
        integral, volume = np.zeros((len(node), dim)), 0.0
        for face in faces_of(dim):
            axis = int(np.flatnonzero(np.ptp(side[list(face)], axis=0) == 0.0)[0])
            along = [k for k in range(dim) if k != axis]
            end = side[face[0], axis]
            for q in product(range(len(gauss)), repeat=dim - 1):
                xi = gauss[list(q)]
                shape = np.array([np.prod(0.5 * (1 + side[c, along] * xi)) for c in face])
                slope = [
                    np.array([
                        0.5 * side[c, k]
                        * np.prod([0.5 * (1 + side[c, m] * x)
                                   for m, x in zip(along, xi, strict=True) if m != k])
                        for c in face
                    ])
                    for k in along
                ]  # fmt: skip
                tangent = [s @ place[list(face)] for s in slope]
                if dim == 2:
                    normal = np.array([tangent[0][1], -tangent[0][0]])
                    normal *= end if axis == 0 else -end
                else:
                    normal = np.cross(tangent[0], tangent[1])
                    normal *= -end if axis == 1 else end
                area = normal * np.prod(weight[list(q)])
                integral += np.outer(shape @ nodal[list(face)], area)
                volume += (shape @ place[list(face)] - position[p]) @ area / dim
        assert volume > 0.0
        scale = np.abs(gradient[p]).max()
        np.testing.assert_allclose(gradient[p], integral / volume, rtol=0, atol=1e-11 * scale)


@every_dim
@pytest.mark.parametrize("warp", [0.0, 0.12])
def test_value_is_the_mean_over_the_domain(dim: int, warp: float) -> None:
    grid = lattice(dim)
    position, corner = random_domains(dim, grid, warp)
    value, _, node = located(grid, position, corner)
    gauss, weight = np.polynomial.legendre.leggauss(5)
    side = sides(dim)
    for p in range(len(position)):
        nodal = np.array([hats(grid, x, node) for x in position[p] + corner[p]])
        total, volume = np.zeros(len(node)), 0.0
        for q in product(range(len(gauss)), repeat=dim):
            factor = 0.5 * (1.0 + side * gauss[list(q)])
            slope = np.stack(
                [0.5 * side[:, k] * np.delete(factor, k, axis=1).prod(axis=1) for k in range(dim)]
            )
            part = np.linalg.det(slope @ corner[p]) * np.prod(weight[list(q)])
            total += part * (factor.prod(axis=1) @ nodal)
            volume += part
        np.testing.assert_allclose(value[p], total / volume, rtol=0, atol=1e-13)


@every_dim
@pytest.mark.parametrize("warp", [0.0, 0.12])
def test_linear_fields_are_exact_on_deformed_domains(dim: int, warp: float) -> None:
    """Values tell the place of the centroid, gradients the unit tensor."""
    grid = lattice(dim)
    position, corner = random_domains(dim, grid, warp)
    value, gradient, node = located(grid, position, corner)
    np.testing.assert_allclose(value.sum(axis=1), 1.0, rtol=0, atol=1e-13)
    slope = np.einsum("pai,aj->pij", gradient, node)
    np.testing.assert_allclose(slope, np.tile(np.eye(dim), (len(slope), 1, 1)), atol=2e-10)
    if warp == 0.0:  # then the centroid is the point
        np.testing.assert_allclose(value @ node, position, rtol=0, atol=1e-13 * np.abs(node).max())


@every_dim
def test_support_is_the_cells_of_the_corners(dim: int) -> None:
    grid = lattice(dim)
    position, corner = random_domains(dim, grid, 0.0)
    value, _, node = located(grid, position, corner)
    expected = np.zeros(value.shape, dtype=bool)
    for p in range(len(position)):
        for place in position[p] + corner[p]:
            expected[p] |= hats(grid, place, node) > 0.0
    assert np.array_equal(value != 0.0, expected)
    assert expected.any(axis=0).all()  # no node is active without a point
    assert expected.sum(axis=1).max() > 2**dim * 2 ** (dim - 1)


@every_dim
def test_a_domain_that_reaches_too_far_is_refused(dim: int) -> None:
    position, corner = random_domains(dim, lattice(dim), 0.0, 3)
    corner[1] *= 1e4
    with pytest.raises(StepFailed, match="extends over more than") as failure:
        located(lattice(dim), position, corner)
    assert failure.value.point == 1


# --- motion ------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@every_basis
def test_domains_follow_an_affine_motion(kind: str, basis: str) -> None:
    """Both are exact then, whatever the rotation and shear; the volume is that of F."""
    dim = dimension(kind)
    laboratory = Laboratory.of(kind, basis, "hencky_elastic", np.random.default_rng(1))
    start = by_number(laboratory.points)["corner"]
    motion = np.array([[0.12, 0.3, -0.1], [-0.25, 0.05, 0.1], [0.2, -0.1, -0.04]])[:dim, :dim]
    if kind == "axisymmetric":
        motion = np.array([[0.05, 0.0], [0.3, -0.1]])
        laboratory.points.position[:, 0] += 0.1  # all domains off the axis
        laboratory.locate()
    whole = np.eye(dim)
    for _ in range(6):
        laboratory.step(laboratory.active.position @ motion.T)
        whole = (np.eye(dim) + motion) @ whole
    found = by_number(laboratory.points)
    np.testing.assert_allclose(found["corner"], start @ whole.T, rtol=0, atol=1e-12)
    edges = 0.5 * np.stack(
        [found["corner"][:, 2**k] - found["corner"][:, 0] for k in range(dim)], 1
    )
    np.testing.assert_allclose(np.linalg.det(edges), 0.25**dim * np.linalg.det(whole), rtol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_moving_corners_tile_the_block(kind: str) -> None:
    """CPDI2: corners that coincide stay together in any motion, so that no gap opens."""
    entries = block_entries(kind, "cpdi2")
    model = Model.from_dict(entries)
    points = initial_points(model)
    laboratory = Laboratory(kind, points, Simulation(model, points).state.grid)
    random = np.random.default_rng(2)
    start = by_number(points)
    for _ in range(4):
        laboratory.step(laboratory.random_displacement(random, 0.1))
    found = by_number(laboratory.points)
    before = (start["position"][:, None] + start["corner"]).reshape(-1, dimension(kind))
    after = (found["position"][:, None] + found["corner"]).reshape(-1, dimension(kind))
    _, number = np.unique(before.round(9), axis=0, return_inverse=True)
    number = number.ravel()
    assert number.max() + 1 == 5 ** dimension(kind)
    for each in range(number.max() + 1):
        assert np.ptp(after[number == each], axis=0).max() < 1e-8
    assert np.abs(after - before).max() > 0.05


@every_dim
def test_a_folded_domain_stops_the_step(dim: int) -> None:
    """One corner pulled across the domain; the state stays as it was."""
    kind = "3d" if dim == 3 else "plane_strain"
    entries = block_entries(kind, "cpdi2", cells=1)
    entries["bodies"][0]["points_per_cell"] = 1
    model = Model.from_dict(entries)
    points = initial_points(model)
    laboratory = Laboratory(kind, points, Simulation(model, points).state.grid)
    before = points.corner.copy()
    u = np.zeros(laboratory.active.position.shape)
    u[0] = 0.9 / dim  # the Jacobian at this corner vanishes at 1 / dim
    laboratory.soil.moved_domains(u)
    u[0] = 1.1 / dim
    with pytest.raises(StepFailed, match="folded or inverted") as failure:
        laboratory.soil.moved_domains(u)
    assert failure.value.point == 0
    np.testing.assert_array_equal(points.corner, before)


def test_names_of_the_bases_are_among_all() -> None:
    assert set(CORNER_BASES) == {"cpdi1", "cpdi2"}
    assert set(CORNER_BASES) < set(_core.basis_names())


def test_turned_boxes_have_turned_domains() -> None:
    entries = block_entries("plane_strain", "cpdi1")
    entries["bodies"][0]["shape"] |= {"angle": 30.0}
    points = initial_points(Model.from_dict(entries))
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    expected = sides(2) * points.initial_half_length[0] @ np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(points.corner, np.tile(expected, (len(points), 1, 1)), atol=1e-15)


@pytest.mark.parametrize("kind", KINDS)
@every_basis
def test_restored_domains_go_on_as_they_were(kind: str, basis: str) -> None:
    entries = block_entries(
        kind, basis, boundaries=rollers(kind, sides=False), loads=[weight(kind, 40.0)],
        schedule={"steps": 4},
    )  # fmt: skip
    model = Model.from_dict(entries)
    whole = Simulation(model)
    whole.advance(0.0, 0.25)
    whole.advance(0.25, 0.5)
    arrays = {name: np.array(array) for name, array in whole.state.arrays().items()}
    resumed = Simulation.restored(model, arrays)
    for simulation in (whole, resumed):
        simulation.advance(0.5, 0.75)
    assert_same_bits(whole.state.points, resumed.state.points)
    edge = np.ptp(whole.state.points.corner, axis=1)
    assert np.ptp(edge, axis=0).max() > 1e-4  # domains differ by now


@pytest.mark.parametrize("kind", KINDS)
def test_slivers_behind_rollers_do_not_run_away(kind: str) -> None:
    """CPDI1 domains lean across the rollers; the nodes behind move no farther than the platen."""
    up = "xyz"[dimension(kind) - 1]
    platen = plane("top", up, 2.0, condition="prescribed", displacement={up: -0.2})
    entries = block_entries(
        kind, "cpdi1", loads=[weight(kind, 2.0)], schedule={"steps": 10},
        boundaries=[*rollers(kind, sides=False), platen],
    )  # fmt: skip
    entries["analysis"] |= {"tolerance": 1e-10, "predictor": False}
    simulation = Simulation(Model.from_dict(entries))
    for k in range(6):
        result = simulation.advance(k / 10, (k + 1) / 10)
        assert np.abs(result.equilibrium.displacement).max() < 0.025
        assert result.equilibrium.iterations <= 4
    assert result.active.position.min() < -0.5  # nodes behind a roller are in use
    assert not simulation.services.warnings.texts
