# SPDX-License-Identifier: BSD-3-Clause
"""The phreatic surface: pore pressure of water at rest, and how much of a domain lies below it.

Theory: docs/theory/water.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Floats
from tilth.bodies.corners import mean_half_edges
from tilth.model.load_curve import LoadCurve
from tilth.model.variation import GridFile
from tilth.variation.grid_file import RegularGrid, read_grid
from tilth.variation.level import elevation

if TYPE_CHECKING:
    from tilth.model import Model
    from tilth.model.variation import Level
    from tilth.mpm.points import MaterialPoints

_QUADRATURE = np.polynomial.legendre.leggauss(4)
_SMALLEST = 1e-300


@dataclass(frozen=True)
class Planes:
    """The planes that touch the phreatic surface above points, n points in dim directions.

    Attributes:
        depth: of each point below its plane, along the vertical [length], shape (n,).
        direction: derivative of the depth by the point's position [-], shape (n, dim): the slopes
            of the plane, and -1 along the vertical.
    """

    depth: Floats
    direction: Floats


class PhreaticSurface:
    """The surface of the water of a model in the course of its schedule."""

    def __init__(self, model: Model) -> None:
        water = model.water
        assert water is not None
        self._unit_weight: float = water.unit_weight
        self._factor = LoadCurve(water.factor or ((0.0, 1.0),))
        self._dim = model.dimension
        self._end = model.schedule.end
        self._final = _Elevation(water.level, self._dim, "water.level")
        self._initial = self._final
        if water.initial_level is not None:
            self._initial = _Elevation(water.initial_level, self._dim, "water.initial_level")

    @classmethod
    def of(cls, model: Model) -> PhreaticSurface | None:
        """Returns the surface of a model's water, None without water.

        Raises:
            BadInput: the file of a level cannot be read.
        """
        return None if model.water is None else cls(model)

    def require_covers(self, position: Floats) -> None:
        """Checks that the water has a level above or below positions (n, dim) [length].

        Raises:
            BadInput: a position beside a polyline or a grid.
        """
        for each in (self._initial, self._final):
            elevation(each.declared, position, each.key)

    def unit_weight(self, time: float) -> float:
        """Returns the unit weight of the water at `time` [force/length^3]."""
        return self._factor.factor(time) * self._unit_weight

    def level(self, position: Floats, time: float) -> Floats:
        """Returns the elevation of the surface at positions (n, dim) [length], shape (n,)."""
        return self._between(self._initial.at(position), self._final.at(position), time)

    @property
    def vertices(self) -> set[float]:
        """The coordinates x at which a level may have a kink [length], in the plane."""
        return {*self._initial.vertices, *self._final.vertices}

    def planes(self, position: Floats, time: float) -> Planes:
        """Returns the planes that touch the surface above or below positions (n, dim)."""
        slope = self._between(self._initial.slope(position), self._final.slope(position), time)
        direction = np.concatenate([slope, np.full((len(position), 1), -1.0)], axis=1)
        return Planes(self.level(position, time) - position[:, -1], direction)

    def pore_pressure(self, position: Floats, time: float) -> Floats:
        """Returns the pressure of the water at positions (n, dim) [stress], >= 0, shape (n,)."""
        depth = self.level(position, time) - position[:, -1]
        return np.asarray(self.unit_weight(time) * np.maximum(depth, 0.0))

    def _between(self, initial: Floats, final: Floats, time: float) -> Floats:
        share = min(max(time / self._end, 0.0), 1.0)
        return final if share == 1.0 else np.asarray(initial + share * (final - initial))


class _Elevation:
    """A declared elevation, continued horizontally beyond its ends."""

    def __init__(self, declared: Level, dim: int, key: str) -> None:
        self.declared, self.key = declared, key
        self._dim = dim
        self._grid: RegularGrid | None = None
        if isinstance(declared, GridFile):
            self._grid = read_grid(declared.file, dim - 1, f"{key}.file")
        elif isinstance(declared, tuple):  # a polyline is a grid along x
            x, height = np.array(declared, dtype=np.float64).T
            self._grid = RegularGrid((0,), (x,), height)

    @property
    def vertices(self) -> list[float]:
        """The coordinates x of its vertices [length]; none of a level surface."""
        return [] if self._grid is None else self._grid.lines[0].tolist()

    def at(self, position: Floats) -> Floats:
        """Returns the elevation at positions (n, dim) [length], shape (n,)."""
        if self._grid is None:
            return np.full(len(position), float(self.declared))  # type: ignore[arg-type]
        return self._grid.at(self._inside(position), self.key, "")

    def slope(self, position: Floats) -> Floats:
        """Returns the derivatives of the elevation [-], shape (n, dim - 1); 0 beyond its ends."""
        slope = np.zeros((len(position), self._dim - 1))
        if self._grid is None:
            return slope
        inside = self._inside(position)
        for axis, lines in zip(self._grid.axes, self._grid.lines, strict=True):
            cell = np.searchsorted(lines, inside[:, axis], side="right").clip(1, len(lines) - 1)
            lower, upper = inside.copy(), inside.copy()
            lower[:, axis], upper[:, axis] = lines[cell - 1], lines[cell]
            rise = self._grid.at(upper, self.key, "") - self._grid.at(lower, self.key, "")
            within = inside[:, axis] == position[:, axis]
            slope[:, axis] = np.where(within, rise / (lines[cell] - lines[cell - 1]), 0.0)
        return slope

    def _inside(self, position: Floats) -> Floats:
        assert self._grid is not None
        inside = position.copy()
        for axis, lines in zip(self._grid.axes, self._grid.lines, strict=True):
            inside[:, axis] = inside[:, axis].clip(lines[0], lines[-1])
        return inside


def half_extents(points: MaterialPoints, direction: Floats) -> Floats:
    """Returns by how much the depth below a plane varies within the points' domains [length].

    direction: derivative of the depth by position, shape (n, dim).

    Half of it along each edge of the domain (of CPDI2 the mean ones), the largest first, (n, dim).
    """
    extents = np.abs(points.half_length * direction)
    corners = points.all_corners()
    if corners is not None:
        extents = np.abs(np.einsum("nej,nj->ne", mean_half_edges(corners), direction))
    return -np.sort(-extents, axis=1)


def wet_share(depth: Floats, extents: Floats) -> tuple[Floats, Floats]:
    """Returns the shares of domains below planes [-], and their derivatives [1/length], (n,) each.

    In 2D the share of a parallelogram is exact. In 3D the integral along the third edge is replaced
    by Gauss's quadrature; it is exact where this edge is parallel to the plane.

    Args:
        depth: of the domains' centres below their planes [length], shape (n,).
        extents: as `half_extents` returns them, shape (n, dim).
    """
    first, second = (np.maximum(extents[:, k], _SMALLEST) for k in (0, 1))
    if extents.shape[1] == 2:
        return _share_of_parallelogram(depth, first, second)
    share, derivative = np.zeros_like(depth), np.zeros_like(depth)
    for place, weight in zip(*_QUADRATURE, strict=True):
        at_place = _share_of_parallelogram(depth + place * extents[:, 2], first, second)
        share += 0.5 * weight * at_place[0]
        derivative += 0.5 * weight * at_place[1]
    return share, derivative


def _share_of_parallelogram(depth: Floats, first: Floats, second: Floats) -> tuple[Floats, Floats]:
    """Returns the share of depth + v first + w second > 0 for v and w in (-1, 1), and d/d depth.

    The mean over w of the share at w, which grows linearly from 0 at -first to 1 at first. Between
    `begin` and `end` it is neither 0 nor 1.
    """
    with np.errstate(over="ignore"):
        begin = ((-first - depth) / second).clip(-1.0, 1.0)
        end = ((first - depth) / second).clip(-1.0, 1.0)
    middle = 0.5 * (depth + 0.5 * (begin + end) * second + first) / first
    share = 0.5 * (end - begin) * middle + 0.5 * (1.0 - end)
    return share, np.asarray(0.25 * (end - begin) / first)
