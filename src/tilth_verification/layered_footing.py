# SPDX-License-Identifier: BSD-3-Clause
"""A smooth strip footing on clay whose strength grows with depth (Davis and Booker 1973)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative, vanishing

PROBLEM = "layered_footing"
WIDTH, DEPTH = 1.0, 2.0
"""Width of the footing and depth of the clay [m]."""
SURFACE_STRENGTH = 10e3
"""Undrained shear strength at the surface, s_u0 [Pa]."""
RIGIDITY = 20_000.0
"""Young's modulus over the strength [-]."""
LIMITS: Mapping[float, float] = MappingProxyType({1.0: 5.982, 4.0: 7.819})
"""k B / s_u0 -> limit pressure over s_u0 [-], by the method of characteristics (Davis and Booker,
The effect of increasing strength with depth on the bearing capacity of clays, Geotechnique 23(4),
1973)."""
SOURCE = "Davis & Booker 1973"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The limit pressure on two grids, in the long form on three, and extrapolated from them."""
    sizes = (0.1, 0.05, 0.025) if long else (0.1, 0.05)
    for growth, limit in LIMITS.items():
        pressures = [limit_pressure(growth, size) for size in sizes]
        at = f"kB/s_u0 = {growth:g}"
        for size, pressure in zip(sizes, pressures, strict=True):
            tolerance = 1.5 * size
            yield relative(f"q/s_u0, {at}, h {size:g} m", pressure, limit, tolerance, SOURCE)
        extrapolated = 2.0 * pressures[-1] - pressures[-2]
        grids = f"h {sizes[-2]:g} and {sizes[-1]:g} m"
        quantity = f"q/s_u0, {at}, extrapolated from {grids} at first order"
        yield relative(quantity, extrapolated, limit, 0.05, SOURCE)
    # F-bar smooths the volumetric strains within each layer, so that horizons have a small effect.
    # In the case file's 15 steps one may or may not be halved, by round-off.
    for anti_locking, tolerance in (("none", 1e-9), ("f_bar", 1e-6)):
        formulation = {"bodies.0.anti_locking": anti_locking, "schedule.steps": 20}
        layers = limit_pressure(1.0, 0.1, {**formulation, **layered()})
        change = layers / limit_pressure(1.0, 0.1, formulation) - 1.0
        quantity = f"change of q by four layers of that clay, anti_locking {anti_locking}, h 0.1 m"
        yield vanishing(quantity, change, tolerance, "same clay")


def layered() -> dict[str, Any]:
    """Returns changes that divide the clay into four layers of the same material."""
    bottoms = [{"material": "clay", "bottom": bottom} for bottom in (1.5, 1.0, 0.5)]
    return {"bodies.0.layers": [*bottoms, {"material": "clay"}], "bodies.0.material": None}


def limit_pressure(
    growth: float, size: float, changes: Mapping[str, Any] = MappingProxyType({})
) -> float:
    """Returns the highest pressure over s_u0 for a growth kB/s_u0, on cells of this size [m]."""
    at_base = SURFACE_STRENGTH * (1.0 + growth * DEPTH / WIDTH)
    rows = [[0.0, SURFACE_STRENGTH], [DEPTH, at_base]]
    by_depth = {"depth": rows, "surface": DEPTH}
    stiffness = {**by_depth, "depth": [[depth, RIGIDITY * su] for depth, su in rows]}
    clay = "materials.clay"
    varying = {f"{clay}.undrained_shear_strength": by_depth, f"{clay}.young_modulus": stiffness}
    model = varied(example(PROBLEM), {"grid.cell_size": size, **varying, **changes})
    pressures: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        pressures.append(-result.resultant("footing")[1] / (0.5 * WIDTH))

    march(model, after_step)
    return float(np.max(pressures)) / SURFACE_STRENGTH
