# SPDX-License-Identifier: BSD-3-Clause
"""One view of a set-up: grid lines, points, and the symbols of conditions and loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tilth.arrays import Floats, Integers, distinct_rows
from tilth.report.domains import corners_of_boxes, drawn_at_once, outlines, sides_towards
from tilth.report.fields import with_unit
from tilth.report.handles import plot_line
from tilth.report.setup_data import Condition, Setup, Soil
from tilth.report.surface_view import draw_surface
from tilth.report.symbols import arrows, support
from tilth.report.texts import AS_IT_IS
from tilth.report.tracked_surfaces import draw_tracked_lines
from tilth.report.water_line import WATER_COLOUR, draw_water

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BODY_COLOURS = ("#c9a66b", "#7d9d9c", "#b5838d", "#8d99ae", "#a3b18a", "#d4a373", "#84a9c0")
_STRONG = np.array([list(bytes.fromhex(colour[1:])) for colour in BODY_COLOURS]) / 255.0
FILLS = np.stack([0.3 + 0.7 * _STRONG, 0.85 * _STRONG], axis=1).reshape(-1, 3)
"""Red, green and blue of the domains of soil by `Setup.shade`."""
CONDITION_COLOURS = ("#1d3557", "#2a6f4e", "#6a3d9a", "#b15928", "#00798c", "#5c4d7d")
LOAD_COLOUR = "#c1121f"
NEW_EDGE = "0.4"
"""Edges of the domains of new soil."""
REMOVED_COLOUR, REMOVED_HATCH = "0.55", "////"
MAXIMUM_DRAWN_DOMAINS = 40_000
MINIMUM_POINT_DIAMETER = 1.0 / 300.0
"""Diameter below which points are not drawn, over the longer side of the view."""
MAXIMUM_SYMBOLS = 25
MAXIMUM_CROSSES = 100
"""Of a flow boundary, at most."""
MAXIMUM_LINES = 150


def draw_view(
    axes: Axes,
    setup: Setup,
    plane: tuple[int, int],
    lower: Floats,
    upper: Floats,
    notes: list[str],
    symbols: bool = True,
) -> None:
    """Draws the view in the plane of two axes of the box between ``lower`` and ``upper``.

    Omissions are added to ``notes``.
    """
    chosen = list(plane)
    low, high = lower[chosen], upper[chosen]
    axes.set_aspect("equal")
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    names = setup.axis_names
    axes.set_xlabel(with_unit(names[chosen[0]], setup.length_unit), **AS_IT_IS)
    axes.set_ylabel(with_unit(names[chosen[1]], setup.length_unit), **AS_IT_IS)
    axes.tick_params(labelsize=8)
    if float(high[1] - low[1]) > 6.0 * float(high[0] - low[0]):
        axes.locator_params(axis="x", nbins=2)
    if float(high[0] - low[0]) > 6.0 * float(high[1] - low[1]):
        axes.locator_params(axis="y", nbins=2)
    _draw_grid(axes, setup, chosen, low, high, notes)
    _draw_bodies(axes, setup, chosen, lower, upper, notes)
    if setup.removed is not None:
        _draw_removed(axes, setup.removed, chosen)
    _draw_body_force(axes, setup, chosen, lower, upper)
    for number, surface in enumerate(setup.surfaces):
        own = setup.colour_of(surface.name, len(setup.conditions) + number)
        colour = CONDITION_COLOURS[own % len(CONDITION_COLOURS)]
        draw_surface(axes, surface, chosen, lower, upper, colour, symbols)
    if setup.dim == 2:
        draw_tracked_lines(axes, setup.tracked)
    if setup.water is not None:
        draw_water(axes, setup.water[1], setup.water[0])
    if not symbols:
        return
    middle = 0.5 * (setup.position.min(axis=0) + setup.position.max(axis=0))
    for number, condition in enumerate(setup.conditions):
        colour = condition_colour(setup, condition, number)
        _draw_condition(axes, condition, chosen, lower, upper, middle, colour, notes)
    for load in setup.loads:
        position, force = load.position[:, chosen], load.force[:, chosen]
        keep = inside(load.position, lower, upper)
        arrows(axes, position[keep], force[keep], LOAD_COLOUR, pivot="tip")


def condition_colour(setup: Setup, condition: Condition, number: int) -> str:
    """Returns the colour of a condition with a number: that of water for flow boundaries."""
    if condition.is_of_flow:
        return WATER_COLOUR
    return CONDITION_COLOURS[setup.colour_of(condition.name, number) % len(CONDITION_COLOURS)]


def inside(position: Floats, lower: Floats, upper: Floats) -> NDArray[np.bool_]:
    """Returns which positions (k, dim) are in the box between the corners (dim,), shape (k,)."""
    return np.asarray(np.all((position >= lower) & (position <= upper), axis=1))


def _draw_grid(
    axes: Axes,
    setup: Setup,
    chosen: list[int],
    low: Floats,
    high: Floats,
    notes: list[str],
) -> None:
    lines = []
    for k, direction in enumerate(chosen):
        ends = setup.in_cells(np.array([low[k], high[k]]), direction)
        first, last = np.ceil(ends[0]), np.floor(ends[1])
        every = int(max(np.ceil((last - first + 1) / MAXIMUM_LINES), 1))
        if every > 1:
            notes.append(f"every {every}th grid line is drawn")
        drawn = np.arange(np.ceil(first / every) * every, last + 1, every)
        for x in setup.coordinates(drawn, direction):
            if k == 0:
                lines.append([(x, low[1]), (x, high[1])])
            else:
                lines.append([(low[0], x), (high[0], x)])
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(lines, colors="0.3", alpha=0.3, linewidths=0.5, zorder=1.5))


def _draw_bodies(
    axes: Axes,
    setup: Setup,
    chosen: list[int],
    lower: Floats,
    upper: Floats,
    notes: list[str],
) -> None:
    """Draws filled domains, and points where these are large enough to be distinguished."""
    from matplotlib.collections import EllipseCollection, PolyCollection

    low, high = lower[chosen], upper[chosen]
    half_lengths = setup.half_lengths
    margin = 0.0 if half_lengths is None else half_lengths.max(axis=0)
    seen = np.flatnonzero(inside(setup.position, lower - margin, upper + margin))
    if len(seen) == 0:
        return
    if setup.dim == 3:  # one point of each row along the line of sight
        steps = np.round(setup.position[seen][:, chosen] / (1e-6 * (high - low)))
        seen = seen[distinct_rows(steps)]
    position = setup.position[seen][:, chosen]
    if half_lengths is None:
        half = np.full_like(
            position, 0.5 * float(np.sqrt(np.prod(np.ptp(position, axis=0)) / len(seen)))
        )
    else:
        half = half_lengths[seen][:, chosen]
    shade = setup.shade[seen]
    diameter = 0.5 * half.min(axis=1)
    drawn = np.median(diameter) > MINIMUM_POINT_DIAMETER * float((high - low).max())
    if not drawn:
        notes.append("single points are not drawn where they are too small")
    if len(position) > MAXIMUM_DRAWN_DOMAINS:
        centre, half, area_shade = _rectangles(position, half, shade)
        area = outlines(centre, corners_of_boxes(half))
    elif setup.corners is None:
        area, area_shade = outlines(position, corners_of_boxes(half)), shade
    elif setup.dim == 2:
        area, area_shade = outlines(position, setup.corners[seen]), shade
    else:
        area, area_shade = _sides(setup, seen, chosen)
    fill = FILLS[area_shade % len(FILLS)]
    edges = np.array([[1.0] * 3, [float(NEW_EDGE)] * 3])
    axes.add_collection(
        PolyCollection(
            drawn_at_once(area),
            facecolors=fill,
            edgecolors=edges[area_shade % 2] if drawn else fill,
            linewidths=0.4,
            zorder=1,
        )
    )
    if not drawn:
        return
    axes.add_collection(
        EllipseCollection(
            diameter,
            diameter,
            np.zeros(len(diameter)),
            units="xy",
            offsets=position,
            facecolors=0.75 * _STRONG[shade // 2 % len(_STRONG)],
            edgecolors="none",
            transOffset=axes.transData,
            zorder=2,
        )
    )


def _draw_removed(axes: Axes, removed: Soil, chosen: list[int]) -> None:
    """Hatches the soil that was removed, over the soil that is left."""
    from matplotlib.collections import PolyCollection

    position, half = removed.position[:, chosen], removed.half_lengths[:, chosen]
    if len(position) == 0:
        return
    if len(position) > MAXIMUM_DRAWN_DOMAINS:
        position, half, _ = _rectangles(position, half, removed.body_id)
    axes.add_collection(
        PolyCollection(
            drawn_at_once(outlines(position, corners_of_boxes(half))),
            facecolors="none",
            edgecolors=REMOVED_COLOUR,
            hatch=REMOVED_HATCH,
            linewidths=0.0,
            zorder=1.8,
        )
    )


def _sides(setup: Setup, seen: Integers, chosen: list[int]) -> tuple[Floats, Integers]:
    """Returns outlines of the domains' visible sides, the farthest first, and their shades."""
    assert setup.corners is not None
    right, up = np.eye(3)[chosen]
    viewer = np.cross(right, up)
    seen = seen[np.argsort(setup.position[seen] @ viewer, kind="stable")]
    sides, _, number = sides_towards(setup.position[seen], setup.corners[seen], viewer)
    return sides[..., chosen], setup.shade[seen[number]]


def _rectangles(position: Floats, half: Floats, shade: Integers) -> tuple[Floats, Floats, Integers]:
    """Returns few rectangles over the domains of many points: centres, half sides and shades."""
    least = (position - half).min(axis=0)
    extent = (position + half).max(axis=0) - least
    side = np.maximum(2.0 * np.median(half, axis=0), extent / np.sqrt(MAXIMUM_DRAWN_DOMAINS))
    slot = np.floor((position - least) / side)
    first = distinct_rows(slot)
    centre, half = least + (slot[first] + 0.5) * side, half[first]
    centre = np.where(half > 0.5 * side, position[first], centre)
    return centre, np.maximum(half, 0.5 * side), shade[first]


def _draw_body_force(
    axes: Axes, setup: Setup, chosen: list[int], lower: Floats, upper: Floats
) -> None:
    """Draws an arrow at the middle of each visible body, unless it is along the line of sight."""
    if setup.body_force is None or not np.any(setup.body_force[chosen]):
        return
    seen = inside(setup.position, lower, upper)
    for body in np.unique(setup.body_id[seen]):
        own = setup.position[seen & (setup.body_id == body)][:, chosen]
        middle = own.mean(axis=0, keepdims=True)
        arrows(axes, middle, setup.body_force[None, chosen], LOAD_COLOUR, pivot="middle")


def _draw_condition(
    axes: Axes,
    condition: Condition,
    chosen: list[int],
    lower: Floats,
    upper: Floats,
    middle: Floats,
    colour: str,
    notes: list[str],
) -> None:
    """Draws symbols at the nodes of one condition, on the side opposite to the soil."""
    seen = inside(condition.position, lower, upper)
    if not np.any(seen):
        return
    nodes, first = np.unique(condition.position[seen][:, chosen], axis=0, return_index=True)
    constrained = condition.constrained[seen][first]
    if lower.size == 3 and len(nodes) > MAXIMUM_SYMBOLS and np.all(np.ptp(nodes, axis=0) > 0.0):
        return  # a plane normal to the line of sight; another view shows it edge on
    every = -(-len(nodes) // MAXIMUM_SYMBOLS)
    if condition.is_of_flow:
        every = -(-len(nodes) // MAXIMUM_CROSSES)
    if condition.displacement is not None:
        every = -(-len(nodes) // (60 if condition.kind == "affine" else 12))
    if every > 1 and condition.kind != "affine":
        notes.append("not every node of a condition has its symbol")
    pick = np.arange(len(nodes))[:: max(every, 1)]
    if condition.displacement is not None:
        moved = condition.displacement[seen][first][:, chosen]
        arrows(axes, nodes[pick], moved[pick], colour, pivot="tail")
        return
    for mask in np.unique(constrained[pick], axis=0):
        group = nodes[pick][np.all(constrained[pick] == mask, axis=1)]
        axis, sign = outward(group, mask[chosen], middle[chosen])
        if condition.kind == "affine" or not np.any(mask[chosen]):
            width = 1.6 if condition.is_of_flow else 1.0
            axes.plot(
                *group.T, "x", color=colour, markersize=4, markeredgewidth=width, zorder=4,
                clip_on=False, in_layout=False,
            )  # fmt: skip
            continue
        kind = "fixed" if np.all(mask[chosen]) else "roller"
        plot_line(
            axes,
            *group.T,
            linestyle="none",
            marker=support(kind, axis, sign),
            markersize=19,
            markerfacecolor="white",
            markeredgecolor=colour,
            markeredgewidth=0.9,
            zorder=4,
            clip_on=False,
            in_layout=False,
        )


def outward(nodes: Floats, mask: NDArray[np.bool_], middle: Floats) -> tuple[int, int]:
    """Returns axis and sign of the side on which the symbols of a group of nodes are drawn."""
    if np.count_nonzero(mask) == 1:
        axis = int(np.flatnonzero(mask)[0])
    else:
        spread = np.ptp(nodes, axis=0)
        axis = int(np.argmin(spread)) if len(nodes) > 1 else len(middle) - 1
    distance = float(nodes[:, axis].mean() - middle[axis])
    return axis, 1 if distance > 0.0 else -1
