# SPDX-License-Identifier: BSD-3-Clause
"""Where stages begin and end in plots over time or steps, and their table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.output.log import LogContents
from tilth.report.blocks import Table

Span = tuple[str, float, float]
"""A stage that a run has begun: its name, where it begins and where it ends or stopped."""

MOST_NAMES = 12
"""Stages whose names are written, at most; of more only the lines are drawn."""


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
) -> Table:
    """Returns a table of the stages; those ``declared`` that were not reached say so."""
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
    return Table(rows, heads)
