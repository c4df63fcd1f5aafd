# SPDX-License-Identifier: BSD-3-Clause
"""A column of clay that consolidates, as a case declares it."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np

from tilth import Model
from tilth.analysis.initial_equilibrium import find_initial_equilibrium, has_initial_equilibrium
from tilth.analysis.staged import StagedAnalysis
from tilth.arrays import Floats
from tilth.mpm.pore_water import PRESSURE

LOAD = 10.0
"""Pressure on the top [kPa]."""
HEIGHT = 3.0
"""[m]"""

CLAY = {
    "model": "hencky_elastic", "young_modulus": 5e3, "poisson_ratio": 0.3,
    "porosity": 0.5, "hydraulic_conductivity": 1e-3,
}  # fmt: skip

CONSTRAINED = 5e3 * 0.7 / (1.3 * 0.4)
"""Constrained modulus [kPa]."""
COEFFICIENT = 1e-3 / 10.0 * CONSTRAINED
"""Coefficient of consolidation [m^2/day]."""

ENTRIES: Mapping[str, Any] = {
    "units": {"length": "m", "force": "kN", "stress": "kPa", "mass": "t", "time": "day"},
    "analysis": {"kind": "plane_strain"},
    "grid": {"cell_size": 0.5},
    "flow": {
        "unit_weight": 10.0,
        "boundaries": [
            {"name": "drain", "type": "plane", "axis": "y", "at": 0.0, "condition": "drained"}
        ],
    },
    "materials": {"clay": CLAY},
    "bodies": [
        {
            "name": "soil",
            "material": "clay",
            "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [0.5, HEIGHT]},
            "basis": "gimp",
            "points_per_cell": 2,
            "surface": {},
        }
    ],
    "boundaries": [
        {"name": name, "type": "plane", "axis": axis, "at": at, "condition": "roller"}
        for name, axis, at in (("left", "x", 0.0), ("right", "x", 0.5), ("base", "y", 0.0))
    ],
    "loads": [
        {
            "name": "fill", "type": "surface", "body": "soil", "start": [0.5, HEIGHT],
            "end": [0.0, HEIGHT], "pressure": LOAD, "factor": [[0, 1], [1, 1]],
        }
    ],
    "schedule": {"end": 8.0, "steps": 4},
}  # fmt: skip

GRAVITY = {
    "name": "gravity", "type": "body_force", "acceleration": [0.0, -10.0],
    "factor": [[0, 1], [1, 1]],
}  # fmt: skip
"""Weight from the start."""

UNDER_WATER: Mapping[str, Any] = {
    "materials.clay": {**CLAY, "density": 1.3, "saturated_density": 1.8},
    "water": {"level": HEIGHT, "unit_weight": 10.0},
    "initial": {"stress": [{"type": "gravity", "body": "soil"}]},
    "loads": [GRAVITY, {**ENTRIES["loads"][0], "factor": [[0, 0], [1, 1]]}],
}
"""What puts the column under water, with its weight and in equilibrium before the load."""

FREE_BLOCK: Mapping[str, Any] = {
    "bodies.0.shape.upper": [1.0, 1.0],
    "bodies.0.anti_locking": "f_bar",
    "materials.clay": {
        **CLAY, "model": "mohr_coulomb", "cohesion": 14.0, "friction_angle": 20.0,
        "dilation_angle": 0.0,
    },
    "flow.boundaries.0.axis": "x",
    "boundaries": [ENTRIES["boundaries"][i] for i in (0, 2)],
    "loads.0": {
        **ENTRIES["loads"][0], "start": [1.0, 1.0], "end": [0.0, 1.0], "pressure": 20.0,
        "factor": [[0, 0], [1, 1]],
    },
}  # fmt: skip
"""What makes a block of Mohr-Coulomb soil of the column, free at one side, drained at the other."""


def column(changes: Mapping[str, Any] | None = None, **more: Any) -> dict[str, Any]:
    """Returns the entries of the column.

    changes: of entries by their keys, such as "flow.boundaries.0.at"; None takes one out.
    """
    entries: Any = copy.deepcopy(dict(ENTRIES))
    for key, value in {**(changes or {}), **more}.items():
        *path, last = key.split(".")
        table = entries
        for name in path:
            table = table[int(name)] if isinstance(table, list) else table.setdefault(name, {})
        place: Any = int(last) if isinstance(table, list) else last
        if value is None:
            del table[place]
        else:
            table[place] = copy.deepcopy(value)
    result: dict[str, Any] = entries
    return result


def computed(entries: Mapping[str, Any]) -> StagedAnalysis:
    """Returns the analysis of a case at its end."""
    analysis = StagedAnalysis(Model.from_dict(dict(entries)))
    if has_initial_equilibrium(analysis.simulation.setup.model):
        find_initial_equilibrium(analysis.simulation)
    for _ in analysis.steps():
        pass
    return analysis


def pressures(analysis: StagedAnalysis) -> Floats:
    """Returns the excess pore pressures of the points [stress], shape (n,)."""
    return np.asarray(analysis.state.points.water[:, PRESSURE])


def series(height: float, time_factor: float, terms: int = 50) -> float:
    """Returns Terzaghi's pressure over the load, at a height over the drain (as a share of H)."""
    m = np.pi * (2 * np.arange(terms) + 1) / 2.0
    return float((2.0 / m * np.sin(m * height) * np.exp(-(m**2) * time_factor)).sum())
