# SPDX-License-Identifier: BSD-3-Clause
"""A long layer on a slope: the factor of safety of its slip along the base, in closed form.

Of a layer of the thickness D, measured across it, on a slope beta the base carries the normal
stress gamma D cos(beta) and the shear stress gamma D sin(beta), whatever the stress along the
slope.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from scipy.optimize import brentq

from tilth.model import Model, MohrCoulomb
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative
from tilth_verification.factor_of_safety import factor_of_safety
from tilth_verification.turned import shifted, turned

PROBLEM = "infinite_slope"
SLOPE = 20.0
"""Of the base against the horizontal [degrees]."""
THICKNESS = 2.0
"""Of the layer, across it [m]."""
WEIGHT = 20e3
"""Unit weight of the soil [N/m3]."""
WATER_WEIGHT = 10e3
"""Unit weight of water [N/m3]."""
WET = 0.8
"""Thickness of the layer below the water table, across it [m]."""
TOLERANCE = 0.02
FINE = 0.002
"""Width of the bracket of the factors [-]."""
AT_45_DEGREES = WEIGHT * THICKNESS * math.cos(math.radians(SLOPE))
"""Stress along the slope at the base when the principal stresses are at 45 degrees to it [Pa]."""
NO_DILATION: dict[str, Any] = {
    "materials.soil.dilation_angle": 0.0,
    "loads.1.pressure_along": [[0.0, 0.0], [THICKNESS, AT_45_DEGREES]],
    "loads.2.pressure_along": [[0.0, AT_45_DEGREES], [THICKNESS, 0.0]],
}


def comparisons(long: bool) -> Iterator[Comparison]:
    """Two grids, turned and shifted copies, and a layer that does not dilate."""
    model = example(PROBLEM)
    source = "closed form, base of an infinite slope"
    exact = associated_factor(model)
    for h in (0.5, 0.25, 0.125) if long else (0.5, 0.25):
        factor = factor_of_safety(varied(model, {"grid.cell_size": h}), FINE)
        yield relative(f"factor of safety, h {h:g} m", factor, exact, TOLERANCE, source)
    copies = [("grid shifted", shifted(model)), ("turned by 17 degrees", turned(model, 17.0))]
    if long:
        copies.append(("turned upright", turned(model, -SLOPE)))
    for name, copy in copies:
        factor = factor_of_safety(copy, FINE)
        yield relative(f"factor of safety, {name}", factor, exact, TOLERANCE, source)
    factor = factor_of_safety(varied(model, NO_DILATION), FINE)
    source = "closed form, flow without change of volume (Davis 1968)"
    quantity = "factor of safety, no dilation"
    yield relative(quantity, factor, factor_without_dilation(model), TOLERANCE, source)
    wet, exact = with_water(model)
    quantity = f"factor of safety, {WET:g} m of water, cells of 0.5 x 0.125 m"
    source = "closed form with the pore pressure at the base"
    yield relative(quantity, factor_of_safety(wet, FINE), exact, TOLERANCE, source)


def with_water(model: Model) -> tuple[Model, float]:
    """Returns the layer with a water table parallel to the slope, and its factor in closed form.

    The pore pressure is that of the vertical distance from the water table, d / cos(beta) for a
    distance d across the layer: in the axes of the layer, water of the unit weight / cos(beta). The
    factor falls steeply towards the base, so that the cells are thin there.
    """
    cosine = math.cos(math.radians(SLOPE))
    pressure = WATER_WEIGHT / cosine * WET
    changes: dict[str, Any] = {
        "grid.cell_size": [0.5, 0.125],
        "materials.soil.cohesion": 500.0,
        "materials.soil.friction_angle": 30.0,
        "materials.soil.dilation_angle": 30.0,
        "materials.soil.saturated_density": WEIGHT / 10.0,
        "water": {
            "level": WET,
            "unit_weight": WATER_WEIGHT / cosine,
            "factor": [[0.0, 0.0], [1.0, 1.0]],
        },
    }
    stronger = varied(model, changes)
    factor = associated_factor(stronger, pressure)
    normal, shear = base_stresses(pressure)
    above = (THICKNESS - WET) / THICKNESS
    dry_normal, dry_shear = (above * each for each in base_stresses())
    # the circle of stress touches the reduced strength on planes along the slope
    twice = 2.0 * strength_of(stronger)[1] / factor
    upper, lower = dry_normal + twice * dry_shear, normal + twice * shear
    rows = [[0.0, 0.0], [THICKNESS - WET, upper], [THICKNESS, lower]]
    ends = {
        "loads.1.pressure_along": rows,
        "loads.2.pressure_along": [[THICKNESS - z, stress] for z, stress in reversed(rows)],
    }
    return varied(stronger, ends), factor


def strength_of(model: Model) -> tuple[float, float]:
    """Returns cohesion [stress] and tan(phi) [-] of the layer."""
    soil = model.materials["soil"]
    assert isinstance(soil, MohrCoulomb)
    friction = math.radians(soil.parameter("friction_angle"))
    return soil.parameter("cohesion"), math.tan(friction)


def base_stresses(pore_pressure: float = 0.0) -> tuple[float, float]:
    """Returns effective normal stress, compression positive, and shear stress at the base [Pa]."""
    slope = math.radians(SLOPE)
    whole = WEIGHT * THICKNESS
    return whole * math.cos(slope) - pore_pressure, whole * math.sin(slope)


def associated_factor(model: Model, pore_pressure: float = 0.0) -> float:
    """Returns (c + sigma' tan phi) / tau at the base [-]."""
    (c, tangent), (normal, shear) = strength_of(model), base_stresses(pore_pressure)
    return (c + normal * tangent) / shear


def factor_without_dilation(model: Model) -> float:
    """Returns the factor for flow without change of volume [-].

    The layer shears along its base without extending along it, so that the principal strain
    increments, and with them the stresses, are at 45 degrees: the circle of stress is centred at
    sigma', and its radius (c cos(phi) + sigma' sin(phi)) is the shear stress.
    """
    (c, tangent), (normal, shear) = strength_of(model), base_stresses()

    def excess(factor: float) -> float:
        reduced = tangent / factor
        return (c / factor + normal * reduced) / math.sqrt(1.0 + reduced**2) - shear

    return float(brentq(excess, 0.1, 10.0))
