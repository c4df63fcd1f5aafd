# SPDX-License-Identifier: BSD-3-Clause
"""Deformation gradients of six strain components, and their derivatives.

Components: xx yy zz xy yz xz, extension positive. Normal strains are logarithmic.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats
from tilth.element_tests.point import COLUMNS, ROWS

Kinematics = Callable[[Floats], tuple[Floats, Floats]]
"""Strain (6,) -> F (3, 3), dF / d strain (3, 3, 6)."""


def without_rotation(strain: Floats) -> tuple[Floats, Floats]:
    """Returns F = exp(E) of a symmetric strain E, and its derivative.

    strain: components of E [-], shape (6,). F is its own right and left stretch.
    The derivative is exact, by divided differences of exp in the principal axes of E (Daleckii &
    Krein; Higham, Functions of Matrices, 2008, thm. 3.11).
    """
    value, axis = np.linalg.eigh(symmetric(strain))
    half = 0.5 * (value[:, None] - value[None, :])
    small = np.abs(half) < 1e-4
    ratio = np.where(small, 1.0 + half**2 / 6.0, np.sinh(half) / np.where(small, 1.0, half))
    difference = np.exp(0.5 * (value[:, None] + value[None, :])) * ratio
    derivative = np.empty((3, 3, 6))
    for k in range(6):
        change = axis.T @ symmetric(np.eye(6)[k]) @ axis
        derivative[:, :, k] = axis @ (difference * change) @ axis.T
    return (axis * np.exp(value)) @ axis.T, derivative


def along_planes(strain: Floats) -> tuple[Floats, Floats]:
    """Returns F of simple shear and stretch, and its derivative.

    strain: logarithmic normal strains and the entries F_xy, F_yz, F_xz [-], shape (6,). Planes
    normal to y stay parallel to the x axis; F_xy is the displacement along x over the initial
    height.
    """
    gradient, derivative = np.zeros((3, 3)), np.zeros((3, 3, 6))
    for k, (i, j) in enumerate(zip(ROWS, COLUMNS, strict=True)):
        gradient[i, j] = np.exp(strain[k]) if k < 3 else strain[k]
        derivative[i, j, k] = gradient[i, j] if k < 3 else 1.0
    return gradient, derivative


def symmetric(components: Floats) -> Floats:
    """Returns the symmetric matrix, shape (3, 3), of six components."""
    matrix = np.empty((3, 3))
    matrix[ROWS, COLUMNS] = matrix[COLUMNS, ROWS] = components
    return matrix
