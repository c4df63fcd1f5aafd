# SPDX-License-Identifier: BSD-3-Clause
"""The shear strength that the soil itself has at the material points."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.points import MaterialPoints


def shear_strength(points: MaterialPoints, model: Model) -> tuple[Floats, Floats]:
    """Returns the present cohesion [stress] and tan(phi) [-] of the points, shape (n,) each.

    A plane that carries the pressure p bears the shear stress c + p tan(phi); the materials say
    what that is (`AnyMaterial.shear_strength`). Both are NaN for a law without such a strength. p
    is the effective pressure where the law is one of effective stress.

    Args:
        points: with their plastic strains, on which the strength may depend.
        model: of their stage, which has their materials.
    """
    cohesion, tangent = np.full((2, len(points)), np.nan)
    for range_ in points.ranges:
        material = model.materials[model.bodies[range_.body].materials[range_.layer]]
        if not material.has_shear_strength:
            continue
        values = np.moveaxis(points.parameters_of(range_), -1, 0)
        columns = dict(zip(material.parameter_names, values, strict=True))
        found = material.shear_strength(columns, points.plastic[range_.points, 0])
        cohesion[range_.points], tangent[range_.points] = found
    return cohesion, tangent
