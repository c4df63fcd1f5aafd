# SPDX-License-Identifier: BSD-3-Clause
"""F-bar with plastic flow that dilates: points keep their own plastic volume change."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tilth import Model, _core
from tilth.analysis.residual import Newton, Refinement
from tilth.analysis.simulation import Simulation
from tilth.analysis.step import Equilibrium, solve_step
from tilth.terms.balance import Balance


def punched(dilation_angle: float, model: str = "mohr_coulomb", **body: Any) -> Simulation:
    """A block of sand with cohesion, of four by four cells, under a pressure on half of its top."""
    entries: dict[str, Any] = {
        "analysis": {"kind": "plane_strain"},
        "grid": {"cell_size": 1.0},
        "materials": {
            "sand": {
                "model": model, "young_modulus": 2e4, "poisson_ratio": 0.3, "density": 2.0,
                "cohesion": 20.0, "friction_angle": 30.0, "dilation_angle": dilation_angle,
                **({"fit": "plane_strain"} if model == "drucker_prager" else {}),
            },
        },
        "bodies": [
            {
                "name": "block", "material": "sand", "basis": "gimp", "points_per_cell": 2,
                "anti_locking": "f_bar", "surface": {},
                "shape": {"type": "box", "lower": [0, 0], "upper": [4, 4]}, **body,
            },
        ],
        "boundaries": [
            {"name": "base", "type": "plane", "axis": "y", "at": 0.0, "condition": "fixed"},
            {"name": "left", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"},
        ],
        "loads": [
            {"type": "surface", "body": "block", "pressure": 100.0, "start": [2.0, 4.0],
             "end": [0.0, 4.0]},
        ],
        "schedule": {"steps": 1},
    }  # fmt: skip
    return Simulation(Model.from_dict(entries))


def solved(simulation: Simulation, refinement: Refinement) -> tuple[Any, Equilibrium, Balance]:
    """The soil, equilibrium and balance of the first step."""
    step = simulation.prepare(0.0, 1.0)
    soil = simulation.soil_on(step.active)
    balance = simulation.balance(step, soil)
    newton = Newton(1e-9, 40, True, {}, refinement)
    found = solve_step(balance, simulation.services, newton)
    return soil, found, balance


def pressure_differences(soil: Any) -> float:
    """Greatest difference of the elastic volumetric strain from that of the cell, over its mean."""
    (centres,) = soil._centres
    strain = _core.volumetric_strains(soil._trial.elastic)
    differences = centres.differences(strain, soil.points.volume)
    return float(np.abs(differences).max() / np.abs(strain).mean())


@pytest.mark.parametrize("model", ["mohr_coulomb", "drucker_prager"])
def test_pressures_of_a_cell_stay_together(model: str) -> None:
    plain, before, _ = solved(punched(30.0, model), Refinement.NONE)
    soil, after, _ = solved(punched(30.0, model), Refinement.SETTLED)
    assert pressure_differences(soil) < 0.5 * pressure_differences(plain)
    settlement, plain_settlement = (-each.displacement[:, 1].min() for each in (after, before))
    assert settlement > plain_settlement
    difference = soil._plastic_volumes.difference
    volume = soil.points.volume
    assert np.abs(difference).max() > 1e-5
    assert abs((volume * difference).sum()) < 1e-10 * np.abs(volume * difference).sum()


def test_flow_without_dilation_is_not_changed() -> None:
    _, plain, _ = solved(punched(0.0), Refinement.NONE)
    soil, refined, _ = solved(punched(0.0), Refinement.SETTLED)
    assert np.abs(soil._plastic_volumes.difference).max() < 1e-6
    np.testing.assert_allclose(
        refined.displacement, plain.displacement, atol=1e-6 * np.abs(plain.displacement).max()
    )
