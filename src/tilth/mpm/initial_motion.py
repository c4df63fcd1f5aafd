# SPDX-License-Identifier: BSD-3-Clause
"""Velocity of the material points at the start."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.model import Model
from tilth.model.fields import AXES
from tilth.mpm.points import MaterialPoints
from tilth.variation.evaluate import parameter_values


def initial_motion(points: MaterialPoints, model: Model) -> Floats:
    """Returns velocity and two zero accelerations at the start, shape (n, 3, dim).

    points: the undeformed points of all bodies.

    Raises:
        BadInput: a place outside a table or a grid, or a function that fails.
    """
    dim = model.dimension
    motion = np.zeros((len(points), 3, dim))
    for i, entry in enumerate(model.initial.velocity):
        own = points.of_body(entry.body)
        position = points.position[own]
        varying = parameter_values(entry, position, f"initial.velocity[{i}]")
        for k in range(dim):
            motion[own, 0, k] = varying.get(AXES[k], getattr(entry, AXES[k]))
        if entry.angular_velocity is not None:
            arm = position - np.array(entry.centre)
            motion[own, 0] += _rotating(entry.angular_velocity, arm)
    return motion


def _rotating(angular_velocity: object, arm: Floats) -> Floats:
    """Returns omega x arm, shape (n, dim)."""
    if arm.shape[1] == 2:
        turned = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        return np.asarray(turned * np.asarray(angular_velocity))
    return np.asarray(np.cross(np.asarray(angular_velocity), arm))
