# SPDX-License-Identifier: BSD-3-Clause
"""Every solver solves the systems of several fields as Gaussian elimination of the full matrix."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from coupled_blocks import PRESSURE, Block, dense_solution, right_side, system_of
from processes import run_together

from tilth.algebra.border import Border
from tilth.algebra.unknowns import Unknowns
from tilth.arrays import Integers
from tilth.comm import Communicator
from tilth.solvers import (
    SOLVERS,
    SolveFailed,
    block_multigrid,
    linear_solver,
    member_patch,
    multigrid,
)
from tilth.solvers.block_multigrid import BlockMultigrid
from tilth.solvers.coupled import begin_system
from tilth.solvers.coupled_direct import WholeMatrix
from tilth.solvers.free_unknowns import FreeUnknowns
from tilth.solvers.row_scaling import RowScaling
from tilth.solvers.schwarz import SchwarzMultigrid
from tilth.solvers.system import LinearSystem

DIRECT = [name for name, solver in SOLVERS.items() if solver.available()]
NAMES = [*DIRECT, "multigrid", "auto"]
BLOCKS = {
    "water": Block((8, 6)),
    "water, stored": Block((8, 6), storage=0.3, step=1.0),
    "unsymmetric": Block((8, 6), skew=1.0),
    "wet in part": Block((8, 6), wet=0.6, skew=1.0),
    "border": Block((8, 6), unknowns=2, skew=1.0),
    "member": Block((8, 6), has_pile=True),
    "member, dry": Block((8, 6), has_pile=True, has_water=False),
    "everything": Block((8, 6), has_pile=True, unknowns=3, skew=1.0, wet=0.6),
    "in space": Block((4, 3, 3), wet=0.7, skew=1.0),
    "everything in space": Block((4, 3, 3), has_pile=True, unknowns=2, skew=1.0),
}

every_solver = pytest.mark.parametrize("name", NAMES)
every_block = pytest.mark.parametrize("kind", BLOCKS)


def assert_same(found: Unknowns, expected: Unknowns, share: float = 1e-8) -> None:
    assert found.of.keys() == expected.of.keys()
    for name, each in expected.of.items():
        largest = np.abs(each).max()
        np.testing.assert_allclose(found.of[name], each, rtol=0, atol=share * largest)
    np.testing.assert_allclose(found.globals, expected.globals, rtol=share)


@every_solver
@every_block
def test_solution_is_that_of_the_full_matrix(name: str, kind: str) -> None:
    """Of a first matrix, and of a second one that is renewed; multigrid may not leave its work."""
    block = BLOCKS[kind]
    system, right = system_of(block), right_side(system_of(block), block)
    solver = linear_solver(name, block.dim, 0, pytest.fail)
    of_step = begin_system(solver, system)
    for factor in (1.0, 3.0):
        system.matrix.memory *= factor
        system.schur = {each: factor * values for each, values in system.schur.items()}
        of_step.renew(similar=factor > 1.0)
        found = of_step.solve(right, 1e-11)
        assert_same(found, dense_solution(system, right))
        for each, values in found.of.items():
            assert not values[system.constrained[each]].any()


@every_solver
@pytest.mark.parametrize("unknowns", [0, 2])
def test_one_field_alone_has_the_bits_of_its_own_solver(name: str, unknowns: int) -> None:
    block = Block((8, 6), has_water=False, unknowns=unknowns)
    system = system_of(block)
    right = right_side(system, block)
    solver, own = (linear_solver(name, 2, 0, pytest.fail) for _ in range(2))
    of_step = begin_system(solver, system)
    found = of_step.solve(right, 1e-8)
    of_displacement = system_of(block).displacement
    of_displacement.border = system.matrix.border
    alone = own.begin(of_displacement)
    x, g = alone.solve_bordered(right.u, right.globals, 1e-8)
    np.testing.assert_array_equal(found.u, x)
    np.testing.assert_array_equal(found.globals, g)
    assert solver.summary == own.summary
    assert of_step.by_multigrid == alone.by_multigrid


def test_band_factors_of_a_slender_body() -> None:
    """Where no global unknown and no member widens the band."""
    for block, chosen in (
        (Block((2, 40)), "banded"),
        (Block((2, 40), unknowns=1), "superlu"),
        (Block((2, 40), has_pile=True), "superlu"),
        (Block((12, 12)), "superlu"),
    ):
        system = system_of(block)
        solver = linear_solver("auto", 2, 0, pytest.fail)
        right = right_side(system, block)
        assert_same(begin_system(solver, system).solve(right, 1e-8), dense_solution(system, right))
        assert solver.direct_systems == Counter([chosen])


@every_solver
def test_soil_that_only_a_rigid_body_supports(name: str) -> None:
    """The matrix of the fields is singular, that with the global unknowns is not."""
    block = Block((6, 6), unknowns=3)
    system, notes = system_of(block), list[str]()
    system.constrained["u"][:] = False
    place = system.displacement.active.position
    motions = np.stack([np.ones_like(place), np.ones_like(place), place[:, ::-1]])
    motions[0, :, 1] = motions[1, :, 0] = 0.0
    motions[2, :, 0] *= -1.0
    system.matrix.border = Border(motions, motions, np.zeros((3, 3)), np.full(3, 1e-7))
    right = right_side(system, block)
    solver = linear_solver(name, 2, 0, notes.append)
    found = begin_system(solver, system).solve(right, 1e-10)
    assert_same(found, dense_solution(system, right), 1e-6)


@every_solver
def test_singular_equations_of_global_unknowns_are_refused(name: str) -> None:
    """Two of them are the same."""
    block = Block((6, 6), unknowns=2)
    system, notes = system_of(block), list[str]()
    border = system.matrix.border
    assert border is not None
    border.columns[1], border.rows[1] = border.columns[0], border.rows[0]
    border.corner[:] = border.corner[0, 0]
    right = right_side(system, block)
    right.globals[:] = 1.0
    with pytest.raises(SolveFailed, match="singular"):
        begin_system(linear_solver(name, 2, 0, notes.append), system).solve(right, 1e-8)
    assert len(notes) == (name == "multigrid")


@every_solver
@pytest.mark.parametrize("case", ["not held", "no pressure", "not a number"])
def test_failures(name: str, case: str) -> None:
    block = Block((6, 6))
    system, notes = system_of(block), list[str]()
    match = "singular"
    if case == "not held":
        system.constrained["u"][:] = False
    elif case == "no pressure":
        for pair in (("u", PRESSURE), (PRESSURE, "u"), (PRESSURE, PRESSURE)):
            system.matrix[pair].values[:] = 0.0
        system.schur[PRESSURE][:] = 0.0
    else:
        system.matrix[PRESSURE, "u"].values[-1] = np.nan
        system.constrained[PRESSURE][:] = False
        match = "not numbers"
    right = right_side(system, block)
    with pytest.raises(SolveFailed, match=match):
        begin_system(linear_solver(name, 2, 0, notes.append), system).solve(right, 1e-8)
    assert len(notes) == (name == "multigrid")


def test_the_direct_solver_takes_over_for_the_rest_of_the_step() -> None:
    """No iteration reaches a residual below round-off; the next step tries it again."""
    block = BLOCKS["everything"]
    system, notes = system_of(block), list[str]()
    right = right_side(system, block)
    solver = linear_solver("multigrid", 2, 0, notes.append)
    of_step = begin_system(solver, system)
    assert of_step.by_multigrid
    for _ in range(2):
        of_step.renew()
        assert_same(of_step.solve(right, 1e-18), dense_solution(system, right))
        assert not of_step.by_multigrid
    assert len(notes) == 1
    assert solver.direct_systems == Counter(superlu=2)
    assert begin_system(solver, system).by_multigrid


def test_more_nodes_are_solved_exactly_where_the_iteration_is_slow(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As for the displacement alone; here all nodes of the displacement."""
    block = Block((16, 16), poisson=0.49, step=1.0, storage=100.0, unknowns=1)
    system = system_of(block)
    right = right_side(system, block)
    usual = linear_solver("multigrid", 2, 0, pytest.fail)
    begin_system(usual, system).solve(right, 1e-9)
    system.displacement.exact_nodes = [np.ones(system.displacement.active.nodes, dtype=bool)]
    monkeypatch.setattr(multigrid, "EXACT_UNKNOWNS", {2: 10})
    monkeypatch.setattr(block_multigrid, "ITERATIONS_WITH_FEWER", 3)
    solver = linear_solver("multigrid", 2, 0, pytest.fail)
    assert_same(
        begin_system(solver, system).solve(right, 1e-9), dense_solution(system, right), 1e-6
    )
    assert solver.iterations[0] < usual.iterations[0]


def test_levels_of_another_matrix_are_made_anew_where_they_fail(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    block = BLOCKS["water"]
    system, drained = system_of(block), system_of(replace(block, poisson=0.45, step=1.0))
    right = right_side(system, block)
    solver = linear_solver("multigrid", 2, 0, pytest.fail)
    of_step = begin_system(solver, system)
    of_step.solve(right, 1e-9)
    system.matrix.memory[:] = drained.matrix.memory
    system.schur = drained.schur
    monkeypatch.setattr(block_multigrid, "MAXIMUM_ITERATIONS", 10)
    of_step.renew(similar=True)
    assert_same(of_step.solve(right, 1e-9), dense_solution(system, right), 1e-6)
    assert of_step.by_multigrid


def test_the_unit_of_the_pressure_does_not_matter() -> None:
    """Equations of water are compared with forces by the matrix, not by their numbers."""
    found: list[tuple[str, Unknowns]] = []
    for unit in (1.0, 2.0**20):
        system = system_of(BLOCKS["water"])
        right = right_side(system, BLOCKS["water"])
        system.matrix["u", PRESSURE].values[:] *= unit
        system.matrix[PRESSURE, "u"].values[:] *= unit
        system.matrix[PRESSURE, PRESSURE].values[:] *= unit**2
        system.schur[PRESSURE] *= unit**2
        right.of[PRESSURE][:] *= unit
        for name in ("superlu", "multigrid"):
            solver = linear_solver(name, 2, 0, pytest.fail)
            x = begin_system(solver, system).solve(right, 1e-8)
            x.of[PRESSURE][:] *= unit
            found.append((solver.summary, x))
    for (text, x), (text_in_unit, in_unit) in zip(found[:2], found[2:], strict=True):
        assert text == text_in_unit
        for each, values in x.of.items():
            np.testing.assert_array_equal(values, in_unit.of[each])


def test_residuals_become_forces() -> None:
    """The factors of rows give all equations the diagonal of the displacement, but for rounding."""
    system = system_of(Block((8, 6), step=1.0))
    factor = RowScaling(system).factors()
    assert (factor["u"] == 1.0).all()
    of_u = np.einsum("eii->ei", system.matrix["u", "u"].values[system.displacement.active.diagonal])
    schur = system.schur[PRESSURE]
    diagonal = np.sort(-schur.ravel())[-system.displacement.active.nodes // 2 :]
    ratio = np.median(diagonal) * factor[PRESSURE][0] ** 2 / np.median(of_u)
    assert 0.25 < ratio < 4.0


def iterations(block: Block, cells: int) -> int:
    block = replace(block, cells=(cells,) * block.dim)
    system = system_of(block)
    solver = linear_solver("multigrid", block.dim, 0, pytest.fail)
    begin_system(solver, system).solve(right_side(system, block), 1e-8)
    return solver.iterations[0]


def flat(block: Block, cells: tuple[int, ...], most: int) -> None:
    found = [iterations(block, each) for each in cells]
    assert max(found) <= most
    assert max(found) <= found[0] + 2


STEPS = (1e-8, 1e-2, 1.0)
"""From undrained to drained."""


@pytest.mark.parametrize("step", STEPS)
def test_iterations_do_not_grow_with_the_grid(step: float) -> None:
    flat(Block((1, 1), step=step), (16, 32), 15)


@pytest.mark.slow
@pytest.mark.parametrize("step", [*STEPS, 1e-4, 10.0])
@pytest.mark.parametrize("poisson", [0.2, 0.45])
def test_iterations_do_not_grow_with_the_grid_up_to_48(step: float, poisson: float) -> None:
    flat(Block((1, 1), step=step, poisson=poisson), (16, 32, 48), 15)


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_iterations_do_not_grow_with_the_grid_in_space(step: float) -> None:
    flat(Block((1, 1, 1), step=step), (6, 12, 18), 15)


@pytest.mark.slow
@pytest.mark.parametrize("step", STEPS)
def test_iterations_with_a_member(step: float) -> None:
    """They grow a little: coarse levels hold the soil by the springs to the member."""
    for block, cells in (
        (Block((1, 1), step=step), (16, 48)),
        (Block((1, 1, 1), step=step), (18,)),
    ):
        assert max(iterations(replace(block, has_pile=True), each) for each in cells) <= 25


def test_members_and_the_soil_that_they_touch_are_solved_together(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Members alone take more iterations."""
    block = Block((1, 1), has_pile=True, has_water=False)
    together = iterations(block, 16)
    monkeypatch.setattr(member_patch, "INCREASED_EXACT_UNKNOWNS", {2: 10})
    alone = iterations(block, 16)
    assert together <= 14
    assert alone > 2 * together


def test_unknowns_of_a_node_are_eliminated_together() -> None:
    """In the order of nested dissection; those of the member come last."""
    block = BLOCKS["everything"]
    system = system_of(block)
    unknowns = FreeUnknowns(system)
    solver = linear_solver("superlu", 2, 0, pytest.fail)
    order = WholeMatrix(system, unknowns, solver)._order
    node = np.full(unknowns.count, -1)
    for name in ("u", PRESSURE):
        number = unknowns.number[name]
        nodes = np.repeat(np.arange(len(number))[:, None], number.shape[1], axis=1)
        node[number[number >= 0]] = nodes[number >= 0]
    along = node[order]
    changes = np.count_nonzero(np.diff(along)) + 1
    assert changes == len(np.unique(along))
    members = system.constrained["pile"].size
    assert (along[-members:] == -1).all()
    assert (along[:-members] >= 0).all()


class Cycles:
    """Makes the cycles of several processes, see `CycleMaker`."""

    def cycle(self, system: LinearSystem, name: str) -> SchwarzMultigrid:
        return SchwarzMultigrid(system)


@pytest.mark.parametrize("processes", [2, 3])
@every_block
def test_block_multigrid_of_processes(processes: int, kind: str) -> None:
    """The solution of one process in hardly more iterations."""
    block = BLOCKS[kind]
    whole = system_of(block)
    right = right_side(whole, block)
    expected = dense_solution(whole, right)
    solver = linear_solver("multigrid", block.dim, 0, pytest.fail)
    begin_system(solver, whole).solve(right, 1e-10)

    def work(comm: Communicator) -> tuple[Integers, Unknowns, int]:
        system = system_of(block, comm)
        levels = BlockMultigrid(system, FreeUnknowns(system), Cycles())
        levels.fill()
        found, steps = levels.solve(right_side(system, block), 1e-10)
        return system.displacement.active.key, found, steps

    for key, found, steps in run_together(processes, work):
        place = np.searchsorted(whole.displacement.active.key, key)
        of = {name: each if name == "pile" else each[place] for name, each in expected.of.items()}
        assert steps <= solver.iterations[0] + 6
        for name, each in of.items():
            atol = 1e-7 * np.abs(expected.of[name]).max()
            np.testing.assert_allclose(found.of[name], each, rtol=0, atol=atol)
        np.testing.assert_allclose(found.globals, expected.globals, rtol=1e-7)
