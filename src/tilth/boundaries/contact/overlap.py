# SPDX-License-Identifier: BSD-3-Clause
"""Soil inside a rigid body at the start: the material points there, and how deep it reaches."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.corners import corner_signs
from tilth.mpm.points import MaterialPoints


def soil_inside(
    distance: Callable[[Floats], Floats], points: MaterialPoints, tolerance: float
) -> tuple[Integers, float]:
    """Returns the material points inside a closed shape, and the depth that soil reaches in it.

    Args:
        distance: returns the signed distance of positions (m, dim) [length] from the shape, < 0
            inside, shape (m,).
        points: the material points.
        tolerance: points less deep than this are not inside [length].

    Returns:
        The indices of the points whose centre is inside, shape (k,), and the largest depth of
        their and all other points' domains [length], 0 without overlap: that of the corners, the
        centres of the faces and the centre of a domain.
    """
    of_centre = np.asarray(distance(points.position))
    near = np.flatnonzero(of_centre < np.linalg.norm(points.half_length, axis=1))
    if not len(near):
        return near, 0.0
    dim, corners = points.position.shape[1], points.all_corners()
    signs = corner_signs(dim)
    corner = signs * points.half_length[near, None] if corners is None else corners[near]
    # the centre of a face is the mean of its corners
    face = np.concatenate([signs.T > 0.0, signs.T < 0.0]) / 2.0 ** (dim - 1)
    places = [corner, np.einsum("fc,nci->nfi", face, corner), np.zeros((len(near), 1, dim))]
    place = points.position[near, None] + np.concatenate(places, axis=1)
    least = float(np.min(distance(place.reshape(-1, dim))))
    return np.flatnonzero(of_centre < -tolerance), max(0.0, -least)
