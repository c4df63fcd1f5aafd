# SPDX-License-Identifier: BSD-3-Clause
"""Where stages begin and end in plots over time or steps, and their table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.log import LogContents
from tilth.report.texts import AS_IT_IS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from tilth.report.svg_axes import SvgAxes

Span = tuple[str, float, float]
"""A stage that a run has begun: its name, where it begins and where it ends or stopped."""

MOST_NAMES = 12
"""Stages whose names are written, at most; of more only the lines are drawn."""
_LONGEST_NAME = 16
_CHARACTER, _LINE = 0.062, 0.12
"""Width of a character and height of a line of the names [inch]."""
_ROOM = 1.1
"""Multiple of the length of a name that it needs along the axis."""


def mark_stages(axes: Axes | SvgAxes, spans: Sequence[Span], width: float) -> None:
    """Draws thin lines between stages and writes their names above the panel.

    The names are upright where one of them is longer than its stage. The limits of the axis become
    those of the stages, with a margin. ``width`` of the panel is in inches.
    """
    if not spans:
        return
    first, last = spans[0][1], spans[-1][2]
    margin = 0.02 * (last - first) or 0.5
    first, last = first - margin, last + margin
    axes.set_xlim(first, last)
    for _, _, end in spans[:-1]:
        axes.axvline(end, color="0.45", linewidth=0.7, linestyle=(0.0, (4.0, 2.0)), zorder=0.9)
    if len(spans) > MOST_NAMES:
        return
    names, upright = _shortened(spans), _upright(spans, width)
    middle = np.array([(0.5 * (begin + end) - first) / (last - first) for _, begin, end in spans])
    if upright:
        middle = _apart(middle, _ROOM * _LINE / width)
    for name, place in zip(names, middle, strict=True):
        axes.annotate(
            name,
            (float(place), 1.0),
            xycoords="axes fraction",
            xytext=(0.0, 3.0),
            textcoords="offset points",
            ha="center",
            va="bottom",
            rotation=90.0 if upright else 0.0,
            fontsize=7.5,
            color="0.3",
            **AS_IT_IS,
        )


def room_for_names(spans: Sequence[Span], width: float) -> float:
    """Returns the height of the names above a panel [inch], more than that of one line."""
    if len(spans) > MOST_NAMES or not _upright(spans, width):
        return 0.0
    return _CHARACTER * max(len(name) for name in _shortened(spans))


def _shortened(spans: Sequence[Span]) -> list[str]:
    return [name if len(name) <= _LONGEST_NAME else f"{name[:15]}\u2026" for name, _, _ in spans]


def _upright(spans: Sequence[Span], width: float) -> bool:
    """Returns whether a name is longer than its stage."""
    if not spans:
        return False
    length = 1.04 * (spans[-1][2] - spans[0][1]) or 1.0
    share = np.array([(end - begin) / length for _, begin, end in spans])
    needed = _ROOM * _CHARACTER * np.array([len(name) for name in _shortened(spans)]) / width
    return bool((needed > share).any())


def _apart(place: Floats, distance: float) -> Floats:
    """Returns increasing positions in [0, 1] that are moved apart to at least a distance."""
    moved = np.array(place)
    for i in range(1, len(moved)):
        moved[i] = max(moved[i], moved[i - 1] + distance)
    moved[-1] = min(moved[-1], 1.0)
    for i in range(len(moved) - 2, -1, -1):
        moved[i] = min(moved[i], moved[i + 1] - distance)
    return moved


def spans_of_steps(history: Mapping[str, Floats], spans: Sequence[Span]) -> list[Span]:
    """Returns the stages by steps: each ends half a step after its last one."""
    found: list[Span] = []
    begin = 0.5
    for name, _, end in spans:
        last = float(history["step"][history["time"] <= end].max()) + 0.5
        found.append((name, begin, max(last, begin)))
        begin = found[-1][2]
    return found


def stage_of(spans: Sequence[Span], time: float) -> Span:
    """Returns the stage that a total time belongs to: the earlier one between two stages."""
    return next((span for span in spans if time <= span[2]), spans[-1])


def outputs_of_stages(times: Floats, spans: Sequence[Span], count: int) -> list[int]:
    """Returns the numbers of the outputs to draw: the first, and the last of each stage.

    If these are less than ``count``, others far from them are added; if they are more than
    ``MOST_NAMES``, every second or third is left out, but not the last.
    """
    ends = [int(np.flatnonzero(times <= end)[-1]) for _, _, end in spans]
    chosen = sorted({0, *ends, len(times) - 1})
    if len(chosen) > MOST_NAMES:
        kept = np.unique(np.round(np.linspace(0, len(chosen) - 1, MOST_NAMES)).astype(int))
        chosen = [chosen[i] for i in kept]
    while len(chosen) < min(count, len(times)):
        apart = np.abs(np.arange(len(times))[:, None] - np.array(chosen)).min(axis=1)
        chosen = sorted([*chosen, int(apart.argmax())])
    return chosen


def first_outputs(
    times: Floats, spans: Sequence[Span], declared: Mapping[str, Any]
) -> dict[str, int]:
    """Returns the first output of each later stage that brings soil or exchanges materials.

    declared: the model as nested mappings and lists.
    """
    bodies = {body.get("name") for body in declared.get("bodies", ())}
    by_name = {stage.get("name"): stage for stage in declared["stages"]}
    found: dict[str, int] = {}
    for name, begin, end in spans[1:]:
        stage = by_name.get(name, {})
        inside = np.flatnonzero((times > begin) & (times <= end))
        if len(inside) and (stage.get("materials") or bodies & {*stage.get("activate", ())}):
            found[name] = int(inside[0])
    return found


def stage_table(
    declared: Sequence[Mapping[str, Any]],
    history: Mapping[str, Floats],
    spans: Sequence[Span],
    log: LogContents,
) -> str:
    """Returns an HTML table of the stages; those ``declared`` that were not reached say so."""
    by_step = {name: (begin, end) for name, begin, end in spans_of_steps(history, spans)}
    by_time = {name: (begin, end) for name, begin, end in spans}
    released = bool(log.released)
    heads = ["", "stage", "time", "steps", "Newton iterations"]
    heads += ["released forces"] if released else []
    rows = []
    for number, stage in enumerate(declared, start=1):
        name = str(stage.get("name", ""))
        cells = [str(number), name]
        if name in by_time:
            begin, end = by_step[name]
            own = (history["step"] > begin) & (history["step"] < end)
            time = by_time[name]
            cells += [f"{time[0]:.6g} to {time[1]:.6g}", str(int(own.sum()))]
            cells += [str(int(history["iterations"][own].sum()))]
            nothing = "none" if number == 1 else "not in the log"
            cells += [log.released.get(name, nothing)] if released else []
        elif stage.get("type") == "strength_reduction":
            cells += ["strength reduction"]
        else:
            cells += ["not reached"]
        rows.append(cells)
    head = "".join(f"<th>{escape(text)}</th>" for text in heads)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>" for cells in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"
