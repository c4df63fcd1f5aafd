# SPDX-License-Identifier: BSD-3-Clause
"""Figures of deformed points coloured by a field, several outputs with one colour scale."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.snapshot import Snapshot
from tilth.report.bridges import region_of
from tilth.report.colour_scale import ColourScale
from tilth.report.continuous import ContinuousField
from tilth.report.domains import corners_of, drawn_at_once, outlines
from tilth.report.fields import field_values, parameter_fields, with_unit
from tilth.report.points_3d import draw_points_3d
from tilth.report.rigid_bodies import draw_rigid_2d, draw_rigid_3d, rigid_vertices
from tilth.report.texts import AS_IT_IS, LABEL_WIDTH, any_characters, on_lines
from tilth.report.tracked_surfaces import (
    add_tracked_legend,
    draw_tracked_2d,
    draw_tracked_3d,
    tracked_vertices,
)
from tilth.report.water_line import draw_water, nearby

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAXIMUM_DRAWN_DOMAINS = 60_000
_MAXIMUM_ASPECT_RATIO = 7.0
"""Ratio of the sides up to which figures are to scale."""
_TITLE_CHARACTERS = 11.0
"""Characters of a panel's title per inch of its width, on average."""
_LABEL_CHARACTERS = 9.0
"""Characters of the colour bar's label per inch of the figure's height."""


def draw_frames(
    snapshots: Sequence[Snapshot],
    colour_by: str,
    units: Mapping[str, str],
    *,
    axisymmetric: bool = False,
    initial: Snapshot | None = None,
    titles: Sequence[str] | None = None,
    water: Callable[[float], Floats | None] = lambda time: None,
    show: str = "field",
    scale: ColourScale | None = None,
) -> Figure:
    """Returns a figure with one panel per snapshot, all with the same axes and colours.

    ``colour_by`` is a name for :func:`tilth.report.fields.field_values`. In 2D the field is drawn
    over the region of the soil, or as ``show`` tells, see :func:`draw_plane`; in 3D the points that
    are visible from outside are drawn. ``scale``: of the colours, else of all values. Bodies more
    than seven times longer than wide are drawn with the narrow side stretched, with a note.
    Tracked surfaces are drawn over the points, in 2D as lines, in 3D by their outline. In 2D those
    of ``initial``, the first output of the run, are drawn dashed on all later ones. The panels have
    the ``titles``, or step and time. Points without a value (NaN) are grey. ``water`` returns the
    vertices of the water's surface in the plane at a time, see :class:`Setup`. Rigid bodies are
    drawn where they are at each output.
    """
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    dim = snapshots[0].dim
    coloured = [field_values(snapshot, colour_by, units) for snapshot in snapshots]
    values = [pair[0] for pair in coloured]
    scale = scale or ColourScale.of(values)
    if colour_by in parameter_fields(snapshots[0]) and show == "field":
        show = "domains"  # the values of neighbours may have nothing between them
    tracked = tracked_vertices(snapshots if initial is None else [initial, *snapshots])
    tracked += rigid_vertices(snapshots)
    lower, upper = extent(snapshots, tracked)
    levels = [water(snapshot.time) for snapshot in snapshots]
    near = [nearby(line, lower, upper) for line in levels if line is not None]
    lower, upper = extent(snapshots, [*tracked, *(part for part in near if len(part))])
    size = upper - lower
    rows, columns = _arrangement(len(snapshots), size[0] / size[-1] if dim == 2 else 1.2)
    stretch = 1.0
    if dim == 2:
        ratio = float(size[1] / size[0])
        if ratio > _MAXIMUM_ASPECT_RATIO:
            stretch = ratio / 5.0
        elif ratio < 1.0 / _MAXIMUM_ASPECT_RATIO:
            stretch = ratio * 5.0
        shown = ratio / stretch
        width = min(7.4 / columns, 5.0 / shown)
        height = max(width * shown, 1.1)
        figsize = (max(columns * (width + 0.55) + 1.4, 6.0), rows * (height + 0.75) + 0.35)
    else:
        figsize = (columns * 3.7 + 1.2, rows * 3.4 + 0.3)
    layout = ConstrainedLayoutEngine(h_pad=0.12)
    figure = Figure(figsize=figsize, layout=layout)
    of_values = scale.matplotlib().to_rgba
    panels: list[Any] = []
    for index, (snapshot, value) in enumerate(zip(snapshots, values, strict=True)):
        first = panels[0] if panels else None
        if dim == 2:
            axes = figure.add_subplot(rows, columns, index + 1, sharex=first, sharey=first)
            draw_plane(axes, snapshot, value, of_values, show)
            draw_rigid_2d(axes, snapshot.rigid_bodies)
            draw_tracked_2d(axes, snapshot, initial)
            _set_axes(axes, lower, upper, stretch, units.get("length", ""), axisymmetric)
            if (line := levels[index]) is not None:
                draw_water(axes, line)
            axes.label_outer()
        else:
            axes = figure.add_subplot(rows, columns, index + 1, projection="3d")
            half, point_colours = snapshot.point_fields.get("domain"), of_values(value)
            unit = units.get("length", "")
            corners = snapshot.point_fields.get("domain_corners")
            draw_points_3d(
                axes, snapshot.position, half, point_colours, lower, upper, unit, 0.05, corners
            )
            draw_rigid_3d(axes, snapshot.rigid_bodies)
            draw_tracked_3d(axes, snapshot.surfaces)
        title = f"step {snapshot.step}, time {snapshot.time:.4g}"
        if titles:
            title = on_lines(titles[index], int(_TITLE_CHARACTERS * figsize[0] / columns))
        axes.set_title(title, fontsize=9, **AS_IT_IS)
        panels.append(axes)
    pad = 0.02 if dim == 2 else 0.12  # in 3D the labels of z are outside the panels
    shrink = 0.9 if rows > 1 else 1.0
    bar = figure.colorbar(scale.matplotlib(), ax=panels, shrink=shrink, pad=pad)
    letters = min(LABEL_WIDTH, max(int(_LABEL_CHARACTERS * figsize[1]), 12))
    bar.set_label(on_lines(coloured[0][1], letters), fontsize=9, **AS_IT_IS)
    bar.ax.tick_params(labelsize=8)
    bar.formatter.set_powerlimits((-3, 4))  # type: ignore[attr-defined]
    notes = []
    if stretch > 1.001:
        notes.append(f"horizontal scale stretched {stretch:.3g} times")
    elif stretch < 0.999:
        notes.append(f"vertical scale stretched {1 / stretch:.3g} times")
    if any(np.isnan(value).any() for value in values):
        notes.append("grey: no value for this soil")
    if notes:
        figure.supxlabel("; ".join(notes), fontsize=8)
    if initial is not None and all(snapshot.step == initial.step for snapshot in snapshots):
        initial = None
    add_tracked_legend(figure, snapshots, initial)
    with any_characters():  # the first pass does not know how narrow panels of equal scales become
        layout.execute(figure)
    return figure


def extent(snapshots: Sequence[Snapshot], others: Sequence[Floats]) -> tuple[Floats, Floats]:
    """Returns the bounding box of all frames and ``others``, (n, dim) each, with a margin."""
    corners = list(others)
    for snapshot in snapshots:
        half = snapshot.point_fields.get("domain", 0.0)
        corners += [snapshot.position - half, snapshot.position + half]
    lower = np.min([corner.min(axis=0) for corner in corners], axis=0)
    upper = np.max([corner.max(axis=0) for corner in corners], axis=0)
    margin = np.maximum(0.03 * (upper - lower), 1e-9 * float(np.abs(upper).max()) + 1e-300)
    return lower - margin, upper + margin


def _arrangement(count: int, ratio: float) -> tuple[int, int]:
    """Returns rows and columns for panels ``ratio`` times as wide as high on a landscape page."""
    if ratio < 0.6 or count == 1:
        columns = min(count, 6)
        return -(-count // columns), columns
    columns = 1 if ratio > 3.5 and count <= 4 else 2 if ratio > 1.3 or count <= 4 else 3
    return -(-count // columns), columns


def _set_axes(
    axes: Axes,
    lower: Floats,
    upper: Floats,
    stretch: float,
    unit: str,
    axisymmetric: bool,
) -> None:
    axes.set_aspect(1.0 / stretch)
    axes.set_xlim(lower[0], upper[0])
    axes.set_ylim(lower[1], upper[1])
    axes.set_xlabel(with_unit("r" if axisymmetric else "x", unit), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(with_unit("y", unit), fontsize=9, **AS_IT_IS)
    axes.tick_params(labelsize=8)
    if stretch > 1.0 or (upper - lower)[1] > 2.5 * (upper - lower)[0]:
        axes.locator_params(axis="x", nbins=3)
    axes.set_facecolor("0.97")


def draw_plane(
    axes: Any, snapshot: Snapshot, values: Floats, colours: Callable[[Floats], Any], show: str
) -> None:
    """Draws values (n,) of the points in the plane, in their colours.

    ``show``: ``"field"`` over the region of the soil, ``"domains"`` each point's, filled, or
    ``"points"``, dots as large as their spacing; those also if there are no domains, or too many.
    """
    position = snapshot.position
    half = snapshot.point_fields.get("domain")
    corners = corners_of(snapshot)
    if corners is not None and show == "field":
        region = region_of(snapshot, corners)
        ContinuousField(region, position, values, colours).add_to(axes)
        return
    from matplotlib.collections import EllipseCollection, PolyCollection

    point_colours = colours(values)
    if corners is not None and show != "points" and len(position) <= MAXIMUM_DRAWN_DOMAINS:
        area = drawn_at_once(outlines(position, corners))
        axes.add_collection(
            PolyCollection(area, facecolors=point_colours, edgecolors=point_colours, linewidths=0.3)
        )
        return
    volume = snapshot.point_fields.get("volume")
    if half is not None:
        diameter = (1.4 if show == "points" else 2.0) * half.max(axis=1)
    elif volume is not None:
        diameter = np.full(len(position), float(np.sqrt(np.median(volume))))
    else:
        diameter = np.full(
            len(position), float(np.sqrt(np.prod(np.ptp(position, axis=0)) / len(position)))
        )
    axes.add_collection(
        EllipseCollection(
            diameter,
            diameter,
            np.zeros(len(position)),
            units="xy",
            offsets=position,
            facecolors=point_colours,
            edgecolors="none",
            transOffset=axes.transData,
        )
    )
