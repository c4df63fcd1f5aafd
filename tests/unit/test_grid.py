# SPDX-License-Identifier: BSD-3-Clause
"""Active grid: numbering, stencil groups, matrix pattern, colours, cells, limits."""

from __future__ import annotations

import numpy as np
import pytest
from small_problems import BASES, KINDS, Laboratory, block_entries, deformed_laboratory, dimension

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.errors import StepFailed
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.domains import bound_domains
from tilth.mpm.initial_points import initial_points

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)


def laboratory(kind: str, basis: str, seed: int = 0) -> Laboratory:
    return deformed_laboratory(kind, basis, "hencky_elastic", np.random.default_rng(seed))


def groups(active: ActiveGrid) -> list[np.ndarray]:
    """Nodes of every group of every body."""
    return [
        stencil.node[a:b]
        for stencil in active.stencils
        for a, b in zip(stencil.node_start[:-1], stencil.node_start[1:], strict=True)
    ]


@pytest.mark.parametrize("seed", range(3))
def test_keys_keep_the_lattice_and_its_order(seed: int) -> None:
    random = np.random.default_rng(seed)
    places = random.integers(-(2**19) + 8, 2**19 - 8, (200, 3))
    places[:4] = [[0, 0, 0], [-1, 0, 0], [0, -1, 0], [2**19 - 9, -(2**19) + 9, 5]]
    keys = np.asarray(_core.node_keys(places))
    assert np.array_equal(np.asarray(_core.lattice(keys)), places)
    order = np.lexsort((places[:, 0], places[:, 1], places[:, 2]))
    assert np.array_equal(np.argsort(keys, kind="stable"), order)


@every_kind
@every_basis
def test_active_nodes_are_those_of_the_points_and_no_more(kind: str, basis: str) -> None:
    active = laboratory(kind, basis).active
    assert (np.diff(active.key) > 0).all()
    touched = np.unique(np.concatenate(groups(active)))
    assert np.array_equal(touched, np.arange(active.nodes))


@every_kind
@every_basis
def test_stencils_cover_all_points_once(kind: str, basis: str) -> None:
    found = laboratory(kind, basis)
    stencil = found.active.stencils[0]
    assert stencil.start[0] == 0
    assert stencil.start[-1] == len(found.points)
    assert (np.diff(stencil.start) > 0).all()
    assert np.array_equal(np.sort(found.points.point_id), np.arange(len(found.points)))


@every_kind
@every_basis
def test_pattern_is_every_pair_that_shares_a_point(kind: str, basis: str) -> None:
    active = laboratory(kind, basis).active
    expected = np.zeros((active.nodes, active.nodes), dtype=bool)
    for nodes in groups(active):
        expected[np.ix_(nodes, nodes)] = True
    found = np.zeros_like(expected)
    for row in range(active.nodes):
        columns = active.column[active.row_start[row] : active.row_start[row + 1]]
        assert (np.diff(columns) > 0).all()
        found[row, columns] = True
    assert np.array_equal(found, expected)
    assert np.array_equal(active.column[active.diagonal], np.arange(active.nodes))


def test_pattern_joins_the_bodies() -> None:
    """Two bodies in one cell share its nodes: that is what couples them."""
    entries = block_entries("plane_strain", "gimp")
    other = dict(entries["bodies"][0], name="other", basis="linear")
    other["shape"] = {"type": "box", "lower": [2.0, 0.0], "upper": [4.0, 2.0]}
    entries["bodies"].append(other)
    model = Model.from_dict(entries)
    active = locate(initial_points(model), Simulation(model).state.grid, Buffers())
    assert len(active.stencils) == 2
    assert active.nodes == 15
    shared = np.flatnonzero(active.position[:, 0] == 2.0)
    for row in shared:
        columns = active.column[active.row_start[row] : active.row_start[row + 1]]
        assert {1.0, 3.0} <= set(active.position[columns, 0])


@every_kind
@every_basis
def test_slabs_of_one_colour_share_no_node(kind: str, basis: str) -> None:
    for stencil in laboratory(kind, basis).active.stencils:
        seen = []
        for c in range(len(stencil.colour_start) - 1):
            touched: list[int] = []
            for slab in range(stencil.colour_start[c], stencil.colour_start[c + 1]):
                own: set[int] = set()
                for g in stencil.order[stencil.slab_start[slab] : stencil.slab_start[slab + 1]]:
                    own |= set(stencil.node[stencil.node_start[g] : stencil.node_start[g + 1]])
                    seen.append(g)
                touched += own
            assert len(touched) == len(set(touched))
        assert sorted(seen) == list(range(len(stencil.start) - 1))


@every_kind
@every_basis
def test_cells_are_those_the_supports_cover(kind: str, basis: str) -> None:
    found = laboratory(kind, basis)
    cells = found.active.cells()
    dim = dimension(kind)
    assert cells.shape[1] == 2**dim
    assert len(np.unique(cells[:, 0])) == len(cells)
    corner = found.active.lattice[cells[:, 0], :dim]
    # VTK's order: around the lower face, then around the upper one
    steps = [[0, 0], [1, 0], [1, 1], [0, 1]]
    if dim == 3:
        steps = [[*s, z] for z in (0, 1) for s in steps]
    for k, step in enumerate(steps):
        assert np.array_equal(found.active.lattice[cells[:, k], :dim], corner + step)
    inside = np.floor((found.points.position - found.grid.origin) / found.grid.cell_size)
    have = set(map(tuple, corner.tolist()))
    assert {tuple(map(int, place)) for place in inside} <= have


@every_basis
def test_sorting_moves_all_arrays_together(basis: str) -> None:
    model = Model.from_dict(block_entries("plane_strain", basis))
    points = initial_points(model)
    random = np.random.default_rng(0)
    for name, array in points.arrays().items():
        if array.dtype == np.float64 and name not in ("position", "half_length"):
            array[:] = random.normal(size=array.shape)
    order = random.permutation(len(points))
    before = {name: array.copy() for name, array in points.arrays().items()}
    points.permute(points.ranges[0], order)
    locate(points, Grid(np.zeros(2), np.ones(2)), Buffers())
    for name, array in points.arrays().items():
        assert np.array_equal(array, before[name][points.point_id]), name


def test_unsorted_points_give_the_same_grid() -> None:
    model = Model.from_dict(block_entries("3d", "gimp"))
    grid = Grid(np.zeros(3), np.full(3, 0.7))
    first, second = initial_points(model), initial_points(model)
    second.permute(second.ranges[0], np.random.default_rng(1).permutation(len(second)))
    one, other = locate(first, grid, Buffers()), locate(second, grid, Buffers())
    assert np.array_equal(one.key, other.key)
    assert np.array_equal(one.column, other.column)


def test_point_beyond_the_limits_is_named() -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "linear")))
    grid = Grid(np.zeros(2), np.ones(2), np.zeros(2), np.array([2.0, 1.5]))
    with pytest.raises(StepFailed, match="left the limits") as failure:
        locate(points, grid, Buffers())
    assert points.position[points.point_id == failure.value.point, 1] == 1.75


def test_point_out_of_reach_is_named() -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "linear")))
    points.position[5] = [1e6, 0.0]
    with pytest.raises(StepFailed, match="too far from the grid's origin") as failure:
        locate(points, Grid(np.zeros(2), np.ones(2)), Buffers())
    assert failure.value.point == 5


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_position_that_is_no_number_is_refused(bad: float) -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "linear")))
    points.position[3, 1] = bad
    with pytest.raises(StepFailed) as failure:
        locate(points, Grid(np.zeros(2), np.ones(2)), Buffers())
    assert failure.value.point == 3


def test_domains_are_kept_between_their_bounds() -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "gimp")))
    grid = Grid(np.zeros(2), np.array([1.0, 0.8]))
    points.half_length[0] = [1e-9, 0.2]
    points.half_length[1] = [0.7, 0.5]
    points.half_length[2] = [-0.3, 0.4]
    assert bound_domains(points, grid) == {"floor": 2, "cap": 1}
    assert points.half_length[0].tolist() == [1e-3, 0.2]
    assert points.half_length[1].tolist() == [0.5, 0.4]
    assert points.half_length[2].tolist() == [1e-3, 0.4]


def test_linear_points_have_no_domain_to_bound() -> None:
    points = initial_points(Model.from_dict(block_entries("plane_strain", "linear")))
    points.half_length[:] = 9.0
    assert bound_domains(points, Grid(np.zeros(2), np.ones(2))) == {"floor": 0, "cap": 0}
    assert (points.half_length == 9.0).all()
