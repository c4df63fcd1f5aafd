# SPDX-License-Identifier: BSD-3-Clause
"""Soil that creeps to rest or on, mechanisms that the grid resolves, and equilibrated systems."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from tilth import AnalysisFailed, StrengthReduction
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.creep import CIRCLING, LEAST_SIZE, PSEUDO_STEPS, creep, crept_to_rest
from tilth.analysis.mechanism import moving_cells
from tilth.analysis.residual import Equations, Guess, Newton
from tilth.analysis.run_warnings import RunWarnings
from tilth.analysis.safety_search import MOST_UNDECIDED, Outcome, Search, Trial
from tilth.analysis.step import Equilibrium
from tilth.analysis.step_result import PreparedStep
from tilth.arrays import Floats
from tilth.comm import SERIAL
from tilth.errors import StepFailed
from tilth.grid.background import Grid
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints
from tilth.mpm.soil import Soil
from tilth.solvers.bordered_system import equilibrated
from tilth.solvers.protocol import Matrix
from tilth.terms.drag import Drag
from tilth.terms.space import Space

NEWTON = Newton(tolerance=1e-8, maximum_iterations=20, line_search=True, round_off={})

STIFF = cast(Soil, SimpleNamespace(flow=lambda displacement: None))
"""Soil that does not flow."""

START = Guess({"u": np.zeros((1, 1))})


class Slider:
    """A block on a plane: its strength holds the pull up to a distance, beyond which it is less.

    Newton's iteration finds its equilibrium from within `reach` only.
    """

    def __init__(self, pull: float, strength: float, reach: float) -> None:
        self.pull, self.strength, self.reach = pull, strength, reach
        self.drag = Drag(cast(Soil, None), np.ones(1), np.zeros((1, 1)))

    def solve(self, newton: Newton, guess: Guess) -> Equilibrium:
        """Stiffness 1 up to the strength: (u, pull - min(u, strength)) with the drag."""
        before, size = float(self.drag.before[0, 0]), self.drag.size
        if math.isinf(size):
            if self.pull > self.strength or abs(self.pull - float(guess.u[0, 0])) > self.reach:
                raise StepFailed("no equilibrium")
            u = self.pull
        else:
            u = (self.pull + before / size) / (1.0 + 1.0 / size)
            if u > self.strength:
                u = before + size * (self.pull - self.strength)
        moved = np.array([[u]])
        zero = np.zeros_like(moved)
        return Equilibrium(Unknowns({"u": moved}), zero, {"u": zero}, zero, [1.0, 0.0])

    @property
    def equations(self) -> Equations:
        """What is out of balance without the drag."""

        def at(x: Unknowns) -> SimpleNamespace:
            return SimpleNamespace(relative=self.pull - min(float(x.u[0, 0]), self.strength))

        return cast(Equations, SimpleNamespace(at=at))


def crept(slider: Slider) -> list[tuple[float, bool]]:
    path = creep(slider.solve, slider.drag, NEWTON, slider.equations, START, STIFF)
    return [(float(each.found.displacement[0, 0]), each.at_rest) for each in path]


def test_soil_with_an_equilibrium_creeps_to_it() -> None:
    slider = Slider(pull=0.9, strength=1.0, reach=0.05)
    path = crept(slider)
    moved = [u for u, _ in path]
    assert moved == sorted(moved)  # it does not overshoot
    assert path[-1] == (0.9, True)
    assert not any(at_rest for _, at_rest in path[:-1])
    assert math.isinf(slider.drag.size)  # the drag is gone


def test_soil_without_one_moves_on() -> None:
    path = crept(Slider(pull=1.1, strength=1.0, reach=10.0))
    moved = np.array([u for u, _ in path])
    assert len(path) == PSEUDO_STEPS
    assert (np.diff(moved[10:]) > 1.5 * np.diff(moved[9:-1])).all()  # steps twice as long each


def test_pseudo_steps_are_more_exact_than_what_the_drag_bears() -> None:
    """Soil that is in equilibrium but for little is led on to the analysis' own tolerance."""
    slider = Slider(pull=0.9, strength=1.0, reach=1e-6)
    tolerances = []

    def solve(newton: Newton, guess: Guess) -> Equilibrium:
        if math.isfinite(slider.drag.size):
            tolerances.append(newton.tolerance)
        return slider.solve(newton, guess)

    path = list(creep(solve, slider.drag, NEWTON, slider.equations, START, STIFF))
    assert path[-1].at_rest
    bound = [min(1e-5, max(0.1 * each.borne, NEWTON.tolerance)) for each in path[:-1]]
    assert tolerances == pytest.approx([1e-5, *bound[:-1]])
    assert min(tolerances) < 1e-5


def test_flow_is_past_once_soil_goes_round_in_a_circle() -> None:
    """Not before: while the drag bears much, soil flows where it later need not."""
    slider, past = Slider(pull=1.1, strength=1.0, reach=10.0), []
    soil = cast(Soil, SimpleNamespace(flow=lambda u: past.append(float(u[0, 0]))))
    path = creep(slider.solve, slider.drag, NEWTON, slider.equations, START, soil)
    moved = [float(each.found.displacement[0, 0]) for each in path]
    assert past == moved[CIRCLING:]


def test_pseudo_steps_that_take_many_iterations_do_not_grow() -> None:
    slider, sizes = Slider(pull=0.9, strength=1.0, reach=0.05), []

    def solve(newton: Newton, guess: Guess) -> Equilibrium:
        sizes.append(slider.drag.size)
        return replace(slider.solve(newton, guess), residuals=[1.0] * 30)

    path = creep(solve, slider.drag, NEWTON, slider.equations, START, STIFF)
    assert [each.at_rest for each in path][-1]
    assert set(sizes) == {1.0, math.inf}


@pytest.mark.parametrize(
    ("driven", "borne", "falls"), [(0.2, 5e-5, True), (0.2, 5e-4, False), (0.0, 5e-5, False)]
)
def test_a_little_soil_may_fall_beside_what_drives_it(
    driven: float, borne: float, falls: bool
) -> None:
    """But not without anything that drives it, nor much of it; and the run says so."""
    one, position = np.ones(1), np.array([[0.0, 0.0], [1.0, 2.0]])
    own = SimpleNamespace(
        elastic_moduli=lambda: SimpleNamespace(young=one), volume=one, position=position
    )
    told: list[float] = []
    warnings = SimpleNamespace(falls=lambda borne, time: told.append(borne))
    grid = SimpleNamespace(cell_size=np.full(2, 1e6))  # soil may fall deep
    active = SimpleNamespace(grid=grid, owned=np.array([True]), comm=SERIAL)
    step = SimpleNamespace(driven=driven, active=active, after=1.0)
    soil = SimpleNamespace(
        active=active, nodal_volume=one, interpolate=lambda u: u, flow=lambda u: None,
        kind="plane_strain",
    )  # fmt: skip
    slider = Slider(pull=1.1, strength=1.0, reach=10.0)
    equations = SimpleNamespace(at=lambda x: SimpleNamespace(relative=borne))
    found = crept_to_rest(
        cast(PreparedStep, step), cast(Soil, soil), cast(MaterialPoints, own),
        cast(RunWarnings, warnings), slider.solve,
        slider.drag, NEWTON, START, cast(Equations, equations), "",
    )  # fmt: skip
    assert (found is not None) == falls
    assert told == [borne] * falls
    if found is not None:
        assert found.residuals[-1] == borne
    assert math.isinf(slider.drag.size)


def test_it_gives_up_where_even_the_shortest_steps_fail() -> None:
    slider = Slider(pull=1.1, strength=1.0, reach=1.0)
    sizes = []

    def failing(newton: Newton, guess: Guess) -> Equilibrium:
        sizes.append(slider.drag.size)
        raise StepFailed("inverted")

    assert not list(creep(failing, slider.drag, NEWTON, slider.equations, START, STIFF))
    assert LEAST_SIZE <= min(sizes) < 4.0 * LEAST_SIZE


def test_the_drag_has_the_stiffness_of_its_force() -> None:
    """And neither once its pseudo-step is infinite."""
    random = np.random.default_rng(1)
    stiffness, before, u, along = 1.0 + random.random(3), *random.normal(size=(3, 3, 2))
    elastic = random.normal(size=(9, 2, 2))
    active = SimpleNamespace(
        diagonal=np.array([0, 4, 8]), row_start=np.arange(0, 10, 3),
        column=np.tile(np.arange(3, dtype=np.int32), 3),
    )  # fmt: skip

    def add_stiffness(pattern: ActiveGrid, blocks: Floats) -> None:
        blocks += elastic

    made = SimpleNamespace(update=lambda u: None, add_stiffness=add_stiffness)
    elastic_soil = cast(Soil, SimpleNamespace(without_strain=lambda factor: made))
    drag = Drag(elastic_soil, stiffness, before, size=0.25)
    term = drag.assembled(cast(Space, SimpleNamespace(active=active)), [])
    blocks = np.zeros((9, 2, 2))
    term.add_stiffness(u, blocks)
    matrix = blocks.reshape(3, 3, 2, 2)
    difference = term.force(u + along) - term.force(u)
    np.testing.assert_allclose(np.einsum("abij,bj->ai", matrix, along), difference, rtol=1e-12)
    whole = elastic.reshape(3, 3, 2, 2)
    moved = 4.0 * (u - before)
    expected = np.einsum("abij,bj->ai", whole, moved) + stiffness[:, None] * moved
    np.testing.assert_allclose(term.force(u), expected, rtol=1e-12)
    drag.size = math.inf
    term.add_stiffness(u, (none := np.zeros((9, 2, 2))))
    assert not term.force(u).any()
    assert not none.any()


def soil(cells: list[tuple[int, int]], volume: Floats | None = None) -> MaterialPoints:
    """One point in each of these cells of size 2; full ones, if no volumes are given."""
    position = 2.0 * np.array(cells, dtype=float) + 1.0
    volume = np.full(len(cells), 4.0) if volume is None else volume
    return cast(MaterialPoints, SimpleNamespace(position=position, volume=volume))


GRID = Grid(np.zeros(2), np.full(2, 2.0))
WHOLE = [(i, j) for i in range(-3, 6) for j in range(-2, 5)]


def mechanism(moving: list[tuple[int, int]], cells: list[tuple[int, int]] = WHOLE) -> int:
    moves = np.array([each in moving for each in cells])
    return moving_cells(soil(cells), moves, GRID, False, SERIAL)


def block(x: range, y: range) -> list[tuple[int, int]]:
    return [(i, j) for i in x for j in y]


def test_a_mechanism_is_three_cells_wide() -> None:
    assert mechanism([]) == 0
    assert mechanism([(0, 0)]) == 0
    assert mechanism(block(range(-3, 6), range(3, 5))) == 0  # a skin of two cells
    assert mechanism([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)]) == 5
    # the corners of a block are in no cross; a second block apart is another mechanism
    assert mechanism(block(range(-3, 1), range(-2, 2)) + block(range(2, 5), range(-2, 1))) == 12


def test_soil_of_few_cells_is_its_own_measure() -> None:
    row = block(range(6), range(1))
    assert mechanism(block(range(3), range(1)), row) == 3
    assert mechanism(block(range(2), range(1)), row) == 0
    assert mechanism([(0, 0)], block(range(2), range(2))) == 1


def test_cells_that_are_less_than_half_full_do_not_count() -> None:
    moving = block(range(3), range(3))
    slivers = soil(WHOLE, np.where([j == 0 for _, j in WHOLE], 1.9, 4.0))
    moves = np.array([each in moving for each in WHOLE])
    assert moving_cells(slivers, moves, GRID, False, SERIAL) == 0
    assert mechanism(moving) == 5


def searched(outcome: dict[str, float], tolerance: float = 0.01) -> Search:
    """A search with equilibrium up to "stable", collapse from "collapse" on, between undecided."""
    search = Search(StrengthReduction(tolerance=tolerance, maximum_factor=5.0))
    while (factor := search.next_factor()) is not None:
        if factor <= outcome["stable"]:
            search.record(Trial(factor, 0.0, 1, Outcome.EQUILIBRIUM))
        elif not search.pursues:
            search.record(Trial(factor, math.nan, 1, Outcome.DEFERRED, "Newton"))
        elif factor < outcome["collapse"]:
            search.record(Trial(factor, math.nan, 1, Outcome.UNDECIDED, "neither", True))
        else:
            search.record(Trial(factor, 1.0, 1, Outcome.COLLAPSE, "moves", True))
        assert len(search.trials) < 60
    return search


def test_a_decided_factor() -> None:
    search = searched({"stable": 1.537, "collapse": 1.537})
    assert search.stable is not None
    assert search.stable <= 1.537 < search.above <= search.stable + 0.01 + 1e-9
    assert search.undecided == []


@pytest.mark.parametrize("collapse", [1.56, 1.9, math.inf])
def test_undecided_trials_widen_the_bracket(collapse: float) -> None:
    """What is certain is the greatest equilibrium and the least collapse, if there is one."""
    search = searched({"stable": 1.5, "collapse": collapse})
    assert search.stable is not None
    assert 1.48 <= search.stable <= 1.5
    assert search.above >= collapse
    if math.isfinite(search.above):
        assert search.above <= collapse + 0.2
    assert 0 < len(search.undecided) <= MOST_UNDECIDED
    assert all(search.stable < each < search.above for each in search.undecided)


def test_an_undecided_trial_at_factor_one_is_an_error() -> None:
    with pytest.raises(AnalysisFailed, match=r"factor 1 is not found again \(neither\): this"):
        searched({"stable": 0.5, "collapse": 2.0})


def test_an_established_collapse_at_factor_one_is_none() -> None:
    search = searched({"stable": 0.7, "collapse": 0.7})
    assert search.stable is not None
    assert 0.68 <= search.stable <= 0.7 < search.above


def test_where_soil_had_to_creep_it_may_always() -> None:
    """A trial that failed from afar says nothing then, and the factor goes on growing."""
    search = Search(StrengthReduction())
    tried = []
    while (factor := search.next_factor()) is not None and factor < 2.0:
        tried.append(factor)
        if factor > 1.15 and not search.pursues:
            search.record(Trial(factor, math.nan, 1, Outcome.DEFERRED, "Newton"))
        else:
            search.record(Trial(factor, 0.0, 1, Outcome.EQUILIBRIUM, crept=factor > 1.15))
    first = next(i for i, trial in enumerate(search.trials) if trial.crept)
    assert all(trial.in_equilibrium for trial in search.trials[first:])
    assert len(tried) - first < 12


def test_equilibration_loses_no_digit() -> None:
    random = np.random.default_rng(3)
    dense = random.normal(size=(6, 6)) * 10.0 ** random.integers(-9, 9, (6, 1))
    dense *= 10.0 ** random.integers(-9, 9, 6)
    dense[2, 3] = 0.0
    start = np.arange(0, 37, 6, dtype=np.int32)
    rows = np.tile(np.arange(6, dtype=np.int32), 6)
    scaled, by_row, by_column = equilibrated(Matrix(dense.T.ravel().copy(), rows, start))
    found = scaled.data.reshape(6, 6).T
    np.testing.assert_array_equal(found / by_row[:, None] / by_column, dense)
    assert np.linalg.cond(found) < 1e-6 * np.linalg.cond(dense)
    assert 0.1 < np.abs(found).max(axis=0).min() <= np.abs(found).max() < 4.0
