# SPDX-License-Identifier: BSD-3-Clause
"""Water of material points whose material is exchanged."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import CONDUCTIVITY, POROSITY, PRESSURE, STORED


def exchanged_water(points: MaterialPoints, initial: MaterialPoints, bulk_modulus: float) -> Floats:
    """Returns the water of points with the pores of new materials, see `MaterialPoints.water`.

    The excess pressure stays; in soil whose water begins to flow it is that of its undrained law,
    0 without. Pores are then full, and so they are where the new material has others. Soil in which
    water does not flow any more has none.

    Args:
        points: as they are.
        initial: undeformed points of all bodies of all stages, with the new materials.
        bulk_modulus: K_w of the water [stress].
    """
    water = points.water.copy()
    if water.shape[1] == 0:
        return water
    new = initial.water[points.point_id]
    before, after = water[:, POROSITY].copy(), new[:, POROSITY]
    water[:, POROSITY], water[:, CONDUCTIVITY] = after, new[:, CONDUCTIVITY]
    begins = (before == 0.0) & (after > 0.0)
    if begins.any() and EXCESS_PORE_PRESSURE in points.state_variables():
        excess = np.nan_to_num(points.state_variable(EXCESS_PORE_PRESSURE))
        water[begins, PRESSURE] = (excess / points.stress_jacobian)[begins]
    jacobian = np.linalg.det(points.deformation_gradient)
    before[begins] = 1.0 - jacobian[begins]  # no water before
    compressed = np.exp(water[:, PRESSURE] / bulk_modulus)
    water[:, STORED] += (after - before) * compressed
    water[after == 0.0] = 0.0
    return water
