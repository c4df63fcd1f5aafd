# SPDX-License-Identifier: BSD-3-Clause
"""What soil carries from node to node in the plane, with basis functions evaluated here."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats
from tilth.mpm.active_grid import ActiveGrid
from tilth.mpm.points import MaterialPoints


def _hat(x: Floats) -> Floats:
    return np.maximum(1.0 - np.abs(x), 0.0)


def _integral_of_hat(x: Floats) -> Floats:
    """From minus infinity."""
    x = np.clip(x, -1.0, 1.0)
    return np.where(x < 0.0, 0.5 * (1.0 + x) ** 2, 1.0 - 0.5 * (1.0 - x) ** 2)


def shape_functions(points: MaterialPoints, active: ActiveGrid) -> tuple[Floats, Floats]:
    """Returns values [-] and gradients [1/length] of all nodes' functions at points in the plane.

    points: all with the linear basis, or all with GIMP.

    Returns:
        Shapes (nodes, n) and (nodes, n, 2).
    """
    size = active.grid.cell_size
    away = (points.position[None] - active.position[:, None]) / size
    if points.ranges[0].basis == "linear":
        value, slope = _hat(away), np.where(np.abs(away) < 1.0, -np.sign(away), 0.0)
    else:
        half = points.half_length[None] / size
        value = (_integral_of_hat(away + half) - _integral_of_hat(away - half)) / (2.0 * half)
        slope = (_hat(away + half) - _hat(away - half)) / (2.0 * half)
    gradient = np.stack([slope[..., 0] * value[..., 1], value[..., 0] * slope[..., 1]], axis=-1)
    return value.prod(axis=-1), gradient / size


def carried(points: MaterialPoints, active: ActiveGrid, acceleration: Floats) -> Floats:
    """Returns the sum of V sigma grad S less that of m S g over points [force], (nodes, 2).

    acceleration: g [length / time^2], shape (2,).
    """
    value, gradient = shape_functions(points, active)
    xx, yy, _, xy, _, _ = points.stress.T
    stress = np.stack([xx, xy, xy, yy], axis=-1).reshape(-1, 2, 2)
    internal = np.einsum("n,nij,anj->ai", points.volume, stress, gradient)
    return np.asarray(internal - (value @ points.mass)[:, None] * acceleration)
