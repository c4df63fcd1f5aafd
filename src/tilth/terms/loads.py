# SPDX-License-Identifier: BSD-3-Clause
"""Loads on the material points: body forces on their mass, and point forces."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.model import BodyForce, Model, PointForce
from tilth.mpm.points import MaterialPoints

DISTANCE_TOLERANCE = 1e-6
"""Difference of distances, in cells, up to which points are equally near to a position."""


def nearest_points(
    points: MaterialPoints,
    position: npt.ArrayLike,
    cell_size: npt.ArrayLike,
    body: str | None = None,
) -> Integers:
    """Returns the permanent numbers of all points that are nearest to a position [length], (k,).

    body: name of the body to which the points belong; any if not given.
    """
    chosen = np.arange(len(points))
    if body is not None:
        chosen = chosen[points.of_body(body)]
    distance = np.linalg.norm(points.position[chosen] - np.asarray(position), axis=1)
    tolerance = DISTANCE_TOLERANCE * float(np.min(np.asarray(cell_size)))
    near = chosen[distance <= distance.min() + tolerance]
    return np.sort(points.point_id[near])


class Loads:
    """The loads of a model on its points.

    Attributes:
        on_points: each point force with the permanent numbers of its points and its load curve.
    """

    def __init__(self, model: Model, points: MaterialPoints) -> None:
        self._body_forces = [
            (np.array(load.acceleration), model.load_curve(load))
            for _, load in model.acting_loads()
            if isinstance(load, BodyForce)
        ]
        self.on_points = [
            (
                load,
                nearest_points(points, load.at, model.cell_size, load.body),
                model.load_curve(load),
            )
            for _, load in model.acting_loads()
            if isinstance(load, PointForce)
        ]

    def __bool__(self) -> bool:
        return bool(self._body_forces or self.on_points)

    @property
    def acts_on_mass(self) -> bool:
        """Whether there are body forces."""
        return bool(self._body_forces)

    def acceleration(self, time: float) -> Floats:
        """Returns the sum of all body forces per mass at `time` [acceleration], shape (dim,)."""
        parts = [curve.factor(time) * acceleration for acceleration, curve in self._body_forces]
        return np.asarray(np.sum(parts, axis=0))

    def force(self, points: MaterialPoints, time: float) -> Floats:
        """Returns the external force on each point at `time` [force], shape (n, dim)."""
        if self._body_forces:
            force = points.mass[:, None] * self.acceleration(time)
        else:
            force = np.zeros(points.position.shape)
        for load, ids, curve in self.on_points:
            share = curve.factor(time) / len(ids)
            force[points.index_of(ids)] += share * np.asarray(load.force)
        return force
