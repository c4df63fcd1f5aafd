# SPDX-License-Identifier: BSD-3-Clause
"""Unknowns that belong to no node: bordered systems in every solver, and in Newton's iteration."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from balances import blocks_at, residual_at
from lattice_fields import ball, edge_nodes, poisson
from rigid_plate import (
    CONSTRAINED_MODULUS,
    HEIGHT,
    WIDTH,
    Plate,
    column,
    conditions,
    equilibrium,
    plate_balance,
)
from scipy.optimize import brentq
from small_problems import dimension

from tilth.algebra.border import Border
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium
from tilth.arrays import Floats
from tilth.mpm.active_grid import Buffers, locate
from tilth.solvers import SOLVERS, LinearSolver, LinearSystem, SolveFailed, linear_solver
from tilth.terms.balance import Balance
from tilth.terms.soil_forces import SoilForces
from tilth.terms.space import displacement_of

NAMES = [name for name, solver in SOLVERS.items() if solver.available()] + ["multigrid", "auto"]
every_solver = pytest.mark.parametrize("name", NAMES)
every_kind = pytest.mark.parametrize("kind", ["plane_strain", "3d"])


def solver_of(name: str, dim: int, notes: list[str] | None = None) -> LinearSolver:
    """A solver by its name in a case file; multigrid may leave its work if `notes` are taken."""
    return linear_solver(name, dim, 0, pytest.fail if notes is None else notes.append)


def bordered(dim: int, components: int, unknowns: int, symmetric: bool = True) -> LinearSystem:
    """A system of some fields with a random border, which makes nothing indefinite."""
    active = ball(dim, 3)
    system = poisson(active, 2.0 * np.eye(components) + 0.3, edge_nodes(active))
    random = np.random.default_rng(dim + 10 * components + 100 * unknowns)
    columns, rows = random.normal(size=(2, unknowns, active.nodes, components))
    corner = np.diag(random.uniform(1e4, 2e4, unknowns)) + random.normal(size=(unknowns, unknowns))
    if symmetric:
        rows, corner = columns, 0.5 * (corner + corner.T)
    system.border = Border(columns, rows, corner, np.ones(unknowns))
    return system


def dense(system: LinearSystem) -> tuple[Floats, Floats]:
    """The whole matrix of the free and the global unknowns, and which nodal ones are free."""
    active, components = system.active, system.components
    whole = np.zeros((active.nodes, components, active.nodes, components))
    rows = np.repeat(np.arange(active.nodes), np.diff(active.row_start))
    whole[rows, :, active.column, :] = system.blocks
    free = np.flatnonzero(~system.constrained.ravel())
    border = system.border
    assert border is not None
    size = border.unknowns
    columns, sides = (part.reshape(size, -1)[:, free] for part in (border.columns, border.rows))
    nodal = whole.reshape(system.constrained.size, -1)[np.ix_(free, free)]
    return np.block([[nodal, columns.T], [sides, border.corner]]), free


def compare(
    name: str, system: LinearSystem, right: Floats, own: Floats, notes: list[str] | None = None
) -> None:
    """Solves a system and compares with a dense solution."""
    matrix, free = dense(system)
    exact = np.linalg.solve(matrix, np.concatenate([right.ravel()[free], own]))
    solver = solver_of(name, system.active.grid.dim, notes)
    nodal, unknowns = solver.begin(system).solve_bordered(right, own, 1e-12)
    assert not nodal[system.constrained].any()
    found = nodal.ravel()[free]
    size = np.abs(exact[: len(free)]).max()
    np.testing.assert_allclose(found, exact[: len(free)], rtol=0, atol=1e-9 * size)
    np.testing.assert_allclose(unknowns, exact[len(free) :], rtol=1e-9)


@every_solver
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("components", [1, 2, 3])
@pytest.mark.parametrize("symmetric", [True, False])
def test_bordered_systems_are_solved(name: str, dim: int, components: int, symmetric: bool) -> None:
    for unknowns in (1, 3):
        system = bordered(dim, components, unknowns, symmetric)
        random = np.random.default_rng(0)
        compare(
            name, system, random.normal(size=system.constrained.shape), random.normal(size=unknowns)
        )


@every_solver
def test_a_zero_right_side_has_the_solution_zero(name: str) -> None:
    system = bordered(2, 2, 3)
    nodal, unknowns = (
        solver_of(name, 2)
        .begin(system)
        .solve_bordered(np.zeros(system.constrained.shape), np.zeros(3), 1e-10)
    )
    assert not nodal.any()
    assert not unknowns.any()


@every_solver
def test_without_a_border_there_are_no_global_unknowns(name: str) -> None:
    system = bordered(2, 2, 1)
    right = np.random.default_rng(0).normal(size=system.constrained.shape)
    system.border = None
    nodal, unknowns = solver_of(name, 2).begin(system).solve_bordered(right, np.zeros(0), 1e-10)
    assert np.array_equal(nodal, solver_of(name, 2).begin(system).solve(right, 1e-10))
    assert unknowns.shape == (0,)


@every_solver
def test_a_matrix_that_only_its_border_makes_regular(name: str) -> None:
    """Nothing but the mean value, a Lagrange multiplier's equation, holds the fields.

    The mean of the solution is the given one, and the multiplier balances the loads. Multigrid is
    told to need a regular A: it must give up, not be wrong.
    """
    active = ball(2, 3)
    system = poisson(active, np.eye(1), np.zeros(active.nodes, dtype=bool))
    mean = np.full((1, active.nodes, 1), 1.0 / active.nodes)
    system.border = Border(mean, mean, np.zeros((1, 1)), np.ones(1))
    right = np.random.default_rng(4).normal(size=(active.nodes, 1))
    notes: list[str] = []
    nodal, unknowns = (
        solver_of(name, 2, notes).begin(system).solve_bordered(right, np.array([0.3]), 1e-12)
    )
    assert nodal.mean() == pytest.approx(0.3, rel=1e-9)
    assert unknowns[0] == pytest.approx(right.sum(), rel=1e-9)
    assert len(notes) == (name == "multigrid")


@every_solver
@pytest.mark.parametrize("case", ["not coupled", "twice the same", "not a number"])
def test_singular_equations_of_global_unknowns_are_refused(name: str, case: str) -> None:
    system = bordered(2, 2, 2)
    assert system.border is not None
    columns, corner = system.border.columns.copy(), system.border.corner.copy()
    if case == "not coupled":
        columns[1], corner[1], corner[:, 1] = 0.0, 0.0, 0.0
    elif case == "twice the same":
        columns[1], corner[:] = columns[0], corner[0, 0]
    else:
        columns[1, -1] = np.nan
    system.border = Border(columns, columns, corner, np.ones(2))
    right = np.ones(system.constrained.shape)
    with pytest.raises(SolveFailed, match=r"singular|not a number"):
        solver_of(name, 2, []).begin(system).solve_bordered(right, np.ones(2), 1e-8)


@every_solver
def test_the_unit_of_a_global_unknown_does_not_matter(name: str) -> None:
    """An angle in degrees in place of radians, its scale with it: the same motion."""
    system = bordered(3, 3, 2)
    border = system.border
    assert border is not None
    right = np.random.default_rng(0).normal(size=system.constrained.shape)
    own = np.array([0.3, -2.0])
    degree = np.array([1.0, np.pi / 180.0])
    expected = solver_of(name, 3).begin(system).solve_bordered(right, own, 1e-10)
    system.border = Border(
        border.columns * degree[:, None, None], border.rows * degree[:, None, None],
        border.corner * np.outer(degree, degree), border.scale * degree,
    )  # fmt: skip
    nodal, unknowns = solver_of(name, 3).begin(system).solve_bordered(right, own * degree, 1e-10)
    size = np.abs(expected[0]).max()
    np.testing.assert_allclose(nodal, expected[0], rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(unknowns * degree, expected[1], rtol=1e-11)


AREA = {"plane_strain": WIDTH, "3d": WIDTH**2}


@every_solver
@every_kind
def test_settlement_of_an_elastic_column_at_small_strain(name: str, kind: str) -> None:
    """One linear system: F H / (M A) + F / (k A), and springs that all carry the same."""
    modulus, force = 5e4, 3.0
    simulation = column(kind)
    balance = plate_balance(simulation, modulus, np.inf, force)
    system = LinearSystem(balance.active, conditions(simulation, balance.active).constrained)
    still, none = np.zeros(system.constrained.shape), np.zeros(1)
    forces = residual_at(balance, still, none)
    system.blocks[:] = blocks_at(balance, still)
    system.border = balance.border(balance.at(still, none))
    solver = solver_of(name, dimension(kind))
    nodal, (settlement,) = solver.begin(system).solve_bordered(-forces.u, -forces.globals, 1e-12)
    pressure = force / AREA[kind]
    expected = -pressure * (HEIGHT / CONSTRAINED_MODULUS + 1.0 / modulus)
    assert settlement == pytest.approx(expected, rel=1e-9)
    strain = -pressure / CONSTRAINED_MODULUS
    exact = np.zeros_like(nodal)
    exact[:, -1] = strain * balance.active.position[:, -1]
    np.testing.assert_allclose(nodal, exact, rtol=0, atol=1e-9 * HEIGHT * abs(strain))


MODULUS, HARDENING, FORCE = 3e3, 0.05, 150.0


def settlement(kind: str) -> float:
    """Under a force that shortens the column by a tenth, in springs that stiffen.

    Cauchy stress in the column M ln(lambda) / lambda, on an area that stays; k (d + d^3 / l^2) in
    the springs.
    """
    pressure = FORCE / AREA[kind]
    stretch = brentq(lambda x: CONSTRAINED_MODULUS * np.log(x) / x + pressure, 0.5, 1.0, xtol=1e-15)
    short = brentq(lambda d: MODULUS * (d + d**3 / HARDENING**2) - pressure, 0.0, 1.0, xtol=1e-16)
    return float((stretch - 1.0) * HEIGHT - short)


def settled(simulation: Simulation, solver: LinearSolver, *plate: float) -> Equilibrium:
    """The equilibrium of the column under its plate, `plate` as the arguments of `Plate`."""
    return equilibrium(simulation, plate_balance(simulation, *plate), solver)


@every_solver
@every_kind
def test_newton_finds_global_unknowns(name: str, kind: str) -> None:
    solver = solver_of(name, dimension(kind))
    found = settled(column(kind), solver, MODULUS, HARDENING, FORCE).x.globals
    assert found == pytest.approx([settlement(kind)], rel=1e-9)
    assert found[0] < -0.05 * HEIGHT


def test_newton_converges_quadratically_with_global_unknowns() -> None:
    found = settled(column("3d"), solver_of("superlu", 3), MODULUS, HARDENING, FORCE)
    small = [r for r in found.residuals if 1e-11 < r < 1e-2]
    assert len(small) >= 2
    for before, after in pairwise(small):
        assert after <= 30.0 * before**2


@every_kind
def test_settlement_does_not_depend_on_the_units(kind: str) -> None:
    """Lengths a thousand times and stresses seven times as large in their numbers; w in 1/50."""
    length, stress, unit = 1000.0, 7.0, 50.0
    plates = (
        (MODULUS, HARDENING, FORCE, 1.0),
        (stress / length * MODULUS, length * HARDENING,
         stress * length ** (dimension(kind) - 1) * FORCE, unit),
    )  # fmt: skip
    solver = solver_of("superlu", dimension(kind))
    one = settled(column(kind), solver, *plates[0])
    other = settled(column(kind, length, stress), solver, *plates[1])
    np.testing.assert_allclose(other.x.globals, unit * length * one.x.globals, rtol=1e-10)
    np.testing.assert_allclose(other.residuals[:-1], one.residuals[:-1], rtol=1e-5)


@every_kind
def test_border_is_the_derivative_of_the_forces(kind: str) -> None:
    balance = plate_balance(column(kind), MODULUS, HARDENING, FORCE, 3.0)
    random = np.random.default_rng(1)
    u, direction = 1e-2 * random.normal(size=(2, balance.active.nodes, balance.active.grid.dim))
    g, turn, step = np.array([0.1]), np.array([0.7]), 1e-4
    residual_at(balance, u, g)
    border = balance.border(balance.at(u, g))
    assert border is not None
    system = LinearSystem(balance.active, np.zeros(u.shape, dtype=bool))
    system.blocks[:] = blocks_at(balance, u, g)
    ahead, behind = (
        residual_at(balance, u + s * step * direction, g + s * step * turn) for s in (1.0, -1.0)
    )
    nodal = (ahead.u - behind.u) / (2.0 * step)
    own = (ahead.globals - behind.globals) / (2.0 * step)
    product = system.times(direction) + np.tensordot(turn, border.columns, axes=1)
    np.testing.assert_allclose(product, nodal, rtol=0, atol=1e-6 * np.abs(nodal).max())
    found = system.inner_products(border.rows, direction) + border.corner @ turn
    np.testing.assert_allclose(found, own, rtol=1e-6)


def test_terms_have_each_their_own_unknowns() -> None:
    """Two plates, a third and two thirds of the springs and of the force, settle as one does."""
    simulation = column("plane_strain")
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    plates = [Plate(active, share * MODULUS, HARDENING, share * FORCE) for share in (1 / 3, 2 / 3)]
    terms = [plates[0], SoilForces(simulation.soil_on(active)), plates[1]]
    balance = Balance(active, terms, [displacement_of(active, conditions(simulation, active))])
    found = equilibrium(simulation, balance, solver_of("multigrid", 2)).x.globals
    assert found == pytest.approx([settlement("plane_strain")] * 2, rel=1e-9)
