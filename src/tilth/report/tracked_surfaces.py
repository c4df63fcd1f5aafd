# SPDX-License-Identifier: BSD-3-Clause
"""Tracked surfaces in figures, at their current and initial positions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers
from tilth.output.snapshot import Snapshot, SurfaceShape
from tilth.report.handles import Handle, plot_line
from tilth.report.texts import LEGEND_WIDTH, add_legend, any_characters, on_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRACKED_COLOURS = ("#e6007e", "#111111", "#ff7f0e", "#0077ff", "#7a4a1e", "#8a2be2")
"""Distinct from both colour scales of the fields; a white margin adds contrast."""
LINE_WIDTH = 1.5
INITIAL_WIDTH = 0.9
INITIAL_STYLE = (0.0, (4.0, 2.5))
MAXIMUM_TRIANGLES_WITH_EDGES = 3_000
"""Number of triangles up to which their edges are drawn."""
_CREASE_COSINE = 0.8
"""Cosine of the angle between two triangles below which the edge between them is a crease."""
_HANDLE_WIDTH, _CHARACTER_WIDTH, _ROW_HEIGHT = 0.75, 0.075, 0.2
"""Space in the legend for a handle, a character of its text, and a row [inch]."""


def colour_of(number: int) -> str:
    """Returns the colour of the surface with this number in its snapshot."""
    return TRACKED_COLOURS[number % len(TRACKED_COLOURS)]


def tracked_vertices(snapshots: Sequence[Snapshot]) -> list[Floats]:
    """Returns the vertices of all tracked surfaces that have any [length], shapes (n, dim)."""
    shapes = [shape for snapshot in snapshots for shape in snapshot.surfaces]
    return [shape.position for shape in shapes if len(shape.position)]


def draw_tracked_2d(axes: Axes, snapshot: Snapshot, initial: Snapshot | None) -> None:
    """Draws lines along the tracked surfaces; those of the output ``initial`` dashed and thin."""
    if initial is not None and initial.step != snapshot.step:
        for number, shape in enumerate(initial.surfaces):
            _draw_lines(axes, shape, color=colour_of(number), **INITIAL_LINE)
    draw_tracked_lines(axes, snapshot.surfaces)


def draw_tracked_lines(axes: Axes, surfaces: Sequence[SurfaceShape]) -> None:
    """Draws lines along tracked surfaces in the plane."""
    for number, shape in enumerate(surfaces):
        _draw_lines(axes, shape, color=colour_of(number), **_LINE)


def draw_tracked_3d(axes: Any, surfaces: Sequence[SurfaceShape]) -> None:
    """Draws outline, border and creases of the tracked surfaces as seen from outside the soil.

    The edges of few triangles are drawn as thin lines. ``axes`` must have their final limits and
    direction of view. The lines are in front of everything, also of soil that would hide them:
    matplotlib sorts whole collections, not their parts.
    """
    from mpl_toolkits.mplot3d.art3d import Line3DCollection  # type: ignore[import-untyped]

    if surfaces:
        axes.computed_zorder = False
    for number, shape in enumerate(surfaces):
        if len(shape.cells) == 0:
            continue
        cells = shape.cells[_faces_viewer(axes, shape.position[shape.cells])]
        edges, emphasised = _edges(shape.position, cells)
        colour = colour_of(number)
        for chosen, width, opacity in (
            (edges[emphasised], 1.2, 1.0),
            (edges[~emphasised], 0.35, 0.6),
        ):
            if len(chosen) and (width > 1.0 or len(cells) <= MAXIMUM_TRIANGLES_WITH_EDGES):
                axes.add_collection3d(
                    Line3DCollection(
                        shape.position[chosen],
                        colors=colour,
                        linewidths=width,
                        alpha=opacity,
                        capstyle="round",
                        zorder=3 + number,
                    ),
                    autolim=False,
                )


def tracked_handles(
    surfaces: Sequence[SurfaceShape], there: Sequence[bool] | None = None
) -> list[Handle]:
    """Returns legend handles of tracked surfaces; ``there``: of which ones, of all if None."""
    return [
        Handle(f"surface: {shape.name}", {"color": colour_of(number), **_LINE})
        for number, shape in enumerate(surfaces)
        if there is None or there[number]
    ]


def add_tracked_legend(
    figure: Figure, snapshots: Sequence[Snapshot], initial: Snapshot | None
) -> None:
    """Adds a legend of the tracked surfaces that one of the panels has, above them.

    ``initial`` is None if not drawn.
    """
    surfaces = snapshots[0].surfaces
    drawn = {shape.name for each in snapshots for shape in each.surfaces if len(shape.cells)}
    handles = tracked_handles(surfaces, [shape.name in drawn for shape in surfaces])
    if initial is not None and snapshots[0].dim == 2:
        there = [i for i, shape in enumerate(initial.surfaces) if len(shape.cells)]
    else:
        there = []
    if there:
        one = len(there) == 1
        label = f"surface{'' if one else 's'} at the start"
        colour = colour_of(there[0]) if one else "0.3"
        handles.append(Handle(label, {"color": colour, **INITIAL_LINE}))
    if not handles:
        return
    width, height = figure.get_size_inches()
    texts = [on_lines(handle.label, LEGEND_WIDTH) for handle in handles]
    longest = max(len(line) for text in texts for line in text.split("\n"))
    lines = max(text.count("\n") for text in texts) + 1
    columns = int(np.clip(width / (_HANDLE_WIDTH + _CHARACTER_WIDTH * longest), 1, len(handles)))
    figure.set_size_inches(width, height + _ROW_HEIGHT * lines * -(-len(handles) // columns))
    add_legend(
        figure,
        handles,
        loc="outside upper center",
        ncols=columns,
        fontsize=8.5,
        frameon=False,
        handlelength=2.6,
    )
    layout = figure.get_layout_engine()
    if layout is not None:
        with any_characters():  # below a high legend more iterations than matplotlib's are needed
            layout.execute(figure)


_LINE: dict[str, Any] = {"linewidth": LINE_WIDTH, "halo": LINE_WIDTH + 1.4}
INITIAL_LINE: dict[str, Any] = {
    "linewidth": INITIAL_WIDTH,
    "linestyle": INITIAL_STYLE,
    "halo": INITIAL_WIDTH + 0.9,
}


def _draw_lines(axes: Axes, shape: SurfaceShape, **style: Any) -> None:
    for line in shape.polylines:
        x, y = shape.position[line].T
        plot_line(axes, x, y, solid_capstyle="round", solid_joinstyle="round", **style)


def _faces_viewer(axes: Any, corner: Floats) -> NDArray[np.bool_]:
    """Returns which triangles, shape (n, 3, 3), are seen from outside the soil; shape (n,)."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform  # type: ignore[import-untyped]

    x, y, _ = proj_transform(*corner.reshape(-1, 3).T, axes.get_proj())
    seen = np.stack([x, y], axis=1).reshape(-1, 3, 2)
    first, second = seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0]
    # Normals point into the soil: the corners of a triangle seen from outside are clockwise.
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] < 0.0)


def _edges(position: Floats, cells: Integers) -> tuple[Integers, NDArray[np.bool_]]:
    """Returns the edges of triangles, shape (m, 3), as pairs of vertices, shape (k, 2).

    The second array flags edges of one triangle only and creases, shape (k,).
    """
    corner = position[cells]
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    ends = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    edges, group = np.unique(ends, axis=0, return_inverse=True)
    total = np.zeros((len(edges), 3))
    np.add.at(total, group.reshape(-1), np.tile(normal, (3, 1)))
    # |n1 + n2|^2 = 2 + 2 cos for two triangles at an edge, 1 for one
    return edges, np.sum(total**2, axis=1) < 2.0 + 2.0 * _CREASE_COSINE
