# SPDX-License-Identifier: BSD-3-Clause
"""A grid with cells of unequal sizes: its sizes, and what depends on those of each place."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from implicit_blocks import implicit
from small_problems import (
    BASES,
    KINDS,
    block_entries,
    dimension,
    material_entries,
    plane,
    spaced,
)

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.boundaries.surfaces.patches import is_sliver, without_small
from tilth.geometry.plane import Plane
from tilth.geometry.quadrature import make_quadrature
from tilth.grid.background import Grid
from tilth.mpm.active_grid import Buffers, locate
from tilth.mpm.domains import bound_domains
from tilth.mpm.f_bar import mean_gradients
from tilth.mpm.initial_points import initial_points
from tilth.mpm.quadrature import locate_in_cells
from tilth.terms.weak_springs import WeakSprings, covered_nodes

LINES = (np.array([0.0, 1.5, 2.5, 3.3, 4.5]), np.array([0.0, 0.2, 0.5, 0.9]))

every_kind = pytest.mark.parametrize("kind", KINDS)
every_dim = pytest.mark.parametrize("dim", [2, 3])


def graded(dim: int = 2) -> Grid:
    """Unequal cells along x and y, cells of 0.7 along z."""
    lines = (*LINES, np.zeros(0))[:dim]
    return Grid(np.array([-1.0, 2.0, 0.3])[:dim], np.array([0.8, 0.2, 0.7])[:dim], lines=lines)


def block(kind: str, basis: str = "gimp", **changed: Any) -> Simulation:
    """A block of 3 cells a side on the grid of `small_problems.GRADED`."""
    entries = spaced(block_entries(kind, basis, cells=3, **changed), "graded")
    return Simulation(Model.from_dict(entries))


# --- sizes --------------------------------------------------------------------------------------


@every_dim
def test_coordinates_in_cells_and_back(dim: int) -> None:
    grid = graded(dim)
    cells = np.random.default_rng(0).uniform(-3.0, 8.0, (200, dim))
    position = grid.position(cells)
    np.testing.assert_allclose(grid.in_cells(position), cells, rtol=0, atol=1e-12)
    ends = grid.position(np.floor(cells)), grid.position(np.floor(cells) + 1.0)
    np.testing.assert_allclose(grid.sizes_at(position), ends[1] - ends[0], rtol=1e-12)


@every_dim
def test_the_mean_volume_around_a_node(dim: int) -> None:
    """A mean over the 2^dim cells, also beyond the first and the last line."""
    grid = graded(dim)
    node = np.array(list(product(range(-2, 7), repeat=dim)))
    cells = node[:, None] - np.array(list(product((0, 1), repeat=dim)))
    mean = grid.sizes(cells).prod(axis=2).mean(axis=1)
    np.testing.assert_allclose(grid.sizes_around(node).prod(axis=1), mean, rtol=1e-14)


def test_the_largest_size_and_the_comparison_of_lines() -> None:
    grid = graded()
    assert grid.largest_size.tolist() == pytest.approx([1.5, 0.4])
    assert grid.has_lines_of(graded())
    assert not grid.has_lines_of(Grid(grid.origin, grid.cell_size))
    other = (LINES[0] * np.array([1.0, 1.0, 1.0, 1.0, 1.01]), LINES[1])
    assert not grid.has_lines_of(Grid(grid.origin, grid.cell_size, lines=other))


# --- domains ------------------------------------------------------------------------------------


def test_domains_are_kept_within_the_cells_of_their_points() -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "gimp")))
    grid = graded()
    points.position[:3] = [[-0.2, 2.1], [1.9, 2.7], [1.9, 2.3]]  # cells of 1.5, 0.8 and 0.2 to 0.4
    points.half_length[:3] = [[0.7, 0.1], [0.7, 0.1], [0.3, 1e-9]]
    points.half_length[3:] = 0.1
    points.position[3:] = [0.1, 2.7]
    assert bound_domains(points, grid) == {"floor": 1, "cap": 1}
    expected = [[0.7, 0.1], [0.4, 0.1], [0.3, 0.3e-3]]
    np.testing.assert_allclose(points.half_length[:3], expected, rtol=1e-12)


@pytest.mark.parametrize("update", ["fixed", "right_stretch", "corners"])
def test_a_body_travels_into_smaller_cells_and_on(update: str) -> None:
    """Its domains follow the cells, so that it stays on the grid: a uniform motion."""
    entries = block_entries("plane_strain", "gimp", schedule={"steps": 12})
    rows = [[0.0, 1.0], [2.0, 1.0], [6.0, 0.25], [9.0, 1.0]]
    entries["grid"]["cell_size"] = {"x": rows, "y": 1.0}
    entries["bodies"][0] |= {"points_per_cell": 1, "domain_update": update}
    simulation = Simulation(Model.from_dict(entries))
    for _ in range(12):
        active = simulation.locate(0.0)
        u = np.tile([0.5, 0.0], (active.nodes, 1))
        soil = simulation.soil_on(active)
        soil.update(u)
        soil.advance(u, soil.moved_domains(u))
        bound_domains(simulation.state.points, simulation.state.grid)
    points, grid = simulation.state.points, simulation.state.grid
    assert points.position[:, 0].min() > 6.0
    assert (points.half_length <= 0.5 * grid.sizes_at(points.position) * (1.0 + 1e-9)).all()
    np.testing.assert_allclose(points.stress, 0.0, atol=1e-9)


def test_smaller_cells_that_come_to_the_soil_shorten_its_domains() -> None:
    """The fine zone follows a tool above a block at rest, at most a cell a step."""
    entries = block_entries("plane_strain", "gimp", cells=1, schedule={"steps": 12})
    entries["bodies"][0]["shape"]["upper"] = [8.0, 1.0]
    entries["bodies"][0]["points_per_cell"] = 1
    above = {"type": "plane", "point": [0.0, 5.0], "normal": [0.0, -1.0]}
    tool = implicit("tool", above, displacement={"x": 6.0, "y": 0.0})
    entries["boundaries"] = [
        tool,
        plane("base", "y", 0.0, condition="fixed"),
        plane("top", "y", 1.0, condition="fixed"),
    ]
    entries["grid"] = {
        "cell_size": {"x": [[-2.0, 1.0], [0.0, 0.3], [2.0, 1.0]], "y": 1.0},
        "follow": {"boundary": "tool", "place": [0.0, 5.0], "axes": ["x"]},
    }
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    for step in range(12):
        active = simulation.advance(step / 12, (step + 1) / 12).active
        size = active.grid.sizes_at(simulation.state.points.position)
        assert (simulation.state.points.half_length <= 0.5 * size * (1.0 + 1e-9)).all()
    assert active.grid.origin[0] == pytest.approx(-2.0 + 5.5)
    assert simulation.state.points.half_length[:, 0].min() < 0.25
    assert any("kept at the size of a cell" in text for text in simulation.services.warnings.texts)


# --- F-bar --------------------------------------------------------------------------------------


@every_dim
def test_mean_gradients_are_those_of_the_functions_over_the_material(dim: int) -> None:
    random = np.random.default_rng(4)
    size = random.uniform(0.3, 2.0, (5, dim))
    local, weight = random.random((5, 7, dim)), random.random((5, 7))
    pairs = [(0, 1)] if dim == 2 else [(1, 2), (2, 0), (0, 1)]
    of_pairs = [local[:, :, i] * local[:, :, j] for i, j in pairs]
    ones = np.ones((5, 7))
    functions = [ones, *np.moveaxis(local, 2, 0), *(of_pairs if dim == 3 else [])]
    moment = np.stack([(weight * f).sum(axis=1) for f in functions], axis=1)
    found = mean_gradients(moment, size)
    for a, corner in enumerate(product((0, 1), repeat=dim)):
        side = np.array(corner[::-1])
        hat = np.where(side, local, 1.0 - local)
        for k in range(dim):
            slope = (1.0 if side[k] else -1.0) / size[:, k, None]
            gradient = slope * np.delete(hat, k, axis=2).prod(axis=2)
            mean = (weight * gradient).sum(axis=1) / weight.sum(axis=1)
            np.testing.assert_allclose(found[:, a, k], mean, rtol=1e-12, atol=1e-14)


# --- weak springs -------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("basis", BASES)
def test_nodal_volume_of_full_cells(kind: str, basis: str) -> None:
    """Inside a full block it is the mean volume of the cells around, and no node has a spring."""
    simulation = block(kind, basis)
    soil = simulation.soil_on(simulation.locate(0.0))
    active, dim = soil.active, dimension(kind)
    lattice = active.lattice[:, :dim]
    inner = ((lattice > 0) & (lattice < 3)).all(axis=1)
    expected = active.grid.sizes_around(lattice).prod(axis=1)[inner]
    np.testing.assert_allclose(soil.nodal_volume[inner], expected, rtol=1e-12)
    assert soil.nodal_volume.sum() == pytest.approx(3.0**dim, rel=1e-12)
    assert covered_nodes(soil)[inner].all()
    springs = WeakSprings.of(soil)
    young = soil.elastic_moduli.young.max()
    size = active.grid.sizes_around(lattice)
    expected = 1e-11 * young * size.prod(axis=1) / size.max(axis=1) ** 2
    np.testing.assert_allclose(springs.shift, expected, rtol=1e-12)


# --- boundaries ---------------------------------------------------------------------------------


def test_pieces_of_a_line_are_as_long_as_the_cells_ask_for() -> None:
    lines = np.cumsum([0.0, 0.1, 0.1, 0.15, 0.2, 0.3, 0.4])
    grid = Grid(np.zeros(2), np.array([0.1, 0.5]), lines=(lines, np.zeros(0)))
    line = Plane([0.0, 0.23], [0.0, 1.0])
    box = np.array([0.0, 0.0]), np.array([1.2, 1.0])
    piece = 0.1 / 3.0
    found = make_quadrature(line, *box, grid, piece, 2.0, local=True)
    x, length = found.position[::3, 0], found.weight.reshape(-1, 3).sum(axis=1)
    inside = (x > 0.0) & (x < lines[-1])
    size = grid.sizes_at(np.stack([x, np.full(len(x), 0.23)], axis=1)).min(axis=1)
    assert (length[inside] <= size[inside] / 3.0 * (1.0 + 1e-9)).all()
    assert length[inside].max() > 0.09
    everywhere = make_quadrature(line, *box, grid, piece, 2.0)
    assert len(found.weight) < 0.8 * len(everywhere.weight)
    assert found.weight.sum() == pytest.approx(everywhere.weight.sum(), rel=1e-12)
    number = np.floor(grid.in_cells(found.position)).reshape(-1, 3, 2)
    np.testing.assert_array_equal(number, number[:, :1].repeat(3, axis=1))


def test_functions_at_places_reproduce_linear_fields() -> None:
    simulation = block("3d", "linear")
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    random = np.random.default_rng(1)
    place = random.uniform(0.0, 3.0, (50, 3))
    order, at = locate_in_cells(active, place)
    slope = random.normal(size=(3, 2))
    nodal = active.position @ slope
    np.testing.assert_allclose(at.interpolate(nodal), place[order] @ slope, atol=1e-13)
    gradient = np.einsum("nak,nai->nki", at.gradient, nodal[at.node[at.cell]])
    np.testing.assert_allclose(gradient, np.tile(slope, (50, 1, 1)), atol=1e-12)


def test_a_support_is_small_by_the_cells_it_is_in() -> None:
    """A quarter of a face of a cell of 1 joins its neighbour; in cells of 0.2 it is large."""
    position = np.array([[0.1, 0.0], [0.35, 0.0], [0.6, 0.0], [0.85, 0.0]])
    normal = np.tile([0.0, 1.0], (4, 1))
    multiplier, weight = np.array([0, 1, 1, 1]), np.full(4, 0.25)
    joined = without_small(multiplier, position, normal, weight, np.ones((4, 2)))
    assert joined.tolist() == [0, 0, 0, 0]
    apart = without_small(multiplier, position, normal, weight, np.full((4, 2), 0.2))
    assert apart.tolist() == [0, 1, 1, 1]
    sliver = np.full(4, 0.015)
    assert is_sliver(np.arange(4), sliver, np.ones((4, 2))).all()
    assert not is_sliver(np.arange(4), sliver, np.full((4, 2), 0.2)).any()


# --- softening ----------------------------------------------------------------------------------


@every_kind
def test_softening_depends_on_the_cell_of_the_point(kind: str) -> None:
    soft = material_entries(
        "mohr_coulomb", residual_cohesion=5.0, softening_strain=1e-3, softening_length=2.0
    )
    simulation = block(kind, materials={"soil": soft})
    points, grid = simulation.state.points, simulation.state.grid
    law = points.ranges[0].law
    strain = points.parameters[:, law.parameters.index("softening_strain")]
    length: Floats = grid.sizes_at(points.position).prod(axis=1) ** (1.0 / grid.dim)
    np.testing.assert_allclose(strain, 2e-3 / length, rtol=1e-12)
    assert np.ptp(strain) > 0.3 * strain.min()
