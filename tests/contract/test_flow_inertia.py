# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water with inertia: waves in a saturated column, tangent, balance of water."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from small_problems import BASES, KINDS, block_entries, plane, rollers

from tilth import BadInput, Model
from tilth.algebra.unknowns import Unknowns
from tilth.analysis.simulation import Simulation
from tilth.mpm.pore_water import STORED
from tilth.terms.pore_water import PORE_PRESSURE

WATER = {"unit_weight": 1e4, "density": 1000.0}
SURFACE = {
    1e-3: {0.05: 60.738e-6, 0.1: 41.614e-6, 0.2: 84.423e-6},
    1e-2: {0.05: 191.394e-6, 0.1: 130.803e-6, 0.2: 265.416e-6},
}
"""Conductivity [m/s] -> time [s] -> settlement [m] of a half space of sand and water, neither of
which can be compressed, under the pressure 3 (1 - cos 75 t) kPa: without the inertia of the water
relative to the sand (u-p form), in one direction (de Boer, Ehlers and Liu 1993)."""


def column(conductivity: float, depth: float, cell: float) -> dict[str, Any]:
    """A column of sand that cannot widen, drained at its loaded top."""
    entries = block_entries("plane_strain", "linear", "hencky_elastic")
    entries["materials"]["soil"] |= {
        "young_modulus": 3e7, "poisson_ratio": 0.2, "density": 1670.0, "porosity": 0.33,
        "hydraulic_conductivity": conductivity,
    }  # fmt: skip
    entries["units"] = {"time": "s"}
    entries["grid"]["cell_size"] = cell
    entries["bodies"][0] |= {"surface": {}, "anti_locking": "none"}
    entries["bodies"][0]["shape"] |= {"lower": [0.0, 0.0], "upper": [cell, depth]}
    entries["boundaries"] = [
        plane("left", "x", 0.0), plane("right", "x", cell), plane("base", "y", 0.0)
    ]  # fmt: skip
    entries["analysis"] |= {"inertia": {"scheme": "newmark"}, "tolerance": 1e-8}
    drain = {"name": "top", "type": "plane", "axis": "y", "at": depth, "condition": "drained"}
    entries["flow"] = {**WATER, "boundaries": [drain]}
    times = np.linspace(0.0, 0.2, 2001)
    factor = np.column_stack([times, 1.0 - np.cos(75.0 * times)])
    entries["loads"] = [
        {"type": "surface", "body": "block", "pressure": 3e3, "factor": factor.tolist(),
         "start": [cell, depth], "end": [0.0, depth]}
    ]  # fmt: skip
    entries["schedule"] = {"end": 0.2, "steps": 200}
    return entries


@pytest.mark.parametrize("scheme", ["backward_euler", "bdf2"])
@pytest.mark.parametrize("conductivity", [1e-3, 1e-2])
def test_surface_of_a_saturated_half_space(conductivity: float, scheme: str) -> None:
    """Within 1 %, on cells of a tenth of the length over which the load reaches in a period."""
    depth, cell = (4.0, 0.05) if conductivity < 5e-3 else (12.0, 0.15)
    entries = column(conductivity, depth, cell)
    entries["flow"]["scheme"] = scheme
    simulation = Simulation(Model.from_dict(entries))
    found, times = {}, np.linspace(0.0, 0.2, 201)
    for before, after in pairwise(times):
        result = simulation.advance(before, after)
        top = result.active.position[:, 1] > depth - 1e-9
        points = simulation.state.points
        slope = points.deformation_gradient[:, 1, 1]
        highest = points.position[:, 1].argmax()
        place = points.position[highest, 1] - points.displacement[highest, 1]
        rest = (depth - place) * (slope[highest] - 1.0)
        found[round(after, 6)] = -float(points.displacement[highest, 1] + rest)
        assert top.any()
    for time, expected in SURFACE[conductivity].items():
        assert found[time] == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("basis", BASES)
def test_the_matrix_is_the_derivative(kind: str, basis: str) -> None:
    """With the acceleration of the water, at large strain."""
    entries = block_entries(kind, basis, "hencky_elastic")
    entries["materials"]["soil"] |= {
        "density": 2.0, "porosity": 0.4, "hydraulic_conductivity": 0.3,
        "permeability": "kozeny_carman",
    }  # fmt: skip
    entries |= {"units": {"time": "s"}, "flow": {"unit_weight": 1.0, "density": 1.5}}
    entries["boundaries"] = rollers(kind, 2.0)
    entries["analysis"]["inertia"] = {"scheme": "newmark"}
    entries["schedule"] = {"end": 1.0, "steps": 10}
    simulation = Simulation(Model.from_dict(entries))
    step = simulation.prepare(0.0, 0.3)
    balance = simulation.balance(step, simulation.soil_on(step.active), holds_others=False)
    random = np.random.default_rng(3)
    size = {"u": 2e-2, PORE_PRESSURE: 40.0}
    x, way = (
        Unknowns({n: size[n] * random.normal(size=f.shape) for n, f in balance.fields.items()})
        for _ in range(2)
    )
    free = ~step.conditions.constrained
    way.of["u"][~free] = 0.0
    matrix, small = balance.space.matrix(), 1e-6
    balance.evaluate(x)
    balance.linearise(x, matrix)
    found = matrix.times(way)
    ahead, behind = (balance.evaluate(x.plus(way, share)) for share in (small, -small))
    for name, values in found.of.items():
        difference = (ahead.of[name] - behind.of[name]) / (2.0 * small)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(values, difference, rtol=0, atol=2e-6 * scale)


def test_water_of_a_shaken_block_stays() -> None:
    entries = column(1e-3, 1.0, 0.25)
    entries["flow"]["boundaries"] = []
    simulation = Simulation(Model.from_dict(entries))
    points = simulation.state.points
    whole = float(points.initial_volume @ points.water[:, STORED])
    for before, after in pairwise(np.linspace(0.0, 0.05, 26)):
        simulation.advance(before, after)
    points = simulation.state.points
    stored = float(points.initial_volume @ points.water[:, STORED])
    assert stored == pytest.approx(whole, rel=1e-8)
    assert np.abs(points.motion[:, 0]).max() > 0.0


def test_inertia_needs_the_density_of_the_water() -> None:
    entries = column(1e-3, 1.0, 0.25)
    del entries["flow"]["density"]
    with pytest.raises(BadInput, match="the analysis has inertia") as error:
        Model.from_dict(entries)
    assert "flow.density" in str(error.value)
