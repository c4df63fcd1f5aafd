# SPDX-License-Identifier: BSD-3-Clause
"""The surface of a terrain: a polyline (2D), or triangles between heights (3D)."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.bodies.height_surfaces import Triangulated
from tilth.bodies.stl_file import merged
from tilth.geometry.open_surface import OpenSurface
from tilth.geometry.polyline import Polyline
from tilth.model import TerrainGeometry
from tilth.model.variation import at_survey_points
from tilth.variation.level import elevation, nodes
from tilth.variation.survey import read_survey

STRAIGHT = 1e-12
"""Change of slope below which a polyline is straight."""


class TerrainLine(Polyline):
    """The open polyline of a terrain in 2D, from its end of least x."""

    def beyond_border(self, x: Floats, reach: float) -> Integers:
        """Returns the numbers of points (n, 2) beyond its ends, within `reach` of one, (k,)."""
        beyond = np.zeros(len(x), dtype=bool)
        for end, ahead in (
            (self.start[0], self.start[0] - self.end[0]),
            (self.end[-1], self.end[-1] - self.start[-1]),
        ):
            offset = x - end
            near = np.flatnonzero(
                (offset @ ahead > 0.0) & (np.linalg.norm(offset, axis=1) <= reach)
            )
            nearest = np.abs(self.distance(x[near])) >= np.linalg.norm(offset[near], axis=1)
            beyond[near[nearest]] = True
        return np.flatnonzero(beyond)


def terrain_surface(terrain: TerrainGeometry, key: str) -> TerrainLine | OpenSurface:
    """Returns the boundary along a terrain.

    In 3D the cells between the lines of a grid are four triangles each, which meet above its middle
    at the mean of its corners; between survey points they are the triangles of Delaunay.

    key: of the geometry in the case file, for messages.
    Raises BadInput for a file that cannot be read, or that does not reach as far as the terrain.
    """
    above = terrain.soil == "above"
    where = f"{key}.surface"
    if at_survey_points(terrain.surface):
        return OpenSurface(*_of_survey(terrain, f"{where}.file"), above)
    lines = [_line(terrain, k, where) for k in range(len(terrain.lower))]
    if len(lines) == 1:
        vertices = _bends(lines[0], _heights(terrain, lines[0][:, None], where))
        return TerrainLine(vertices, closed=False, left=above)
    place = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1)
    height = _heights(terrain, place.reshape(-1, 2), where)
    return OpenSurface(*_of_grid(place, height.reshape(place.shape[:2])), above)


def _line(terrain: TerrainGeometry, k: int, key: str) -> Floats:
    """Returns the coordinates along a horizontal axis between which the surface is linear."""
    every = nodes(terrain.surface, len(terrain.lower), k, key)
    low, high = terrain.lower[k], terrain.upper[k]
    slack = 1e-6 * (high - low)
    inner = every[(every > low + slack) & (every < high - slack)]
    return np.concatenate([[low], inner, [high]])


def _heights(terrain: TerrainGeometry, place: Floats, key: str) -> Floats:
    position = np.column_stack([place, np.zeros(len(place))])
    return elevation(terrain.surface, position, key)


def _bends(x: Floats, z: Floats) -> Floats:
    """Returns the ends of a polyline and the vertices where it bends, (n, 2)."""
    slope = np.diff(z) / np.diff(x)
    bend = np.abs(np.diff(slope)) > STRAIGHT * (1.0 + np.abs(slope[1:]))
    return np.asarray(np.column_stack([x, z])[np.concatenate([[True], bend, [True]])])


def _of_grid(place: Floats, height: Floats) -> tuple[Floats, Integers]:
    """Returns vertices and triangles, anticlockwise seen from above, of heights (nx, ny)."""
    crossing = np.concatenate([place, height[..., None]], axis=2)
    middle = 0.25 * (crossing[:-1, :-1] + crossing[1:, :-1] + crossing[:-1, 1:] + crossing[1:, 1:])
    number = np.arange(height.size).reshape(height.shape)
    centre = height.size + np.arange(middle[..., 0].size)
    around = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    corners = [each.ravel() for each in around]
    sides = [np.stack([corners[k], corners[(k + 1) % 4], centre], axis=1) for k in range(4)]
    vertex = np.concatenate([crossing.reshape(-1, 3), middle.reshape(-1, 3)])
    return vertex, np.concatenate(sides)


def _of_survey(terrain: TerrainGeometry, key: str) -> tuple[Floats, Integers]:
    """Returns vertices and triangles, anticlockwise seen from above, of survey points."""
    file: Any = terrain.surface
    survey = read_survey(file.file, len(terrain.lower), key)
    lower, upper = np.array(terrain.lower), np.array(terrain.upper)
    corner = Triangulated.within(survey, lower, upper, key, file.file).triangle
    vertex, node = merged(corner)
    edge = vertex[node[:, 1:], :2] - vertex[node[:, :1], :2]
    turn = edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0]
    node = np.where((turn < 0.0)[:, None], node[:, ::-1], node)[turn != 0.0]
    vertex[:, :2] += survey.origin
    return vertex, node
