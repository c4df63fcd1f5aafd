# SPDX-License-Identifier: BSD-3-Clause
"""Ghost stabilisation: no effect on linear motions, none on full cells, and a bounded matrix."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from balances import blocks_at, residual_at
from ghost_blocks import block
from small_problems import (
    BASES,
    KINDS,
    SPACINGS,
    block_entries,
    dimension,
    spaced,
)

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.background import Grid
from tilth.grid.keys import find_keys, lattice_keys
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.filled_cells import LEAST_ELASTIC_SHARE, filled_cells
from tilth.terms.ghost import Faces, Kind, ghost_faces
from tilth.terms.inertia import Inertia, TimeIntegration, TimeStep
from tilth.terms.linear import LinearForces
from tilth.terms.soil_forces import SoilForces

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
every_spacing = pytest.mark.parametrize("spacing", SPACINGS)
GAMMA = 0.005


def ghost(simulation: Simulation, active: ActiveGrid, gamma: float = GAMMA) -> LinearForces:
    """The penalty of all faces."""
    constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
    faces = ghost_faces(simulation.soil_on(active), constrained, gamma)
    return LinearForces([of_axis.coupling() for of_axis in faces])


def blocks_of(balance: Balance) -> np.ndarray:
    """The node blocks of a balance at rest, (blocks, dim, dim)."""
    active = balance.active
    still = np.zeros((active.nodes, active.grid.dim))
    residual_at(balance, still)
    return blocks_at(balance, still)


def stiffness(simulation: Simulation, active: ActiveGrid, gamma: float) -> np.ndarray:
    """The whole matrix over Young's modulus, of nodes without any condition."""
    balance = Balance(
        active, [SoilForces(simulation.soil_on(active)), ghost(simulation, active, gamma)]
    )
    active, blocks = balance.active, blocks_of(balance)
    size = active.nodes * active.grid.dim
    matrix = sp.bsr_matrix((blocks, active.column, active.row_start), shape=(size, size)).toarray()
    return 0.5 * (matrix + matrix.T) / simulation.state.points.ranges[0].parameters[0]


@every_kind
@every_basis
@every_spacing
def test_linear_motions_are_free_of_force(kind: str, basis: str, spacing: str) -> None:
    simulation, active = block(kind, basis, 0.3, spacing=spacing)
    balance = Balance(active, [ghost(simulation, active)])

    def force(u: np.ndarray) -> np.ndarray:
        return residual_at(balance, u).u

    scale = np.abs(blocks_of(balance)).max()
    assert scale > 1e-4 * simulation.state.points.ranges[0].parameters[0]
    dim = active.grid.dim
    random = np.random.default_rng(3)
    motion = random.normal(size=dim) + active.position @ random.normal(size=(dim, dim))
    assert np.abs(force(motion)).max() < 1e-13 * scale * np.abs(motion).max()
    u = random.normal(size=motion.shape)
    assert np.abs(force(u).sum(axis=0)).max() < 1e-13 * scale * active.nodes
    assert (u * force(u)).sum() > 0.0


def jump_energy(place: tuple[int, ...], axis: int, grid: Grid, moved: dict[Any, Floats]) -> float:
    """h times the integral of the square of the jump of the normal derivative over one face.

    place: lattice indices of the lower of the two cells. moved: displacement of nodes by place.
    """
    step = np.eye(grid.dim, dtype=np.int64)[axis]
    below, above = (grid.sizes(np.array(place) + i * step) for i in range(2))
    gauss = 0.5 + np.array([-0.5, 0.5]) / 3.0**0.5
    energy = 0.0
    for at in product(gauss, repeat=grid.dim - 1):
        jump = np.zeros(grid.dim)
        for corner in product((0, 1), repeat=grid.dim - 1):
            value = np.prod(np.where(corner, at, 1.0 - np.array(at)))
            node = np.array(place) + np.insert(corner, axis, 0)
            first, second, third = (moved[tuple(node + i * step)] for i in range(3))
            jump += value * ((third - second) / above[axis] - (second - first) / below[axis])
        energy += float(jump @ jump) / 2 ** (grid.dim - 1)
    area = float(np.delete(below, axis).prod())
    return 0.5 * (below[axis] + above[axis]) * area * energy


def jump_energies(soil: Soil, active: ActiveGrid, u: Floats) -> Iterator[tuple[int, int, Floats]]:
    """Numbers of the two cells at each face; share of the penalty, h and h times int [du/dn]^2.

    The share is 1 for an empty and 0 for a half full cell; h is the mean size of the two cells.
    """
    grid, dim = active.grid, active.grid.dim
    moved = dict(zip(map(tuple, active.lattice[:, :dim].tolist()), u, strict=True))
    key, fill, _ = filled_cells(soil)
    place = np.asarray(_core.lattice(key))[:, :dim]
    number = {tuple(each): k for k, each in enumerate(place.tolist())}
    for low, axis in product(range(len(key)), range(dim)):
        high = number.get(tuple((place[low] + np.eye(dim, dtype=np.int64)[axis]).tolist()))
        if high is None:
            continue
        share = max(0.0, 1.0 - 2.0 * fill[low], 1.0 - 2.0 * fill[high])
        width = grid.sizes(place[[low, high]])[:, axis].mean()
        energy = jump_energy(tuple(place[low].tolist()), axis, grid, moved)
        if soil.kind == "axisymmetric":
            energy *= 2.0 * np.pi * float(grid.position(place[[low, high]] + 0.5)[:, 0].mean())
        yield low, high, np.array([share, width, energy])


@every_kind
@every_spacing
def test_energy_is_that_of_the_jumps(kind: str, spacing: str) -> None:
    """On each face gamma E h int [du/dn]^2, by the share of what its cells lack to be half full.

    E is the harmonic mean over the volume in both cells.
    """
    simulation, active = block(kind, "gimp", 0.3, spacing=spacing)
    soil, random = simulation.soil_on(active), np.random.default_rng(2)
    if spacing == "uniform" and kind != "axisymmetric":
        simulation.state.points.elastic_share[:] = random.uniform(
            0.1, 1.0, len(simulation.state.points)
        )
    balance = Balance(active, [ghost(simulation, active)])
    u = random.normal(size=(active.nodes, active.grid.dim))
    _, fill, modulus = filled_cells(soil)
    energy = shares = 0.0
    for low, high, (share, _, jump) in jump_energies(soil, active, u):
        volume = fill[[low, high]]
        mean = volume.sum() / (volume / modulus[[low, high]]).sum()
        energy += GAMMA * share * mean * jump
        shares += 0.0 < share < 1.0
    assert shares > 0
    assert (u * residual_at(balance, u).u).sum() == pytest.approx(energy, rel=1e-12)
    faces = ghost_faces(soil, np.zeros(u.shape, dtype=bool), GAMMA)
    assert all((len(each.unit) > 1) == (spacing == "graded") for each in faces)


DENSITY = 2.0
ABOVE, BELOW = 0, 1


def energy_of_mass(soil: Soil, active: ActiveGrid, faces: list[Faces], v: Floats) -> float:
    """v . M v of the mass with that of these faces, less that of the points themselves."""
    h, free = 0.1, np.zeros(v.shape, dtype=bool)
    step = TimeStep(TimeIntegration.backward_euler(), h, from_rest=True)
    mass = DENSITY * soil.points.initial_volume
    inertia = Inertia(soil, mass, faces, step, 0.0, free, np.zeros(v.shape))
    Balance(active, [SoilForces(soil), inertia])
    assert inertia.in_matrix is not None
    whole = h**2 * float((v * inertia.in_matrix.force(v)).sum())
    of_points = float(mass @ (soil.interpolate(v) ** 2).sum(axis=1))
    assert whole > 1.01 * of_points
    return whole - of_points


@every_kind
@every_spacing
@pytest.mark.parametrize("basis", ["linear", "gimp"])
def test_energy_of_the_mass_of_faces_is_that_of_the_jumps(
    kind: str, spacing: str, basis: str
) -> None:
    """On each face rho h^3 / 12 int [dv/dn]^2, by the share of the penalty.

    Soil that has come to a larger volume has no less of it.
    """
    simulation, active = block(kind, basis, 0.3, spacing=spacing)
    points = simulation.state.points
    stretch = np.random.default_rng(4).uniform(0.9, 1.1, len(points))
    points.deformation_gradient[:, 0, 0] = stretch
    np.testing.assert_allclose(points.volume, stretch * points.initial_volume, rtol=1e-14)
    soil = simulation.soil_on(active)
    v = np.random.default_rng(2).normal(size=(active.nodes, active.grid.dim))
    faces = ghost_faces(soil, np.zeros(v.shape, dtype=bool), GAMMA)
    energy = sum(
        DENSITY * width**2 / 12.0 * share * jump
        for _, _, (share, width, jump) in jump_energies(soil, active, v)
    )
    assert energy_of_mass(soil, active, faces, v) == pytest.approx(energy, rel=1e-10)


@every_kind
@every_spacing
@pytest.mark.parametrize("nodes", ["layer", "one"])
def test_nodes_behind_a_boundary_follow_those_in_front(kind: str, spacing: str, nodes: str) -> None:
    """The last nodes along x, of relative stiffness 0.4: 2 E on their lines in place of gamma E.

    It replaces as much of the penalty of partly filled cells that have such nodes. The mass has the
    same shares, without these factors, of the whole jump.
    """
    depth = 0.4
    simulation, active = block(kind, "gimp", 0.3, spacing=spacing)
    soil, young = simulation.soil_on(active), simulation.state.points.ranges[0].parameters[0]
    u = np.random.default_rng(2).normal(size=(active.nodes, active.grid.dim))
    last = active.lattice[:, 0].max()
    line = np.ones(active.nodes, dtype=bool)
    if nodes == "one":
        line = (active.lattice[:, 1:] == active.lattice[:, 1:].max(axis=0) // 2).all(axis=1)
    behind = line & (active.lattice[:, 0] == last)
    assert behind.sum() == 1 or nodes == "layer"
    depths = np.zeros((behind.sum(), active.grid.dim, 2))
    depths[:, 0, BELOW] = depth
    exterior = active.key[behind], depths
    faces = ghost_faces(soil, np.zeros(u.shape, dtype=bool), GAMMA, exterior)
    balance = Balance(active, [LinearForces([each.coupling() for each in faces])])
    cell = np.asarray(_core.lattice(filled_cells(soil)[0]))
    from_cell = active.lattice[behind] - cell[:, None]  # of such nodes: 0 or 1 if they are its own
    own = (np.isin(from_cell, (0, 1)).all(axis=2)).any(axis=1)
    of_penalty = of_mass = 0.0
    every = zip(
        jump_energies(soil, active, u),
        jump_energies(soil, active, u * line[:, None]),
        strict=True,
    )
    for (low, high, (share, width, jump)), (*_, (_, _, on_lines)) in every:
        follows = depth * (own[high] and not own[low] and cell[high, 0] > cell[low, 0])
        partly = share * (1.0 - depth * (own[low] or own[high]))
        of_penalty += (GAMMA * partly * jump + 2.0 * follows * on_lines) * young
        of_mass += DENSITY * width**2 / 12.0 * (partly + follows) * jump
    assert (u * residual_at(balance, u).u).sum() == pytest.approx(of_penalty, rel=1e-12)
    assert energy_of_mass(soil, active, faces, u) == pytest.approx(of_mass, rel=1e-10)


@every_kind
def test_a_boundary_on_a_line_has_no_nodes_behind_it_by_round_off(kind: str) -> None:
    """A face of a step in which its weight is round-off would remember the displacement in it."""
    simulation, active = block(kind, "gimp", 0.3)
    soil, free = simulation.soil_on(active), np.zeros((active.nodes, active.grid.dim), dtype=bool)
    last = active.lattice[:, 0] == active.lattice[:, 0].max()
    along = np.zeros((last.sum(), active.grid.dim, 2))
    along[:, 0, BELOW] = 1.0
    for depth, kinds in ((1e-16, {Kind.EDGE}), (1e-6, {Kind.EDGE, Kind.EXTERIOR})):
        faces = ghost_faces(soil, free, GAMMA, (active.key[last], depth * along))
        assert {each.kind for each in faces} == kinds


@every_kind
def test_nodes_behind_a_boundary_do_not_follow_soil_that_is_behind_them(kind: str) -> None:
    """The last nodes along x have their soil above them: that below is beyond a thin wall."""
    simulation, active = block(kind, "gimp", 0.3)
    soil, free = simulation.soil_on(active), np.zeros((active.nodes, active.grid.dim), dtype=bool)
    last = active.lattice[:, 0] == active.lattice[:, 0].max()
    beyond = np.zeros((last.sum(), active.grid.dim, 2))
    beyond[:, 0, ABOVE] = 0.4
    faces = ghost_faces(soil, free, GAMMA, (active.key[last], beyond))
    alone = ghost_faces(soil, free, GAMMA)
    assert [each.kind for each in faces] == [each.kind for each in alone]
    for each, other in zip(faces, alone, strict=True):
        np.testing.assert_array_equal(each.weight, other.weight)


def test_conditions_of_equally_filled_cells_count_on_both_sides() -> None:
    """The penalty beside a roller on the left is the mirror image of that beside one on the right.

    The uppermost cells of the row are filled alike, but for round-off.
    """
    simulation, active = block("plane_strain", "cpdi1", 0.0)
    simulation.state.points.position[:, 1] -= 0.3
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    soil, x = simulation.soil_on(active), active.position[:, 0]
    image = np.array([
        np.flatnonzero(np.all(np.isclose(active.position, [2.0 - at[0], at[1]]), axis=1))[0]
        for at in active.position
    ])  # fmt: skip
    found = []
    for side in (0.0, 2.0):
        constrained = np.zeros((active.nodes, 2), dtype=bool)
        constrained[x == side, 0] = True
        faces = ghost_faces(soil, constrained, GAMMA)
        balance = Balance(active, [LinearForces([each.coupling() for each in faces])])
        size = 2 * active.nodes
        matrix = sp.bsr_matrix(
            (blocks_of(balance), balance.active.column, balance.active.row_start), (size, size)
        )
        found.append(matrix.toarray().reshape(active.nodes, 2, active.nodes, 2))
    left, right = found
    turned = right[image][:, :, image] * np.outer([-1.0, 1.0], [-1.0, 1.0])[:, None]
    assert left.any()
    np.testing.assert_allclose(turned, left, rtol=0.0, atol=1e-12 * left.max())


@every_kind
@pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi2"])
def test_full_cells_of_a_graded_grid_have_none(kind: str, basis: str) -> None:
    entries = spaced(block_entries(kind, basis, cells=3), "graded")
    simulation = Simulation(Model.from_dict(entries))
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    _, fill, _ = filled_cells(simulation.soil_on(active))
    np.testing.assert_allclose(fill, 1.0, rtol=1e-12)
    assert not blocks_of(Balance(active, [ghost(simulation, active)])).any()


@every_kind
@every_basis
def test_full_cells_have_none(kind: str, basis: str) -> None:
    simulation, active = block(kind, basis, 0.0)
    _, fill, modulus = filled_cells(simulation.soil_on(active))
    np.testing.assert_allclose(fill, 1.0, rtol=1e-12)
    np.testing.assert_allclose(modulus, simulation.state.points.ranges[0].parameters[0], rtol=1e-12)
    assert not blocks_of(Balance(active, [ghost(simulation, active)])).any()


@every_kind
@every_basis
@every_spacing
def test_cells_hold_the_volume_of_the_points(kind: str, basis: str, spacing: str) -> None:
    simulation, active = block(kind, basis, 0.37, spacing=spacing)
    key, fill, _ = filled_cells(simulation.soil_on(active))
    cell = np.asarray(_core.lattice(key))[:, : dimension(kind)]
    size = active.grid.sizes(cell).prod(axis=1)
    if kind == "axisymmetric":
        size = size * 2.0 * np.pi * active.grid.position(cell + 0.5)[:, 0]
    total = (fill * size).sum()
    assert total == pytest.approx(simulation.state.points.initial_volume.sum(), rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@every_basis
def test_condition_is_bounded_as_a_block_moves_through_a_cell(kind: str, basis: str) -> None:
    """50 positions, fill from 1e-6 to 1: bounded with, unbounded without.

    Without, the least eigenvalue falls with the overlap itself for standard points, with a power of
    it for domains.
    """
    rigid = 3 if kind == "plane_strain" else 6
    shifts = np.concatenate([np.logspace(-6, -1, 20), np.linspace(0.1, 0.999, 30)])
    least: dict[float, list[float]] = {0.0: [], GAMMA: []}
    greatest = []
    for shift in shifts if kind == "plane_strain" else shifts[::5]:
        for gamma, found in least.items():
            eigenvalues = np.linalg.eigvalsh(stiffness(*block(kind, basis, shift), gamma))
            found.append(eigenvalues[rigid])
            greatest.append(eigenvalues[-1])
    assert min(least[0.0]) < (10.0 * shifts[0] if basis == "linear" else 1e-10)
    assert min(least[GAMMA]) > 1e-4
    assert max(greatest) / min(least[GAMMA]) < 3e4


@every_basis
def test_rotated_blocks_with_lone_points_are_regular(basis: str) -> None:
    """Singular without in many positions, regular with in all; CPDI's domains are turned too."""
    random = np.random.default_rng(1)
    least: dict[float, list[float]] = {0.0: [], GAMMA: []}
    for _ in range(40):
        angle, shift = random.uniform(5.0, 85.0), random.random()
        for gamma, found in least.items():
            simulation, active = block("plane_strain", basis, shift, angle=angle, cells=4, points=8)
            found.append(np.linalg.eigvalsh(stiffness(simulation, active, gamma))[3])
    assert (np.array(least[0.0]) < 1e-10).sum() > 10
    assert min(least[GAMMA]) > 1e-4


@every_kind
@every_basis
def test_yielding_soil_is_tied_less(kind: str, basis: str) -> None:
    """The penalty follows the elastic share of the last strain, down to a least one."""

    def penalty(share: float) -> np.ndarray:
        simulation, active = block(kind, basis, 0.3)
        simulation.state.points.elastic_share[:] = share
        return blocks_of(Balance(active, [ghost(simulation, active)]))

    elastic = penalty(1.0)
    np.testing.assert_allclose(penalty(0.25), 0.25 * elastic, rtol=1e-12)
    least = LEAST_ELASTIC_SHARE * elastic
    np.testing.assert_allclose(penalty(0.0), least, rtol=1e-12, atol=1e-15 * np.abs(least).max())


@every_kind
def test_softest_points_of_a_cell_count(kind: str) -> None:
    """Each cell has the volume-weighted harmonic mean of its points' moduli."""
    simulation, active = block(kind, "linear", 0.3)
    points = simulation.state.points
    points.elastic_share[:] = np.random.default_rng(5).uniform(0.0, 1.0, len(points))
    key, _, modulus = filled_cells(simulation.soil_on(active))
    cell = np.floor(points.position).astype(np.int64)
    of_cell = find_keys(key, lattice_keys(np.pad(cell, ((0, 0), (0, 3 - cell.shape[1])))))
    softness = 1.0 / (
        points.elastic_moduli().young * np.maximum(points.elastic_share, LEAST_ELASTIC_SHARE)
    )
    volume = np.bincount(of_cell, points.volume, len(key))
    expected = volume / np.bincount(of_cell, points.volume * softness, len(key))
    np.testing.assert_allclose(modulus, expected, rtol=1e-12)
