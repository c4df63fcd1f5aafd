# SPDX-License-Identifier: BSD-3-Clause
"""Charts of the history: tracked quantities, and the convergence of Newton's method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tilth.arrays import Floats
from tilth.model.track import OF_RELAXATION
from tilth.output.history import FIRST_COLUMNS, OF_STAGES
from tilth.report.charts import WARNING, Chart, Line
from tilth.report.fields import with_unit
from tilth.report.relaxations import Relaxed
from tilth.report.stage_marks import Span

_LEAST_RESIDUAL = 1e-300


def tracked_columns(history: Mapping[str, Floats]) -> dict[str, Floats]:
    """Returns the columns of the tracked quantities by their headings."""
    own = (*FIRST_COLUMNS, *OF_STAGES, *OF_RELAXATION)
    return {name: values for name, values in history.items() if name.split(" [")[0] not in own}


def history_charts(
    history: Mapping[str, Floats],
    time_unit: str,
    stages: Sequence[Span] = (),
    relaxed: Sequence[Relaxed] = (),
) -> list[Chart]:
    """Returns charts of all tracked quantities against time.

    Rows without a value (NaN) are gaps. ``stages`` are those of the run by their total times,
    ``relaxed`` its relaxations.
    """
    label = with_unit("time", time_unit)
    return [
        Chart(
            f"{name} over time",
            label,
            name,
            [Line(history["time"], values)],
            stages=stages,
            upright=[(each.time, WARNING) for each in relaxed],
        )
        for name, values in tracked_columns(history).items()
    ]


def newton_charts(
    steps: Floats,
    iterations: Floats,
    residuals: Sequence[float],
    last_step: int,
    stages: Sequence[Span] = (),
) -> list[Chart]:
    """Returns charts of the iterations of all steps, shape (rows,), and of the last residuals.

    ``stages`` are those of the run by their steps.
    """
    most = 1.15 * max(float(iterations.max(initial=0.0)), 1.0)
    each_step = Chart(
        "Newton iterations of each step",
        "step",
        "Newton iterations",
        [Line(steps, iterations, kind="stems")],
        whole="xy",
        limits=(0.0, most),
        stages=stages,
    )
    shown = np.maximum(np.asarray(residuals, dtype=np.float64), _LEAST_RESIDUAL)
    last = Chart(
        f"Residuals of step {last_step}",
        f"Newton iteration of step {last_step}",
        "relative residual",
        [Line(np.arange(len(shown), dtype=np.float64), shown)],
        logarithmic=True,
        whole="x",
    )
    return [each_step, last] if len(shown) else [each_step]
