# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers: true residuals, singular matrices, the restricted system, ordering."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from small_problems import (
    BASES,
    KINDS,
    Laboratory,
    block_entries,
    deformed_laboratory,
    dimension,
)

from tilth import BadInput, Model, _core
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import forcing_term
from tilth.mpm.active_grid import Buffers, locate
from tilth.solvers import SOLVERS, LinearSolver, LinearSystem, SolveFailed, choose_solver
from tilth.solvers.banded import BandedLU
from tilth.solvers.protocol import Matrix

INSTALLED = [name for name, solver in SOLVERS.items() if solver.available()]
every_solver = pytest.mark.parametrize("name", INSTALLED)


def random_matrix(n: int, symmetric: bool) -> sp.csc_matrix:
    random = np.random.default_rng(n)
    matrix = sp.random(n, n, density=min(1.0, 8 / n), random_state=n, format="csc")
    if symmetric:
        matrix = matrix + matrix.T
    shift = sp.diags(random.uniform(2, 3, n) + np.abs(matrix).sum(axis=1).A1)
    return sp.csc_matrix(matrix + shift)


def columns(matrix: Any) -> Matrix:
    """A matrix of SciPy's as the solvers take it."""
    matrix = sp.csc_matrix(matrix)
    return Matrix(*(getattr(matrix, name).copy() for name in ("data", "indices", "indptr")))


@pytest.mark.parametrize("n", [1, 30])
def test_product_in_columns(n: int) -> None:
    matrix = random_matrix(n, False)
    x = np.random.default_rng(0).normal(size=n)
    np.testing.assert_allclose(columns(matrix).times(x), matrix @ x, rtol=1e-14)


@every_solver
@pytest.mark.parametrize("n", [1, 2, 50, 400])
@pytest.mark.parametrize("symmetric", [True, False])
def test_solution_and_its_true_residual(name: str, n: int, symmetric: bool) -> None:
    matrix = random_matrix(n, symmetric)
    exact = np.random.default_rng(0).normal(size=n)
    solver = choose_solver(name)
    solver.setup(columns(matrix))
    solution = solver.solve(matrix @ exact)
    np.testing.assert_allclose(solution.x, exact, rtol=1e-10, atol=1e-12)
    rest = np.linalg.norm(matrix @ exact - matrix @ solution.x) / np.linalg.norm(matrix @ exact)
    assert solution.residual == pytest.approx(rest, abs=1e-16)
    assert solution.residual < 1e-12


@every_solver
def test_zero_right_side_needs_no_solve(name: str) -> None:
    solver = choose_solver(name)
    solver.setup(columns(random_matrix(10, True)))
    solution = solver.solve(np.zeros(10))
    assert not solution.x.any()
    assert solution.residual == 0.0


@every_solver
def test_setup_replaces_the_matrix_before(name: str) -> None:
    """No memory beyond the last setup, also for a matrix of the same pattern."""
    solver = choose_solver(name)
    matrix = random_matrix(30, True)
    solver.setup(columns(matrix))
    solver.solve(np.ones(30))
    solver.setup(columns(2.0 * matrix))
    np.testing.assert_allclose(2.0 * matrix @ solver.solve(np.ones(30)).x, np.ones(30), rtol=1e-12)


@every_solver
@pytest.mark.parametrize("case", ["zero row", "floating block", "not a number"])
def test_singular_matrix_is_refused(name: str, case: str) -> None:
    matrix = random_matrix(20, True).tolil()
    if case == "zero row":
        matrix[3, :] = 0.0
        matrix[:, 3] = 0.0
    elif case == "floating block":  # a spring between two unknowns that nothing else holds
        matrix[4:6, :] = 0.0
        matrix[:, 4:6] = 0.0
        matrix[4:6, 4:6] = [[1.0, -1.0], [-1.0, 1.0]]
    else:
        matrix[2, 2] = np.nan
    solver = choose_solver(name)
    reason = "entries that are not numbers" if case == "not a number" else "singular"
    with pytest.raises(SolveFailed, match=reason), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        solver.setup(columns(matrix))
        solver.solve(np.ones(20))


def test_auto_takes_the_first_installed_solver() -> None:
    assert type(choose_solver("auto")) is SOLVERS[INSTALLED[0]]
    assert "superlu" in INSTALLED


def test_missing_solver_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(SOLVERS["pardiso"], "available", classmethod(lambda cls: False))
    with pytest.raises(BadInput, match=r"pip install") as error:
        choose_solver("pardiso")
    assert error.value.key == "analysis.solver"
    assert type(choose_solver("auto")) is SOLVERS["superlu"]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_restricted_system_is_the_whole_one_on_the_free_unknowns(kind: str, basis: str) -> None:
    random = np.random.default_rng(0)
    laboratory = deformed_laboratory(kind, basis, "von_mises", random)
    still = np.zeros(laboratory.active.position.shape)
    whole = laboratory.stiffness(still).toarray()
    fixed = random.uniform(size=still.shape) < 0.3
    system = LinearSystem(laboratory.active, fixed)
    system.blocks[:] = 0.0
    laboratory.soil.add_stiffness(laboratory.active, system.blocks)
    assert np.array_equal(np.sort(system.free), np.flatnonzero(~fixed.ravel()))
    expected = whole[np.ix_(system.free, system.free)]
    assert np.array_equal(system.matrix().in_scipy().toarray(), expected)
    u = random.normal(size=still.shape)
    np.testing.assert_allclose(system.times(u).ravel(), whole @ u.ravel(), rtol=1e-12, atol=1e-9)


@every_solver
@pytest.mark.parametrize("kind", KINDS)
def test_solvers_agree_on_a_stiffness(name: str, kind: str) -> None:
    laboratory = Laboratory.of(kind, "gimp", "hencky_elastic", np.random.default_rng(1))
    active = laboratory.active
    fixed = np.zeros(active.position.shape, dtype=bool)
    fixed[active.position[:, -1] <= 0.0] = True
    laboratory.soil.update(np.zeros(fixed.shape))
    system = LinearSystem(active, fixed)
    system.blocks[:] = 0.0
    laboratory.soil.add_stiffness(active, system.blocks)
    rows = np.arange(active.nodes)
    for k in range(dimension(kind)):
        system.blocks[active.diagonal[rows], k, k] += 1.0
    matrix = system.matrix()
    right = np.random.default_rng(2).normal(size=len(system.free))
    solver = choose_solver(name)
    solver.setup(matrix)
    np.testing.assert_allclose(
        solver.solve(right).x,
        np.linalg.solve(matrix.in_scipy().toarray(), right),
        rtol=1e-8,
        atol=1e-10,
    )


@pytest.mark.parametrize("shape", [(1, 1, 1), (30, 1, 1), (12, 9, 1), (6, 7, 5), (100, 2, 3)])
@pytest.mark.parametrize("reach", [1, 2])
def test_nested_dissection_is_a_permutation(shape: tuple[int, int, int], reach: int) -> None:
    places = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1).reshape(-1, 3)
    random = np.random.default_rng(0)
    kept = places[random.uniform(size=len(places)) < 0.8]
    if len(kept) == 0:
        kept = places
    order = np.asarray(_core.nested_dissection(np.ascontiguousarray(kept - 7), reach))
    assert np.array_equal(np.sort(order), np.arange(len(kept)))


def test_nested_dissection_separates_and_saves_fill() -> None:
    n = 40
    places = np.stack(np.meshgrid(np.arange(n), np.arange(n), [0]), axis=-1).reshape(-1, 3)
    order = np.asarray(_core.nested_dissection(np.ascontiguousarray(places), 1))
    near = np.abs(places[:, None, :2] - places[None, :, :2]).max(axis=2) <= 1
    matrix = sp.csc_matrix(near * -1.0 + 12.0 * np.eye(n * n))
    last = places[order[-n:]]  # the last unknowns are one whole grid line: the first separator
    assert np.ptp(last[:, 0]) == 0 or np.ptp(last[:, 1]) == 0

    def fill(p: np.ndarray) -> int:
        factors = sp.linalg.splu(
            matrix[p][:, p], permc_spec="NATURAL", options={"SymmetricMode": True}
        )
        return int(factors.L.nnz)

    assert fill(order) < 0.6 * fill(np.arange(n * n))


@pytest.mark.parametrize(("cells", "banded"), [([2, 60], True), ([60, 2], True), ([30, 30], False)])
def test_narrow_bands_are_left_to_the_banded_solver(cells: list[int], banded: bool) -> None:
    entries = block_entries("plane_strain", "gimp", cells=1)
    entries["grid"]["cell_size"] = 0.1
    entries["bodies"][0]["shape"]["upper"] = [0.1 * count for count in cells]
    simulation = Simulation(Model.from_dict(entries))
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    system = LinearSystem(active, np.zeros((active.nodes, 2), dtype=bool))
    system.blocks[:] = 0.0
    system.blocks[active.diagonal] = np.eye(2)
    asked = []

    class Asked(BandedLU):
        def setup(self, matrix: Matrix, near_null_space: Any = None) -> None:
            asked.append(matrix)
            super().setup(matrix)

    right_side = np.random.default_rng(0).normal(size=(active.nodes, 2))
    solver = LinearSolver(choose_solver("superlu"), banded=Asked())
    of_step = solver.begin(system)
    for _ in range(2):
        np.testing.assert_allclose(of_step.solve(right_side, 0.0), right_side, rtol=1e-14)
    assert len(asked) == (2 if banded else 0)


def test_band_is_recomputed_where_the_pattern_changes() -> None:
    """Matrices of other sizes and patterns in turn, the first one twice."""
    solver = BandedLU()
    for n, symmetric in ((40, True), (40, True), (40, False), (25, True)):
        matrix = random_matrix(n, symmetric)
        solver.setup(columns(matrix))
        np.testing.assert_allclose(matrix @ solver.solve(np.ones(n)).x, np.ones(n), rtol=1e-12)


@pytest.mark.parametrize("pattern", ["tridiagonal", "arrow", "two pieces"])
def test_rows_are_interchanged_in_a_band(pattern: str) -> None:
    """Matrices with zeros on the diagonal, unsymmetric in their values."""
    random = np.random.default_rng(3)
    n = 40
    distance = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    full = np.where((distance > 0) & (distance <= 2), random.normal(size=(n, n)), 0.0)
    if pattern == "arrow":
        full[0], full[:, 0] = random.normal(size=(2, n))
    elif pattern == "two pieces":
        full[:18, 18:] = full[18:, :18] = 0.0
    order = random.permutation(n)
    full = full[np.ix_(order, order)]
    exact = random.normal(size=n)
    solver = BandedLU()
    solver.setup(columns(full))
    np.testing.assert_allclose(solver.solve(full @ exact).x, exact, rtol=1e-9, atol=1e-9)


def test_the_band_is_as_narrow_as_the_body() -> None:
    """Of a lattice of 3 by 50 nodes, numbered at random: a slice and one node more."""
    random = np.random.default_rng(0)
    places = np.stack(np.meshgrid(np.arange(50), np.arange(3), indexing="ij"), axis=-1)
    places = random.permutation(places.reshape(-1, 2))
    near = np.abs(places[:, None] - places[None]).max(axis=2) <= 1
    matrix = columns(10.0 * np.eye(150) - near)
    assert _core.BandFactors(matrix.indptr, matrix.indices).widths() == [4, 8]


def test_connected_parts_of_a_pattern() -> None:
    links = sp.random(60, 60, density=0.01, random_state=1, format="csr")
    links = sp.csr_matrix(links + links.T + sp.eye(60))
    parts = np.asarray(_core.connected_parts(links.indptr.astype(np.int64), links.indices))
    count, expected = sp.csgraph.connected_components(links, directed=False)
    assert 1 < count < 60
    assert np.array_equal(parts, expected)


@pytest.mark.parametrize(
    ("relative", "tolerance", "share"),
    [(1.0, 1e-9, 1e-4), (1e-6, 1e-9, 1e-4), (1e-7, 1e-9, 1e-3), (2e-9, 1e-9, 1e-2)],
)
def test_linear_tolerance_follows_the_residual(
    relative: float, tolerance: float, share: float
) -> None:
    assert forcing_term(relative, tolerance) == pytest.approx(share)
    assert share * relative >= 0.01 * tolerance  # never more accurate than it is worth


def test_inner_product_in_pieces() -> None:
    random = np.random.default_rng(0)
    for n in (0, 1, 4095, 4096, 4097, 10000):
        a, b = random.normal(size=(2, n))
        assert _core.inner(a, b) == pytest.approx(float(a @ b), rel=1e-12, abs=1e-12)
