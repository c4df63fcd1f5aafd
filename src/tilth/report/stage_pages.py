# SPDX-License-Identifier: BSD-3-Clause
"""Figures of the stages of a set-up: a panel for each stage, in 3D a row of three views."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.handles import Handle
from tilth.report.setup import legend_handles
from tilth.report.setup_3d import draw_in_space
from tilth.report.setup_data import Condition, Load, Setup, Surface
from tilth.report.setup_view import BODY_COLOURS, NEW_EDGE, REMOVED_COLOUR, REMOVED_HATCH, draw_view
from tilth.report.stage_setups import StagedSetup, StageSetup
from tilth.report.texts import AS_IT_IS, add_legend, any_characters, on_lines

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PANELS, ROWS_3D = 12, 6
"""Stages of a figure at most, in the plane and in 3D."""
_MAXIMUM_ASPECT_RATIO = 6.0
"""Ratio of the sides of a panel above which the longer side is shown shortened."""
_CHARACTERS = 17.0
"""Characters of a panel's title per inch of its width, on average."""
_TITLE_LINES = 3
_LEGEND_WIDTH = 2.9
_ARROW, _PANEL = 0.5, 3.2
"""Length of the arrows of loads and of the longer side of a panel, about [inch]."""


def draw_stages(staged: StagedSetup) -> Iterator[Figure]:
    """Yields the figures of the stages, at most 12 on each, in 3D 6.

    New soil is darker, removed soil hatched. Loads are those at the end of a stage.
    """
    dim = staged.stages[0].setup.dim
    most = PANELS if dim == 2 else ROWS_3D
    count = -(-len(staged.stages) // most)
    for page in range(count):
        numbers = range(page * most, min((page + 1) * most, len(staged.stages)))
        yield _draw_page(staged, numbers, f"{page + 1} of {count}" if count > 1 else "")


def _draw_page(staged: StagedSetup, numbers: range, page: str) -> Figure:
    bounds = [staged.at(number).bounds() for number in numbers]
    lower = np.min([low for low, _ in bounds], axis=0)
    upper = np.max([high for _, high in bounds], axis=0)
    lower, upper = _with_arrows(staged, numbers, lower, upper)
    notes: list[str] = []
    setup = staged.stages[0].setup
    draw = _draw_plane if setup.dim == 2 else _draw_space
    figure = draw(staged, numbers, lower, upper, notes)
    width = float(figure.get_size_inches()[0])
    title = " ".join(filter(None, (setup.title or "Set-up", page and f"({page})")))
    figure.suptitle(on_lines(title, int(10.5 * width)), fontsize=12, x=0.02, ha="left", **AS_IT_IS)
    add_legend(
        figure,
        _legend(staged, numbers),
        loc="outside right upper",
        fontsize=8.5,
        frameon=False,
        labelspacing=0.9,
        handlelength=1.6,
    )
    if notes:
        text = on_lines("\n".join(dict.fromkeys(notes)), int(20.0 * width))
        figure.supxlabel(text, fontsize=7.5, color="0.35", **AS_IT_IS)
    layout = figure.get_layout_engine()
    if layout is not None:
        with any_characters():  # next to a wide legend more iterations than matplotlib's are needed
            layout.execute(figure)
    return figure


def _draw_plane(
    staged: StagedSetup, numbers: range, lower: Floats, upper: Floats, notes: list[str]
) -> Figure:
    """Returns a figure with a panel for each stage."""
    from matplotlib.figure import Figure

    size = upper - lower
    ratio = float(np.clip(size[0] / size[1], 1.0 / _MAXIMUM_ASPECT_RATIO, _MAXIMUM_ASPECT_RATIO))
    columns = 1 if ratio > 3.5 or len(numbers) == 1 else 2 if ratio > 0.7 else 4
    columns = min(columns, len(numbers))
    rows = -(-len(numbers) // columns)
    width = min(7.5 / columns, 4.5 * ratio)
    figure = Figure(
        figsize=(columns * (width + 0.6) + _LEGEND_WIDTH, rows * (width / ratio + 0.95) + 0.5),
        layout="constrained",
    )
    stretch = float(size[0] / size[1]) / ratio
    for place, number in enumerate(numbers):
        axes = figure.add_subplot(rows, columns, place + 1)
        draw_view(axes, staged.at(number), (0, 1), lower, upper, notes)
        axes.set_aspect(stretch)
        axes.label_outer()
        axes.set_title(_title(staged, number, width), fontsize=8.5, loc="left", **AS_IT_IS)
    if abs(stretch - 1.0) > 1e-9:
        side = "horizontal" if stretch > 1.0 else "vertical"
        notes.append(f"{side} scale shortened {max(stretch, 1.0 / stretch):.3g} times")
    return figure


def _with_arrows(
    staged: StagedSetup, numbers: range, lower: Floats, upper: Floats
) -> tuple[Floats, Floats]:
    """Returns corners of a box that contains the arrows of the loads too."""
    length = _ARROW / _PANEL * float((upper - lower).max())
    for number in numbers:
        for load in staged.stages[number].setup.loads:
            longest = float(np.linalg.norm(load.force, axis=1).max(initial=0.0))
            tails = load.position - length * load.force / (longest or 1.0)
            lower, upper = (
                np.minimum(lower, tails.min(axis=0)),
                np.maximum(upper, tails.max(axis=0)),
            )
    return lower, upper


def _draw_space(
    staged: StagedSetup, numbers: range, lower: Floats, upper: Floats, notes: list[str]
) -> Figure:
    """Returns a figure with a row for each stage: from the front, from the side, in space."""
    from matplotlib.figure import Figure

    size = upper - lower
    widths = np.clip(np.array([size[0], size[1], 0.9 * max(size[0], size[1])]) / size.max(), 0.4, 1)
    width = 10.0 * widths / widths.sum()
    height = float(np.clip((width[0] * size[2] / size[0]), 1.6, 3.6))
    figure = Figure(
        figsize=(10.6 + _LEGEND_WIDTH, len(numbers) * (height + 0.95) + 0.5), layout="constrained"
    )
    grid = figure.add_gridspec(len(numbers), 3, width_ratios=list(width))
    for row, number in enumerate(numbers):
        setup = staged.at(number)
        for column, (plane, name) in enumerate((((0, 2), "front"), ((1, 2), "side"))):
            axes = figure.add_subplot(grid[row, column])
            draw_view(axes, setup, plane, lower, upper, notes)
            if column == 0:
                text = _title(staged, number, float(width[0]))
                axes.set_title(text, fontsize=8.5, loc="left", **AS_IT_IS)
            else:
                axes.set_title(f"{name} (along x)", fontsize=8.5)
        space: Any = figure.add_subplot(grid[row, 2], projection="3d")
        draw_in_space(space, setup, lower, upper)
    return figure


def _title(staged: StagedSetup, number: int, width: float) -> str:
    """Returns number and name of a stage, its time, and on further lines what changes."""
    stage = staged.stages[number]
    head = f"{stage.number}  {stage.name}  (time {stage.start:g} to {stage.end:g})"
    text = on_lines("; ".join(stage.changes), int(_CHARACTERS * width)).split("\n")
    if len(text) > _TITLE_LINES - 1:
        text = [*text[: _TITLE_LINES - 2], f"{text[_TITLE_LINES - 2]} ..."]
    return "\n".join([head, *text])


def _legend(staged: StagedSetup, numbers: range) -> list[Handle]:
    """Returns the legend's handles of everything that is there in one of the stages."""
    stages = [staged.stages[number] for number in numbers]
    handles = legend_handles(everything(staged, stages))
    extra = [staged.at(number) for number in numbers]
    if any(np.any(each.is_new) for each in extra):
        colour = BODY_COLOURS[0]
        patch: dict[str, Any] = {"facecolor": colour, "edgecolor": NEW_EDGE}
        handles.append(Handle("darker: new in the stage", patch=patch))
    if any(each.removed is not None and len(each.removed.position) for each in extra):
        patch = {"facecolor": "none", "edgecolor": REMOVED_COLOUR, "linewidth": 0.0}
        patch["hatch"] = REMOVED_HATCH
        handles.append(Handle("removed at the start\nof the stage", patch=patch))
    return handles


def everything(staged: StagedSetup, stages: Sequence[StageSetup]) -> Setup:
    """Returns a set-up with all soil, and with the largest of each condition and load."""
    setups = [stage.setup for stage in stages]
    conditions: dict[str, Condition] = {}
    surfaces: dict[str, Surface] = {}
    loads: dict[str, Load] = {}
    for setup in setups:
        for condition in setup.conditions:
            if _motion(condition) >= _motion(conditions.get(condition.name)):
                conditions[condition.name] = condition
        for surface in setup.surfaces:
            if _motion(surface) >= _motion(surfaces.get(surface.name)):
                surfaces[surface.name] = surface
        for load in setup.loads:
            before = loads.get(load.name)
            loads[load.name] = load if before is None else _larger(before, load)
    forces = [setup.body_force for setup in setups if setup.body_force is not None]
    last = len(setups[0].boundary_names)

    def order(part: Condition | Surface) -> int:
        return setups[0].colour_of(part.name, last)

    return replace(
        staged.whole(),
        conditions=sorted(conditions.values(), key=order),
        surfaces=sorted(surfaces.values(), key=order),
        loads=list(loads.values()),
        body_force=max(forces, key=lambda each: float(np.linalg.norm(each))) if forces else None,
        tracked=staged.surfaces,
    )


def _motion(part: Condition | Surface | None) -> float:
    """Returns the largest component of a displacement; -1 if there is no part."""
    if part is None:
        return -1.0
    return 0.0 if part.displacement is None else float(np.abs(part.displacement).max(initial=0.0))


def _larger(one: Load, other: Load) -> Load:
    """Returns the larger of two loads, with a note where they differ."""
    totals = [float(np.linalg.norm(each.force.sum(axis=0))) for each in (one, other)]
    if abs(totals[0] - totals[1]) <= 1e-9 * max(totals):
        return one
    larger = one if totals[0] > totals[1] else other
    return replace(larger, name=f"{other.name}, at most")
