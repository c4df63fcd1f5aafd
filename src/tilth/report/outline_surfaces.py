# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in the plane as the outline of a body: which side is soil, vertices along."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.output.snapshot import SurfaceShape


def of_bodies(
    position: Floats, body_id: Integers, surfaces: Sequence[SurfaceShape]
) -> dict[int, list[SurfaceShape]]:
    """Returns the surfaces by the number of the body that is nearest to most of their vertices."""
    from scipy.spatial import cKDTree

    found: dict[int, list[SurfaceShape]] = {}
    there = [shape for shape in surfaces if len(shape.cells)]
    if there and len(position):
        tree = cKDTree(position)
        for shape in there:
            near = body_id[tree.query(shape.position)[1]]
            body, count = np.unique(near, return_counts=True)
            found.setdefault(int(body[count.argmax()]), []).append(shape)
    return found


def vertices_along(surfaces: Sequence[SurfaceShape], distance: float) -> Floats:
    """Returns positions along the surfaces, at most ``distance`` apart, shape (n, 2)."""
    found = []
    for shape in surfaces:
        start, end = shape.position[shape.cells[:, 0]], shape.position[shape.cells[:, 1]]
        length = np.linalg.norm(end - start, axis=1)
        count = np.maximum(np.ceil(length / distance), 1.0).astype(np.int64)
        cell = np.repeat(np.arange(len(count)), count)
        place = (np.arange(len(cell)) - np.repeat(np.cumsum(count) - count, count)) / count[cell]
        found += [start[cell] + place[:, None] * (end - start)[cell], end[-1:]]
    return np.unique(np.concatenate(found), axis=0)


def inside_of(
    surfaces: Sequence[SurfaceShape], places: Floats, reach: float, margin: float
) -> Flags:
    """Returns which places, (n, 2), are on the soil's side of the surfaces by ``margin`` at least.

    All those are that are more than ``reach`` from a surface, or beyond its ends.
    """
    from scipy.spatial import cKDTree

    inside = np.ones(len(places), dtype=bool)
    for shape in surfaces:
        start, end = shape.position[shape.cells[:, 0]], shape.position[shape.cells[:, 1]]
        step = end - start
        longest = float(np.linalg.norm(step, axis=1).max())
        count = min(8, len(start))
        gap, cell = cKDTree(0.5 * (start + end)).query(places, k=[*range(1, count + 1)])
        near = np.flatnonzero(gap[:, 0] <= reach + longest)
        own = cell[near]
        offset = places[near][:, None, :] - start[own]
        along = (offset * step[own]).sum(axis=2) / np.maximum((step[own] ** 2).sum(axis=2), 1e-300)
        foot = np.clip(along, 0.0, 1.0)
        away = np.linalg.norm(offset - foot[:, :, None] * step[own], axis=2)
        nearest = away.argmin(axis=1)
        pick = np.arange(len(near)), nearest
        across = step[own][..., 0] * offset[..., 1] - step[own][..., 1] * offset[..., 0]
        across = across / np.maximum(np.linalg.norm(step[own], axis=2), 1e-300)
        # At a vertex both segments are equally near; the one that is seen more from its side tells.
        ties = away <= away[pick][:, None] * (1.0 + 1e-9) + 1e-12 * longest
        strength = np.where(ties, np.abs(across), -1.0).argmax(axis=1)
        height = across[np.arange(len(near)), strength]
        closed = shape.cells[0, 0] == shape.cells[-1, 1]
        chosen = own[np.arange(len(near)), strength]
        position_along = along[np.arange(len(near)), strength]
        beyond = ((chosen == 0) & (position_along < 0.0)) | (
            (chosen == len(start) - 1) & (position_along > 1.0)
        )
        judged = (away[pick] <= reach) & (closed | ~beyond)
        inside[near[judged & (height < margin)]] = False
    return inside
