# SPDX-License-Identifier: BSD-3-Clause
"""Ground between a base and the surface of a terrain: in 2D a polygon, in 3D a height field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.bodies.height_surfaces import Gridded, HeightSurface, Triangulated
from tilth.bodies.lattice import anchored_axes, cut_lattice, spread
from tilth.bodies.request import BodyPoints, Request
from tilth.model import Polygon, Terrain
from tilth.model.shape_base import Bounds
from tilth.model.variation import at_survey_points
from tilth.variation.level import elevation, nodes
from tilth.variation.survey import map_text, read_survey

OUTLINE_TOLERANCE = 1e-6
"""Centres of sub-cells within this fraction of a sub-cell of the outline are inside."""


@dataclass(frozen=True)
class HeightField:
    """Ground over a rectangle in plan, between two surfaces.

    Attributes:
        lower, upper: corners of the rectangle [length], shape (2,).
        base, top: the surfaces.
    """

    lower: Floats
    upper: Floats
    base: HeightSurface
    top: HeightSurface

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        lower = *self.lower.tolist(), self.base.range()[0]
        return lower, (*self.upper.tolist(), self.top.range()[1])

    def measure(self) -> float:
        """Returns the volume [length^3]."""
        bottom = self.base.range()[0]
        return self.top.volume_above(bottom) - self.base.volume_above(bottom)

    def heights(self, place: Floats) -> tuple[Floats, Floats]:
        """Returns base and top at places in plan (n, 2), of the nearest place in the rectangle."""
        inner = np.clip(place, self.lower, self.upper)
        return self.base.at(inner), self.top.at(inner)

    def over(self, place: Floats) -> Flags:
        """Returns which places in plan (n, 2) are in the rectangle, shape (n,)."""
        return np.asarray(((place >= self.lower) & (place <= self.upper)).all(axis=1))

    def inside(self, position: Floats) -> Flags:
        """Returns which positions (n, 3) are inside, shape (n,)."""
        base, top = self.heights(position[:, :2])
        z = position[:, 2]
        return np.asarray(self.over(position[:, :2]) & (z >= base) & (z <= top))


def terrain_of(shape: Terrain, request: Request) -> Polygon | HeightField:
    """Returns the form of a terrain.

    Raises:
        BadInput: a file cannot be read, does not cover the body, or the base is not below the
            surface.
    """
    lines = [_lines(shape, k, request) for k in range(len(shape.lower))]
    if len(lines) == 1:
        return _polygon(shape, lines[0], request)
    lower, upper = (np.array(corner, dtype=float) for corner in (shape.lower, shape.upper))
    base, top = (_surface(shape, key, (lines[0], lines[1]), request) for key in ("base", "surface"))
    form = HeightField(lower, upper, base, top)
    place = np.concatenate([surface.vertices() for surface in (base, top)])
    low, high = form.heights(place)
    _require_thickness(place, high - low, request)
    return form


def _surface(
    shape: Terrain, key: str, lines: tuple[Floats, Floats], request: Request
) -> HeightSurface:
    """Returns the base or the surface of a terrain in 3D; lines: as of `_lines`, for both axes."""
    level = shape.levels()[key]
    if at_survey_points(level):
        survey = read_survey(level.file, 2, where := f"{_key(request, key)}.file")
        lower, upper = (np.array(corner, dtype=float) for corner in (shape.lower, shape.upper))
        return Triangulated.within(survey, lower, upper, where, level.file)
    crossing = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    height = _elevation(shape, key, crossing.reshape(-1, 2), request)
    return Gridded(lines, height.reshape(crossing.shape[:2]))


def _lines(shape: Terrain, k: int, request: Request) -> Floats:
    """Returns the coordinates along a horizontal axis between which gridded surfaces are linear."""
    low, high = shape.lower[k], shape.upper[k]
    own = [
        nodes(level, len(shape.lower), k, _key(request, key))
        for key, level in shape.levels().items()
    ]
    every = np.unique(np.concatenate(own))
    slack = OUTLINE_TOLERANCE * float(request.cell_size[k])
    inner = every[(every > low + slack) & (every < high - slack)]
    return np.concatenate([[low], inner, [high]])


def _key(request: Request, name: str) -> str:
    return f"{request.key}.shape.{name}"


def _elevation(shape: Terrain, key: str, place: Floats, request: Request) -> Floats:
    """Returns the elevation of a level at places in plan (n, dim - 1), shape (n,)."""
    position = np.column_stack([place, np.zeros(len(place))])
    return elevation(shape.levels()[key], position, _key(request, key))


def _require_thickness(place: Floats, thickness: Floats, request: Request) -> None:
    worst = int(thickness.argmin()) if len(thickness) else 0
    if len(thickness) and thickness[worst] <= 0.0:
        raise request.refused(
            f"the base is not below the surface at {map_text(place[worst])}: the ground would "
            f"be {thickness[worst]:.6g} thick",
            "lower the base, or let the body end before this place",
            "shape.base",
        )


def _polygon(shape: Terrain, lines: Floats, request: Request) -> Polygon:
    """Returns the polygon between two polylines."""
    place = lines[:, None]
    base, top = (_elevation(shape, key, place, request) for key in ("base", "surface"))
    _require_thickness(place, top - base, request)
    lower = np.column_stack([lines, base])
    upper = np.column_stack([lines, top])
    vertices = [*_bends(lower), *_bends(upper)[::-1]]
    return Polygon(vertices=[(float(x), float(z)) for x, z in vertices])


def _bends(line: Floats) -> Floats:
    """Returns the ends of a polyline and the vertices where it bends, (n, 2)."""
    slope = np.diff(line[:, 1]) / np.diff(line[:, 0])
    bend = np.abs(np.diff(slope)) > 1e-12 * (1.0 + np.abs(slope[1:]))
    return np.asarray(line[np.concatenate([[True], bend, [True]])])


def height_field_points(form: HeightField, request: Request) -> BodyPoints:
    """Returns the points of a height field: the centres of the grid's sub-cells inside it."""
    lower, upper = (np.array(corner) for corner in form.bounds())
    axes, sizes = anchored_axes(request, lower, upper)
    margin = OUTLINE_TOLERANCE * float(request.requested_spacing().min())
    x, y = np.meshgrid(axes[0], axes[1], indexing="xy")  # stored (y, x)
    place = np.column_stack([x.ravel(), y.ravel()])
    base, top = form.heights(place)
    over = form.over(place)  # triangles of two surveys may cross between their vertices
    _require_thickness(place[over], (top - base)[over], request)
    base, top = base.reshape(x.shape), top.reshape(x.shape)
    z = spread(axes[2], 2)
    inside = (z >= base - margin) & (z <= top + margin)
    for k in range(2):
        within = (axes[k] >= form.lower[k] - margin) & (axes[k] <= form.upper[k] + margin)
        inside = inside & spread(within, k)
    return cut_lattice(request, axes, sizes, inside, form.measure())
