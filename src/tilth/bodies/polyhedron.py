# SPDX-License-Identifier: BSD-3-Clause
"""Body within a closed surface of triangles: its points, and vertical lines through it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tilth.arrays import Flags, Floats, Integers
from tilth.bodies.lattice import anchored_axes, cut_lattice
from tilth.bodies.request import BodyPoints, Request
from tilth.bodies.stl_file import closed_surface, read_stl
from tilth.bodies.vertical_lines import Crossed, crossed, crossed_by_lines, pairs
from tilth.errors import BadInput
from tilth.model import Stl
from tilth.model.shape_base import Bounds

OUTLINE_TOLERANCE = 1e-6
"""Centres of sub-cells within this fraction of a sub-cell of the surface are inside."""

SHIFT = (1.0e-9, 0.7e-9)
"""Shift of vertical lines over the extent of the body, off the edges of its triangles."""


@dataclass(frozen=True)
class Polyhedron:
    """Body within a closed surface.

    Attributes:
        vertices: [length], shape (m, 3).
        triangle: numbers of the vertices, normals outwards, shape (n, 3).
        volume: [length^3].
    """

    vertices: Floats
    triangle: Integers
    volume: float

    def bounds(self) -> Bounds:
        """Returns the bounding box."""
        lower, upper = self.vertices.min(axis=0), self.vertices.max(axis=0)
        return tuple(lower.tolist()), tuple(upper.tolist())

    def measure(self) -> float:
        """Returns the volume [length^3]."""
        return self.volume

    def crossings(self, place: Floats) -> Crossed:
        """Returns where vertical lines at places in plan (n, 2) cross the surface.

        Returns:
            Numbers of the lines, the heights, and 1 where a line that goes up leaves the body, -1
            where it enters, shape (k,) each.
        """
        extent = float(np.ptp(self.vertices, axis=0).max())
        at = place + extent * np.array(SHIFT)
        line, _, height, sign = crossed_by_lines(self.vertices[self.triangle], at)
        return line, height, sign

    def inside(self, position: Floats) -> Flags:
        """Returns which positions (n, 3) are inside: lines from them leave once more than enter."""
        line, height, sign = self.crossings(position[:, :2])
        above = height > position[line, 2]
        total = np.bincount(line[above], sign[above], len(position))
        return np.asarray(total > 0.5)


def polyhedron_of(shape: Stl, request: Request) -> Polyhedron:
    """Returns the body within the surface in a file, in units of the case.

    Raises:
        BadInput: the file cannot be read, or the surface is not closed.
    """
    key = f"{request.key}.shape.file"
    corner = read_stl(Path(shape.file), key)
    try:
        return Polyhedron(*closed_surface(corner * shape.scale))
    except BadInput as error:
        raise BadInput(error.problem, error.remedy, key=key, value=shape.file) from None


def polyhedron_points(form: Polyhedron, request: Request) -> BodyPoints:
    """Returns the points of a body: the centres of the grid's sub-cells inside it.

    Centres are inside that are so after a shift by a margin to any side, so that those on the
    surface are inside on all sides of the body.
    """
    lower, upper = (np.array(corner) for corner in form.bounds())
    axes, sizes = anchored_axes(request, lower, upper)
    margin = OUTLINE_TOLERANCE * float(request.requested_spacing().min())
    x, y, z = axes
    corner = form.vertices[form.triangle]
    inside = np.zeros((len(y), len(x), len(z)), dtype=bool)
    for dx, dy in ((1.0, 0.7), (-1.0, 0.7), (0.7, -1.0), (-0.7, -1.0)):
        column, height, sign = _in_columns(corner, x + margin * dx, y + margin * dy)
        end = np.searchsorted(z, height + sign * margin, side="right")
        jump = np.zeros((len(y) * len(x), len(z) + 1), dtype=np.int32)
        np.add.at(jump, (column, end), sign.astype(np.int32))
        above = np.cumsum(jump[:, ::-1], axis=1)[:, :-1][:, ::-1]
        inside |= (above > 0).reshape(inside.shape)
    return cut_lattice(request, axes, sizes, inside.transpose(2, 0, 1), form.volume)


def _in_columns(corner: Floats, x: Floats, y: Floats) -> Crossed:
    """Returns columns y x of a lattice (x fastest) that cross triangles, as `crossings` does."""
    ends = [
        (
            np.searchsorted(line, corner[..., k].min(axis=1), side="left"),
            np.searchsorted(line, corner[..., k].max(axis=1), side="right"),
        )
        for k, line in enumerate((x, y))
    ]
    (left, right), (near, far) = ends
    wide = right - left
    found = []
    for triangle, number in pairs(np.zeros_like(wide), wide * (far - near)):
        row, column = np.divmod(number, wide[triangle])
        row, column = row + near[triangle], column + left[triangle]
        place = np.column_stack([x[column], y[row]])
        hit, height, sign = crossed(corner[triangle], place)
        found.append(((row * len(x) + column)[hit], height, sign))
    line, height, sign = (np.concatenate(each) for each in zip(*found, strict=True))
    return line, height, sign
