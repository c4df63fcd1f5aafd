# SPDX-License-Identifier: BSD-3-Clause
"""Thin shapes between soil that is to part from one of their sides, which one overlay cannot do.

The grid has one displacement at a place. Soil on both sides of a shape that is thinner than two
cells moves as one, so that it hardly parts from one side alone, and the shape bears what a
bilateral contact would: an anchor at its own width below the ground 8.2 B s_u where it is a cell
thick, and 2.6 where it is two. Soil of different overlays, of bodies in a contact pair,
does part.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.boundaries.contact.make import extents
from tilth.boundaries.contact.surface import ContactSurface
from tilth.errors import BadInput
from tilth.grid.background import Grid
from tilth.mpm.points import MaterialPoints
from tilth.variation.tables import place_text

LEAST_CELLS = 1.0
"""Thickness in cells below which a shape is refused."""

OWN_NODES = 2.0
"""Thickness in cells from which on the sides of a body have nodes of their own."""

ROUND_OFF = 1e-6
"""Share of a thickness, or of a cell, that is round-off."""

REACH = 0.5
"""Distance from a side, in cells, at which there is soil or none."""

NEIGHBOURS = 8
"""Points that are compared with a place, so that their domains may differ."""

NO_SOIL = -1

Begins = Callable[[str], bool]


def require_thin_shapes_held(
    surfaces: Sequence[ContactSurface], begins: Begins, points: MaterialPoints, grid: Grid
) -> None:
    """Refuses unilateral shapes in soil that are thinner than a cell.

    Args:
        surfaces: of boundaries and rigid bodies.
        begins: whether one of a name begins with this stage.
        points: the soil.
        grid: the background grid.

    Raises:
        BadInput: soil of one overlay is on both sides of one.
    """
    for surface, what in _thin_in_soil(surfaces, begins, points, grid, 0.0, LEAST_CELLS):
        raise BadInput(what, _REMEDY, key=surface.key)


def thin_warnings(
    surfaces: Sequence[ContactSurface], begins: Begins, points: MaterialPoints, grid: Grid
) -> Iterator[tuple[str, str]]:
    """Yields unilateral shapes in soil of one to two cells: what it is about, and the text.

    Arguments as of `require_thin_shapes_held`.
    """
    for surface, what in _thin_in_soil(surfaces, begins, points, grid, LEAST_CELLS, OWN_NODES):
        yield f"thickness of {surface.key}", f"{surface.key}: {what}; {_REMEDY}"


_REMEDY = (
    f"give a box, or a closed line, that is at least {OWN_NODES:g} cells thick, cut out of the "
    'soil (holes) and with wished_in_place = true, or smaller cells; or normal = "bilateral" '
    "where suction holds the soil; or bodies of soil on the two sides with a contact pair"
)


def _thin_in_soil(
    surfaces: Sequence[ContactSurface],
    begins: Begins,
    points: MaterialPoints,
    grid: Grid,
    least: float,
    most: float,
) -> Iterator[tuple[ContactSurface, str]]:
    """Yields unilateral shapes between soil whose thickness is in a range, and what is wrong.

    least, most: of the thickness [cells].
    """
    for surface in surfaces:
        if not begins(surface.body_name or surface.name):
            continue
        laws = [surface.contact, *surface.contact_with.values()]
        if surface.quadrature is None or all(law.normal != "unilateral" for law in laws):
            continue
        thickness = 0.0 if surface.is_thin else extents(surface.geometry, grid.cell_size)[1]
        cells = thickness / surface.cell + ROUND_OFF
        if not least <= cells < most:
            continue
        how = "has no thickness"
        if thickness > 0.0:
            how = f"is only {thickness:.3g} thick, {thickness / surface.cell:.2g} cells,"
        for at, names in _between(surface, thickness, points, grid):
            yield (
                surface,
                f"the shape of {surface.name!r} {how} and is in soil: at {place_text(at)} there "
                f"is {names} on both sides. The grid has one displacement there for both, so that "
                'with normal = "unilateral" the soil hardly parts from one side alone, nor slides '
                "past the other: the force of an anchor or a wall is too large, several times "
                "where it breaks away",
            )


def _between(
    surface: ContactSurface, thickness: float, points: MaterialPoints, grid: Grid
) -> Iterator[tuple[Floats, str]]:
    """Yields a place (dim,) with unilateral soil of one overlay on both sides, and its name.

    thickness: of the shape [length].
    """
    place, normal, _ = surface.surface_points(0.0)
    if len(place) == 0 or len(points) == 0:
        return
    names = {range_.body: range_.name for range_ in points.ranges}
    overlay = {range_.body: range_.overlay for range_ in points.ranges}
    reach = REACH * grid.sizes_at(place) * normal
    through = thickness * normal
    one, other = (_bodies_at(at, points, grid) for at in (place + reach, place - through - reach))
    found = []
    for i in np.flatnonzero((one != NO_SOIL) & (other != NO_SOIL)):
        both = int(one[i]), int(other[i])
        laws = [surface.contact_with.get(names[body], surface.contact) for body in both]
        if overlay[both[0]] == overlay[both[1]] and any(law.normal == "unilateral" for law in laws):
            found.append((place[i], " and ".join(dict.fromkeys(repr(names[b]) for b in both))))
    yield from found[len(found) // 2 :][:1]


def _bodies_at(place: Floats, points: MaterialPoints, grid: Grid) -> Integers:
    """Returns the number of the body whose soil is at each place (n, dim), or `NO_SOIL`."""
    from scipy.spatial import cKDTree

    half = points.half_length / grid.sizes_at(points.position)
    tree = cKDTree(grid.in_cells(points.position))
    count = min(NEIGHBOURS, len(points))
    at = grid.in_cells(place)
    _, near = tree.query(at, k=[*range(1, count + 1)], p=np.inf)
    gap = (np.abs(tree.data[near] - at[:, None]) - half[near]).max(axis=2)
    nearest = gap.argmin(axis=1)
    row = np.arange(len(at))
    body = points.body_id[near[row, nearest]]
    return np.where(gap[row, nearest] <= ROUND_OFF, body, NO_SOIL).astype(np.int64)
