# SPDX-License-Identifier: BSD-3-Clause
"""The surface of the water in figures in the plane: a blue line with the mark of a water level."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.handles import Handle

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WATER_COLOUR = "#0096d6"
_MOST_SHOWN = 0.5
"""Distance from the soil up to which the water's surface is inside a picture, over its longest
side."""
_ROOM = 0.03
"""Room for the mark on the line, over the same side."""


def nearby(line: Floats, lower: Floats, upper: Floats) -> Floats:
    """Returns positions around a line that a picture of a box should contain, shape (k, 2).

    Its vertices at the sides and inside, unless they are far above or below the box, and room for
    the mark.
    """
    x = line[:, 0]
    inner = x[(x > lower[0]) & (x < upper[0])]
    across = np.concatenate([[lower[0]], inner, [upper[0]]])
    found = np.column_stack([across, np.interp(across, x, line[:, 1])])
    longest = float((upper - lower).max())
    far = _MOST_SHOWN * longest
    found = found[(found[:, 1] > lower[1] - far) & (found[:, 1] < upper[1] + far)]
    return np.concatenate([found, found + np.array([0.0, _ROOM * longest])])


def draw_water(axes: Axes, line: Floats, initial: Floats | None = None) -> None:
    """Draws the surface of the water, within the limits that the axes have.

    ``line``: vertices from left to right [length], shape (k, 2); ``initial``: the same at the
    start, drawn dashed if it is another one.
    """
    if initial is not None and not np.array_equal(initial, line):
        axes.plot(*initial.T, color=WATER_COLOUR, linewidth=0.9, linestyle=(0, (4, 3)), zorder=5)
    axes.plot(*line.T, color=WATER_COLOUR, linewidth=1.4, zorder=5)
    left, right = axes.get_xlim()
    place = left + 0.9 * (right - left)
    height = float(np.interp(place, *line.T))
    low, high = sorted(axes.get_ylim())
    if low <= height <= high:
        axes.plot([place], [height], zorder=5, **_mark())


def water_handle(moves: bool) -> Handle:
    """Returns the legend's handle of the water; ``moves``: whether its level changes."""
    label = "water level\nat the end, dashed at the start" if moves else "water level"
    return Handle(label, {"color": WATER_COLOUR, "linewidth": 1.4})


def _mark() -> dict[str, Any]:
    """Returns the style of a triangle that stands on the line."""
    triangle = [(0.0, 0.0), (-0.5, 0.9), (0.5, 0.9), (0.0, 0.0)]
    return {
        "linestyle": "none",
        "marker": triangle,
        "markersize": 11,
        "markerfacecolor": "white",
        "markeredgecolor": WATER_COLOUR,
        "markeredgewidth": 1.1,
    }
