# SPDX-License-Identifier: BSD-3-Clause
"""A field on nodes of its own, a bar with skin springs, coupled to the soil."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import block_entries, dimension, rollers
from toy_bar import Bar

from tilth import Model
from tilth.analysis.setup import InStep
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_terms import TERMS, balance_of, terms_of
from tilth.arrays import Floats

LENGTH = 6.0
AXIAL, SKIN, LOAD = 3e3, 40.0, 2.0


def bar(kind: str, elements: int = 12, **changed: Any) -> Bar:
    """A bar from the top of the soil down, between lines of the grid."""
    dim = dimension(kind)
    nodes = np.full((elements + 1, dim), 2.3)
    nodes[:, -1] = np.linspace(8.0, 8.0 - LENGTH, elements + 1)
    return Bar(nodes, **{"axial": AXIAL, "skin": SKIN, "load": LOAD} | changed)


def with_bar(kind: str, own: Bar, solver: str, held: bool) -> Simulation:
    """Soil 4 wide and 8 high with the bar; none of its nodes moves if it is held."""
    dim = dimension(kind)
    entries = block_entries(kind, "linear", cells=4)
    entries["bodies"][0]["shape"]["upper"] = [4.0] * (dim - 1) + [8.0]
    entries["analysis"] |= {"solver": solver, "tolerance": 1e-10}
    if not held:
        entries["boundaries"] = rollers(kind, 4.0)
    return Simulation(Model.from_dict(entries), terms=[*TERMS, own.terms()], fields=[own])


def settlement(depth: Floats) -> Floats:
    """Of a bar in soil that does not move: linear t-z springs."""
    decay = np.sqrt(SKIN / AXIAL)
    along = np.cosh(decay * (LENGTH - depth)) / np.sinh(decay * LENGTH)
    return np.asarray(LOAD / (AXIAL * decay) * along)


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_bar_on_springs_settles_as_its_closed_form(kind: str) -> None:
    """Linear elements: the error falls with the square of their length."""
    errors = []
    for elements in (6, 12):
        own = bar(kind, elements)
        simulation = with_bar(kind, own, "superlu", held=True)
        simulation.advance(0.0, 0.5)
        simulation.advance(0.5, 1.0)
        expected = settlement(LENGTH * np.linspace(0.0, 1.0, elements + 1))
        errors.append(np.abs(-own.moved[:, -1] - expected).max() / expected[0])
        assert np.abs(own.moved[:, :-1]).max() < 1e-12
    assert errors[0] < 2e-3
    assert errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_all_solvers_find_the_same_in_soil_that_gives_way(kind: str) -> None:
    found = []
    for solver in ("superlu", "multigrid"):
        own = bar(kind)
        simulation = with_bar(kind, own, solver, held=False)
        result = simulation.advance(0.0, 1.0)
        base = result.resultant(f"low {'xyz'[dimension(kind) - 1]}")
        assert base[-1] == pytest.approx(LOAD, rel=1e-6)  # what the head carries comes down
        assert own.moved[0, -1] < -1.02 * settlement(np.zeros(1))[0]
        found.append(own.moved)
        summary = simulation.services.solver.summary
        assert ("multigrid" in summary) == (solver == "multigrid"), summary
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-7 * np.abs(found[0]).max())


def test_the_matrix_is_the_derivative_of_all_residuals() -> None:
    own = bar("plane_strain")
    simulation = with_bar("plane_strain", own, "superlu", held=False)
    step = simulation.prepare(0.0, 1.0)
    of = InStep(simulation.setup, simulation.state, step, simulation.soil_on(step.active))
    balance = balance_of(of, terms_of(of, simulation.services.timers))
    random = np.random.default_rng(3)
    x = balance.first()
    of_fields = {n: 1e-3 * random.normal(size=f.shape) for n, f in balance.fields.items()}
    way, matrix = type(x)(of_fields), balance.space.matrix()
    balance.evaluate(x)
    balance.linearise(x, matrix)
    found = matrix.times(way)
    ahead, behind = (balance.evaluate(x.plus(way, share)) for share in (1e-3, -1e-3))
    for name, values in found.of.items():
        difference = (ahead.of[name] - behind.of[name]) / 2e-3
        np.testing.assert_allclose(values, difference, rtol=0, atol=1e-6 * np.abs(values).max())


def test_a_resumed_bar_goes_on_with_the_same_bits() -> None:
    own = bar("plane_strain")
    simulation = with_bar("plane_strain", own, "superlu", held=False)
    simulation.advance(0.0, 0.5)
    arrays = {name: each.copy() for name, each in simulation.state.arrays().items()}
    simulation.advance(0.5, 1.0)
    again = bar("plane_strain")
    terms = [*TERMS, again.terms()]
    resumed = Simulation.restored(simulation.setup.model, arrays, terms=terms, fields=[again])
    resumed.locate(0.5)
    resumed.advance(0.5, 1.0)
    assert np.array_equal(again.moved, own.moved)
