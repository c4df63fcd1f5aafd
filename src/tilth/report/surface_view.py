# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries in one view of a set-up: lines with symbols of supports."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats, Integers
from tilth.report.setup_data import Surface
from tilth.report.surface_lines import (
    chains,
    clip_segments,
    clip_triangles,
    join_collinear,
    moved_corners,
    oriented,
    polyline,
    seen_edge_on,
)
from tilth.report.symbols import arrows

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINE_STYLES: dict[str, Any] = {"tangential": (0, (4, 1, 1, 1)), "direction": (0, (1.2, 0.9))}
"""Dash patterns of the kinds that are not drawn as solid lines."""
LINE_WIDTH = 2.0
FINAL_POSITION_STYLE: dict[str, Any] = {
    "linestyle": (0, (5, 3)),
    "linewidth": 1.2,
    "alpha": 0.85,
    "zorder": 3.8,
}
"""Line style of the position at the end."""
_HATCHING_DEPTH = {2: 0.018, 3: 0.026}
"""Depth of the hatching over the longer side of the view, in 2D and 3D."""
_MAXIMUM_ARROWS = 8


def draw_surface(
    axes: Axes,
    surface: Surface,
    chosen: list[int],
    lower: Floats,
    upper: Floats,
    colour: str,
    symbols: bool = True,
) -> None:
    """Draws the view of a surface in the plane of two axes, in the box ``lower`` to ``upper``.

    The supports are drawn on the side outward from the soil. A surface that moves has arrows, and a
    dashed line at its position at the end.
    """
    moved = None
    if surface.displacement is not None and np.any(surface.displacement):
        moved = moved_corners(surface.corner, surface.displacement)
    stroke = _HATCHING_DEPTH[lower.size] * float((upper - lower)[chosen].max())
    if lower.size == 2:
        segment, seen = clip_segments(surface.corner, lower, upper)
        _draw_rigid(axes, surface.kind, segment, surface.normal[seen], stroke, colour, symbols)
        if moved is not None:
            line, seen = clip_segments(moved, lower, upper)
            _draw_final_position(axes, line, surface.normal[seen], colour)
    else:
        _draw_faces(axes, surface, chosen, lower, upper, stroke, colour, symbols)
        if moved is not None:
            normal = _normals(moved, surface)
            edge, _, _ = seen_edge_on(moved, normal, chosen)
            line = clip_segments(edge, lower, upper)[0][:, :, chosen]
            _draw_final_position(axes, *join_collinear(line, _across(line)), colour)
    if symbols and surface.displacement is not None and moved is not None:
        _draw_motion(axes, surface, chosen, lower, upper, colour)


def _draw_faces(
    axes: Axes,
    surface: Surface,
    chosen: list[int],
    lower: Floats,
    upper: Floats,
    stroke: float,
    colour: str,
    symbols: bool,
) -> None:
    """Draws triangles as pale areas, their outline as lines, and supports where seen edge on."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    area, _ = clip_triangles(surface.corner, lower, upper)
    if area:
        # One path with all parts of the same orientation: no seams, and no part is drawn twice.
        parts = [_anticlockwise(polygon[:, chosen]) for polygon in area]
        closed = np.concatenate([np.concatenate([part, part[:1]]) for part in parts])
        codes = np.full(len(closed), Path.LINETO)
        ends = np.cumsum([len(part) + 1 for part in parts])
        codes[ends - 1], codes[np.append(0, ends[:-1])] = Path.CLOSEPOLY, Path.MOVETO
        whole = PathPatch(
            Path(closed, codes), facecolor=colour, edgecolor="none", alpha=0.16, zorder=2.5
        )
        axes.add_artist(whole)  # `add_patch` looks for the limits of many areas for long
    edge, along, edge_on = seen_edge_on(surface.corner, surface.normal, chosen)
    line, seen = clip_segments(edge, lower, upper)
    line, edge_on = line[:, :, chosen], edge_on[seen]
    axes.add_collection(
        LineCollection(list(line[~edge_on]), colors=colour, linewidths=1.0, zorder=3.9)
    )
    joined, normal = join_collinear(line[edge_on], along[seen][edge_on])
    _draw_rigid(axes, surface.kind, joined, normal, stroke, colour, symbols)


def _draw_rigid(
    axes: Axes,
    kind: str,
    segment: Floats,
    normal: Floats,
    stroke: float,
    colour: str,
    symbols: bool,
) -> None:
    """Draws lines (n, 2, 2) and their supports; ``stroke`` is the depth of the hatching."""
    from matplotlib.collections import EllipseCollection, LineCollection

    if len(segment) == 0:
        return
    segment = oriented(segment, normal)
    order = chains(segment)
    for chain in order:
        axes.plot(
            *polyline(segment, chain).T,
            color=colour,
            linewidth=LINE_WIDTH,
            linestyle=LINE_STYLES.get(kind, "-"),
            solid_capstyle="butt",
            zorder=4,
        )
    if not symbols:
        return
    extent = float(np.ptp(segment.reshape(-1, 2), axis=0).max())
    unit = min(stroke, 0.1 * extent)
    spacing = (4.0 if kind == "roller" else 0.9) * unit
    symbol_positions = [
        _symbol_positions(segment[chain], normal[chain], spacing) for chain in order
    ]
    position = np.concatenate([found[0] for found in symbol_positions])
    outward = -np.concatenate([found[1] for found in symbol_positions])
    shape = np.array(_ROLLER if kind == "roller" else _HATCH)
    side = np.column_stack([-outward[:, 1], outward[:, 0]])
    strokes = position[:, None, None, :] + unit * (
        shape[None, :, :, :1] * side[:, None, None, :]
        + shape[None, :, :, 1:] * outward[:, None, None, :]
    )
    free = ~np.any(_crosses(strokes, segment), axis=1)
    axes.add_collection(
        LineCollection(
            list(strokes[free].reshape(-1, 2, 2)), colors=colour, linewidths=0.9, zorder=3.9
        )
    )
    if kind == "roller":
        axes.add_collection(
            EllipseCollection(
                0.84 * unit,
                0.84 * unit,
                0.0,
                units="xy",
                offsets=(position + 0.42 * unit * outward)[free],
                transOffset=axes.transData,
                facecolors="white",
                edgecolors=colour,
                linewidths=0.9,
                zorder=3.9,
            )
        )


_HATCH = [[[0.0, 0.02], [0.6, 1.0]]]
"""Strokes of a support: coordinates of their ends along the surface and away from the soil."""
_ROLLER = [
    [[-0.9, 0.86], [0.9, 0.86]],
    [[-0.6, 0.86], [-0.25, 1.4]],
    [[0.0, 0.86], [0.35, 1.4]],
    [[0.6, 0.86], [0.95, 1.4]],
]


def _symbol_positions(segment: Floats, normal: Floats, spacing: float) -> tuple[Floats, Floats]:
    """Returns equidistant points along a chain of segments, and normals there, (k, 2) each."""
    length = np.linalg.norm(segment[:, 1] - segment[:, 0], axis=1)
    ends = np.concatenate([[0.0], np.cumsum(length)])
    count = max(int(ends[-1] / spacing), 1)
    station = (np.arange(count) + 0.5) * ends[-1] / count
    own = np.clip(np.searchsorted(ends, station, side="right") - 1, 0, len(segment) - 1)
    part = (station - ends[own]) / length[own]
    return segment[own, 0] + part[:, None] * (segment[own, 1] - segment[own, 0]), normal[own]


def _crosses(strokes: Floats, segment: Floats) -> Floats:
    """Returns which strokes (k, s, 2, 2) cross one of the lines (n, 2, 2), shape (k, s)."""
    start, step = strokes[..., 0, :], strokes[..., 1, :] - strokes[..., 0, :]
    result = np.zeros(start.shape[:2], dtype=bool)
    for first, last in segment:
        line = last - first
        apart = first - start
        turn = step[..., 0] * line[1] - step[..., 1] * line[0]
        lengths = np.linalg.norm(step, axis=-1) * np.linalg.norm(line)
        safe = np.where(np.abs(turn) <= 1e-12 * lengths, np.inf, turn)  # parallel lines do not meet
        on_stroke = (apart[..., 0] * line[1] - apart[..., 1] * line[0]) / safe
        on_line = (apart[..., 0] * step[..., 1] - apart[..., 1] * step[..., 0]) / safe
        # A stroke begins at a distance from its own line; one that ends on another line crosses it.
        between = np.abs(on_stroke - 0.5) < 0.5 + 1e-6
        result |= between & (np.abs(on_line - 0.5) <= 0.5) & np.isfinite(safe)
    return result


def _draw_final_position(axes: Axes, segment: Floats, normal: Floats, colour: str) -> None:
    """Draws dashed lines, shape (n, 2, 2), with the normals (n, 2)."""
    segment = oriented(segment, normal)
    for chain in chains(segment):
        axes.plot(*polyline(segment, chain).T, color=colour, **FINAL_POSITION_STYLE)


def _draw_motion(
    axes: Axes,
    surface: Surface,
    chosen: list[int],
    lower: Floats,
    upper: Floats,
    colour: str,
) -> None:
    """Draws a few arrows of the displacement at the centres of facets."""
    assert surface.displacement is not None
    centre = surface.corner.mean(axis=1)
    seen = np.flatnonzero(np.all((centre >= lower) & (centre <= upper), axis=1))
    if len(seen) == 0:
        return
    if lower.size == 2:
        number = min(len(seen), _MAXIMUM_ARROWS)
        pick = seen[((np.arange(number) + 0.5) * len(seen) / number).astype(int)]
    else:
        pick = seen[_distributed(centre[seen][:, chosen])]
    shown = surface.displacement[pick][:, chosen]
    long = np.linalg.norm(shown, axis=1) > 0.05 * float(np.abs(surface.displacement).max())
    if np.any(long):  # the others are along the line of sight
        arrows(axes, centre[pick[long]][:, chosen], shown[long], colour, pivot="tail")


def _distributed(position: Floats) -> Integers:
    """Returns the numbers of few of many points of a view, shape (n, 2), distributed over it."""
    low, extent = position.min(axis=0), np.ptp(position, axis=0)
    part = np.array([1.0, 3.0, 5.0]) / 6.0
    wanted = low + extent * np.stack(np.meshgrid(part, part), axis=-1).reshape(-1, 2)
    distance = np.linalg.norm(position[:, None, :] - wanted, axis=2)
    picked: Integers = np.unique(distance.argmin(axis=0))
    return picked


def _anticlockwise(polygon: Floats) -> Floats:
    """Corners of a polygon of a view, shape (k, 2), in that order, the first again at the end."""
    x, y = (polygon - polygon[0]).T
    area = float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    turned = polygon if area >= 0.0 else polygon[::-1]
    return np.concatenate([turned, turned[:1]])


def _normals(corner: Floats, surface: Surface) -> Floats:
    """Unit normals of moved triangles, shape (n, 3), on the side of the soil."""

    def cross(c: Floats) -> Floats:
        product: Floats = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
        return product

    sign = np.sign(np.einsum("ij,ij->i", cross(surface.corner), surface.normal))
    vector = cross(corner) * sign[:, None]
    unit: Floats = vector / np.maximum(np.linalg.norm(vector, axis=1), 1e-300)[:, None]
    return unit


def _across(segment: Floats) -> Floats:
    """Unit vectors across lines of one view, shape (n, 2); the same for collinear ones."""
    step = segment[:, 1] - segment[:, 0]
    vector = np.column_stack([-step[:, 1], step[:, 0]])
    length = np.linalg.norm(vector, axis=1)
    down = (vector[:, 1] < -1e-9 * length) | (
        (np.abs(vector[:, 1]) <= 1e-9 * length) & (vector[:, 0] < 0.0)
    )
    scale = np.where(down, -1.0, 1.0) / np.maximum(length, 1e-300)
    unit: Floats = scale[:, None] * vector
    return unit
