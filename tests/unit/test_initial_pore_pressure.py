# SPDX-License-Identifier: BSD-3-Clause
"""Excess pore pressure at the start."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from test_flow_stages import entries_of

from tilth import BadInput, Model
from tilth.analysis.initial_equilibrium import find_initial_equilibrium
from tilth.analysis.simulation import Simulation
from tilth.mpm.pore_water import POROSITY, PRESSURE, STORED


def column(**changed: Any) -> dict[str, Any]:
    """Sand on its drain, loaded and with the same excess pressure: no effective stress."""
    entries = entries_of()
    del entries["stages"]
    entries["bodies"] = [entries["bodies"][2] | {"surface": {}}]
    entries["bodies"][0]["shape"] |= {"lower": [0.0, 0.0], "upper": [3.0, 2.0]}
    load = {"type": "surface", "body": "bank", "pressure": 4.0, "factor": [[0, 1], [9, 1]]}
    entries["loads"] = [load | {"start": [3.0, 2.0], "end": [0.0, 2.0]}]
    entries["track"] = []
    entries["schedule"] = {"end": 8.0, "steps": 4}
    entries["initial"] = {"pore_pressure": [{"body": "bank", "excess_pore_pressure": 4.0}]}
    return entries | changed


def test_water_that_bears_the_load_leaves() -> None:
    simulation = Simulation(Model.from_dict(column()))
    points = simulation.state.points
    assert (points.water[:, PRESSURE] == 4.0).all()
    settlement = []
    for before, after in pairwise([0.0, 1e-6, 4.0, 400.0, 40000.0]):
        simulation.advance(before, after)
        settlement.append(-float(points.displacement[:, 1].min()))
    modulus = 400.0 * 0.8 / (1.2 * 0.6)
    place = float((points.position - points.displacement)[:, 1].max())
    # the projection drains the cell beside the drain as a step of h^2 / (4 c) does: T = (h/H)^2 / 4
    assert settlement[0] < 2.0 * np.sqrt((0.5 / 2.0) ** 2 / 4.0 / np.pi) * settlement[-1]
    assert settlement[0] < settlement[1] < settlement[2]
    assert settlement[3] == pytest.approx(settlement[2], rel=1e-3)
    strain = settlement[-1] / place
    assert modulus * strain == pytest.approx(4.0, rel=0.02)


def test_pressure_that_varies_and_water_that_is_compressed() -> None:
    entries = column()
    rows = {"axis": "y", "values": [[0.0, 4.0], [2.0, 0.0]]}
    entries["initial"] = {"pore_pressure": [{"body": "bank", "excess_pore_pressure": rows}]}
    entries["flow"]["bulk_modulus"] = 100.0
    points = Simulation(Model.from_dict(entries)).state.points
    pressure = 4.0 - 2.0 * points.position[:, 1]
    np.testing.assert_allclose(points.water[:, PRESSURE], pressure, rtol=1e-12)
    stored = points.water[:, POROSITY] * np.exp(pressure / 100.0)
    np.testing.assert_allclose(points.water[:, STORED], stored, rtol=1e-12)


def test_stress_at_the_start_is_in_equilibrium_with_the_pressure() -> None:
    """The effective stress is the load less the pressure, whatever was declared."""
    entries = column()
    entries["initial"] = {
        "pore_pressure": [{"body": "bank", "excess_pore_pressure": 1.5}],
        "stress": [{"type": "given", "body": "bank", "stress": [-2.0, -2.0, -2.0, 0.0]}],
    }
    simulation = Simulation(Model.from_dict(entries))
    find_initial_equilibrium(simulation)
    points = simulation.state.points
    inner = np.abs(points.position[:, 1] - 1.0) < 0.5
    np.testing.assert_allclose(points.stress[inner, 1], -2.5, rtol=1e-3)
    assert (points.water[:, PRESSURE] == 1.5).all()
    np.testing.assert_allclose(points.water[:, STORED], 0.5, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "key", "what"),
    [
        ({"flow": None}, "initial.pore_pressure[0]", "has no meaning without [flow]"),
        ({"body": "bunk"}, "initial.pore_pressure[0].body", "did you mean"),
        ({"material": "concrete"}, "initial.pore_pressure[0].body", "no water flows through its"),
        ({"twice": True}, "initial.pore_pressure[1].body", "already"),
    ],
)
def test_wrong_entries(change: dict[str, Any], key: str, what: str) -> None:
    entries = column()
    given = entries["initial"]["pore_pressure"]
    if "flow" in change:
        del entries["flow"]
    if "body" in change:
        given[0]["body"] = change["body"]
    if "material" in change:
        entries["bodies"].append(
            entries["bodies"][0] | {"name": "block", "material": "concrete", "surface": None}
        )
        entries["bodies"][1]["shape"] = {"type": "box", "lower": [3, 0], "upper": [4, 2]}
        given[0]["body"] = "block"
    if "twice" in change:
        given.append(dict(given[0]))
    with pytest.raises(BadInput) as error:
        Model.from_dict(entries)
    assert key in str(error.value)
    assert what in str(error.value)
