# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that overlap: their material would count twice."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.arrays import Integers
from tilth.bodies.corners import corner_signs
from tilth.bodies.discretise import inside_body
from tilth.grid.background import background_grid
from tilth.model import Model
from tilth.mpm.points import MaterialPoints

INNER_SHARE = 0.5
"""A point is inside another body if the part of its domain of this relative size is: so bodies that
touch, with a curved side approximated by a polygon or a mesh, do not overlap."""


def overlapping_bodies(model: Model, points: MaterialPoints) -> Iterator[tuple[int, int, Integers]]:
    """Yields pairs of bodies that overlap, with the points of the first inside the other.

    Bodies are numbers in the model, points are indices, shape (k,). The first body is the one with
    more points inside the other.

    Raises:
        BadInput: the mesh of a body cannot be read.
    """
    for one, other in _near_pairs(points):
        found = [
            (body, host, _points_inside(model, points, body, host))
            for body, host in ((one, other), (other, one))
        ]
        most = max(found, key=lambda each: len(each[2]))
        if len(most[2]):
            yield most


def _near_pairs(points: MaterialPoints) -> list[tuple[int, int]]:
    """Returns the pairs of bodies of which one has points within the bounds of the other."""
    there = points.whole_bodies()
    inner, outer = (
        np.array(
            [
                [(x - share * h).min(axis=0), (x + share * h).max(axis=0)]
                for x, h in ((points.position[own], points.half_length[own]) for _, own in there)
            ]
        )
        for share in (0.0, 1.0)
    )
    lower, upper = inner[:, None, 0], inner[:, None, 1]
    near = ((lower <= outer[None, :, 1]) & (upper >= outer[None, :, 0])).all(axis=2)
    first, second = np.nonzero(np.triu(near | near.T, 1))
    return [(there[i][0].body, there[j][0].body) for i, j in zip(first, second, strict=True)]


def _points_inside(model: Model, points: MaterialPoints, body: int, host: int) -> Integers:
    """Returns the points of a body that are inside the shape of another."""
    own, others = (points.of_body(model.bodies[i].name) for i in (body, host))
    lower = (points.position[others] - points.half_length[others]).min(axis=0)
    upper = (points.position[others] + points.half_length[others]).max(axis=0)
    position = points.position[own]
    within_bounds = ((position >= lower) & (position <= upper)).all(axis=1)
    near: Integers = np.flatnonzero(within_bounds) + int(own.start)
    if len(near) == 0:
        return near
    inside = inside_body(model.bodies[host], model.analysis.kind, background_grid(model))
    near = near[inside(points.position[near])]
    corners = points.all_corners()
    if corners is None:
        corner = corner_signs(model.dimension) * points.half_length[near, None]
    else:
        corner = corners[near]
    inner = points.position[near, None] + INNER_SHARE * corner
    within = inside(inner.reshape(-1, model.dimension)).reshape(inner.shape[:2])
    return near[within.all(axis=1)]
