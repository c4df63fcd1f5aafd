# SPDX-License-Identifier: BSD-3-Clause
"""Inertia with all bases, materials and kinds of analysis: nothing stops, the energies add up."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from small_problems import (
    AXES,
    BASES,
    KINDS,
    PORE_FLUID,
    block_entries,
    dimension,
    rollers,
    weight,
)

from tilth import Model
from tilth.analysis.energies import ENERGY_KINDS, Energies
from tilth.analysis.simulation import Simulation

MATERIALS = (
    "hencky_elastic",
    "von_mises",
    "tresca",
    "mohr_coulomb",
    "separating_drucker_prager",
    "modified_cam_clay",
    "undrained_drucker_prager",
)
STEPS, COURANT, SPEED = 12, 0.125, 0.05
"""Number of steps, their size in a wave's time through a cell, fall in the waves' speed."""


def falling_block(kind: str, basis: str, material: str) -> dict[str, Any]:
    """Two cells of soil high that fall on a smooth base, hard enough to yield."""
    entries = block_entries(kind, basis, material, boundaries=rollers(kind, sides=False))
    fluid = PORE_FLUID["pore_fluid_bulk_modulus"] if material.startswith("undrained") else 0.0
    up, wave = AXES[dimension(kind) - 1], np.sqrt((1350.0 + fluid) / 2.0)
    entries["analysis"] |= {"inertia": {"scheme": "newmark"}, "tolerance": 1e-8}
    if material != "hencky_elastic":
        entries["bodies"][0]["anti_locking"] = "f_bar"
    if material == "modified_cam_clay":
        entries["boundaries"] = rollers(kind)
    velocity = [{"body": "block", up: -SPEED * wave}]
    entries["initial"] = {**entries.get("initial", {}), "velocity": velocity}
    entries["loads"] = [{**weight(kind, 10.0), "factor": [[0.0, 1.0], [1.0, 1.0]]}]
    schedule = {"end": STEPS * COURANT / wave, "steps": STEPS}
    return {**entries, "units": {"time": "s"}, "schedule": schedule}


@pytest.mark.slow
@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("basis", BASES)
@pytest.mark.parametrize("kind", KINDS)
def test_the_energies_of_an_impact_add_up(kind: str, basis: str, material: str) -> None:
    """What is in none of them, of the time integration and the projection, is below 5 %."""
    simulation = Simulation(Model.from_dict(falling_block(kind, basis, material)))
    simulation.check()
    energies = Energies.at_start(simulation.setup, simulation.state)
    schedule = simulation.setup.model.schedule
    kinetic = energies.start - simulation.state.points.stored_energy()
    for number in range(STEPS):
        times = schedule.regular_time(number), schedule.regular_time(number + 1)
        energies.add(simulation.advance(*times))
    points = simulation.state.points
    for name, array in points.arrays().items():
        assert np.isfinite(array).all(), name
    found = energies.values(simulation.setup, simulation.state, schedule.end)
    assert set(found) == {*ENERGY_KINDS, "seepage"}
    assert found["plastic_dissipation"] >= 0.0
    assert abs(found["kinetic"] - kinetic) > 0.05 * kinetic
    greatest = max(kinetic, *(abs(value) for value in found.values()))
    assert abs(found["numerical_dissipation"]) < 0.05 * greatest
