# SPDX-License-Identifier: BSD-3-Clause
"""New soil on the deformed ground: it moves vertically with the ground that it touches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.mpm.points import MaterialPoints, PointRange
from tilth.variation.tables import place_text

TOUCHING = 1.05
"""Points touch if their distance is at most this multiple of the sum of their half lengths."""

NEIGHBOURS = 4
"""Points of the ground whose displacements are averaged."""

INSIDE = 0.75
"""A point overlaps with another if it is nearer than this share of the larger half length."""

LARGEST_OVERLAP = 0.05
"""Share of a new body's points that may overlap with soil, at rough edges of the ground."""


@dataclass(frozen=True)
class _Soil:
    """Points that are there, and where they were declared, each of shape (n, dim)."""

    position: Floats
    half_length: Floats
    declared: Floats
    declared_half: Floats

    def joined(self, other: _Soil) -> _Soil:
        """Returns these points and others."""
        return _Soil(
            np.concatenate([self.position, other.position]),
            np.concatenate([self.half_length, other.half_length]),
            np.concatenate([self.declared, other.declared]),
            np.concatenate([self.declared_half, other.declared_half]),
        )


def placed_on_ground(
    new: MaterialPoints, ground: MaterialPoints, initial: MaterialPoints, key: str
) -> dict[str, Floats]:
    """Moves new points vertically by the displacement of the ground that they touch.

    New bodies are placed from below, and each is ground for those above it.
    The displacement of the ground is that since it was declared. It is taken at the points of the
    ground that touch the new body where both are declared, and averaged horizontally. So the volume
    of the new soil is the declared one.

    Args:
        new: undeformed points of new bodies; they are moved.
        ground: the present points.
        initial: the undeformed points of all bodies, in the order of their numbers.
        key: of the stage, for messages.

    Returns:
        By the names of the bodies, rows (horizontal position, displacement) [length] of the ground
        below, shape (m, dim); m is 0 if a body does not touch the ground.

    Raises:
        BadInput: a new body overlaps with soil.
    """
    found: dict[str, Floats] = {}
    order = ground.in_order  # which of equally near rows count must not depend on that of a run
    number = ground.point_id[order]
    there = _Soil(
        ground.position[order],
        ground.half_length[order],
        initial.position[number],
        initial.half_length[number],
    )
    for body, own in _from_below(new):
        declared, half = new.position[own].copy(), new.half_length[own]
        touching = _touching(declared, half, there.declared, there.declared_half)
        vertical = (there.position - there.declared)[touching, -1]
        rows = np.column_stack([there.declared[touching, :-1], vertical])
        new.position[own, -1] += settlement(rows, declared[:, :-1])
        _require_no_overlap(new, own, there, f"{key}.activate", body.name)
        there = there.joined(_Soil(new.position[own], half, declared, half))
        found[body.name] = rows
    return found


def _from_below(new: MaterialPoints) -> list[tuple[PointRange, slice]]:
    """Returns the bodies with their points, in the order of their lowest points."""
    return sorted(new.whole_bodies(), key=lambda each: float(new.position[each[1], -1].min()))


def settlement(rows: Floats, place: Floats) -> Floats:
    """Returns the ground's vertical displacement at horizontal positions [length], shape (n,).

    The mean of the nearest rows, weighted by the inverse of their distance.

    rows: horizontal position and displacement, shape (m, dim). place: shape (n, dim - 1).
    """
    if len(rows) == 0:
        return np.zeros(len(place))
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS, len(rows))
    distance, nearest = cKDTree(rows[:, :-1]).query(place, k=[*range(1, count + 1)])
    weight = 1.0 / np.maximum(distance, 1e-9 * (distance.max(initial=0.0) or 1.0))
    return np.asarray((weight * rows[nearest, -1]).sum(axis=1) / weight.sum(axis=1))


def _touching(position: Floats, half: Floats, ground: Floats, half_of_ground: Floats) -> Flags:
    """Returns which points of the ground touch a body, shape (points of the ground,)."""
    from scipy.spatial import cKDTree

    reach = TOUCHING * (half.max() + half_of_ground.max()) * np.sqrt(position.shape[1])
    tree = cKDTree(position)
    nearest = tree.query(ground, k=NEIGHBOURS, distance_upper_bound=reach)[1]
    touching = np.zeros(len(ground), dtype=bool)
    for column in nearest.T:
        near = column < len(position)
        apart = np.abs(ground[near] - position[column[near]])
        limit = TOUCHING * (half_of_ground[near] + half[column[near]])
        touching[near] |= (apart <= limit).all(axis=1)
    return touching


def _require_no_overlap(
    new: MaterialPoints, own: slice, ground: _Soil, key: str, name: str
) -> None:
    """Refuses new points within soil."""
    from scipy.spatial import cKDTree

    position, half = new.position[own], new.half_length[own]
    _, nearest = cKDTree(ground.position).query(position, k=min(NEIGHBOURS, len(ground.position)))
    nearest = nearest.reshape(len(position), -1)
    apart = np.abs(position[:, None] - ground.position[nearest])
    size = np.maximum(half[:, None], ground.half_length[nearest])
    inside = (apart < INSIDE * size).all(axis=2).any(axis=1)
    if inside.mean() > LARGEST_OVERLAP:
        first = int(np.flatnonzero(inside)[0])
        raise BadInput(
            f"{int(inside.sum())} of the {len(position)} points of {name!r} would be placed inside "
            f"soil that is there already, such as the one at {place_text(position[first])}",
            "excavate that soil before, or place the body above it",
            key=key,
            value=name,
        )
