# SPDX-License-Identifier: BSD-3-Clause
"""Multigrid against the direct solver: all kinds of systems, threads, grid sizes, failures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from implicit_blocks import squeezed
from linear_systems import (
    TOLERANCE,
    Systems,
    block,
    require_agreement,
    solve,
    systems_of,
    without_pattern,
)
from small_problems import BASES, KINDS, block_entries, dimension, plane, weight

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Flags
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.solvers import (
    LinearSolver,
    Multigrid,
    SolveFailed,
    choose_solver,
)
from tilth.solvers import linear as linear_module
from tilth.solvers import multigrid as multigrid_module
from tilth_verification.cases import example, varied

pytestmark = pytest.mark.slow


CELLS = {"plane_strain": 20, "axisymmetric": 20, "3d": 7}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
def test_full_cells(kind: str, basis: str, anti_locking: str) -> None:
    more = {} if anti_locking == "none" else {"anti_locking": anti_locking}
    system, right = systems_of(block(kind, basis, CELLS[kind], **more))[0]
    require_agreement(system, right, most=40)
    require_agreement(system, without_pattern(system), most=40)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("cut", [0.3, 0.7, 0.95])
def test_partly_filled_cells_with_ghost_stabilisation(kind: str, basis: str, cut: float) -> None:
    system, right = systems_of(block(kind, basis, CELLS[kind], cut=cut))[0]
    require_agreement(system, right, most=45)
    require_agreement(system, without_pattern(system), most=45)


@pytest.mark.parametrize("seed", range(20))
def test_oblique_surface_in_space(seed: int) -> None:
    """Coarse nodes at its edge may have the same fine nodes only: blocks without an inverse."""
    random = np.random.default_rng(seed)
    model = block("3d", "linear", 8)
    points = initial_points(model)
    off = 0.15 * points.half_length * random.uniform(-1, 1, points.position.shape)
    x, y, z = (points.position + off).T
    slope = random.uniform(0.0, 1.0, 2)
    kept = z < random.uniform(0.3, 0.9) - slope[0] * (x - 0.5) - slope[1] * (y - 0.5)
    points = MaterialPoints.undeformed(
        [replace(points.ranges[0], stop=int(kept.sum()))], (points.position + off)[kept],
        points.initial_volume[kept], points.half_length[kept],
    )  # fmt: skip
    simulation = Simulation(model, points)
    simulation.services.solver = solver = Systems()
    simulation.advance(0.0, model.schedule.regular_time(1))
    system, _ = solver.kept[0]
    assert solve(system, without_pattern(system))[1] <= 20


CUT_CELL = {"plane_strain": 0.043, "axisymmetric": 0.043, "3d": 0.13}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_implicit_boundaries(kind: str, basis: str) -> None:
    """Penalties of 1e3 times the soil's stiffness on every side."""
    model = varied(
        squeezed(kind, basis, "roller", 1e-3),
        {"grid.cell_size": CUT_CELL[kind], "schedule.steps": 50},
    )
    system, right = systems_of(model)[0]
    assert solve(system, right)[1] <= 40
    assert solve(system, without_pattern(system))[1] <= 55


@pytest.mark.parametrize("n", [16, 32])
def test_iterations_do_not_grow_with_the_grid(n: int) -> None:
    counts = []
    for cells in (n, 2 * n):
        system, _ = systems_of(block("plane_strain", "linear", cells))[0]
        counts.append(solve(system, without_pattern(system))[1])
    assert counts[1] <= counts[0] + 3


def test_iterations_do_not_grow_with_the_grid_in_3d() -> None:
    counts = []
    for cells in (6, 12):
        system, _ = systems_of(block("3d", "linear", cells, anti_locking="f_bar"))[0]
        counts.append(solve(system, without_pattern(system))[1])
    assert counts[1] <= counts[0] + 4


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_two_cells_between_rollers(kind: str) -> None:
    """Both coarse nodes interpolate to the one free node between: a singular coarsest matrix."""
    upper = [1.0] * (dimension(kind) - 1) + [25.0]
    system, _ = systems_of(varied(block(kind, "linear", 2), {"bodies.0.shape.upper": upper}))[0]
    assert system.constrained.size > 200, "there are coarser levels"
    assert solve(system, without_pattern(system))[1] <= 20


def footing(**changes: Any) -> Model:
    """The strip footing's case on a coarse grid and with few large steps into the plateau."""
    coarse = {"grid.cell_size": 0.25, "schedule": {"steps": 6}}
    return varied(example("strip_footing"), {**coarse, **changes})


def strip_load() -> Model:
    """A pressure close to the limit load on a strip of the same clay; its ends move with it."""
    entries = footing().to_dict()
    del entries["boundaries"][-1], entries["track"]
    entries["bodies"][0]["surface"] = {}
    pressure = 5.0 / 3.0**0.5 * entries["materials"]["clay"]["yield_stress"]
    strip = {"start": [0.5, 5.0], "end": [0.0, 5.0], "pressure": pressure}
    entries["loads"] = [{"type": "surface", "body": "soil", **strip}]
    return Model.from_dict(entries)


@pytest.mark.parametrize("symmetric", [True, False])
def test_plastic_tangent(symmetric: bool) -> None:
    """Nearly a mechanism; a pressure that follows a strip's ends has an unsymmetric matrix."""
    system, right = systems_of(footing() if symmetric else strip_load(), steps=6)[-1]
    multigrid = Multigrid(system.active, system.constrained)
    multigrid.fill(system.blocks)
    assert (multigrid._asymmetry < multigrid_module.SYMMETRY_TOLERANCE) == symmetric
    assert system.exact_nodes[0].sum() > 10
    require_agreement(system, right, most=40)
    exactly = solve(system, right, 1e-4)[1]
    system.exact_nodes = []  # cycles alone take longer, but are right, too
    assert solve(system, right, 1e-4)[1] > exactly + 5


def test_the_first_chosen_nodes_that_are_few_enough_are_solved_exactly(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system, _ = systems_of(footing())[-1]
    few = np.zeros(system.active.nodes, dtype=bool)
    few[:3] = True
    monkeypatch.setitem(multigrid_module.EXACT_UNKNOWNS, 2, 6)
    multigrid = Multigrid(system.active, system.constrained)
    multigrid.fill(system.blocks, [np.ones_like(few), few])
    assert multigrid._exact is not None
    assert set(multigrid._exact.unknown // 2) <= {0, 1, 2}
    multigrid.fill(system.blocks, [np.ones_like(few)])
    assert multigrid._exact is None


def test_more_nodes_are_solved_exactly_once_fewer_have_failed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    system, right = systems_of(footing(), steps=6)[-1]
    monkeypatch.setitem(multigrid_module.EXACT_UNKNOWNS, 2, 6)
    monkeypatch.setattr(multigrid_module, "ITERATIONS_WITH_FEWER", 10)
    multigrid = Multigrid(system.active, system.constrained)
    multigrid.fill(system.blocks, system.exact_nodes)
    assert multigrid._exact is None
    found = multigrid.solve(right, 1e-4)
    assert found.residual <= 2e-4
    assert found.iterations < 20, "what cycles alone need"
    multigrid.fill(system.blocks, system.exact_nodes)
    assert multigrid._exact is not None, "the next system of the step begins with them"
    assert multigrid.begin(system.active, system.constrained)
    multigrid.fill(system.blocks, system.exact_nodes)
    assert multigrid._exact is None, "the next step does not"


def test_whole_run_gives_the_direct_solvers_result() -> None:
    found = {}
    for name in ("multigrid", "superlu"):
        simulation = Simulation(footing(**{"analysis.solver": name}))
        for step in range(4):
            simulation.advance(
                simulation.setup.model.schedule.regular_time(step),
                simulation.setup.model.schedule.regular_time(step + 1),
            )
        assert not any("direct solver" in text for text in simulation.services.warnings.texts)
        found[name] = simulation.state.points.displacement[
            simulation.state.points.index_of(np.arange(len(simulation.state.points)))
        ]
    largest = np.abs(found["superlu"]).max()
    np.testing.assert_allclose(found["multigrid"], found["superlu"], atol=1e-6 * largest)


@pytest.mark.usefixtures("every_loop_in_parallel")
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
def test_same_bits_for_any_number_of_threads(kind: str, anti_locking: str) -> None:
    more = {"cut": 0.7} if anti_locking == "none" else {"anti_locking": anti_locking}
    system, _ = systems_of(block(kind, "gimp", CELLS[kind], **more))[0]
    solutions = []
    for threads in (1, 2, 3):
        _core.set_threads(threads)
        solutions.append(solve(system, without_pattern(system))[0].tobytes())
    assert len(set(solutions)) == 1


@pytest.mark.parametrize("n", [1, 4095, 4097])
def test_fused_vector_operations(n: int) -> None:
    a, b, c, x = np.random.default_rng(0).normal(size=(4, n))
    assert _core.two_inner(a, b, c) == pytest.approx((float(a @ b), float(a @ c)), rel=1e-12)
    y = b.copy()
    _core.combine(2.0, a, -0.5, y)
    np.testing.assert_allclose(y, 2.0 * a - 0.5 * b, rtol=1e-14, atol=1e-14)
    moved, rest = x.copy(), c.copy()
    size = _core.advance(0.3, a, b, moved, rest)
    np.testing.assert_allclose(moved, x + 0.3 * a, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(rest, c - 0.3 * b, rtol=1e-14, atol=1e-14)
    assert size == pytest.approx(float(rest @ rest), rel=1e-12)


def test_asymmetry_is_that_of_the_matrix() -> None:
    system, _ = systems_of(block("plane_strain", "linear", 8))[0]
    system.blocks *= np.random.default_rng(0).uniform(0.5, 1.5, system.blocks.shape)
    constrained, active = system.constrained, system.active
    u, v = (np.where(constrained, 0.0, without_pattern(system, seed)) for seed in (1, 2))
    of_u, of_v = (np.where(constrained, 0.0, system.times(x)) for x in (u, v))
    expected = abs((u * of_v).sum() - (v * of_u).sum()) / np.linalg.norm(of_v)
    square, u_of_v, v_of_u = _core.asymmetry(
        2, active.row_start, active.column, system.blocks, constrained, u.ravel(), v.ravel()
    )
    found = abs(u_of_v - v_of_u) / np.sqrt(square)
    assert found == pytest.approx(expected, rel=1e-10)
    assert found > 1e-3


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_sixteen_bits_suffice_for_a_soft_layer_on_rock(kind: str) -> None:
    """A row's coefficients are stored relative to its largest: here 1e6 times the soil's own."""
    entries = block(kind, "linear", CELLS[kind], anti_locking="f_bar").to_dict()
    soil, (body,) = entries["materials"]["soil"], entries["bodies"]
    entries["materials"]["rock"] = soil | {"young_modulus": 1e6 * soil["young_modulus"]}
    below, above = (body["shape"] | {end: list(body["shape"][end])} for end in ("upper", "lower"))
    below["upper"][-1] = above["lower"][-1] = round(0.5 * CELLS[kind]) / CELLS[kind]
    entries["bodies"] = [
        body | {"shape": above},
        body | {"name": "base", "material": "rock", "shape": below},
    ]
    system, right = systems_of(Model.from_dict(entries))[0]
    assert solve(system, right)[1] <= 20
    assert solve(system, without_pattern(system))[1] <= 20


def test_nearly_incompressible_block() -> None:
    model = varied(
        block("3d", "linear", 8, anti_locking="f_bar"), {"materials.soil.poisson_ratio": 0.499}
    )
    system, _ = systems_of(model)[0]
    assert solve(system, without_pattern(system))[1] <= 60


def test_levels_kept_for_the_same_grid_give_the_same_bits() -> None:
    system, right = systems_of(block("plane_strain", "gimp", 24, cut=0.7))[0]
    kept = Multigrid(system.active, system.constrained)
    kept.fill(3.0 * system.blocks + 1.0)
    other = system.constrained.copy()
    other[np.flatnonzero(~other[:, 0])[0], 0] = True
    assert not kept.begin(system.active, other)
    assert kept.begin(system.active, system.constrained)
    kept.fill(system.blocks)
    fresh = Multigrid(system.active, system.constrained)
    fresh.fill(system.blocks)
    found = [solver.solve(right, TOLERANCE).x.tobytes() for solver in (kept, fresh)]
    assert found[0] == found[1]


def test_levels_are_rebuilt_only_for_another_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    systems = [systems_of(block("plane_strain", "linear", n))[0] for n in (24, 24, 25)]
    made: list[int] = []

    class Counted(Multigrid):
        def __init__(self, active: ActiveGrid, constrained: Flags) -> None:
            made.append(len(constrained))
            super().__init__(active, constrained)

    monkeypatch.setattr(linear_module, "Multigrid", Counted)
    solver = LinearSolver(choose_solver("superlu"), 0)
    for system, right in systems:
        of_step = solver.begin(system)
        for _ in range(2):  # iterations of Newton's method
            of_step.solve(right, TOLERANCE)
    assert made == [25**2, 26**2]


def test_summary_tells_systems_and_iterations() -> None:
    system, right = systems_of(block("plane_strain", "linear", 24))[0]
    solver = LinearSolver(choose_solver("superlu"), 0)
    assert solver.summary == "none"
    of_step = solver.begin(system)
    of_step.solve(right, TOLERANCE)
    most = solve(system, right)[1]
    of_step.solve(right, 1e-2)
    least = solve(system, right, 1e-2)[1]
    counts = f"{(most + least) / 2:.1f} iterations each, at most {most}"
    assert solver.summary == f"2 by multigrid ({counts})"
    system.blocks[:] = np.nan
    of_step.renew()
    with pytest.raises(SolveFailed):
        of_step.solve(right, TOLERANCE)
    assert solver.summary == f"2 by multigrid ({counts})"
    direct = LinearSolver(choose_solver("banded"))
    system, right = systems_of(block("plane_strain", "linear", 4))[0]
    direct.begin(system).solve(right, TOLERANCE)
    assert direct.summary == "1 by banded"


def test_gaps_and_negative_places_of_the_lattice() -> None:
    """Two pieces apart, off the origin: each is solved as if it were alone."""
    entries = block_entries("plane_strain", "linear", cells=1, loads=[weight("plane_strain", 1.0)])
    entries["grid"]["cell_size"] = 0.1
    piece = entries["bodies"][0]
    entries["bodies"] = [
        {**piece, "name": "low", "shape": {"type": "box", "lower": [-2.3, 0], "upper": [-1.1, 1]}},
        {**piece, "name": "far", "shape": {"type": "box", "lower": [0.9, 0], "upper": [2.0, 0.7]}},
    ]
    entries["boundaries"] = [
        plane("base", "y", 0.0, condition="fixed"),
    ]
    system, right = systems_of(Model.from_dict(entries))[0]
    require_agreement(system, right, most=25)


def test_zero_right_side() -> None:
    system, right = systems_of(block("plane_strain", "linear", 8))[0]
    multigrid = Multigrid(system.active, system.constrained)
    multigrid.fill(system.blocks)
    assert not multigrid.solve(np.zeros_like(right), TOLERANCE).x.any()


@pytest.mark.parametrize("case", ["too few iterations", "not a number", "indefinite"])
def test_unconverged_solution_is_refused(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    system, right = systems_of(block("plane_strain", "linear", 24))[0]
    if case == "too few iterations":
        monkeypatch.setattr(multigrid_module, "MAXIMUM_ITERATIONS", 3)
    elif case == "not a number":
        system.blocks[len(system.blocks) // 2] = np.nan
    else:
        system.blocks[::2] *= -1.0
    with pytest.raises(SolveFailed):
        solve(system, right)


def test_direct_solver_takes_over_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multigrid_module, "MAXIMUM_ITERATIONS", 2)
    simulation = Simulation(footing(**{"analysis.solver": "multigrid"}))
    result = simulation.advance(0.0, simulation.setup.model.schedule.regular_time(1))
    assert result.equilibrium.residuals[-1] <= simulation.setup.model.analysis.tolerance
    (warning,) = (text for text in simulation.services.warnings.texts if "direct solver" in text)
    assert "no solution in 2 iterations" in warning


@pytest.mark.parametrize("over", [-1, 1])
def test_small_systems_are_left_to_the_direct_solver(over: int) -> None:
    system, right = systems_of(block("plane_strain", "linear", 24))[0]
    told: list[str] = []
    solver = LinearSolver(choose_solver("superlu"), system.constrained.size + over, told.append)
    system.blocks[len(system.blocks) // 2] *= -1.0  # multigrid refuses what is not a stiffness
    solver.begin(system).solve(right, TOLERANCE)
    assert bool(told) == (over < 0)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_slender_system_is_as_large_as_it_is_thick(kind: str) -> None:
    """A direct solver's work for an unknown depends on the cross-section, not on the length."""
    dim, cells = dimension(kind), 4
    model = block(kind, "linear", cells)
    system = systems_of(model)[0][0]
    assert linear_module.effective_size(system) == pytest.approx(system.constrained.size, rel=1e-14)
    long = [1.0] * (dim - 1) + [5.0]
    system = systems_of(varied(model, {"bodies.0.shape.upper": long}))[0][0]
    assert system.constrained.size == dim * (cells + 1) ** (dim - 1) * (5 * cells + 1)
    assert linear_module.effective_size(system) == pytest.approx(
        dim * (cells + 1) ** dim, rel=1e-14
    )


def test_pieces_far_apart_are_left_to_the_direct_solver() -> None:
    entries = block_entries("plane_strain", "linear", cells=4, loads=[weight("plane_strain", 1.0)])
    piece = entries["bodies"][0]
    far = {"type": "box", "lower": [0.0, 1e5], "upper": [4.0, 1e5 + 4.0]}
    entries["bodies"].append({**piece, "name": "far", "shape": far})
    entries["boundaries"] = [
        plane("base", "y", 0.0, condition="fixed"),
        plane("high base", "y", 1e5, condition="fixed"),
    ]
    system, right = systems_of(Model.from_dict(entries))[0]
    told: list[str] = []
    x = LinearSolver(choose_solver("superlu"), 0, told.append).begin(system).solve(right, TOLERANCE)
    assert "far apart" in told[0]
    rest = np.where(system.constrained, 0.0, right - system.times(x))
    assert np.linalg.norm(rest) <= 1e-10 * np.linalg.norm(right)
