# SPDX-License-Identifier: BSD-3-Clause
"""Sums over points, values, gradients and blocks of any field against dense arrays of the basis."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from small_problems import (
    BASES,
    ELASTIC,
    KINDS,
    SPACINGS,
    Laboratory,
    block_entries,
    jittered_points,
    spaced,
)

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.domains import bound_domains
from tilth.mpm.point_integrals import PointIntegrals

pytestmark = pytest.mark.usefixtures("every_loop_in_parallel")

every_basis = pytest.mark.parametrize("basis", BASES)
every_dim = pytest.mark.parametrize("dim", [2, 3])
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)
SHAPES = [("1", "1"), ("1", "dim"), ("dim", "1"), ("dim", "dim")]
every_shape = pytest.mark.parametrize(("rows", "columns"), SHAPES)


def number(components: str, dim: int) -> int:
    return dim if components == "dim" else 1


@cache
def located(dim: int, basis: str, spacing: str = "uniform") -> ActiveGrid:
    """The grid of two ranges of different bases; lines cut the domains at random."""
    entries = block_entries("3d" if dim == 3 else "plane_strain", basis)
    other = {"name": "other", "basis": "gimp" if basis == "linear" else "linear"}
    shape = {"type": "box", "lower": [2.0] + [0.0] * (dim - 1), "upper": [3.0] + [2.0] * (dim - 1)}
    entries["bodies"].append(entries["bodies"][0] | other | {"shape": shape})
    model = Model.from_dict(spaced(entries, spacing))
    random = np.random.default_rng(3)
    points = jittered_points(model, random, 0.4)
    grid = Simulation(model, points).state.grid
    points.position += random.uniform(-0.2, 0.2, points.position.shape)
    points.half_length *= random.uniform(0.6, 1.2, points.half_length.shape)
    tilt = np.eye(dim) + 0.1 * random.standard_normal((len(points), dim, dim))
    points.corner[:] = np.einsum("pij,pcj->pci", tilt, points.corner)
    bound_domains(points, grid)
    return Laboratory("3d" if dim == 3 else "plane_strain", points, grid).active


def dense_basis(active: ActiveGrid) -> Floats:
    """Values, then gradients, of all points at all nodes, shape (n, nodes, 1 + dim)."""
    dim = active.grid.dim
    found = np.zeros((len(active.points), active.nodes, 1 + dim))
    for range_, stencil in zip(active.points.ranges, active.stencils, strict=True):
        value, gradient = stencil.basis()
        at = 0
        for g in range(len(stencil.start) - 1):
            node = stencil.node[stencil.node_start[g] : stencil.node_start[g + 1]]
            n = len(node)
            for p in range(range_.start + stencil.start[g], range_.start + stencil.start[g + 1]):
                found[p, node, 0] = value[at : at + n]
                found[p, node, 1:] = gradient[dim * at : dim * (at + n)].reshape(dim, n).T
                at += n
    return found


def dense_matrix(active: ActiveGrid, blocks: Floats) -> Floats:
    """The matrix of the blocks, shape (nodes, r, nodes, c)."""
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    matrix = np.zeros((active.nodes, active.nodes, *blocks.shape[1:]))
    matrix[rows, active.column] = blocks
    return matrix.transpose(0, 2, 1, 3)


def added(active: ActiveGrid, matrices: Floats) -> Floats:
    """The blocks of the points' matrices."""
    blocks = np.zeros((len(active.column), matrices.shape[1], matrices.shape[3]))
    PointIntegrals(active).add_blocks(active.block_positions, matrices, blocks)
    return blocks


def random_matrices(active: ActiveGrid, rows: str, columns: str) -> Floats:
    dim, random = active.grid.dim, np.random.default_rng(7)
    r, c = number(rows, dim), number(columns, dim)
    return random.standard_normal((len(active.points), r, 1 + dim, c, 1 + dim))


def close(found: Floats, expected: Floats) -> None:
    assert_allclose(found, expected, rtol=0, atol=1e-13 * np.abs(expected).max())


@every_dim
@every_basis
@every_spacing
@pytest.mark.parametrize("components", ["1", "dim"])
def test_fields_against_dense_arrays(dim: int, basis: str, spacing: str, components: str) -> None:
    active = located(dim, basis, spacing)
    integrals, parts = PointIntegrals(active), dense_basis(active)
    c, random = number(components, dim), np.random.default_rng(5)
    values, nodal = (random.standard_normal((n, c)) for n in (len(active.points), active.nodes))
    flux = random.standard_normal((*values.shape, dim))
    close(integrals.scattered(values), np.einsum("pa,pi->ai", parts[..., 0], values))
    close(integrals.interpolated(nodal), np.einsum("pa,ai->pi", parts[..., 0], nodal))
    close(
        integrals.scattered_gradient(flux),
        np.einsum("pal,pil->ai", parts[..., 1:], flux, optimize=True),
    )
    close(
        integrals.gradient(nodal),
        np.einsum("pal,ai->pil", parts[..., 1:], nodal, optimize=True),
    )


@every_dim
@every_basis
@every_spacing
def test_linear_fields_have_their_value_and_gradient(dim: int, basis: str, spacing: str) -> None:
    active = located(dim, basis, spacing)
    slope = np.random.default_rng(1).standard_normal((dim, dim))
    nodal = 0.3 + active.position @ slope.T
    integrals = PointIntegrals(active)
    assert_allclose(
        integrals.gradient(nodal), np.tile(slope, (len(active.points), 1, 1)), atol=1e-12
    )
    if basis in ("linear", "cpdi1", "cpdi2"):
        exact = 0.3 + active.points.position @ slope.T
        own = active.points.ranges[0].points
        assert_allclose(integrals.interpolated(nodal)[own], exact[own], atol=1e-12)


@every_dim
@every_basis
@every_spacing
@every_shape
def test_blocks_against_dense_arrays(
    dim: int, basis: str, spacing: str, rows: str, columns: str
) -> None:
    active = located(dim, basis, spacing)
    matrices, parts = random_matrices(active, rows, columns), dense_basis(active)
    by_row = parts @ np.moveaxis(matrices, 2, 1).reshape(len(parts), 1 + dim, -1)
    by_row = by_row.reshape(len(parts), active.nodes, *np.delete(matrices.shape[1:], 1))
    expected = np.tensordot(by_row, parts, axes=([0, 4], [0, 2])).transpose(0, 1, 3, 2)
    close(dense_matrix(active, added(active, matrices)), expected)


@every_dim
@every_basis
@every_shape
def test_transposed_matrices_have_transposed_blocks(
    dim: int, basis: str, rows: str, columns: str
) -> None:
    """Also where some of their parts are zero, which are left out in one of the two only."""
    active = located(dim, basis)
    matrices = random_matrices(active, rows, columns)
    matrices[::2, :, 0] = matrices[1::3, :, 1:] = 0.0
    turned = np.ascontiguousarray(matrices.transpose(0, 3, 4, 1, 2))
    found, other = (dense_matrix(active, added(active, each)) for each in (matrices, turned))
    close(other, found.transpose(2, 3, 0, 1))


@every_dim
@every_basis
@pytest.mark.parametrize("components", ["1", "dim"])
def test_symmetric_matrices(dim: int, basis: str, components: str) -> None:
    """Blocks of two nodes are transposed to the bit; one asymmetric point adds its own part."""
    active = located(dim, basis)
    matrices = random_matrices(active, components, components)
    matrices = matrices + matrices.transpose(0, 3, 4, 1, 2)
    symmetric = dense_matrix(active, added(active, matrices))
    apart = ~np.eye(active.nodes, dtype=bool)
    found = symmetric.transpose(0, 2, 1, 3)[apart]
    assert np.array_equal(found, symmetric.transpose(2, 0, 3, 1)[apart])
    matrices[0, 0, 0, 0, 1] += 1.0
    part = dense_basis(active)[0]
    change = np.outer(part[:, 0], part[:, 1])
    symmetric[:, 0, :, 0] += change
    close(dense_matrix(active, added(active, matrices)), symmetric)


@every_basis
@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_of_elastic_soil_at_rest(kind: str, basis: str) -> None:
    """Hooke's law as matrices of the points; in axisymmetry with the hoop strain u_r / r."""
    laboratory = Laboratory.of(kind, basis, "hencky_elastic", np.random.default_rng(2))
    active, points, dim = laboratory.active, laboratory.points, laboratory.grid.dim
    one, e, nu = np.eye(dim), ELASTIC["young_modulus"], ELASTIC["poisson_ratio"]
    shear, first = e / (2.0 * (1.0 + nu)), e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    matrices = np.zeros((len(points), dim, 1 + dim, dim, 1 + dim))
    matrices[:, :, 1:, :, 1:] = (
        first * np.einsum("ik,jl->ikjl", one, one)
        + shear * np.einsum("ij,kl->ikjl", one, one)
        + shear * np.einsum("il,jk->ikjl", one, one)
    )
    if kind == "axisymmetric":
        radius = points.position[:, 0]
        matrices[:, 0, 0, 0, 0] = (first + 2.0 * shear) / radius**2
        for k in range(dim):
            matrices[:, 0, 0, k, 1 + k] = matrices[:, k, 1 + k, 0, 0] = first / radius
    found = added(active, points.initial_volume[:, None, None, None, None] * matrices)
    laboratory.soil.update(np.zeros((active.nodes, dim)))
    expected = np.zeros_like(found)
    laboratory.soil.add_stiffness(active, expected)
    assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@every_dim
@every_basis
def test_derivatives_of_a_coupled_residual(dim: int, basis: str) -> None:
    """Forms of second order, whose central differences are exact, of a scalar and a vector."""
    active = located(dim, basis)
    integrals, n, random = PointIntegrals(active), len(active.points), np.random.default_rng(4)
    u, p, du, dp = (random.standard_normal((active.nodes, c)) for c in (dim, 1, dim, 1))
    one = np.eye(dim)

    def at_points(u: Floats, p: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        return (
            integrals.gradient(u), np.trace(integrals.gradient(u), axis1=1, axis2=2),
            integrals.interpolated(p)[:, 0], integrals.gradient(p)[:, 0],
        )  # fmt: skip

    def residual(u: Floats, p: Floats) -> tuple[Floats, Floats]:
        _, volume, value, slope = at_points(u, p)
        moved = integrals.interpolated(u)
        of_u = integrals.scattered(value[:, None] * moved) + integrals.scattered_gradient(
            (volume * value)[:, None, None] * one
        )
        of_p = integrals.scattered((volume * value)[:, None]) + integrals.scattered_gradient(
            (value[:, None] * slope)[:, None]
        )
        return of_u, of_p

    _, volume, value, slope = at_points(u, p)
    uu, up = np.zeros((n, dim, 1 + dim, dim, 1 + dim)), np.zeros((n, dim, 1 + dim, 1, 1 + dim))
    pu, pp = np.zeros((n, 1, 1 + dim, dim, 1 + dim)), np.zeros((n, 1, 1 + dim, 1, 1 + dim))
    uu[:, :, 0, :, 0] = value[:, None, None] * one
    uu[:, :, 1:, :, 1:] = value[:, None, None, None, None] * np.einsum("ik,jl->ikjl", one, one)
    up[:, :, 0, 0, 0] = integrals.interpolated(u)
    up[:, :, 1:, 0, 0] = volume[:, None, None] * one
    pu[:, 0, 0, :, 1:] = value[:, None, None] * one
    pp[:, 0, 0, 0, 0] = volume
    pp[:, 0, 1:, 0, 0] = slope
    pp[:, 0, 1:, 0, 1:] = value[:, None, None] * one

    def product(matrices: Floats, nodal: Floats) -> Floats:
        return np.einsum("aibj,bj->ai", dense_matrix(active, added(active, matrices)), nodal)

    ahead, behind = residual(u + du, p + dp), residual(u - du, p - dp)
    found = product(uu, du) + product(up, dp), product(pu, du) + product(pp, dp)
    for own, high, low in zip(found, ahead, behind, strict=True):
        close(own, 0.5 * (high - low))


@every_dim
@every_basis
@every_shape
def test_same_bits_for_any_number_of_threads(dim: int, basis: str, rows: str, columns: str) -> None:
    active = located(dim, basis)
    integrals, matrices = PointIntegrals(active), random_matrices(active, rows, columns)
    flux = np.ascontiguousarray(matrices[:, :, 0, 0, 1:])
    bits = set()
    for threads in (1, 2, 3):
        _core.set_threads(threads)
        nodal = integrals.scattered_gradient(flux)
        arrays = added(active, matrices), nodal, integrals.gradient(nodal)
        bits.add(b"".join(each.tobytes() for each in arrays))
    assert len(bits) == 1


def test_blocks_of_a_range_with_one_group() -> None:
    """Points in one cell alone: their blocks are those of the dense arrays as well."""
    model = Model.from_dict(block_entries("plane_strain", "linear", cells=1))
    simulation = Simulation(model)
    active = Laboratory("plane_strain", simulation.state.points, simulation.state.grid).active
    assert [len(each.start) for each in active.stencils] == [2]
    matrices, parts = random_matrices(active, "1", "dim"), dense_basis(active)
    expected = np.einsum("pak,pikjl,pbl->aibj", parts, matrices, parts)
    close(dense_matrix(active, added(active, matrices)), expected)


def test_blocks_are_added() -> None:
    active = located(2, "gimp")
    matrices = random_matrices(active, "1", "dim")
    blocks = np.full((len(active.column), 1, 2), 3.0)
    integrals = PointIntegrals(active)
    integrals.add_blocks(active.block_positions, 0.0 * matrices, blocks)
    assert (blocks == 3.0).all()
    integrals.add_blocks(active.block_positions, matrices, blocks)
    close(blocks, 3.0 + added(active, matrices))


@pytest.mark.parametrize(
    ("matrices", "blocks", "words"),
    [
        ((1, 3, 2, 3), (2, 1), "point_matrix has 1 entries along axis 1, expected 2"),
        ((2, 3, 1, 2), (2, 1), "point_matrix has 2 entries along axis 4, expected 3"),
        ((6, 1, 3), (2, 1), "point_matrix has 4 axes, expected 5"),
        ((3, 3, 1, 3), (3, 1), "matrix has 3 components, expected 1 or 2"),
        ((2, 3, 0, 3), (2, 0), "matrix has 0 components, expected 1 or 2"),
        ((2, 3, 1, 3), (2,), "matrix has 2 axes, expected 3"),
    ],
)
def test_blocks_of_wrong_shapes_are_refused(
    matrices: tuple[int, ...], blocks: tuple[int, ...], words: str
) -> None:
    active = located(2, "gimp")
    stencil, (start, position) = active.stencils[0], active.block_positions[0]
    given = np.zeros((int(stencil.start[-1]), *matrices))
    to = np.zeros((len(active.column), *blocks))
    with pytest.raises(ValueError, match=words):
        _core.add_point_blocks(stencil, start, position, given, to)


def test_positions_outside_of_the_blocks_are_refused() -> None:
    active = located(2, "gimp")
    matrices = random_matrices(active, "1", "1")
    with pytest.raises(ValueError, match="does not fit"):
        PointIntegrals(active).add_blocks(active.block_positions, matrices, np.zeros((9, 1, 1)))


@pytest.mark.parametrize(
    ("points", "nodal", "words"),
    [
        ((1, 3), (0, 1), "has 3 entries along axis 2, expected 2"),
        ((2, 2), (0, 1), "has 2 entries along axis 1, expected 1"),
        ((2,), (0, 1), "has 2 axes, expected 3"),
        ((3, 2), (0, 3), "nodal has 3 components, expected 1 or 2"),
        ((1, 2), (0,), "nodal has 1 axes, expected 2"),
        ((1, 2), (-5, 1), "nodal has less rows than the stencil has nodes"),
    ],
)
def test_gradients_of_wrong_shapes_are_refused(
    points: tuple[int, ...], nodal: tuple[int, ...], words: str
) -> None:
    active = located(2, "gimp")
    stencil = active.stencils[0]
    of_points = np.zeros((int(stencil.start[-1]), *points))
    of_nodes = np.zeros((int(stencil.node.max()) + 1 + nodal[0], *nodal[1:]))
    with pytest.raises(ValueError, match=words):
        _core.scatter_gradient(stencil, of_points, of_nodes)
    with pytest.raises(ValueError, match=words):
        _core.interpolate_gradient(stencil, of_nodes, of_points)
