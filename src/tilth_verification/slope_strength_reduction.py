# SPDX-License-Identifier: BSD-3-Clause
"""Factors of safety of slopes by strength reduction, against slip circles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.model import MohrCoulomb, Tresca
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.comparison import Comparison, relative
from tilth_verification.factor_of_safety import factor_of_safety
from tilth_verification.slip_circles import Of, Slope, uniform

PROBLEM = "slope_strength_reduction"
PUBLISHED = 1.38
"""Of the slope by Bishop and Morgenstern (1960); Griffiths and Lane (1999) 1.4 by finite elements.
"""
TAYLOR = 1.47
"""Of the undrained slope on its own clay, from Taylor's stability number (1937)."""
WEIGHT = 20e3
"""Unit weight of all soils [N/m3]."""
TOLERANCE = 0.03
GROUND = [(-30.0, 10.0), (12.0, 10.0), (32.0, 0.0), (60.0, 0.0)]
"""Surface of the slope of `case.toml` [m]."""
WATER = 10e3
"""Unit weight of water [N/m3]."""
IMPLICIT: dict[str, Any] = {
    "boundaries": [
        {
            "name": name,
            "type": "implicit",
            "geometry": {"type": "plane", "point": [0.0, 0.0], "normal": normal},
            "condition": condition,
        }
        for name, normal, condition in (
            ("base", [0.0, 1.0], "fixed"),
            ("left", [1.0, 0.0], "roller"),
        )
    ]
}
"""Boundaries at any position in the grid."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Soil with friction on two grids, on other bases, shifted; undrained clay on two layers."""
    yield from _with_friction(long)
    yield from _undrained(long)
    yield from _in_water(long)


def bishop(unit_weight: float = WEIGHT, **water: Any) -> float:
    """Returns Bishop's simplified factor of the slope of `case.toml`, the least of all circles.

    unit_weight: of the soil [N/m3]. water: of `Slope`.
    """
    soil = example(PROBLEM).materials["soil"]
    assert isinstance(soil, MohrCoulomb)
    slope = Slope(
        GROUND,
        unit_weight,
        uniform(soil.parameter("cohesion")),
        uniform(math.tan(math.radians(soil.parameter("friction_angle")))),
        **water,
    )
    return slope.least_factor((-5.0, 12.0), (14.0, 32.0))


def _with_friction(long: bool) -> Iterator[Comparison]:
    circles = bishop()
    source = "Bishop and Morgenstern (1960)"
    yield relative("factor of safety by slip circles", circles, PUBLISHED, 0.003, source)
    source, model = "Bishop's method, least circle", example(PROBLEM)
    for h in (1.0, 0.5, 0.25) if long else (1.0, 0.5):
        factor = factor_of_safety(varied(model, {"grid.cell_size": h}))
        yield relative(f"factor of safety, h {h:g} m", factor, circles, TOLERANCE, source)
    for basis in ("linear", "cpdi2"):
        factor = factor_of_safety(with_basis(model, basis))
        yield relative(f"factor of safety, {basis}, h 1 m", factor, circles, TOLERANCE, source)
    for points in (3, 4) if long else (3,):
        factor = factor_of_safety(varied(model, {"bodies.0.points_per_cell": points}))
        quantity = f"factor of safety, {points} x {points} points, h 1 m"
        yield relative(quantity, factor, circles, TOLERANCE, source)
    # a lattice of points 0.5 m apart, as before; grid lines through none of the edges
    factor = factor_of_safety(varied(model, {"grid.origin": [0.5, 0.5], **IMPLICIT}))
    quantity = "factor of safety, boundaries between grid lines, h 1 m"
    yield relative(quantity, factor, circles, TOLERANCE, source)


def undrained_circles(strength_below: float) -> float:
    """Returns the least factor of circles in `two_layers.toml`, with a strength below [Pa]."""
    upper = example(PROBLEM, "two_layers.toml").materials["upper"]
    assert isinstance(upper, Tresca)
    strength = upper.parameter("undrained_shear_strength")
    slope = Slope(
        [(-60.0, 20.0), (20.0, 20.0), (40.0, 10.0), (120.0, 10.0)],
        WEIGHT,
        lambda x, y: np.where(y < 10.0, strength_below, strength),
        uniform(0.0),
    )
    return slope.least_factor((-20.0, 20.0), (22.0, 70.0))


def _undrained(long: bool) -> Iterator[Comparison]:
    model, below = example(PROBLEM, "two_layers.toml"), "materials.lower.undrained_shear_strength"
    circles = undrained_circles(50e3)
    yield relative("s_u equal: slip circles", circles, TAYLOR, 0.005, "Taylor (1937)")
    for strength, name in ((50e3, "s_u equal"), (40e3, "s_u below 0.8 of that above")):
        exact = undrained_circles(strength)
        for h in (2.0, 1.0) if long else (2.0,):
            factor = factor_of_safety(varied(model, {below: strength, "grid.cell_size": h}))
            quantity = f"{name}: factor of safety, h {h:g} m"
            yield relative(quantity, factor, exact, TOLERANCE, "moments about the least circle")


def _in_water(long: bool) -> Iterator[Comparison]:
    """Under water as dry with the buoyant weight; water that has fallen, slowly and at once."""
    source, fallen = "Bishop's method, least circle, same water", example(PROBLEM, "drawdown.toml")
    coarse = {"grid.cell_size": 1.0}
    under = varied(fallen, {"water.initial_level": 15.0, "water.level": 15.0, **coarse})
    dry = {"water": None, "materials.soil.saturated_density": None, **coarse}
    buoyant = varied(fallen, {**dry, "materials.soil.density": 1000.0})
    wet, factor = factor_of_safety(under), factor_of_safety(buoyant)
    quantity = "factor of safety under water, h 1 m"
    yield relative(quantity, wet, factor, 0.005, "dry with the buoyant weight")
    exact = bishop(water_level=15.0, water_weight=WATER, pore_pressure=_pressure(15.0))
    quantity = "circles under water"
    yield relative(quantity, exact, bishop(WEIGHT - WATER), 0.001, "circles, buoyant weight")
    for level in (6.0, 3.0):
        at_level = varied(fallen, {"water.level": level})
        exact = bishop(water_level=level, water_weight=WATER, pore_pressure=_pressure(level))
        quantity = f"factor of safety, water at {level:g} m, h 0.5 m"
        yield relative(quantity, factor_of_safety(at_level), exact, TOLERANCE, source)
    at_once = varied(fallen, {"water.level": [[-1.0, 4.0], [24.0, 4.0], [32.0, 0.0], [40.0, 0.0]]})
    exact = bishop(pore_pressure=_pressure(4.0, at_ground=True))
    quantity = "factor of safety, 4 m of water gone before that in the soil, h 0.5 m"
    yield relative(quantity, factor_of_safety(at_once), exact, TOLERANCE, source)


def _pressure(level: float, at_ground: bool = False) -> Of:
    """Returns the pore pressure below a level, or below the ground where that is lower [Pa]."""

    def pressure(x: Floats, y: Floats) -> Floats:
        ground = np.interp(x, *np.transpose(GROUND)) if at_ground else level
        return np.asarray(WATER * np.maximum(np.minimum(level, ground) - y, 0.0))

    return pressure
