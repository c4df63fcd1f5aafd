# SPDX-License-Identifier: BSD-3-Clause
"""Velocity of the first mode of a bar of length 1 m, fixed at x = 0 and free at x = 1 m."""

import numpy as np

AMPLITUDE = 1e-5
"""At the free end [m/s]; the strain is at most 1.6e-7."""


def velocity(position):
    """Returns the velocity along x [m/s], shape (n,), at positions (n, 2) [m]."""
    return AMPLITUDE * np.sin(0.5 * np.pi * position[:, 0])
