# SPDX-License-Identifier: BSD-3-Clause
"""Limits on the size of the points' domains, and the largest extent of a domain from its point."""

from __future__ import annotations

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.corners import mean_half_edges
from tilth.mpm.grid import Grid
from tilth.mpm.points import MaterialPoints

LEAST_HALF_LENGTH = 1e-3
"""Half lengths stay above this share of a cell; only a degenerate update comes so far."""

LARGEST_HALF_LENGTH = 0.5
"""Half lengths stay below this share of a cell, so that a point touches at most two per axis."""


def bound_domains(points: MaterialPoints, grid: Grid) -> dict[str, int]:
    """Clips half lengths to [1e-3, 0.5] cells; returns how many points each bound held.

    Keys: "floor" and "cap". Only bodies whose basis has a domain are looked at.
    """
    held = {"floor": 0, "cap": 0}
    round_off = 1e-12
    low = LEAST_HALF_LENGTH * grid.cell_size
    high = LARGEST_HALF_LENGTH * grid.cell_size
    for body in points.bodies:
        if body.domain_update is None:
            continue
        half = points.half_length[body.start : body.stop]
        held["floor"] += int((half < low).any(axis=1).sum())
        held["cap"] += int((half > high * (1.0 + round_off)).any(axis=1).sum())
        half.clip(low, high, out=half)
    return held


def keep_off_axis(part: MaterialPoints) -> None:
    """Shrinks the domains of one body that F carried across the axis of symmetry.

    Their corners' distances from the point, along the radius, are reduced in one proportion, so
    that the domain ends at the axis: it stays a parallelogram with the point in its middle.
    """
    radius, inwards = part.position[:, 0], -part.corner[:, :, 0].min(axis=1)
    across = inwards > radius
    part.corner[across, :, 0] *= (np.maximum(radius, 0.0) / inwards)[across, None]


def half_edges(points: MaterialPoints, chosen: Integers | None = None) -> Floats | None:
    """Returns half the edges of parallelepipeds that stand for the domains, shape (n, dim, dim).

    Row k of a matrix is an edge, the one along x first [length]. Of CPDI1 they are the domain's
    own; of CPDI2 their mean directions, so long that the ellipsoid through the corners of the
    parallelepiped holds those of the domain. None if no body's basis has corners.

    chosen: numbers of the points, all if not given.
    """
    corners = points.all_corners()
    if corners is None:
        return None
    if chosen is not None:
        corners = corners[chosen]
    dim = corners.shape[2]
    edges = mean_half_edges(corners)
    place = np.einsum("nci,nik->nck", corners, np.linalg.inv(edges))
    farthest = np.sqrt((place**2).sum(axis=2).max(axis=1) / dim)
    return np.asarray(edges * np.maximum(farthest, 1.0)[:, None, None])


def upper_edges(points: MaterialPoints) -> Floats:
    """Returns the greatest coordinates of the points' domains [length], shape (n, dim)."""
    corners = points.all_corners()
    reach = points.half_length if corners is None else corners.max(axis=1)
    return np.asarray(points.position + reach)
