# SPDX-License-Identifier: BSD-3-Clause
"""Outlines of the points' domains, from their corners (x fastest, seen from the points)."""

from __future__ import annotations

import numpy as np

from ..output.snapshot import FloatArray


def corners_of_boxes(half_lengths: FloatArray) -> FloatArray:
    """Corners of boxes with these half lengths, shape (n, dim) -> (n, 2**dim, dim)."""
    dim = half_lengths.shape[1]
    signs = 2.0 * ((np.arange(2**dim)[:, None] >> np.arange(dim)) & 1) - 1.0
    return signs * half_lengths[:, None, :]


def outlines(position: FloatArray, corners: FloatArray) -> FloatArray:
    """Places of the corners of plane domains along their outline, shape (n, 4, 2)."""
    return position[:, None, :] + corners[:, [0, 1, 3, 2]]


def sides_towards(
    position: FloatArray, corners: FloatArray, viewer: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Of each two opposite sides of domains in space the one that faces the viewer.

    ``viewer`` is the direction to the viewer, shape (3,). Returns places of the sides' corners,
    shape (3, n, 4, 3), and their outward unit normals, (3, n, 3).
    """
    sides, normals = [], []
    for axis in range(3):
        first, second = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
        around = np.array([0, first, first + second, second])
        lower, upper = corners[:, around], corners[:, around + (1 << axis)]
        inwards, outwards = _normal(lower), _normal(upper)
        chosen = (outwards @ viewer >= -(inwards @ viewer))[:, None]
        sides.append(position[:, None, :] + np.where(chosen[..., None], upper, lower))
        normals.append(np.where(chosen, outwards, -inwards))
    return np.stack(sides), np.stack(normals)


def _normal(side: FloatArray) -> FloatArray:
    """Unit normals of sides (n, 4, 3), right-handed with the order of their corners, (n, 3)."""
    across = np.cross(side[:, 2] - side[:, 0], side[:, 3] - side[:, 1])
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))
