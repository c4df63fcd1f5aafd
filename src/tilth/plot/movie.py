# SPDX-License-Identifier: BSD-3-Clause
"""A field of a run at all its outputs, as a movie."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tilth.errors import BadInput
from tilth.output.disk import asked_to_save
from tilth.output.files import written_whole
from tilth.output.folder import HISTORY
from tilth.output.history import read_history
from tilth.output.snapshot import Snapshot
from tilth.plot.curves import COLOURS
from tilth.plot.encoders import encoder_for
from tilth.plot.field import Show, scale_between, view_of
from tilth.plot.names import column_of, require_field
from tilth.plot.picture import FieldPicture, Scene
from tilth.plot.run import PlottedRun
from tilth.report.colour_scale import ColourScale
from tilth.report.fields import field_values, with_unit
from tilth.report.texts import AS_IT_IS, any_characters, on_lines

FPS = 8.0
"""Frames per second, if not given."""
LEAST_FPS, MOST_FPS = 0.01, 60.0
_RESOLUTION = 120
"""Pixels per inch."""
Scale = Literal["fixed", "frame"]


def write_movie(
    folder: Path | str,
    field: str,
    path: Path | str,
    *,
    show: Show = "field",
    scale: Scale = "fixed",
    values: tuple[float, float] | None = None,
    fps: float = FPS,
    history: str | None = None,
    section: str | None = None,
    progress: Callable[[int, int], None] = lambda done, all_: None,
) -> int:
    """Writes a field at all outputs of a run into a movie; returns the number of frames.

    All frames have the same limits of the axes, around the soil at all outputs.

    Args:
        folder: of the run.
        field: its name, or with a component, as of ``field_figure``.
        path: file to write, which ends with .gif, .webp or .mp4; one that is there is replaced.
        show: as of ``field_figure``.
        scale: "fixed" for the same colours in all frames, "frame" for those of each frame's values.
        values: those at the ends of the colours in all frames.
        fps: outputs per second.
        history: a column of the history that is drawn over time below the field.
        section: of a run in space the plane to draw, as of ``field_figure``.
        progress: called after each frame with the number of frames done and of all.

    Raises:
        BadInput: there are no results, the field or the column is none of theirs, or the movie
            cannot be written as asked for.
        AnalysisFailed: the disk is full, or cannot be written for another reason of its own. An
            earlier file stays as it is then, and no part of the new one is left.
    """
    from matplotlib import rc_context

    path = Path(path)
    if not LEAST_FPS <= fps <= MOST_FPS:
        remedy = f"give a number from {LEAST_FPS:g} to {MOST_FPS:g}"
        raise BadInput("is no rate of frames", remedy, key="fps", value=fps)
    if scale == "frame" and values is not None:
        problem = "the range is given for colours of each frame"
        raise BadInput(problem, "leave out --range, or take --scale fixed", key="scale")
    encoder = encoder_for(path, fps)
    run = PlottedRun.of(folder)
    results = run.results
    last = results.snapshot(-1)
    require_field(last, field)
    curve = None if history is None else _curve(run, history)
    view = view_of(run, last, field, show, section)
    scene = Scene.of(run, view, field, range(len(results)), scale_between(values))
    picture = FieldPicture(run, view, field, scene, strip=curve is not None)
    marker = _draw_curve(run, picture.strip, curve) if curve is not None else None
    picture.draw(last)
    picture.finish()
    with (
        rc_context(encoder.settings),
        asked_to_save(path),
        written_whole(path) as new,
        any_characters(),
        encoder.saving(picture.figure, new, _RESOLUTION),
    ):
        for index in range(len(results)):
            snapshot = results.snapshot(index)
            picture.draw(snapshot, _own(run, snapshot, field) if scale == "frame" else None)
            if marker is not None:
                marker(snapshot.time)
            encoder.writer.grab_frame()
            progress(index + 1, len(results))
    return len(results)


def _own(run: PlottedRun, snapshot: Snapshot, field: str) -> ColourScale:
    return ColourScale.of([field_values(snapshot, field, run.results.units)[0]])


def _curve(run: PlottedRun, name: str) -> tuple[Any, Any, str]:
    """Returns times, values and heading of a column of the history."""
    history = read_history(run.folder / HISTORY)
    heading = column_of(list(history), name)
    return history["time"], history[heading], heading


def _draw_curve(run: PlottedRun, axes: Any, curve: tuple[Any, Any, str]) -> Callable[[float], None]:
    """Draws a curve in axes; returns a function that marks a time on it."""
    times, values, heading = curve
    axes.plot(times, values, color=COLOURS[0], linewidth=1.3)
    axes.set_xlabel(with_unit("time", run.results.units.get("time", "")), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(on_lines(heading, 18), fontsize=9, **AS_IT_IS)
    axes.tick_params(labelsize=8)
    axes.locator_params(axis="y", nbins=4)
    axes.grid(color="0.9", linewidth=0.6)
    (dot,) = axes.plot([], [], "o", color=COLOURS[1], markersize=5)
    line = axes.axvline(times[0], color="0.5", linewidth=0.8, zorder=1.5)

    def mark(time: float) -> None:
        line.set_xdata([time, time])
        dot.set_data([time], [np.interp(time, times, values)])

    return mark
