# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water by the backward difference formula of order 2."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from consolidating import with_flow
from small_problems import BASES, KINDS, block_entries, dimension, rollers

from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.pore_water import PRESSURE, STORED
from tilth.terms.backward_difference import BackwardDifference
from tilth.terms.pore_water import PORE_PRESSURE

NU = 0.2
CONSTRAINED = 1000.0 * (1.0 - NU) / ((1.0 + NU) * (1.0 - 2.0 * NU))
END = 0.2
"""Time over H^2/c at which the load (1 - cos(5 pi T)) / 2 is on its top and goes on."""


@pytest.mark.parametrize("ratio", [0.3, 1.0, 1.7, 2.0])
def test_quadratic_changes_are_exact(ratio: float) -> None:
    before, size = 0.7, 0.7 * ratio
    formula = BackwardDifference.after(before, size)
    y = np.polynomial.Polynomial([0.3, -1.1, 2.3])
    change, last = y(size) - y(0.0), y(0.0) - y(-before)
    expected = formula.of_rate * y.deriv()(size)
    assert change - formula.of_last_change * last == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(("last", "size"), [(0.0, 0.4), (0.1, 0.4), (0.1, 0.0)])
def test_first_and_much_longer_steps_are_those_of_backward_euler(last: float, size: float) -> None:
    formula = BackwardDifference.after(last, size)
    assert (formula.of_rate, formula.of_last_change) == (size, 0.0)


def test_steps_that_double_but_for_round_off_are_of_order_2() -> None:
    assert BackwardDifference.after(0.1, 0.2 * (1.0 + 1e-12)).ratio > 0.0


@dataclass
class Column:
    """A column of cells of size 1 that cannot widen, under a smooth load on its top.

    Attributes:
        height: with a drain at the base (a line of the grid), or on the tracked surface of the top.
        load: its greatest value over the modulus.
    """

    basis: str
    height: float
    drain: str
    load: float = 1e-4

    def simulation(self, scheme: str) -> Simulation:
        """At the start."""
        entries = block_entries("plane_strain", self.basis, "hencky_elastic")
        entries["materials"]["soil"] |= {"young_modulus": 1000.0, "poisson_ratio": NU}
        entries["bodies"][0]["shape"] |= {"lower": [0.0, 0.0], "upper": [1.0, self.height]}
        entries["bodies"][0]["surface"] = {}
        entries["boundaries"] = rollers("plane_strain", 1.0)
        entries["analysis"]["tolerance"] = 1e-10
        top = {"type": "surface", "body": "block", "start": [1.0, self.height],
               "end": [0.0, self.height]}  # fmt: skip
        time = np.linspace(0.0, END, 5121)
        factor = np.column_stack([self.unit * time, 0.5 * (1.0 - np.cos(5.0 * np.pi * time))])
        pressure = self.load * CONSTRAINED
        entries["loads"] = [{**top, "pressure": pressure, "factor": factor.tolist()}]
        entries["schedule"] = {"steps": 1, "end": self.unit * END}
        base = {"type": "plane", "axis": "y", "at": 0.0}
        drain = {"name": "drain", "condition": "drained", **(base if self.drain == "base" else top)}
        return Simulation(with_flow(entries, [drain], scheme))

    @property
    def unit(self) -> float:
        """H^2/c [time]."""
        return self.height**2 / CONSTRAINED

    def run(self, scheme: str, times: Sequence[float] | Floats) -> Floats:
        """Steps between times from 0 to 1; returns what has been found at the end.

        The pressure at the sealed end, settlement and water that has left; what was dissipated over
        the work of the load.
        """
        simulation = self.simulation(scheme)
        water = simulation.state.pore_pressure
        assert water is not None
        start = stored(simulation)
        work = seepage = 0.0
        for before, after in pairwise(np.asarray(times) * END * self.unit):
            result = simulation.advance(float(before), float(after))
            left = start - stored(simulation)
            assert water.drained_through("drain") == pytest.approx(left, abs=1e-12 * self.height)
            work, seepage = work + result.work, seepage + result.seepage_work
        points = simulation.state.points
        y = points.position[:, 1]
        sealed = y.argmax() if self.drain == "base" else y.argmin()
        size = self.load * self.height
        return np.array([
            points.water[sealed, PRESSURE] / (self.load * CONSTRAINED),
            points.displacement[y.argmax(), 1] / size, water.drained_through("drain") / size,
            seepage / work,
        ])  # fmt: skip


def stored(simulation: Simulation) -> float:
    points = simulation.state.points
    return float(points.initial_volume @ points.water[:, STORED])


def equal(steps: int) -> Floats:
    return np.linspace(0.0, 1.0, steps + 1)


def growing(steps: int) -> Floats:
    """The first one 2.8 times shorter than the second."""
    return np.asarray(equal(steps) ** 1.5)


def alternating(steps: int) -> Floats:
    """Short and long ones, half and double as long as the last."""
    size = np.where(np.arange(steps) % 2 == 0, 1.0, 2.0)
    return np.concatenate([[0.0], np.cumsum(size) / size.sum()])


COLUMNS = {
    "base": Column("linear", 16.0, "base"),
    "surface in cells": Column("gimp", 16.4, "surface"),
    "surface that settles": Column("gimp", 16.4, "surface", load=0.2),
}
MEASURED: Sequence[tuple[str, Callable[[int], Floats], tuple[float, ...]]] = (
    ("base", equal, (2.32, 1.78, 1.77, 2.04)),
    ("surface in cells", equal, (2.32, 1.77, 1.77, 2.04)),
    ("surface in cells", growing, (3.82, 1.87, 1.87, 2.41)),
    ("surface in cells", alternating, (2.22, 1.90, 1.90, 2.06)),
    ("surface that settles", equal, (2.95, 1.66, 1.71, 2.16)),
)
"""Orders from the changes of 20 to 40 and 80 steps; they tend to 2 with more of them."""


@pytest.mark.parametrize(("column", "times", "orders"), MEASURED)
def test_order_in_time(
    column: str, times: Callable[[int], Floats], orders: tuple[float, ...]
) -> None:
    """Of pressure, settlement, drained water and dissipated work; the water is kept in each step.

    80 steps of backward Euler are still farther from the limit than 20 of order 2.
    """
    one, two, four = (COLUMNS[column].run("bdf2", times(steps)) for steps in (20, 40, 80))
    np.testing.assert_allclose(np.log2(np.abs((two - one) / (four - two))), orders, atol=0.06)
    limit = four + (four - two) / 3.0
    euler = COLUMNS[column].run("backward_euler", times(80))
    assert (np.abs(euler - limit) > 1.1 * np.abs(one - limit))[[0, 3]].all()


def test_steps_that_grow_fast_are_those_of_backward_euler() -> None:
    times = np.concatenate([[0.0], np.cumsum(2.5 ** np.arange(6))])
    times /= times[-1]
    found = [COLUMNS["base"].run(scheme, times) for scheme in ("backward_euler", "bdf2")]
    np.testing.assert_array_equal(*found)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("basis", "inertia"), [*((basis, False) for basis in BASES), ("gimp", True)]
)
def test_the_matrix_is_the_derivative(kind: str, basis: str, inertia: bool) -> None:
    """In a second step that is longer than the first, at large strain, all terms of the input."""
    dim = dimension(kind)
    entries = block_entries(kind, basis, "hencky_elastic")
    entries["boundaries"] = rollers(kind, 2.0)
    entries["schedule"] = {"end": 1.0, "steps": 10}
    if inertia:
        entries["analysis"]["inertia"] = {"scheme": "newmark"}
        entries["materials"]["soil"] |= {"density": 2.0}
    geometry = {"type": "plane", "point": [0.0] * (dim - 1) + [1.3],
                "normal": [0.0] * (dim - 1) + [-1.0]}  # fmt: skip
    wet = {"name": "wet", "type": "implicit", "condition": "pressure", "excess_pressure": 20.0,
           "geometry": geometry}  # fmt: skip
    model = with_flow(
        entries, [wet], "bdf2", 1.5 if inertia else None, permeability="kozeny_carman"
    )
    simulation = Simulation(model)
    simulation.advance(0.0, 0.1)
    step = simulation.prepare(0.1, 0.25)
    balance = simulation.balance(step, simulation.soil_on(step.active), holds_others=False)
    random = np.random.default_rng(3)
    size = {"u": 2e-2, PORE_PRESSURE: 40.0}
    x, way = (
        Unknowns({n: size[n] * random.normal(size=f.shape) for n, f in balance.fields.items()})
        for _ in range(2)
    )
    way.of["u"][step.conditions.constrained] = 0.0
    matrix, small = balance.space.matrix(), 1e-6
    balance.evaluate(x)
    balance.linearise(x, matrix)
    found: Any = matrix.times(way)
    ahead, behind = (balance.evaluate(x.plus(way, share)) for share in (small, -small))
    for name, values in found.of.items():
        difference = (ahead.of[name] - behind.of[name]) / (2.0 * small)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(values, difference, rtol=0, atol=2e-6 * scale)
