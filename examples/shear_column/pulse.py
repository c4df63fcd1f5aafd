# SPDX-License-Identifier: BSD-3-Clause
"""Velocity of a pulse in the middle of a bar of length 1 m, turned by 30 degrees."""

import numpy as np

ALONG = np.array([np.cos(np.radians(30.0)), np.sin(np.radians(30.0))])
AMPLITUDE = 1e-4
"""[m/s]"""


def speed(along):
    """Returns the velocity along the bar [m/s] at distances from its lower end [m]."""
    return AMPLITUDE * np.exp(-(((along - 0.5) / 0.08) ** 2))


def velocity_x(position):
    """Returns the velocity along x [m/s], shape (n,), at positions (n, 2) [m]."""
    return ALONG[0] * speed(position @ ALONG)


def velocity_y(position):
    """Returns the velocity along y [m/s], shape (n,), at positions (n, 2) [m]."""
    return ALONG[1] * speed(position @ ALONG)


def of_straight_bar(position):
    """Returns the velocity [m/s], shape (n,), of a bar along x at positions (n, 2) [m]."""
    return speed(position[:, 0])
