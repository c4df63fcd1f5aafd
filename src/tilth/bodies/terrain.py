# SPDX-License-Identifier: BSD-3-Clause
"""Ground between a base and the surface of a terrain: in 2D a polygon, in 3D a height field."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.bodies.lattice import anchored_axes, cut_lattice, spread
from tilth.bodies.request import BodyPoints, Request
from tilth.fields.level import elevation, nodes
from tilth.fields.tables import place_text
from tilth.model import Polygon, Terrain
from tilth.model.shape_base import Bounds

OUTLINE_TOLERANCE = 1e-6
"""Centres of sub-cells within this fraction of a sub-cell of the outline are inside."""


@dataclass(frozen=True)
class HeightField:
    """Ground over a rectangle in plan, between two surfaces that are bilinear between its lines.

    Attributes:
        lines: increasing coordinates of its lines along x and y [length], from side to side.
        top, base: elevations of the surfaces at their crossings [length], shape (nx, ny).
    """

    lines: tuple[Floats, Floats]
    top: Floats
    base: Floats

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        (x0, x1), (y0, y1) = ((float(line[0]), float(line[-1])) for line in self.lines)
        return (x0, y0, float(self.base.min())), (x1, y1, float(self.top.max()))

    def measure(self) -> float:
        """Returns the volume [length^3]; a bilinear height has the mean of its corners."""
        height = self.top - self.base
        mean = 0.25 * (height[1:, 1:] + height[:-1, 1:] + height[1:, :-1] + height[:-1, :-1])
        return float(np.einsum("i,j,ij->", *(np.diff(line) for line in self.lines), mean))

    def heights(self, place: Floats) -> tuple[Floats, Floats]:
        """Returns base and top at places in plan (n, 2), of the nearest place in the rectangle."""
        from scipy.interpolate import RegularGridInterpolator  # takes 0.2 s: only where needed

        inner = np.column_stack(
            [np.clip(place[:, k], line[0], line[-1]) for k, line in enumerate(self.lines)]
        )
        base, top = (RegularGridInterpolator(self.lines, z)(inner) for z in (self.base, self.top))
        return np.asarray(base), np.asarray(top)

    def over(self, place: Floats) -> Flags:
        """Returns which places in plan (n, 2) are in the rectangle, shape (n,)."""
        inside = np.ones(len(place), dtype=bool)
        for k, line in enumerate(self.lines):
            inside &= (place[:, k] >= line[0]) & (place[:, k] <= line[-1])
        return inside

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
    crossing = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    base, top = (
        _elevation(shape, key, crossing.reshape(-1, 2), request).reshape(crossing.shape[:2])
        for key in ("base", "surface")
    )
    _require_thickness(crossing.reshape(-1, 2), (top - base).ravel(), request)
    return HeightField((lines[0], lines[1]), top, base)


def _lines(shape: Terrain, k: int, request: Request) -> Floats:
    """Returns the coordinates along a horizontal axis between which both surfaces are linear."""
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
    worst = int(thickness.argmin())
    if thickness[worst] <= 0.0:
        raise request.refused(
            f"the base is not below the surface at {place_text(place[worst])}: the ground would "
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
    base, top = (z.reshape(x.shape) for z in form.heights(np.column_stack([x.ravel(), y.ravel()])))
    z = spread(axes[2], 2)
    inside = (z >= base - margin) & (z <= top + margin)
    for k, line in enumerate(form.lines):
        within = (axes[k] >= line[0] - margin) & (axes[k] <= line[-1] + margin)
        inside = inside & spread(within, k)
    return cut_lattice(request, axes, sizes, inside, form.measure())
