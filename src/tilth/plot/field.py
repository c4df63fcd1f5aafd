# SPDX-License-Identifier: BSD-3-Clause
"""A field of a run at one time, as a figure for a paper."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from tilth.errors import BadInput
from tilth.output.folder import RESULTS, read_declared, require_folder
from tilth.output.vtkhdf import Results, read_results
from tilth.plot.names import output_at, require_field
from tilth.report.colour_scale import ColourScale
from tilth.report.field_plots import draw_frames

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Show = Literal["field", "points", "domains"]


def field_figure(
    folder: Path | str,
    field: str,
    *,
    time: float | None = None,
    show: Show = "field",
    values: tuple[float, float] | None = None,
) -> Figure:
    """Returns the figure of a field over the deformed soil, to scale, with rigid bodies.

    Of a run in space the points that are visible from outside are drawn.

    Args:
        folder: of the run.
        field: its name, or with a component, such as ``cauchy_stress_yy``.
        time: of an output; the last one if None.
        show: the field over the region of the soil, or each point, or each point's domain.
        values: those at the ends of the colours; by default the least and the largest one.

    Raises:
        BadInput: there are no results, or the field or the time is none of theirs.
    """
    results = results_of(folder)
    snapshot = results.snapshot(output_at(results, time))
    require_field(snapshot, field)
    scale = None if values is None else _given_scale(*values)
    figure: Any = draw_frames(
        [snapshot],
        field,
        results.units,
        axisymmetric=_is_axisymmetric(folder),
        initial=results.snapshot(0),
        show=show,
        scale=scale,
    )
    for axes in figure.axes:
        axes.set_facecolor("white")
    return figure  # type: ignore[no-any-return]


def results_of(folder: Path | str) -> Results:
    """Returns the results in the folder of a run; raises ``BadInput`` if there are none."""
    require_folder(Path(folder))
    return read_results(Path(folder) / RESULTS)


def _given_scale(low: float, high: float) -> ColourScale:
    if not low < high:
        raise BadInput("the first value must be below the second", key="range", value=[low, high])
    return ColourScale(low, high, "coolwarm" if low == -high else "viridis")


def _is_axisymmetric(folder: Path | str) -> bool:
    with suppress(BadInput, KeyError, TypeError):
        return bool(read_declared(folder)["analysis"]["kind"] == "axisymmetric")
    return False
