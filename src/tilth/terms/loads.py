# SPDX-License-Identifier: BSD-3-Clause
"""Loads on the material points: body forces on their mass, point forces and line forces."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tilth.arrays import Flags, Floats, Integers
from tilth.errors import BadInput
from tilth.grid.background import background_grid
from tilth.model import BodyForce, LineForce, Model, PointForce, SeismicLoad
from tilth.model.load_curve import LoadCurve
from tilth.mpm.points import MaterialPoints
from tilth.terms.point_shares import NoShares, shares_at
from tilth.variation.tables import place_text

DISTANCE_TOLERANCE = 1e-6
"""Difference of distances, in cells, up to which points are equally near to a position."""

REACH = 8.0
"""Points so many cells and half domains away, along each axis, have no share."""

PIECES_PER_CELL = 2
"""Pieces of a line force per cell, at least, each with two Gauss points."""

GAUSS_POINTS = 0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0)
"""Points on a piece, from 0 to 1, of equal weight: exact for cubics."""


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


@dataclass(frozen=True)
class LoadOnPoints:
    """A point force or a line force on the points that carry it.

    Attributes:
        load: the declaration.
        curve: load factor over time.
        point_id: permanent numbers of the points, shape (k,).
        share: of the points in the load's force, shape (k,): [-] of a point force, with the sum 1;
            [length] of a line force, with the length of the line as the sum.
        place: where the load acts in the undeformed body [length], shape (places, dim).
        weight: share of each place, shape (places,).
    """

    load: PointForce | LineForce
    curve: LoadCurve
    point_id: Integers
    share: Floats
    place: Floats
    weight: Floats


class Loads:
    """The loads of a model on its points.

    Args:
        model: the declared problem.
        points: the material points of the undeformed bodies.
        present: those that are there; all if None.

    Attributes:
        on_points: point forces and line forces.

    Raises:
        BadInput: a point force or line force without soil that could carry it.
    """

    def __init__(
        self, model: Model, points: MaterialPoints, present: MaterialPoints | None = None
    ) -> None:
        there = np.ones(len(points), dtype=bool)
        if present is not None:
            there = np.isin(points.point_id, present.point_id)
        self._body_forces = [
            (np.array(load.acceleration), model.load_curve(load))
            for _, load in model.acting_loads()
            if isinstance(load, BodyForce)
        ]
        self._seismic = [
            (np.array(load.coefficient), model.load_curve(load))
            for _, load in model.acting_loads()
            if isinstance(load, SeismicLoad)
        ]
        self.on_points = [
            _on_points(model, number, load, points, there)
            for number, load in model.acting_loads()
            if isinstance(load, PointForce | LineForce)
        ]

    def __bool__(self) -> bool:
        return bool(self._body_forces or self.on_points)

    @property
    def acts_on_mass(self) -> bool:
        """Whether there are body forces."""
        return bool(self._body_forces)

    def acceleration(self, time: float) -> Floats:
        """Returns all forces per mass at `time` [acceleration], shape (dim,), seismic ones too."""
        parts = [curve.factor(time) * acceleration for acceleration, curve in self._body_forces]
        gravity = np.asarray(np.sum(parts, axis=0))
        magnitude = float(np.linalg.norm(gravity))
        seismic = [curve.factor(time) * magnitude * part for part, curve in self._seismic]
        return np.asarray(np.sum([gravity, *seismic], axis=0))

    def force(self, points: MaterialPoints, time: float) -> Floats:
        """Returns the external force on each point at `time` [force], shape (n, dim)."""
        if self._body_forces:
            force = points.mass[:, None] * self.acceleration(time)
        else:
            force = np.zeros(points.position.shape)
        for each in self.on_points:
            share = each.curve.factor(time) * each.share[:, None]
            row = points.index_of(each.point_id)
            there = row >= 0  # the others are points of other processes
            force[row[there]] += share[there] * np.asarray(each.load.force)
        return force


def _on_points(
    model: Model, number: int, load: PointForce | LineForce, points: MaterialPoints, there: Flags
) -> LoadOnPoints:
    """Returns the points that carry a load, of those that are there, and their shares."""
    of_body, grid = points.of_body(load.body), background_grid(model)
    own = np.arange(len(points))[of_body][there[of_body]]
    position, half = points.position[own], points.initial_half_length[own]
    reach = REACH * (half.max(axis=0) + grid.largest_size)

    def shares(place: Floats, key: str) -> tuple[Integers, Floats]:
        near = np.flatnonzero((np.abs(position - place) <= reach).all(axis=1))
        try:
            rows, share = shares_at(place, position[near], half[near], grid.sizes_at(place))
        except NoShares as error:
            where = place_text(place)
            what = f"the body {load.body!r} cannot carry a force at {where}: {error.reason}"
            key = f"loads[{number}].{key}"
            value = getattr(load, key.rpartition(".")[2])
            raise BadInput(what, "move it to the soil", key=key, value=value) from error
        return near[rows], share

    if isinstance(load, PointForce):
        key, place, weight = "at", np.array([load.at]), np.ones(1)
    else:
        key = "end"
        for each in ("start", "end"):  # first: a line between them may have very many points
            shares(np.array(getattr(load, each)), each)
        place, weight = _on_line(load, min(model.cell_size))
    share = np.zeros(len(position))
    for at, part in zip(place, weight, strict=True):
        rows, of_points = shares(at, key)
        share[rows] += part * of_points
    carrying = np.flatnonzero(share)
    order = np.argsort(points.point_id[own][carrying])
    carrying = carrying[order]
    return LoadOnPoints(
        load, model.load_curve(load), points.point_id[own][carrying], share[carrying], place, weight
    )


def _on_line(load: LineForce, cell: float) -> tuple[Floats, Floats]:
    """Returns the Gauss points of a line [length], shape (n, 3), and their lengths, (n,)."""
    start, along = np.array(load.start), np.array(load.end) - np.array(load.start)
    length = float(np.linalg.norm(along))
    pieces = max(1, math.ceil(PIECES_PER_CELL * length / cell))
    at = (np.arange(pieces)[:, None] + GAUSS_POINTS).ravel() / pieces
    return start + at[:, None] * along, np.full(2 * pieces, 0.5 * length / pieces)
