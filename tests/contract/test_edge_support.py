# SPDX-License-Identifier: BSD-3-Clause
"""Support of soil without cohesion at edges: derivative, limit, no effect on linear motions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from balances import blocks_at, committed, residual_at
from small_problems import AXES, BASES, KINDS, block_entries, dimension, plane, spaced

from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.arrays import Flags, Floats
from tilth.mpm.active_grid import ActiveGrid, Buffers, locate
from tilth.mpm.soil import Soil
from tilth.terms.balance import Balance
from tilth.terms.edge_support import SHARE, EdgeSupport, SupportForces
from tilth.terms.ghost import Ghost, Kind, ghost_faces
from tilth.terms.unheld_weight import HELD_BY_COHESION, unheld_weight

every_kind = pytest.mark.parametrize("kind", KINDS)
every_basis = pytest.mark.parametrize("basis", BASES)
GAMMA = 0.005
UNIT_WEIGHT = 20.0


def sand(
    kind: str, basis: str = "gimp", spacing: str = "uniform", shift: float = 0.3, **entries: Any
) -> tuple[Simulation, ActiveGrid]:
    """A block of sand of two cells a side, shifted along the diagonal."""
    dim = dimension(kind)
    model: dict[str, Any] = block_entries(
        kind, basis, boundaries=[plane(axis, axis, 0.0) for axis in AXES[:dim]]
    )
    body = model["bodies"][0]
    model["materials"][body["material"]] = {
        "model": "mohr_coulomb", "young_modulus": 2e4, "poisson_ratio": 0.3, "density": 2.0,
        "cohesion": 0.0, "friction_angle": 35.0, "dilation_angle": 0.0, **entries,
    }  # fmt: skip
    body.pop("points_per_cell", None)
    body["points"] = [4] * dim
    body["shape"] = {"type": "box", "lower": [shift] * dim, "upper": [2 + shift] * dim}
    simulation = Simulation(Model.from_dict(spaced(model, spacing)))
    return simulation, locate(simulation.state.points, simulation.state.grid, Buffers())


def support(
    simulation: Simulation,
    active: ActiveGrid,
    owner: EdgeSupport | None = None,
    stiffening: float = 1.0,
    constrained: Flags | None = None,
) -> SupportForces:
    """The term of all faces that hold weight; constrained: prescribed components."""
    soil = simulation.soil_on(active)
    weight = np.full(len(soil.points), UNIT_WEIGHT)
    if constrained is None:
        constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
    faces = ghost_faces(soil, constrained, GAMMA, unit_weight=weight)
    held = [each for each in faces if each.kind is Kind.WEIGHT]
    assert held
    return (owner or EdgeSupport(active.grid.dim)).term(active, held, stiffening)


def matrix_of(balance: Balance, u: Floats) -> Floats:
    """The derivative of a balance at u, (nodes dim, nodes dim)."""
    active = balance.active
    residual_at(balance, u)
    blocks = blocks_at(balance, u)
    size = active.nodes * active.grid.dim
    return np.asarray(
        sp.bsr_matrix((blocks, active.column, active.row_start), shape=(size, size)).toarray()
    )


@every_kind
@every_basis
@pytest.mark.parametrize("spacing", ["uniform", "graded"])
def test_the_stiffness_is_the_derivative_of_the_force(kind: str, basis: str, spacing: str) -> None:
    simulation, active = sand(kind, basis, spacing)
    balance = Balance(active, [support(simulation, active)])
    random = np.random.default_rng(5)
    u = 0.02 * random.normal(size=(active.nodes, active.grid.dim))
    matrix = matrix_of(balance, u)
    direction = random.normal(size=u.shape)
    step = 1e-6
    ahead, behind = (residual_at(balance, u + way * step * direction).u for way in (1.0, -1.0))
    difference = (ahead - behind).ravel() / (2.0 * step)
    found = matrix @ direction.ravel()
    np.testing.assert_allclose(found, difference, rtol=0, atol=1e-6 * np.abs(difference).max())
    assert np.abs(matrix - matrix.T).max() <= 1e-12 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(matrix).min() >= -1e-9 * np.abs(matrix).max()


@every_kind
@every_basis
def test_linear_motions_are_free_of_force_and_forces_have_no_resultant(
    kind: str, basis: str
) -> None:
    simulation, active = sand(kind, basis)
    balance = Balance(active, [support(simulation, active)])
    u = active.position @ np.random.default_rng(3).normal(size=(active.grid.dim, active.grid.dim))
    random = np.random.default_rng(4).normal(size=u.shape)
    scale = np.abs(residual_at(balance, random).u).max()
    assert scale > 0.0
    assert np.abs(residual_at(balance, u).u).max() <= 1e-12 * scale * np.abs(u).max()
    force = residual_at(balance, random).u
    assert np.abs(force.sum(axis=0)).max() <= 1e-12 * scale * active.nodes
    x = active.position
    for i, j in [(0, 1)] if active.grid.dim == 2 else [(0, 1), (1, 2), (2, 0)]:
        moment = (x[:, i] * force[:, j] - x[:, j] * force[:, i]).sum()
        assert abs(moment) <= 1e-11 * scale * active.nodes * np.abs(x).max()


@every_kind
def test_the_force_stays_below_a_share_of_the_weight(kind: str) -> None:
    """Of one corner of a face: SHARE f (1 - f) rho b h times its area over 2^(dim - 1)."""
    simulation, active = sand(kind)
    term = support(simulation, active)
    (balance,) = [Balance(active, [term])]
    random = np.random.default_rng(6).normal(size=(active.nodes, active.grid.dim))
    near, far = (np.abs(residual_at(balance, size * random).u).sum() for size in (1e2, 1e4))
    assert near == pytest.approx(far, rel=1e-3)
    for part in term.parts:
        product, square = part.products(1e4 * random)
        traction = part.stiffness * np.sqrt(
            (product * (part.moved + 1e4 * random[part.faces.node])).sum(axis=(1, 2)) / square
        )
        h = part.faces.size[:, part.faces.axis]
        area = np.delete(active.grid.cell_size, part.faces.axis).prod()
        f = part.faces.fill
        limit = SHARE * f * (1.0 - f) * UNIT_WEIGHT * h * part.faces.weight
        assert traction == pytest.approx(limit * np.sqrt(area / h), rel=1e-3)


def test_a_frozen_geometry_has_the_same_forces() -> None:
    """Moduli k times greater, displacements k times smaller, also those that are kept."""
    simulation, active = sand("plane_strain")
    owner = EdgeSupport(2)
    term = support(simulation, active, owner)
    balance = Balance(active, [term])
    u = 0.05 * np.random.default_rng(2).normal(size=(active.nodes, 2))
    residual_at(balance, u)
    committed(balance, u)
    expected = residual_at(Balance(active, [support(simulation, active, owner)]), u).u
    frozen = Balance(active, [support(simulation, active, owner, 1e4)])
    np.testing.assert_allclose(residual_at(frozen, 1e-4 * u).u, expected, rtol=1e-9)


def test_what_is_kept_decays_with_motion_and_is_restored() -> None:
    simulation, active = sand("plane_strain")
    owner = EdgeSupport(2)
    still = np.zeros((active.nodes, 2))
    u = 0.01 * np.random.default_rng(2).normal(size=still.shape)
    for motion in (u, still):
        balance = Balance(active, [support(simulation, active, owner)])
        held = residual_at(balance, motion).u
        committed(balance, motion)
    again = EdgeSupport(2)
    again.restore(owner.state())
    after = residual_at(Balance(active, [support(simulation, active, again)]), still).u
    np.testing.assert_array_equal(after, held)
    carried = np.abs(held).max()
    for _ in range(3):
        balance = Balance(active, [support(simulation, active, owner)])
        flow = np.full_like(still, 0.2)  # a uniform motion makes no kink
        residual_at(balance, flow)
        committed(balance, flow)
    after = residual_at(Balance(active, [support(simulation, active, owner)]), still).u
    assert np.abs(after).max() < 0.02 * carried


def test_what_is_not_held_in_a_step_is_not_held_later_for_it() -> None:
    """A layer of nodes is prescribed in a step and free in the next: its motion left no force."""
    simulation, active = sand("plane_strain")
    free = np.zeros((active.nodes, active.grid.dim), dtype=bool)
    layer = active.lattice[:, 0].max() - active.lattice[:, 0]
    held, u = free.copy(), np.zeros(free.shape)
    held[layer == 0] = True
    u[layer == 0] = np.random.default_rng(7).normal(size=u[layer == 0].shape)
    for constrained, has_force in ((held, False), (free, True)):
        owner = EdgeSupport(active.grid.dim)
        owner.commit(support(simulation, active, owner, constrained=constrained).parts, u)
        kept = support(simulation, active, owner)
        force = residual_at(Balance(active, [kept]), np.zeros(u.shape)).u
        assert force[layer == 2].any() == has_force


def test_only_sand_without_cohesion_is_held() -> None:
    gravity = np.array([0.0, -10.0])

    def weight(**entries: Any) -> Floats:
        simulation, _ = sand("plane_strain", **entries)
        return unheld_weight(
            simulation.state.points, simulation.setup.model, gravity, simulation.state.grid
        )

    cell = 1.0
    full = 20.0
    assert weight() == pytest.approx(full)
    assert weight(cohesion=0.5 * HELD_BY_COHESION * full * cell) == pytest.approx(0.5 * full)
    assert not weight(cohesion=HELD_BY_COHESION * full * cell).any()
    assert not weight(friction_angle=0.0, cohesion=0.1).any()


def test_no_faces_without_stabilisation_or_weight() -> None:
    simulation, active = sand("plane_strain")
    soil: Soil = simulation.soil_on(active)
    free = np.zeros((active.nodes, 2), dtype=bool)
    weight = np.full(len(soil.points), UNIT_WEIGHT)
    assert ghost_faces(soil, free, 0.0, unit_weight=weight) == []
    none = Ghost(GAMMA, 2)
    none.couplings(soil, free, None, 0.0 * weight)
    assert none.of_weight == []
