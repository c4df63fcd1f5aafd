# SPDX-License-Identifier: BSD-3-Clause
"""Plots of the history: tracked quantities, and the convergence of Newton's method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.model.track import OF_RELAXATION
from tilth.output.history import FIRST_COLUMNS, OF_STAGES
from tilth.report.fields import with_unit
from tilth.report.relaxations import Relaxed, mark_relaxations
from tilth.report.stage_marks import Span, mark_stages, room_for_names
from tilth.report.svg_figure import SvgFigure
from tilth.report.texts import LABEL_WIDTH, on_lines

LINE = "#1d3557"
_WIDTH = 3.7
"""Width of a panel, about [inch]."""


def draw_curves(
    history: Mapping[str, Floats],
    time_unit: str,
    stages: Sequence[Span] = (),
    relaxed: Sequence[Relaxed] = (),
) -> SvgFigure | None:
    """Returns plots of all tracked quantities against time; None if there are none.

    Rows without a value (NaN) are gaps. ``stages`` are those of the run by their total times,
    ``relaxed`` its relaxations.
    """
    own = (*FIRST_COLUMNS, *OF_STAGES, *OF_RELAXATION)
    names = [name for name in history if name.split(" [")[0] not in own]
    if not names:
        return None
    columns = 1 if len(names) == 1 else 2
    rows = -(-len(names) // columns)
    height = 2.9 + room_for_names(stages, _WIDTH)
    figure = SvgFigure(figsize=(4.6 * columns + 0.4, height * rows))
    for index, name in enumerate(names):
        axes = figure.add_subplot(rows, columns, index + 1)
        few = len(history["time"]) <= 60
        axes.plot(
            history["time"],
            history[name],
            color=LINE,
            linewidth=1.3,
            marker="o" if few else None,
            markersize=3,
        )
        mark_stages(axes, stages, _WIDTH)
        mark_relaxations(axes, relaxed)
        axes.set_xlabel(with_unit("time", time_unit))
        axes.set_ylabel(on_lines(name, LABEL_WIDTH))
        axes.grid()
    return figure


def draw_newton(
    steps: Floats,
    iterations: Floats,
    residuals: Sequence[float],
    last_step: int,
    stages: Sequence[Span] = (),
) -> SvgFigure:
    """Returns plots of the iterations of all steps, shape (rows,), and of the last residuals.

    ``stages`` are those of the run by their steps.
    """
    height = 2.9 + room_for_names(stages, _WIDTH)
    figure = SvgFigure(figsize=(9.6, height))
    left = figure.add_subplot(1, 2, 1)
    left.vlines(steps, 0.0, iterations, color="0.8", linewidth=1.0)
    left.plot(steps, iterations, "o", color=LINE, markersize=3)
    mark_stages(left, stages, _WIDTH)
    left.set_xlabel("step")
    left.set_ylabel("Newton iterations")
    left.set_ylim(0.0, 1.15 * max(float(iterations.max(initial=0.0)), 1.0))
    left.x.whole = left.y.whole = True
    right = figure.add_subplot(1, 2, 2)
    shown = np.maximum(np.asarray(residuals, dtype=np.float64), 1e-300)
    if len(shown):
        right.semilogy(np.arange(len(shown)), shown, "o-", color=LINE, markersize=4)
        right.x.whole = True
    right.set_xlabel(f"Newton iteration of step {last_step}")
    right.set_ylabel("relative residual")
    left.grid()
    right.grid()
    return figure
