# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a three-dimensional set-up: three views along the axes and one in space."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .fields import with_unit
from .outer import outer_points
from .setup_data import Setup
from .setup_view import BODY_COLOURS, MOST_POINTS, draw_view

if TYPE_CHECKING:
    from matplotlib.figure import Figure

VIEWS = (((0, 2), "front (along y)"), ((1, 2), "side (along x)"), ((0, 1), "plan (along z)"))


def draw_setup_3d(setup: Setup, notes: list[str]) -> Figure:
    """Four panels; what had to be thinned out is added to ``notes``."""
    from matplotlib.figure import Figure

    lower, upper = setup.bounds()
    size = upper - lower
    figure = Figure(figsize=(10.5, 8.0), layout="constrained")
    layout = figure.add_gridspec(
        2, 2, width_ratios=_ratio(size[0], size[1]), height_ratios=_ratio(size[2], size[1])
    )
    places = (layout[0, 0], layout[0, 1], layout[1, 0])
    for place, (plane, title) in zip(places, VIEWS, strict=True):
        axes = figure.add_subplot(place)
        draw_view(axes, setup, plane, lower, upper, notes)
        axes.set_title(title, fontsize=9)
    space = figure.add_subplot(layout[1, 1], projection="3d")
    seen = outer_points(setup.position, setup.half_lengths)
    seen = seen[:: -(-len(seen) // MOST_POINTS)]
    space.scatter(
        *setup.position[seen].T,
        c=[BODY_COLOURS[body % len(BODY_COLOURS)] for body in setup.body_id[seen]],
        s=float(np.clip(200_000 / max(len(seen), 1), 1.0, 60.0)),
        linewidths=0.0,
    )
    space.set_box_aspect(np.maximum(size, 0.2 * float(size.max())), zoom=0.88)
    space.set_xlim(lower[0], upper[0])
    space.set_ylim(lower[1], upper[1])
    space.set_zlim(lower[2], upper[2])
    for name in "xyz":
        getattr(space, f"set_{name}label")(with_unit(name, setup.length_unit), fontsize=8)
        space.locator_params(axis=name, nbins=4)
    space.tick_params(labelsize=7)
    true = bool(size.min() >= 0.2 * size.max())
    space.set_title("in space" if true else "in space (thickness exaggerated)", fontsize=9)
    return figure


def _ratio(first: float, second: float) -> list[float]:
    """Widths of two panels in proportion to what they show, but none too narrow to read."""
    share = float(np.clip(first / (first + second), 0.3, 0.7))
    return [share, 1.0 - share]
