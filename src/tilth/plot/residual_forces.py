# SPDX-License-Identifier: BSD-3-Clause
"""The forces that are out of balance at the nodes, over the material points, as a figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.report.fields import AXES, with_unit
from tilth.report.texts import AS_IT_IS, on_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 1e-3
"""Least force that is drawn, over the largest."""

ARROWS = 0.1
"""Least force that has an arrow, over the largest."""

LENGTH = 0.12
"""Of the largest arrow, over the longer side of the picture."""

SIZE, ROOM = 7.0, 0.08
"""Longer side of axes [inch], and the space around the soil over its longest side."""

SOIL, YIELDING = "#d9d4c7", "#e8b48a"
FORCE, MARK = "#23395b", "#c1121f"

FRONT, ABOVE = (0, 2), (0, 1)
"""Axes of the projections of a model in space."""


@dataclass(frozen=True)
class OutOfBalance:
    """Where the residual of an iteration is.

    Attributes:
        points: positions of the material points [length], shape (n, dim).
        half_length: of their domains [length], shape (n, dim).
        yielding: which of them yield, shape (n,).
        nodes: positions of the nodes [length], shape (nodes, dim).
        force: what is out of balance on the soil there [force], shape (nodes, dim).
    """

    points: Floats
    half_length: Floats
    yielding: Flags
    nodes: Floats
    force: Floats


def residual_figure(
    residuals: OutOfBalance, title: str, mark: str, length_unit: str, force_unit: str
) -> Figure:
    """Returns the figure of the forces out of balance, the largest one marked.

    Nodes have the colour of their force; from `ARROWS` of the largest on they have an arrow.
    Models in space are seen from the front and from above, with all nodes.

    Args:
        residuals: the forces, and where the soil is.
        title: of the figure.
        mark: what the largest one is, for the legend; empty to mark none.
        length_unit, force_unit: labels.
    """
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    size = np.linalg.norm(residuals.force, axis=1)
    largest = float(size.max(initial=0.0))
    is_known = bool(np.isfinite(size).all()) and largest > 0.0
    views = [FRONT, ABOVE] if residuals.points.shape[1] == 3 else [ABOVE]
    low, high = _limits(residuals)
    figure = Figure(figsize=_size(high - low, views), layout="constrained")
    scale = LogNorm(SHOWN * largest, largest) if is_known else None
    drawn: Any = None
    for number, (across, up) in enumerate(views, 1):
        axes: Any = figure.add_subplot(len(views), 1, number)
        _draw_soil(axes, residuals, (across, up))
        if scale is not None:
            drawn = _draw_forces(axes, residuals, size, (across, up), scale, high - low)
            if mark:
                _mark_largest(axes, residuals.nodes[int(size.argmax())][[across, up]])
        axes.set_xlim(low[across], high[across])
        axes.set_ylim(low[up], high[up])
        axes.set_aspect("equal")
        axes.set_xlabel(with_unit(AXES[across], length_unit), fontsize=9, **AS_IT_IS)
        axes.set_ylabel(with_unit(AXES[up], length_unit), fontsize=9, **AS_IT_IS)
        axes.tick_params(labelsize=8)
        if len(views) > 1:
            axes.set_title(("from the front", "from above")[number - 1], fontsize=9, loc="left")
    if drawn is not None:
        bar = figure.colorbar(drawn, ax=figure.axes, shrink=0.7)
        bar.set_label(
            with_unit("force out of balance at a node", force_unit), fontsize=9, **AS_IT_IS
        )
        bar.ax.tick_params(labelsize=8)
    figure.suptitle(on_lines(title, 84), fontsize=10, **AS_IT_IS)
    handles: list[Any] = [Patch(color=SOIL, label="soil")]
    if residuals.yielding.any():
        handles.append(Patch(color=YIELDING, label="soil that yields in the step"))
    if is_known and mark:
        ring: dict[str, Any] = {"marker": "o", "markersize": 10, "markeredgewidth": 1.6}
        handles.append(Line2D([], [], ls="", mfc="none", mec=MARK, label=mark, **ring))
    legend = figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8, frameon=False
    )
    for text in legend.get_texts():
        text.set(**AS_IT_IS)
    return figure


def _limits(residuals: OutOfBalance) -> tuple[Floats, Floats]:
    """Returns the corners around soil and nodes with a force, with some room, shape (dim,)."""
    size = np.linalg.norm(residuals.force, axis=1)
    near = residuals.nodes[size > SHOWN * size.max(initial=0.0)]
    half = residuals.half_length
    parts = [residuals.points - half, residuals.points + half, near]
    every = np.concatenate([part for part in parts if len(part)])
    low, high = every.min(axis=0), every.max(axis=0)
    room = ROOM * float((high - low).max())
    return low - room, high + room


def _size(extent: Floats, views: list[tuple[int, int]]) -> tuple[float, float]:
    """Returns width and height of the figure [inch]."""
    wide = float(extent[0])
    tall = sum(float(extent[up]) for _, up in views)
    scale = SIZE / max(wide, tall)
    return max(scale * wide + 1.8, 5.5), max(scale * tall + 0.9, 3.0) + 0.4 * len(views)


def _draw_soil(axes: Any, residuals: OutOfBalance, plane: tuple[int, int]) -> None:
    """Draws the domains of the points, in projection one for all that lie behind each other."""
    from matplotlib.collections import PolyCollection

    chosen = list(plane)
    place, half = residuals.points[:, chosen], residuals.half_length[:, chosen]
    for yields, colour in ((False, SOIL), (True, YIELDING)):
        own = residuals.yielding == yields
        if not own.any():
            continue
        cells = np.round(place[own] / half[own].mean(axis=0)).astype(np.int64)
        _, first = np.unique(cells, axis=0, return_index=True)
        at, side = place[own][first], half[own][first]
        corner = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        outline = at[:, None, :] + corner * side[:, None, :]
        axes.add_collection(
            PolyCollection(outline, facecolors=colour, edgecolors="white", linewidths=0.25)
        )


def _draw_forces(
    axes: Any,
    residuals: OutOfBalance,
    size: Floats,
    plane: tuple[int, int],
    scale: Any,
    extent: Floats,
) -> Any:
    """Draws nodes in the colour of their force, and arrows; returns what has the colours."""
    chosen = list(plane)
    seen = np.flatnonzero(size >= SHOWN * size.max())
    seen = seen[np.argsort(size[seen])]  # the largest on top
    place = residuals.nodes[seen][:, chosen]
    drawn = axes.scatter(*place.T, c=size[seen], norm=scale, cmap="viridis_r", s=14, zorder=3)
    strong = seen[size[seen] >= ARROWS * size.max()]
    arrow = residuals.force[strong][:, chosen] * (LENGTH * float(extent.max()) / size.max())
    axes.quiver(
        *residuals.nodes[strong][:, chosen].T, *arrow.T, angles="xy", scale_units="xy", scale=1.0,
        color=FORCE, width=0.004, zorder=4,
    )  # fmt: skip
    return drawn


def _mark_largest(axes: Any, place: Floats) -> None:
    ring = {"facecolors": "none", "edgecolors": MARK, "linewidths": 1.6, "zorder": 5}
    axes.scatter(*place[:, None], s=150, **ring)
