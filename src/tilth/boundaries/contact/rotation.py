# SPDX-License-Identifier: BSD-3-Clause
"""Finite rotations by rotation vectors, and the displacement of a rigid body's points.

In the plane a rotation vector has one component, the angle; in space three (Rodrigues' formula).
"""

from __future__ import annotations

import math

import numpy as np

from tilth.arrays import Floats

SMALL_ANGLE = 0.1
"""Angle [rad] below which series replace the quotients of sines and cosines, which cancel there."""

DIFFERENCE = 1e-5
"""Step of the central differences for second derivatives in space [rad]."""


def rotation_by(vector: Floats) -> Floats:
    """Returns the rotation matrix of a rotation vector [rad], (1,) or (3,), shape (dim, dim)."""
    if len(vector) == 1:
        cosine, sine = math.cos(vector[0]), math.sin(vector[0])
        return np.array([[cosine, -sine], [sine, cosine]])
    angle = float(np.linalg.norm(vector))
    spin = cross_matrix(vector)
    first, second, _ = _quotients(angle)
    return np.eye(3) + first * spin + second * spin @ spin


def vector_of(rotation: Floats) -> Floats:
    """Returns the rotation vector [rad] of a rotation matrix (dim, dim), at most pi long."""
    if len(rotation) == 2:
        return np.array([math.atan2(rotation[1, 0], rotation[0, 0])])
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_matrix(rotation).as_rotvec())


def vector_near(rotation: Floats, vector: Floats) -> Floats:
    """Returns the rotation vector [rad] of a matrix (3, 3) that is nearest to a vector, (3,).

    Rotation vectors that differ by whole turns about their axis belong to the same matrix.
    """
    found = vector_of(rotation)
    angle = float(np.linalg.norm(found))
    if angle == 0.0:
        return found
    axis = found / angle
    turns = round((float(vector @ axis) - angle) / (2.0 * math.pi))
    return np.asarray(axis * (angle + 2.0 * math.pi * turns))


def rotated_by(vector: Floats, arm: Floats) -> Floats:
    """Returns the displacements (R - I) arm [length], shape (n, dim), of arms of this shape."""
    return np.asarray(arm @ (rotation_by(vector) - np.eye(arm.shape[1])).T)


def derivative(vector: Floats, arm: Floats) -> Floats:
    """Returns the derivative of `rotated_by` by the components of the vector, (1 or 3, n, dim)."""
    turned = arm @ rotation_by(vector).T
    if len(vector) == 1:
        return np.stack([-turned[:, 1], turned[:, 0]], axis=1)[None]
    axes = left_jacobian(vector).T  # of each component: the axis of the further rotation
    return np.stack([np.cross(axis, turned) for axis in axes])


def second_derivative(vector: Floats, arm: Floats) -> Floats:
    """Returns the second derivative of `rotated_by`, shape (1 or 3, 1 or 3, n, dim)."""
    if len(vector) == 1:
        return np.asarray(-(arm @ rotation_by(vector).T)[None, None])
    parts = []
    for unit in np.eye(3):
        forward = derivative(vector + DIFFERENCE * unit, arm)
        backward = derivative(vector - DIFFERENCE * unit, arm)
        parts.append((forward - backward) / (2.0 * DIFFERENCE))
    return np.stack(parts, axis=1)


def left_jacobian(vector: Floats) -> Floats:
    """Returns J with the further rotation J dv at the vector v, shape (1, 1) or (3, 3)."""
    if len(vector) == 1:
        return np.eye(1)
    spin = cross_matrix(vector)
    _, second, third = _quotients(float(np.linalg.norm(vector)))
    return np.eye(3) + second * spin + third * spin @ spin


def left_jacobian_derivative(vector: Floats, moment: Floats) -> Floats:
    """Returns the derivative of J^T times a moment by the vector, shape (1, 1) or (3, 3)."""
    if len(vector) == 1:
        return np.zeros((1, 1))
    columns = []
    for unit in np.eye(3):
        forward = left_jacobian(vector + DIFFERENCE * unit)
        backward = left_jacobian(vector - DIFFERENCE * unit)
        columns.append((forward - backward).T @ moment / (2.0 * DIFFERENCE))
    return np.stack(columns, axis=1)


def cross_matrix(vector: Floats) -> Floats:
    """Returns the matrix of the cross product with a vector (3,), shape (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _quotients(angle: float) -> tuple[float, float, float]:
    """Returns sin(a)/a, (1 - cos(a))/a^2 and (a - sin(a))/a^3."""
    square = angle * angle
    if angle < SMALL_ANGLE:
        return _series(1, square), _series(2, square), _series(3, square)
    return (
        math.sin(angle) / angle,
        (1.0 - math.cos(angle)) / square,
        (angle - math.sin(angle)) / (square * angle),
    )


def _series(first: int, square: float) -> float:
    """Returns the sum of (-a^2)^k / (first + 2 k)! to round-off, for a square a^2 [-]."""
    return sum((-square) ** k / math.factorial(first + 2 * k) for k in range(6))
