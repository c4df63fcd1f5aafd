# SPDX-License-Identifier: BSD-3-Clause
"""The surfaces of a model's rigid bodies, and where the bodies are in a state."""

from __future__ import annotations

import numpy as np

from tilth.analysis.state import State
from tilth.arrays import Floats
from tilth.geometry.make import make_shapes
from tilth.geometry.rigid import RigidShape
from tilth.grid.background import background_grid
from tilth.model import Model
from tilth.mpm.points import MaterialPoints


def rigid_shapes(model: Model, initial: MaterialPoints) -> dict[str, RigidShape]:
    """Returns the surfaces of all rigid bodies by their names; facets are half a cell long.

    initial: the undeformed points, whose box is that of unbounded shapes.

    Raises:
        BadInput: a file or function of a shape cannot be used.
    """
    grid, half = background_grid(model), initial.initial_half_length
    lower, upper = (initial.position - half).min(axis=0), (initial.position + half).max(axis=0)
    lower, upper = lower - 2.0 * grid.sizes_at(lower), upper + 2.0 * grid.sizes_at(upper)
    return {
        body.name: RigidShape(
            body.name,
            make_shapes(body, model),
            np.array(body.centre),
            0.5 * float(grid.cell_size.min()),
            lower,
            upper,
            model.analysis.kind == "axisymmetric",
        )
        for body in model.rigid_bodies
    }


def placed(state: State, name: str) -> tuple[Floats, Floats]:
    """Returns displacement (dim,) [length] and rotation vector (3,) [rad] of a rigid body.

    Zeros before its first step.
    """
    body = state.rigid_bodies.get(name)
    if body is None:
        return np.zeros(state.grid.dim), np.zeros(3)
    return body.displacement, body.rotation
