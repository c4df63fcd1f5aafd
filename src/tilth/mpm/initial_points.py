# SPDX-License-Identifier: BSD-3-Clause
"""Initial material points of a model."""

from __future__ import annotations

from functools import partial

import numpy as np

from tilth.arrays import Floats
from tilth.bodies import discretise
from tilth.model import Model
from tilth.model.isotropic import ParametersAt
from tilth.model.problems import dotted
from tilth.mpm.domains import keep_off_axis
from tilth.mpm.initial_stress import set_initial_stress
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.mpm.user_moduli import require_declared_moduli


def initial_points(model: Model) -> MaterialPoints:
    """Returns the undeformed material points of all bodies of a model, with their initial stress.

    Raises:
        BadInput: a body without points, a stress that its law cannot have, or a law of the user
            that cannot be loaded or has other moduli than the declared ones.
    """
    bodies, parts, start = [], [], 0
    varying: dict[str, Floats] = {}
    cell_length = float(np.prod(model.cell_size)) ** (1.0 / model.dimension)
    for body in model.bodies:
        part = discretise(body, model.analysis.kind, model.dimension, model.origin, model.cell_size)
        material, law = model.materials[body.material], model.laws[body.material]
        at = ParametersAt(partial(getattr, material), cell_length)
        parameters = material.parameter_array(at, len(part.position))
        require_declared_moduli(law, parameters, dotted(("materials", body.material)))
        if parameters.ndim == 2:
            varying[body.name] = parameters
        bodies.append(
            PointRange(
                name=body.name,
                start=start,
                stop=start + len(part.position),
                basis=body.basis,
                domain_update=body.domain_update,
                law=law,
                parameters=parameters if parameters.ndim == 1 else None,
                density=material.density or 0.0,
                anti_locking=body.anti_locking,
            )
        )
        parts.append(part)
        start += len(part.position)
    corners = any(body.has_corners for body in bodies)
    points = MaterialPoints.undeformed(
        bodies,
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.volume for part in parts]),
        np.concatenate([part.half_length for part in parts]),
        np.concatenate([part.corners() for part in parts]) if corners else None,
        varying,
    )
    set_initial_stress(points, model)
    if model.analysis.kind == "axisymmetric":
        for point_range in bodies:
            if point_range.convected_by_gradient:
                keep_off_axis(points.part(point_range))
        points.update_bounding_boxes()
    return points
