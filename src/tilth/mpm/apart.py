# SPDX-License-Identifier: BSD-3-Clause
"""Bodies that begin near each other with different overlays and without contact."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.model import Model
from tilth.model.contact_pairs import unpaired_bodies
from tilth.mpm.points import MaterialPoints
from tilth.variation.tables import place_text

LEAST_GAP = 1.0 - 1e-6
"""Gap in cells up to which bodies are near each other: at one they have no cell in common."""

NEIGHBOURS = 16
"""Points of the other body that are compared with each one, so that their sizes may differ."""


def require_apart(model: Model, points: MaterialPoints, grid: Grid) -> None:
    """Refuses bodies that would pass through each other, as they begin nearer than a cell.

    The gap is that between the domains of their points, the largest of those along the axes.

    Args:
        model: with contact pairs, because of which bodies have overlays of their own.
        points: undeformed, of all bodies.
        grid: the background grid.

    Raises:
        BadInput: names the two bodies, their gap and the place.
    """
    for one, other in unpaired_bodies(model):
        found = min(_gaps(points, grid, one, other), default=None)
        if found is None or found[0] >= LEAST_GAP:
            continue
        gap, place = found
        raise BadInput(
            f"the bodies {one!r} and {other!r} begin nearer to each other than a cell: at "
            f"{place_text(np.array(place))} they are {max(gap, 0.0):.2g} of a cell apart. They "
            "have no contact pair, but overlays (nodes) of their own because of their contact "
            "with others: they would pass through each other",
            f'declare a pair with bodies = ["{one}", "{other}"]; if they stick together, list '
            "these two before all other bodies of pairs",
            key="contact_pairs",
        )


def _gaps(
    points: MaterialPoints, grid: Grid, one: str, other: str
) -> Iterator[tuple[float, list[float]]]:
    """Yields the least gap of two bodies in cells, and where it is, if it may be below a cell."""
    from scipy.spatial import cKDTree

    own, others = (np.arange(each.start, each.stop) for each in map(points.of_body, (one, other)))
    first, second = (_in_cells(points, grid, each) for each in (own, others))
    reach = 1.0 + float(first[1].max()) + float(second[1].max())
    low, high = first[0].min(axis=0) - reach, first[0].max(axis=0) + reach
    near = np.flatnonzero(((second[0] >= low) & (second[0] <= high)).all(axis=1))
    if len(near) == 0:
        return
    position, half = second[0][near], second[1][near]
    count = min(NEIGHBOURS, len(near))
    _, found = cKDTree(position).query(
        first[0], k=[*range(1, count + 1)], p=np.inf, distance_upper_bound=reach
    )
    row, column = np.nonzero(found < len(near))
    if len(row) == 0:
        return
    partner = found[row, column]
    apart = np.abs(first[0][row] - position[partner]) - first[1][row] - half[partner]
    gap = apart.max(axis=1)
    least = int(gap.argmin())
    yield float(gap[least]), points.position[own[row[least]]].tolist()


def _in_cells(points: MaterialPoints, grid: Grid, own: Integers) -> tuple[Floats, Floats]:
    """Returns places and half lengths of points in cells, shape (n, dim) each."""
    position = points.position[own]
    return grid.in_cells(position), points.half_length[own] / grid.sizes_at(position)
