# SPDX-License-Identifier: BSD-3-Clause
"""Outlines and visible sides of the points' domains, from their corners (x fastest)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.corners import corner_signs
from tilth.output.snapshot import Snapshot


def corners_of_boxes(half_lengths: Floats) -> Floats:
    """Returns corners (n, 2**dim, dim) of boxes with half lengths (n, dim), relative to centres."""
    return corner_signs(half_lengths.shape[1]) * half_lengths[:, None, :]


def corners_of(snapshot: Snapshot) -> Floats | None:
    """Returns the corners of the points' domains, relative to them, (n, 2**dim, dim), or None."""
    fields = snapshot.point_fields
    if "domain_corners" in fields or "domain" not in fields:
        return fields.get("domain_corners")
    return corners_of_boxes(fields["domain"])


def outlines(position: Floats, corners: Floats) -> Floats:
    """Returns the corners of plane domains along their outline [length], shape (n, 4, 2)."""
    return position[:, None, :] + corners[:, [0, 1, 3, 2]]


def drawn_at_once(area: Floats) -> Sequence[Floats]:
    """Returns polygons (n, k, 2) as matplotlib's collections take them.

    They make the paths of an array at once, of a list one by one; their type asks for a list.
    """
    return cast(Sequence[Floats], area)


def sides_towards(
    position: Floats, corners: Floats, viewer: Floats
) -> tuple[Floats, Floats, Integers]:
    """Returns the sides of domains in space that face the viewer, domain by domain.

    ``viewer`` is the direction to the viewer, shape (3,). The results are the sides' corners
    [length], shape (k, 4, 3), their outward unit normals, (k, 3), and their domains, (k,).
    """
    sides = []
    for axis in range(3):
        first, second = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
        around = np.array([0, second, first + second, first])
        sides += [corners[:, around], corners[:, around[::-1] + (1 << axis)]]
    normals = np.stack([_normal(side) for side in sides], axis=1)
    number, side = np.nonzero(normals @ viewer > 0.0)
    side_corners = position[number, None, :] + np.stack(sides, axis=1)[number, side]
    return side_corners, normals[number, side], number


def _normal(side: Floats) -> Floats:
    """Returns the unit normals of sides (n, 4, 3), right-handed with their corners, (n, 3)."""
    across = np.cross(side[:, 2] - side[:, 0], side[:, 3] - side[:, 1])
    return np.asarray(across / np.linalg.norm(across, axis=1, keepdims=True))
