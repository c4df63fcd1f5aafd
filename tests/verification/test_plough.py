# SPDX-License-Identifier: BSD-3-Clause
"""The rows of the plough fail where the force is not steady, and where soil is doubled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tilth.analysis.simulation import Simulation
from tilth_verification import plough
from tilth_verification.cases import example
from tilth_verification.comparison import Comparison
from tilth_verification.plough import CELL, Tow

FORCE = 8e3
"""Steady force [N]."""


@pytest.fixture(scope="module")
def simulation() -> Simulation:
    return Simulation(example(plough.PROBLEM))


@pytest.fixture
def run(simulation: Simulation) -> Tow:
    """Uneven steps to 5 m, with a force that changes from step to step but does not drift."""
    way = 5.0 * np.linspace(0.0, 1.0, 193) ** 0.9
    ones, work = np.ones_like(way), FORCE * way
    force = FORCE * (1.0 + 0.02 * np.sin(np.pi / CELL * 8.0 * way))
    ends = np.column_stack([ones, ones])
    return Tow(way, force, work, work, ones, ends, 193, simulation)


def missed(rows: list[Comparison]) -> list[str]:
    return [row.quantity for row in rows if not row.passed]


def test_a_steady_force_passes(run: Tow) -> None:
    assert missed(list(plough.steady(run))) == []


def test_a_force_that_grows_by_four_per_cent_of_its_mean_does_not(run: Tow) -> None:
    growing = replace(run, force=FORCE * (1.0 + 0.04 * (run.way - 4.5)))
    rows = list(plough.steady(growing))
    assert rows[0].computed == pytest.approx(0.04, rel=1e-6)
    assert missed(rows) == [rows[0].quantity]


def test_a_force_that_is_higher_over_one_cell_does_not(run: Tow) -> None:
    high = np.where((run.way > 4.5) & (run.way < 4.75), 1.08 * FORCE, FORCE)
    rows = list(plough.steady(replace(run, force=high)))
    assert rows[1].quantity in missed(rows)


def test_soil_that_is_compressed_or_whose_work_is_lost_is_seen(run: Tow) -> None:
    assert plough.filling(run.end.state.points) == pytest.approx(1.0, rel=0.05)
    falling = replace(run, volume=1.0 - 0.002 * run.way / run.way[-1], energy=0.8 * run.work)
    seen = missed(list(plough.kept(falling)))
    assert any("soil's volume" in quantity for quantity in seen)
    assert any("energy" in quantity for quantity in seen)


def test_soil_that_is_doubled_is_seen(simulation: Simulation) -> None:
    points = simulation.state.points
    place = points.position.copy()
    try:
        points.position[place[:, 0] > 6.0] -= np.array([1.0, 0.0, 0.0])
        assert plough.filling(points) > 1.9
    finally:
        points.position[:] = place
