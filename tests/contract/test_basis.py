# SPDX-License-Identifier: BSD-3-Clause
"""What every basis must satisfy: unity, linear reproduction, gradients, support."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import pytest
from small_problems import BASES, CORNER_BASES

from tilth import _core
from tilth.arrays import Floats
from tilth.grid.background import Grid
from tilth.model.laws import laws
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.points import MaterialPoints, PointRange

GRIDS = {
    "unit": lambda dim: Grid(np.zeros(dim), np.ones(dim)),
    "shifted": lambda dim: Grid(
        np.array([-3.7, 11.3, 0.21])[:dim], np.array([0.3, 2.0, 0.7])[:dim]
    ),
    "graded": lambda dim: graded(dim),
}


def graded(dim: int) -> Grid:
    """Cells of sizes whose ratios are up to 1.5; the first and the last lines are among them."""
    lines = (
        np.array([0.0, 1.5, 2.5, 3.3, 4.5]),
        np.cumsum([0.0, 0.3, 0.2, 0.2, 0.3, 0.45]),
        np.cumsum([0.0, 2.0, 3.0]),
    )[:dim]
    origin = np.array([-3.7, 11.3, 0.21])[:dim]
    return Grid(origin, np.array([np.diff(line).min() for line in lines]), lines=lines)


every_basis = pytest.mark.parametrize("basis", BASES)
every_dim = pytest.mark.parametrize("dim", [2, 3])
every_grid = pytest.mark.parametrize("grid", list(GRIDS))


@dataclass
class Evaluated:
    """Basis of all points, dense: values (n, nodes), gradients (n, nodes, dim)."""

    value: Floats
    gradient: Floats
    node: Floats
    touched: Floats


def evaluate(basis: str, grid: Grid, position: Floats, half_length: Floats) -> Evaluated:
    """Basis values through the same calls as a load step, points in the order given."""
    n, dim = position.shape
    body = PointRange(
        "body", 0, n, basis, None, laws()["hencky_elastic"], np.array([1.0, 0.0]), 0.0
    )
    points = MaterialPoints.undeformed([body], position.copy(), np.ones(n), half_length)
    active = locate(points, grid, Buffers())
    stencil = active.stencils[0]
    value = np.zeros((n, active.nodes))
    gradient = np.zeros((n, active.nodes, dim))
    touched = np.zeros((n, active.nodes), dtype=bool)
    all_values, all_gradients = stencil.basis()
    offset = 0
    for g in range(len(stencil.start) - 1):
        nodes = stencil.node[stencil.node_start[g] : stencil.node_start[g + 1]]
        for p in range(stencil.start[g], stencil.start[g + 1]):
            number = points.point_id[p]
            value[number, nodes] = all_values[offset : offset + len(nodes)]
            flat = all_gradients[dim * offset : dim * (offset + len(nodes))]
            gradient[number, nodes] = flat.reshape(dim, -1).T
            touched[number, nodes] = True
            offset += len(nodes)
    return Evaluated(value, gradient, active.position, touched)


def random_points(dim: int, grid: Grid, n: int = 200) -> tuple[Floats, Floats]:
    """Points on both sides of the origin; half lengths from very small to half a cell."""
    random = np.random.default_rng(dim)
    cells = random.uniform(-4, 4, (n, dim))
    half = 10.0 ** random.uniform(-3, np.log10(0.5), (n, dim))
    half[: n // 4] = 0.5
    return placed(grid, cells, half)


def placed(grid: Grid, cells: Floats, half: Floats) -> tuple[Floats, Floats]:
    """Positions and half lengths [length] of points by coordinates and half lengths in cells."""
    position = grid.position(cells)
    return position, half * grid.sizes_at(position)


def points_on_grid_lines(dim: int, grid: Grid) -> tuple[Floats, Floats]:
    """Points on grid lines, and points whose domains end on grid lines, in every combination."""
    places = np.array([-2.0, -0.5, 0.0, 0.25, 0.75, 3.0])
    cells = np.stack(np.meshgrid(*[places] * dim), axis=-1).reshape(-1, dim)
    half = np.tile([0.25, 0.5], (len(cells), 2))[:, :dim].copy()
    return placed(grid, cells, half)


def assert_reproduces_linear_fields(found: Evaluated, grid: Grid, position: Floats) -> None:
    dim = position.shape[1]
    scale = np.abs(found.node).max()
    np.testing.assert_allclose(found.value.sum(axis=1), 1.0, rtol=0, atol=1e-13)
    total = found.gradient.sum(axis=1) * grid.cell_size
    np.testing.assert_allclose(total, 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.value @ found.node, position, rtol=0, atol=1e-13 * scale)
    moment = np.einsum("pai,aj->pij", found.gradient, found.node)
    bound = 1e-12 * scale / grid.cell_size.min()
    np.testing.assert_allclose(moment, np.tile(np.eye(dim), (len(moment), 1, 1)), atol=bound)


@every_basis
@every_dim
@every_grid
def test_linear_fields_are_reproduced(basis: str, dim: int, grid: str) -> None:
    lattice = GRIDS[grid](dim)
    position, half = random_points(dim, lattice)
    found = evaluate(basis, lattice, position, half)
    assert_reproduces_linear_fields(found, lattice, position)
    assert found.value.min() >= -1e-15


@every_basis
@every_dim
@every_grid
def test_linear_fields_are_reproduced_on_grid_lines(basis: str, dim: int, grid: str) -> None:
    lattice = GRIDS[grid](dim)
    position, half = points_on_grid_lines(dim, lattice)
    assert_reproduces_linear_fields(evaluate(basis, lattice, position, half), lattice, position)


@pytest.mark.parametrize("basis", [basis for basis in BASES if basis not in CORNER_BASES])
@every_dim
@every_grid
def test_gradient_is_the_derivative_of_the_value(basis: str, dim: int, grid: str) -> None:
    """Of domains with corners it is not: see test_corner_basis.py."""
    lattice = GRIDS[grid](dim)
    position, half = random_points(dim, lattice)
    # keep points, and the ends of their domains, away from the kinks on grid lines
    step = 1e-6
    far = np.ones(len(position), dtype=bool)
    for place in (position, position - half, position + half):
        end = lattice.in_cells(place)
        far &= (np.abs(end - np.rint(end)) > 10 * step).all(axis=1)
    assert far.sum() > 100
    position, half = position[far], half[far]
    here = evaluate(basis, lattice, position, half)
    for k in range(dim):
        shift = np.zeros(dim)
        shift[k] = step * lattice.cell_size[k]
        above = evaluate(basis, lattice, position + shift, half)
        below = evaluate(basis, lattice, position - shift, half)
        assert above.node.shape == below.node.shape == here.node.shape
        slope = (above.value - below.value) / (2 * shift[k])
        bound = 1e-6 / lattice.cell_size[k]  # round-off 1e-16 over step and smallest domain
        np.testing.assert_allclose(here.gradient[:, :, k], slope, rtol=0, atol=bound)


@every_basis
@every_dim
def test_values_far_from_the_origin_lose_position_round_off_only(basis: str, dim: int) -> None:
    grid = GRIDS["unit"](dim)
    position, half = random_points(dim, grid, 50)
    half = np.maximum(half, 0.05)
    far = 4096.0 * np.array([1.0, -1.0, 3.0])[:dim]
    near = evaluate(basis, grid, position, half)
    away = evaluate(basis, grid, position + far, half)
    np.testing.assert_array_equal(away.node, near.node + far)
    np.testing.assert_allclose(away.value, near.value, atol=1e-10)


@every_dim
@pytest.mark.parametrize(("basis", "largest"), [("linear", 2), ("gimp", 3)])
def test_support_is_exactly_what_the_domain_overlaps(basis: str, largest: int, dim: int) -> None:
    grid = GRIDS["shifted"](dim)
    position, half = random_points(dim, grid)
    found = evaluate(basis, grid, position, half)
    reach = grid.cell_size + (half if basis == "gimp" else 0.0 * half)
    distance = np.abs(position[:, None, :] - found.node[None, :, :])
    inside = (distance < reach[:, None, :] - 1e-9).all(axis=2)
    assert np.array_equal(found.touched, inside)
    assert found.touched.sum(axis=1).max() == largest**dim


@every_dim
def test_gimp_tends_to_linear_for_small_domains(dim: int) -> None:
    grid = GRIDS["shifted"](dim)
    position, _ = random_points(dim, grid, 80)
    tiny = np.tile(1e-7 * grid.cell_size, (80, 1))
    gimp = evaluate("gimp", grid, position, tiny)
    linear = evaluate("linear", grid, position, tiny)
    assert np.array_equal(gimp.node, linear.node)
    np.testing.assert_allclose(gimp.value, linear.value, atol=1e-7)


def hats(x: float, node: Floats, lines: Floats) -> Floats:
    """Hat functions of nodes (n,) on grid lines at a place between two of these."""
    above = int(np.searchsorted(lines, x))
    low, high = lines[above - 1], lines[above]
    share = (x - low) / (high - low)
    value = np.where(np.isclose(node, low), 1.0 - share, 0.0)
    return np.where(np.isclose(node, high), share, value)


@every_dim
@pytest.mark.parametrize("spacing", ["unit", "graded"])
def test_gimp_is_the_mean_of_the_hats_over_the_domain(dim: int, spacing: str) -> None:
    """Against Gauss integration of the linear basis over the pieces between grid lines."""
    grid = GRIDS[spacing](dim)
    position, half = random_points(dim, grid, 30)
    found = evaluate("gimp", grid, position, half)
    gauss, weight = np.polynomial.legendre.leggauss(2)  # a hat is linear in each piece
    for p in range(len(position)):
        along = []
        for k in range(dim):
            low, high = position[p, k] - half[p, k], position[p, k] + half[p, k]
            lines = grid.position(np.arange(-9.0, 10.0)[:, None] * np.ones(dim))[:, k]
            inner = lines[(lines > low) & (lines < high)]
            cuts = np.unique(np.concatenate([[low], inner, [high]]))
            mean = np.zeros(len(found.node))
            for a, b in itertools.pairwise(cuts):
                for x, w in zip(0.5 * (a + b) + 0.5 * (b - a) * gauss, weight, strict=True):
                    hat = hats(x, found.node[:, k], lines)
                    mean += 0.5 * (b - a) * w * hat / (high - low)
            along.append(mean)
        np.testing.assert_allclose(found.value[p], np.prod(along, axis=0), atol=1e-12)


def test_names_of_unknown_bases_are_refused() -> None:
    one = np.zeros((1, 2))
    with pytest.raises(ValueError, match="unknown basis 'cubic'"):
        _core.support_keys(
            "cubic", one, one + 0.5, Grid(np.zeros(2), np.ones(2)), np.zeros(1, dtype=np.int64)
        )
