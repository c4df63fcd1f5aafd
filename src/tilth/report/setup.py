# SPDX-License-Identifier: BSD-3-Clause
"""Figure of a set-up: points, grid, conditions and loads before the first step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.amounts import cells_text
from tilth.report.handles import Handle
from tilth.report.setup_data import FLOW_KINDS, Condition, Load, Setup, Soil, Surface
from tilth.report.setup_view import (
    BODY_COLOURS,
    CONDITION_COLOURS,
    LOAD_COLOUR,
    condition_colour,
    draw_view,
)
from tilth.report.surface_view import LINE_STYLES, LINE_WIDTH
from tilth.report.symbols import arrow, hatching, support
from tilth.report.texts import AS_IT_IS, add_legend, any_characters, on_lines
from tilth.report.tracked_surfaces import tracked_handles
from tilth.report.water_line import water_handle

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "Condition",
    "Load",
    "Setup",
    "Soil",
    "Surface",
    "draw_setup",
    "legend_handles",
]

_MAXIMUM_ASPECT_RATIO = 6.0
"""Ratio of the sides above which the ends are also shown enlarged."""
_TITLE_CHARACTERS = 10.5
"""Characters of the title per inch of the figure's width, on average."""


def draw_setup(setup: Setup) -> Figure:
    """Returns the figure of a set-up: 2D to scale, 3D as views along the axes and one in 3D."""
    from matplotlib.figure import Figure

    notes: list[str] = []
    lower, upper = setup.bounds()
    if setup.dim == 3:
        from tilth.report.setup_3d import draw_setup_3d

        figure = draw_setup_3d(setup, lower, upper, notes)
    else:
        size = upper - lower
        ratio = float(size.max() / size.min())
        if ratio <= _MAXIMUM_ASPECT_RATIO:
            width = float(np.clip(5.5 * size[0] / size[1], 3.5, 8.0))
            height = float(np.clip(width * size[1] / size[0], 2.2, 6.5))
            figure = Figure(figsize=(width + 2.9, height + 1.0), layout="constrained")
            draw_view(figure.add_subplot(), setup, (0, 1), lower, upper, notes)
        else:
            figure = _draw_elongated(setup, lower, upper, notes)
    width = int(_TITLE_CHARACTERS * float(figure.get_size_inches()[0]))
    title = on_lines(setup.title or "Set-up", width)
    figure.suptitle(title, fontsize=12, x=0.02, ha="left", **AS_IT_IS)
    add_legend(
        figure,
        legend_handles(setup),
        loc="outside right upper",
        fontsize=8.5,
        frameon=False,
        labelspacing=0.9,
        handlelength=1.6,
    )
    notes += [
        f"{surface.name} lies outside the picture"
        for surface in setup.surfaces
        if len(surface.visible_vertices(lower, upper)) == 0
    ]
    if notes:
        text = on_lines("\n".join(dict.fromkeys(notes)), 2 * width)
        figure.supxlabel(text, fontsize=7.5, color="0.35", **AS_IT_IS)
    layout = figure.get_layout_engine()
    if layout is not None and setup.surfaces:
        with any_characters():  # next to a wide legend more iterations than matplotlib's are needed
            layout.execute(figure)
    return figure


def _draw_elongated(setup: Setup, lower: Floats, upper: Floats, notes: list[str]) -> Figure:
    """Returns a figure of the whole and its two ends enlarged, all to scale."""
    from matplotlib.figure import Figure

    size = upper - lower
    long = int(np.argmax(size))
    window = 2.0 * float(size[1 - long])
    if long == 1:
        figure = Figure(figsize=(8.6, 7.0), layout="constrained")
        layout = figure.add_gridspec(2, 2, width_ratios=[1, 2.2])
        whole = figure.add_subplot(layout[:, 0])
        ends = [figure.add_subplot(layout[1, 1]), figure.add_subplot(layout[0, 1])]
        names = ["lower end", "upper end"]
    else:
        figure = Figure(figsize=(10.5, 5.6), layout="constrained")
        layout = figure.add_gridspec(2, 2, height_ratios=[1, 2.0])
        whole = figure.add_subplot(layout[0, :])
        ends = [figure.add_subplot(layout[1, 0]), figure.add_subplot(layout[1, 1])]
        names = ["left end", "right end"]
    draw_view(whole, setup, (0, 1), lower, upper, notes, symbols=False)
    whole.set_title("whole, to scale", fontsize=9)
    for axes, name, at_start in zip(ends, names, (True, False), strict=True):
        first, last = lower.copy(), upper.copy()
        if at_start:
            last[long] = first[long] + window
        else:
            first[long] = last[long] - window
        draw_view(axes, setup, (0, 1), first, last, notes)
        axes.set_title(name, fontsize=9)
        x, y = np.stack([first, last], axis=1)
        whole.plot(x[[0, 1, 1, 0, 0]], y[[0, 0, 1, 1, 0]], color="k", linewidth=0.8)
    return figure


_SUPPORTS = {"fixed": "\N{WHITE UP-POINTING TRIANGLE}", "roller": "\N{WHITE CIRCLE}"}
_ARROW, _CROSS = "\N{RIGHTWARDS ARROW}", "\N{MULTIPLICATION SIGN}"
LEGEND_ENTRIES = 40
"""Entries of the legend at most; more would leave no room for the picture."""


def legend_handles(setup: Setup) -> list[Handle]:
    """Returns legend handles of bodies, conditions with the constrained components, and loads."""
    names = setup.axis_names
    handles: list[Handle] = []
    for body, name in enumerate(setup.body_names):
        count = int(np.count_nonzero(setup.body_id == body))
        colour = BODY_COLOURS[body % len(BODY_COLOURS)]
        area = {"color": colour, "alpha": 0.8}
        handles.append(Handle(f"{name}\n{count:,} points", patch=area))
    handles.append(Handle(_cell_text(setup), {"color": "0.7", "linewidth": 0.8}))
    for place, condition in enumerate(setup.conditions):
        colour = condition_colour(setup, condition, place)
        constrained = np.any(condition.constrained, axis=0) if len(condition.constrained) else []
        components = ", ".join(name for name, h in zip(names, constrained, strict=False) if h)
        style: dict[str, Any] = {"marker": "x", "markersize": 5}
        sign = _CROSS
        text = f"{condition.name}\n{condition.kind}, {components} constrained"
        if condition.displacement is not None:
            largest = float(np.linalg.norm(condition.displacement, axis=1).max(initial=0.0))
            amount = f"up to {_number(largest)} {setup.length_unit}".rstrip()
            text = f"{condition.name}\n{condition.kind} in {components},\n{amount}"
            style = {"marker": arrow((1.0, 0.0)), "markersize": 14, "markerfacecolor": colour}
            sign = _ARROW
        elif condition.is_of_flow:
            text = f"{condition.name}\n{FLOW_KINDS[condition.kind]}"
        elif condition.kind != "affine":
            kind = "fixed" if np.all(constrained) else "roller"
            style = {"marker": support(kind, 1, -1), "markersize": 19, "markerfacecolor": "w"}
            sign = _SUPPORTS[kind]
        style = {"linestyle": "none", "markeredgecolor": colour, **style}
        handles.append(Handle(text, style, sign=sign))
    for place, surface in enumerate(setup.surfaces, start=len(setup.conditions)):
        number = setup.colour_of(surface.name, place)
        colour = CONDITION_COLOURS[number % len(CONDITION_COLOURS)]
        handles.append(_surface_handle(surface, colour, setup.length_unit))
    for shape, handle in zip(setup.tracked, tracked_handles(setup.tracked), strict=True):
        handle.label = f"{shape.name}\ntracked surface"
        handles.append(handle)
    if setup.water is not None:
        handles.append(water_handle(not np.array_equal(*setup.water)))
    for load in setup.loads:
        total = load.force.sum(axis=0)
        amount = f"{_number(float(np.linalg.norm(total)))} {setup.force_unit}".rstrip()
        direction = (float(total[0]), float(total[setup.dim - 1]))
        handles.append(_arrow_handle(direction, f"{load.name}\n{amount} in total"))
    if setup.body_force is not None and np.any(setup.body_force):
        amount = _number(float(np.linalg.norm(setup.body_force)))
        direction = (float(setup.body_force[0]), float(setup.body_force[setup.dim - 1]))
        handles.append(_arrow_handle(direction, f"body force\nacceleration {amount}"))
    if len(handles) > LEGEND_ENTRIES:
        more = f"and {len(handles) - LEGEND_ENTRIES + 1:,} more"
        handles = [*handles[: LEGEND_ENTRIES - 1], Handle(more, {"linestyle": "none"})]
    return handles


_CONSTRAINED = {
    "roller": "normal constrained",
    "fixed": "all constrained",
    "tangential": "tangential constrained",
    "direction": "one direction constrained",
}


def _surface_handle(surface: Surface, colour: str, unit: str) -> Handle:
    """Returns the legend handle of an implicit boundary with the symbol of its support."""
    text = f"{surface.name}\nimplicit, {_CONSTRAINED.get(surface.kind, surface.kind)}"
    if surface.kind in ("rigid body", "absorbing"):
        text = f"{surface.name}\n{surface.kind}"
    if surface.words:
        text += f"\n{surface.words}"
    if surface.kind != "rigid body" and surface.displacement is not None:
        largest = float(np.linalg.norm(surface.displacement, axis=1).max(initial=0.0))
        text += f",\nmoves up to {largest:.4g} {unit}".rstrip()
    style = {
        "color": colour,
        "linewidth": LINE_WIDTH,
        "linestyle": LINE_STYLES.get(surface.kind, "-"),
        "marker": support("roller", 1, -1) if surface.kind == "roller" else hatching(),
        "markersize": 19,
        "markerfacecolor": "white",
        "markeredgewidth": 0.9,
    }
    return Handle(text, style)


def _arrow_handle(direction: tuple[float, float], label: str) -> Handle:
    """Returns a handle with an arrow, or a cross if the direction vanishes in the view."""
    style: dict[str, Any] = {"marker": "x", "markersize": 5}
    if any(direction):
        style = {"marker": arrow(direction), "markersize": 15, "markerfacecolor": LOAD_COLOUR}
    style = {"linestyle": "none", "markeredgecolor": LOAD_COLOUR, **style}
    return Handle(label, style, sign=_ARROW if any(direction) else _CROSS)


def _cell_text(setup: Setup) -> str:
    """Returns the legend text of the grid."""
    largest = setup.cell_size.copy()
    for k, line in setup.graded():
        largest[k] = np.diff(line).max()
    text = cells_text(zip(setup.cell_size, largest, strict=True), setup.length_unit)
    return "grid, " + text.replace(" of ", " of\n", 1)


def _number(value: float) -> str:
    """Returns a number as short text, if possible without a power of ten."""
    return f"{value:,.6g}" if 1e-3 <= abs(value) < 1e6 else f"{value:.4g}"
