# SPDX-License-Identifier: BSD-3-Clause
"""A field of a run at one time, as a figure for a paper."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tilth.errors import BadInput
from tilth.output.folder import MODEL, RESULTS, require_folder
from tilth.output.vtkhdf import Results, read_results
from tilth.plot.names import output_at, require_field
from tilth.plot.section import Section, section_of
from tilth.report.colour_scale import ColourScale
from tilth.report.field_plots import draw_frames
from tilth.report.fields import AXES, field_values, with_unit
from tilth.report.texts import AS_IT_IS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Show = Literal["field", "points", "domains"]


def field_figure(
    folder: Path | str,
    field: str,
    *,
    time: float | None = None,
    show: Show = "field",
    section: str | None = None,
    values: tuple[float, float] | None = None,
) -> Figure:
    """Returns the figure of a field over the deformed soil, to scale, with rigid bodies.

    Args:
        folder: of the run.
        field: its name, or with a component, such as ``cauchy_stress_yy``.
        time: of an output; the last one if None.
        show: the field over the region of the soil, or each point, or each point's domain.
        section: of a run in space the plane to draw, such as ``x=1.0``; without it, the points
            that are visible from outside are drawn.
        values: those at the ends of the colours; by default the least and the largest one.

    Raises:
        BadInput: there are no results, or the field, the time or the section is none of theirs.
    """
    results = results_of(folder)
    return figure_of(folder, results, output_at(results, time), field, show, section, values)


def results_of(folder: Path | str) -> Results:
    """Returns the results in the folder of a run; raises ``BadInput`` if there are none."""
    require_folder(Path(folder))
    return read_results(Path(folder) / RESULTS)


def figure_of(
    folder: Path | str,
    results: Results,
    index: int,
    field: str,
    show: Show = "field",
    section: str | None = None,
    values: tuple[float, float] | None = None,
) -> Figure:
    """Returns the figure of output number ``index``; arguments as of :func:`field_figure`."""
    snapshot = results.snapshot(index)
    require_field(snapshot, field)
    if section is not None and results.dim != 3:
        raise BadInput("the results are in the plane", "leave it out", key="section", value=section)
    scale = None if values is None else _given_scale(*values)
    if section is None:
        figure: Any = draw_frames(
            [snapshot],
            field,
            results.units,
            axisymmetric=_is_axisymmetric(folder),
            initial=results.snapshot(0),
            show=show,
            scale=scale,
        )
        return _finished(figure)
    plane = Section.of(section)
    found, label = field_values(snapshot, field, results.units)
    state, own = section_of(snapshot, found, plane)
    state = _with_field(state, field, own)
    figure = draw_frames([state], field, results.units, show=show, scale=scale)
    axes = figure.axes[0]
    unit = results.units.get("length", "")
    axes.set_xlabel(with_unit(AXES[plane.others[0]], unit), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(with_unit(AXES[plane.others[1]], unit), fontsize=9, **AS_IT_IS)
    figure.axes[-1].set_ylabel(label, fontsize=9, **AS_IT_IS)
    place = with_unit(f"{AXES[plane.axis]} = {plane.place:g}", "").strip()
    axes.set_title(f"{place} {unit}, time {snapshot.time:.4g}", fontsize=9, **AS_IT_IS)
    return _finished(figure)


def _with_field(state: Any, field: str, own: Any) -> Any:
    """Returns a state with a scalar field of this name."""
    from dataclasses import replace

    return replace(state, point_fields={**state.point_fields, field: own})


def _given_scale(low: float, high: float) -> ColourScale:
    if not low < high:
        raise BadInput("the first value must be below the second", key="range", value=[low, high])
    return ColourScale(low, high, "coolwarm" if low == -high else "viridis")


def _is_axisymmetric(folder: Path | str) -> bool:
    with suppress(OSError, ValueError, KeyError, TypeError):
        model = json.loads((Path(folder) / MODEL).read_text(encoding="utf-8"))
        return bool(model["analysis"]["kind"] == "axisymmetric")
    return False


def _finished(figure: Any) -> Figure:
    """Returns a figure with a white background around the soil."""
    for axes in figure.axes:
        axes.set_facecolor("white")
    return figure  # type: ignore[no-any-return]
