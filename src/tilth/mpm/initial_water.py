# SPDX-License-Identifier: BSD-3-Clause
"""Water in the pores of the material points at the start."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import (
    CONDUCTIVITY,
    POROSITY,
    PRESSURE,
    STORED,
    VELOCITY,
    PoreWater,
)
from tilth.variation.evaluate import parameter_values


def initial_water(model: Model, points: MaterialPoints) -> Floats:
    """Returns the water of the undeformed points of all bodies, see `MaterialPoints.water`.

    Raises:
        BadInput: a place outside a table or a grid, or a function that fails.
    """
    flow = model.flow
    if flow is None:
        return np.zeros((len(points), 0))
    changes = 2 if flow.scheme == "bdf2" else 0
    water = np.zeros((len(points), VELOCITY + model.dimension + changes))
    for range_ in points.ranges:
        material = model.materials[model.bodies[range_.body].materials[range_.layer]]
        if material.conducts_water:
            own = range_.points
            for column, key in ((POROSITY, "porosity"), (CONDUCTIVITY, "hydraulic_conductivity")):
                value = getattr(material, key)
                varies = not isinstance(value, float)
                water[own, column] = points.varying[key][own] if varies else value
            water[own, CONDUCTIVITY] *= material.principal_ratios[0]
    water[:, CONDUCTIVITY] /= flow.unit_weight
    wet = water[:, POROSITY] > 0.0
    for i, entry in enumerate(model.initial.pore_pressure):
        own = points.of_body(entry.body)
        given = parameter_values(entry, points.position[own], f"initial.pore_pressure[{i}]")
        pressure = given.get("excess_pore_pressure", entry.excess_pore_pressure)
        water[own, PRESSURE] = np.where(wet[own], pressure, 0.0)
    pores = PoreWater.of(points, water, flow.bulk_modulus or np.inf)
    water[:, STORED] = np.where(wet, pores.stored(np.ones(len(points)), water[:, PRESSURE]), 0.0)
    return water
