# SPDX-License-Identifier: BSD-3-Clause
"""Loads on the material points: body forces on their mass, and forces that ride on points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tilth.arrays import Floats, Integers
from tilth.model import BodyForce, Model, PointForce
from tilth.mpm.points import MaterialPoints

TIE = 1e-6
"""Points whose distances to a place differ by less than this share of a cell are equally near."""


def nearest_points(
    points: MaterialPoints, place: npt.ArrayLike, cell_size: npt.ArrayLike, body: str | None = None
) -> Integers:
    """Returns the permanent numbers of the points nearest to a place [length], ties included."""
    chosen = np.arange(len(points))
    if body is not None:
        part = next(b for b in points.bodies if b.name == body)
        chosen = chosen[part.start : part.stop]
    distance = np.linalg.norm(points.position[chosen] - np.asarray(place), axis=1)
    tie = TIE * float(np.min(np.asarray(cell_size)))
    near = chosen[distance <= distance.min() + tie]
    return np.sort(points.point_id[near])


class Loads:
    """The loads of a model on its points.

    Attributes:
        on_points: each point force with the permanent numbers of the points that carry it.
    """

    def __init__(self, model: Model, points: MaterialPoints) -> None:
        self._body_forces = [
            (np.array(load.acceleration), model.load_curve(load))
            for load in model.loads
            if isinstance(load, BodyForce)
        ]
        self.on_points = [
            (
                load,
                nearest_points(points, load.at, model.cell_size, load.body),
                model.load_curve(load),
            )
            for load in model.loads
            if isinstance(load, PointForce)
        ]

    def __bool__(self) -> bool:
        return bool(self._body_forces or self.on_points)

    def acceleration(self, time: float) -> Floats:
        """Returns the sum of all body forces per mass at `time`, shape (dim,)."""
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
