# SPDX-License-Identifier: BSD-3-Clause
"""A field over the region of the soil: an image of its values, clipped by the region's outline."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats
from tilth.report.raster import draw_polygons
from tilth.report.region import Region, areas_of, shares_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

OUTLINE_COLOUR, OUTLINE_WIDTH = "0.25", 0.5
"""Of the line around the soil; the width [point]."""
_MOST_PIXELS = 1_600
"""Of the longer side of the image."""
_AROUND = 3
"""Pixels around the region that also have its colours, so that its edge is full."""


@dataclass(frozen=True, eq=False)
class ContinuousField:
    """A field of points over their region, for figures."""

    region: Region
    position: Floats
    """Of the points [length], shape (n, 2)."""
    values: Floats
    """Of the points, shape (n,)."""
    colours: Callable[[Floats], Floats]
    """Colours of values (n,), shape (n, 3 or 4)."""
    zorder: float = 1.0

    def values_image(
        self, low: Floats, high: Floats, width: int, height: int
    ) -> tuple[Floats, NDArray[np.bool_]]:
        """Returns values and what is soil at pixels between two corners, the upper row first.

        Both are of shape (height, width).
        """
        found = np.full((height, width), np.nan)
        there = np.zeros((height, width), dtype=bool)
        scale = np.array([width, height]) / (high - low)
        for part in (*self.region.bridges, *self.region.parts):
            vertex = (part.vertex - low) * scale
            vertex[:, 1] = height - vertex[:, 1]
            triangle = part.triangle[np.argsort(_thickness(vertex[part.triangle]))]
            corner = vertex[triangle]
            number = draw_polygons(corner, width, height)
            row, column = np.nonzero(number >= 0)
            own = number[row, column]
            centre = np.stack([column, row], axis=1).astype(np.float64) + 0.5
            share = _shares_within(corner[own], centre)
            at_vertex = part.values(self.position, self.values)
            found[row, column] = (share * at_vertex[triangle[own]]).sum(axis=1)
            there |= number >= 0
        return found, there

    def image(self, low: Floats, high: Floats, width: int, height: int) -> NDArray[np.uint8]:
        """Returns the pixels: red, green, blue and opacity, shape (height, width, 4)."""
        values, there = self.values_image(low, high, width, height)
        pixels = np.zeros((height, width, 4), dtype=np.uint8)
        colour = np.asarray(self.colours(values[there]))[:, :3]
        pixels[there, :3] = np.rint(255.0 * colour).astype(np.uint8)
        pixels[there, 3] = 255
        for _ in range(_AROUND):
            for axis, shift in ((0, 1), (0, -1), (1, 1), (1, -1)):
                moved = np.roll(pixels, shift, axis=axis)
                edge = [slice(None), slice(None)]
                edge[axis] = slice(0, 1) if shift == 1 else slice(-1, None)
                moved[tuple(edge)] = 0
                empty = (pixels[..., 3] == 0) & (moved[..., 3] > 0)
                pixels[empty] = moved[empty]
        return pixels

    def lines(self) -> list[Floats]:
        """Returns the closed lines around the bodies and their holes, shapes (k, 2).

        Anticlockwise around a body, clockwise around a hole.
        """
        return [line for part in self.region.parts for line in part.outline()]

    def _between(self) -> list[Floats]:
        """Returns the closed lines around what lies between bodies, as `lines`."""
        return [line for part in self.region.bridges for line in part.outline()]

    def add_to(self, axes: Axes) -> None:
        """Draws the field into axes; their limits remain."""
        from matplotlib.collections import PathCollection
        from matplotlib.image import AxesImage
        from matplotlib.path import Path

        lines = self.lines()
        if not lines:
            return
        corner = np.concatenate(lines)
        lower, upper = corner.min(axis=0), corner.max(axis=0)
        size = upper - lower
        lower, upper = lower - 0.004 * size.max(), upper + 0.004 * size.max()
        size = upper - lower
        width, height = np.maximum(_MOST_PIXELS * size / size.max(), 2.0).astype(int).tolist()
        image = AxesImage(
            axes,
            extent=(lower[0], upper[0], lower[1], upper[1]),
            origin="upper",
            interpolation="nearest",
            zorder=self.zorder,
        )
        image.set_data(self.image(lower, upper, width, height))
        path = Path.make_compound_path(*(Path(line, closed=True) for line in lines))
        axes.add_image(image)
        whole = Path.make_compound_path(
            *(Path(line, closed=True) for line in [*lines, *self._between()])
        )
        image.set_clip_path(whole, axes.transData)
        axes.add_collection(
            PathCollection(
                [path],
                facecolors="none",
                edgecolors=OUTLINE_COLOUR,
                linewidths=OUTLINE_WIDTH,
                zorder=self.zorder + 0.01,
            )
        )


def _thickness(corner: Floats) -> Floats:
    """Returns the areas of triangles (n, 3, 2) over their longest sides, shape (n,)."""
    side = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2).max(axis=1)
    return np.asarray(np.abs(areas_of(corner)) / np.maximum(side, 1e-300))


def _shares_within(corner: Floats, place: Floats) -> Floats:
    """Returns the weights of triangles' corners at places, or where they are nearest to those."""
    share = shares_of(corner, place)
    beside = np.flatnonzero((share < 0.0).any(axis=1))
    best = np.full(len(beside), np.inf)
    for first in range(3):
        second = (first + 1) % 3
        start, step = corner[beside, first], corner[beside, second] - corner[beside, first]
        offset = place[beside] - start
        along = (offset * step).sum(axis=1) / np.maximum((step**2).sum(axis=1), 1e-300)
        along = np.clip(along, 0.0, 1.0)
        away = np.linalg.norm(offset - along[:, None] * step, axis=1)
        nearer = away < best
        best = np.minimum(best, away)
        own = np.zeros((int(nearer.sum()), 3))
        own[:, first], own[:, second] = 1.0 - along[nearer], along[nearer]
        share[beside[nearer]] = own
    return share
