# SPDX-License-Identifier: BSD-3-Clause
"""A field along a line through the soil, as a figure for a paper."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.output.snapshot import Snapshot
from tilth.plot.curves import COLOURS, SIZE, STYLES, finish_lines
from tilth.plot.names import output_at, require_field
from tilth.plot.run import results_of
from tilth.report.bridges import region_of
from tilth.report.domains import corners_of
from tilth.report.fields import field_values, with_unit
from tilth.report.interpolation import values_at
from tilth.report.texts import AS_IT_IS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PLACES = 401
"""Places along a line at which a field is evaluated."""


def path_figure(
    folder: Path | str,
    field: str,
    start: Floats,
    end: Floats,
    *,
    time: float | None = None,
    times: Sequence[float] = (),
) -> Figure:
    """Returns the figure of a field over the distance along a line; gaps where there is no soil.

    Args:
        folder: of the run.
        field: its name, or with a component.
        start: where the line begins [length], shape (dim,), in deformed coordinates.
        end: where it ends, shape (dim,).
        time: of an output; the last one if None.
        times: of several outputs instead, each of which has its curve, such as isochrones.

    Raises:
        BadInput: as ``field_figure``, or the line has no length, or none of it is in the soil.
    """
    from matplotlib.figure import Figure

    results = results_of(folder)
    asked = times if len(times) else (time,)
    numbers = [output_at(results, each) for each in asked]
    first, last = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    given = ":".join(",".join(f"{each:g}" for each in point) for point in (first, last))
    if not len(first) == len(last) == results.dim or (first == last).all():
        problem = f"is not a line between two places with {results.dim} coordinates each"
        raise BadInput(problem, key="path", value=given)
    distance = np.linspace(0.0, float(np.linalg.norm(last - first)), _PLACES)
    places = first + np.linspace(0.0, 1.0, _PLACES)[:, None] * (last - first)
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    label, is_in_soil = "", False
    unit_of_time = results.units.get("time", "")
    for number, output in enumerate(numbers):
        snapshot = results.snapshot(output)
        require_field(snapshot, field)
        values, label = field_values(snapshot, field, results.units)
        found = values_along(snapshot, values, places)
        is_in_soil |= not np.isnan(found).all()
        axes.plot(
            distance,
            found,
            color=COLOURS[number % len(COLOURS)],
            linestyle=STYLES[number // len(COLOURS) % len(STYLES)],
            linewidth=1.5,
            label=f"time {snapshot.time:.4g} {unit_of_time}".rstrip(),
        )
    if not is_in_soil:
        raise BadInput("is not in the soil", "choose other ends", key="path", value=given)
    finish_lines(axes, with_unit("Distance along the line", results.units.get("length", "")), label)
    ends = [f"({', '.join(f'{each:g}' for each in point)})" for point in (first, last)]
    title = f"{ends[0]} to {ends[1]}"
    if len(times):
        for text in axes.legend(fontsize=8, frameon=False).get_texts():
            text.set(**AS_IT_IS)
    else:
        title += f", time {results.times[numbers[0]]:.4g}"
    axes.set_title(title, fontsize=9, **AS_IT_IS)
    return figure


def values_along(snapshot: Snapshot, values: Floats, places: Floats) -> Floats:
    """Returns a field's values at places (m, dim), shape (m,); NaN outside of the soil."""
    corners = corners_of(snapshot)
    assert corners is not None
    if snapshot.dim == 2:
        return region_of(snapshot, corners).values_in(snapshot.position, values, places)
    found = np.full(len(places), np.nan)
    for body in np.unique(snapshot.body_id):  # bodies that touch keep their own values
        own = np.flatnonzero(snapshot.body_id == body)
        inside = np.flatnonzero(_inside(snapshot.position[own], corners[own], places))
        found[inside] = values_at(snapshot.position[own], values[own], places[inside])
    return found


def _inside(position: Floats, corners: Floats, places: Floats) -> Flags:
    """Returns which places in space are in the boxes around domains of points, shape (m,)."""
    from scipy.spatial import cKDTree

    half = 0.5 * np.ptp(corners, axis=1)
    near = cKDTree(position).query(places, k=[*range(1, min(9, len(half) + 1))])[1]
    away = np.abs(places[:, None, :] - position[near])
    return np.asarray((away <= 1.1 * half[near]).all(axis=2).any(axis=1))
