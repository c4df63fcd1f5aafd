# SPDX-License-Identifier: BSD-3-Clause
"""Whether the domains of a body's points fill its shape, as well as their distance allows.

The volumes of points that are the centres of a lattice's sub-cells are multiplied by one factor, so
that they sum to the volume of the shape. Parts of the shape between the centres are so made up for
by the others, and the factor tells how much there is of them.
"""

from __future__ import annotations

import numpy as np

from tilth import grid_lines
from tilth.arrays import Integers
from tilth.bodies.request import BodyPoints, Request

ROUND_OFF = 1e-9
"""Difference of two volumes over the larger one that is none."""


def require_filled(points: BodyPoints, request: Request) -> None:
    """Refuses points whose domains differ more from their shape than its surface allows.

    Where the surface crosses a line of centres, the length within differs by at most half a
    sub-cell from that of the sub-cells whose centres are within. Summed over the lines along each
    axis, this is half a sub-cell's volume for each side between a sub-cell with a point and one
    without; what is beyond comes from parts that no line of centres meets.

    Args:
        points: of the body, before domains are cut at an axis of symmetry.
        request: its resolution.

    Raises:
        BadInput: the volumes differ by more than this bound.
    """
    if points.corner is not None:  # they fill the elements, and their volumes are theirs
        return
    own = request.circumference(points.position) * np.prod(2.0 * points.half_length, axis=1)
    filled, volume = float(own.sum()), float(points.volume.sum())
    difference = volume - filled
    if abs(difference) <= ROUND_OFF * max(filled, volume):
        return
    bound = 0.5 * float(own @ _open_sides(points, request))
    if abs(difference) <= bound:
        return
    raise request.refused(
        f"the domains of its points fill {filled:.4g} of the volume {volume:.4g} of the shape, "
        f"and its surface explains a difference of {bound:.3g} at most: parts that are thinner "
        "than the distance of the points have none",
        "use more points per cell, a smaller spacing or a finer grid, or leave these parts out",
        request.resolution,
    )


def _open_sides(points: BodyPoints, request: Request) -> Integers:
    """Returns how many sides of each sub-cell have no point beyond them, shape (n,)."""
    index = _sub_cells(points, request)
    index = index - index.min(axis=0) + 1
    shape = tuple(index.max(axis=0) + 2)
    key = np.ravel_multi_index(tuple(index.T), shape)
    taken = np.sort(key)
    sides = np.full(len(key), 2 * index.shape[1], dtype=np.int64)
    for k in range(index.shape[1]):
        step = int(np.prod(shape[k + 1 :], dtype=np.int64))
        for beside in (key - step, key + step):
            place = np.minimum(np.searchsorted(taken, beside), len(taken) - 1)
            sides -= taken[place] == beside
    return sides


def _sub_cells(points: BodyPoints, request: Request) -> Integers:
    """Returns the indices of the sub-cells whose centres the points are, shape (n, d)."""
    grid, width = request.grid, 2.0 * points.half_length[0]
    place = points.position - points.position[0]
    if points.frame is not None:
        place = place @ points.frame
    index = np.rint(place / width)
    for k, per_cell in request.per_graded_cell.items():
        cells = grid_lines.in_cells(points.position[:, k] - grid.origin[k], grid.lines[k])
        index[:, k] = np.floor(per_cell * cells)
    return np.asarray(index, dtype=np.int64)
