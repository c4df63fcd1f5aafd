# SPDX-License-Identifier: BSD-3-Clause
"""The surfaces of a model's rigid bodies, and where the bodies are in a simulation."""

from __future__ import annotations

import numpy as np

from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.geometry.make import make_shapes
from tilth.geometry.rigid import RigidShape
from tilth.model import Model
from tilth.mpm.points import MaterialPoints


def rigid_shapes(model: Model, initial: MaterialPoints) -> dict[str, RigidShape]:
    """Returns the surfaces of all rigid bodies by their names; facets are half a cell long.

    initial: the undeformed points, whose box is that of unbounded shapes.

    Raises:
        BadInput: a file or function of a shape cannot be used.
    """
    cell = np.array(model.cell_size)
    half = initial.initial_half_length
    lower = (initial.position - half).min(axis=0) - 2.0 * cell
    upper = (initial.position + half).max(axis=0) + 2.0 * cell
    return {
        body.name: RigidShape(
            body.name,
            make_shapes(body, model),
            np.array(body.centre),
            0.5 * float(cell.min()),
            lower,
            upper,
            model.analysis.kind == "axisymmetric",
        )
        for body in model.rigid_bodies
    }


def placed(simulation: Simulation, name: str) -> tuple[Floats, Floats]:
    """Returns displacement (dim,) [length] and rotation vector (3,) [rad] of a rigid body.

    Zeros before its first step.
    """
    state = simulation.rigid_bodies.get(name)
    if state is None:
        return np.zeros(simulation.model.dimension), np.zeros(3)
    return state.displacement, state.rotation
