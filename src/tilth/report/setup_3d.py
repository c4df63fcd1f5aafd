# SPDX-License-Identifier: BSD-3-Clause
"""Figure of a three-dimensional set-up: three views along the axes and one in 3D."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.points_3d import draw_points_3d
from tilth.report.setup_data import Setup
from tilth.report.setup_view import BODY_COLOURS, CONDITION_COLOURS, REMOVED_COLOUR, draw_view
from tilth.report.surface_lines import clip_triangles
from tilth.report.tracked_surfaces import draw_tracked_3d

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWS = (((0, 2), "front (along y)"), ((1, 2), "side (along x)"), ((0, 1), "plan (along z)"))


def draw_setup_3d(setup: Setup, lower: Floats, upper: Floats, notes: list[str]) -> Figure:
    """Returns a figure of four panels of the box between two corners.

    Omissions are added to ``notes``.
    """
    from matplotlib.figure import Figure

    size = upper - lower
    figure = Figure(figsize=(10.5, 8.0), layout="constrained")
    layout = figure.add_gridspec(
        2, 2, width_ratios=_ratio(size[0], size[1]), height_ratios=_ratio(size[2], size[1])
    )
    cells = (layout[0, 0], layout[0, 1], layout[1, 0])
    for cell, (plane, title) in zip(cells, VIEWS, strict=True):
        axes = figure.add_subplot(cell)
        draw_view(axes, setup, plane, lower, upper, notes)
        axes.set_title(title, fontsize=9)
    space = figure.add_subplot(layout[1, 1], projection="3d")
    draw_in_space(space, setup, lower, upper)
    true = bool(size.min() >= 0.2 * size.max())
    space.set_title("in space" if true else "in space (thickness exaggerated)", fontsize=9)
    return figure


def draw_in_space(axes: Any, setup: Setup, lower: Floats, upper: Floats) -> None:
    """Draws points, surfaces and removed soil of the box between two corners in 3D."""
    from matplotlib.colors import to_rgba

    strong = np.array([to_rgba(colour) for colour in BODY_COLOURS])
    palette = np.stack([strong, strong * [0.8, 0.8, 0.8, 1.0]], axis=1).reshape(-1, 4)
    colours = palette[setup.shade % len(palette)]
    half, unit = setup.half_lengths, setup.length_unit
    draw_points_3d(axes, setup.position, half, colours, lower, upper, unit, 0.2, setup.corners)
    if setup.removed is not None and len(setup.removed.position):
        position, half = setup.removed.position, setup.removed.half_lengths
        ghost = np.tile(to_rgba(REMOVED_COLOUR, 0.12), (len(position), 1))
        draw_points_3d(axes, position, half, ghost, lower, upper, unit, 0.2)
    _draw_surfaces(axes, setup, lower, upper)
    draw_tracked_3d(axes, setup.tracked)


def _draw_surfaces(axes: Any, setup: Setup, lower: Floats, upper: Floats) -> None:
    """Draws the surfaces between ``lower`` and ``upper``, transparent."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection  # type: ignore[import-untyped]

    for place, surface in enumerate(setup.surfaces, start=len(setup.conditions)):
        number = setup.colour_of(surface.name, place)
        colour = CONDITION_COLOURS[number % len(CONDITION_COLOURS)]
        area, _ = clip_triangles(surface.corner, lower, upper)
        if area:
            axes.add_collection3d(
                Poly3DCollection(area, facecolors=colour, alpha=0.3, linewidths=0.0)
            )


def _ratio(first: float, second: float) -> list[float]:
    """Returns relative widths of two panels in proportion to their contents, at least 0.3."""
    fraction = float(np.clip(first / (first + second), 0.3, 0.7))
    return [fraction, 1.0 - fraction]
