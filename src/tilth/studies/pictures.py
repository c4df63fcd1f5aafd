# SPDX-License-Identifier: BSD-3-Clause
"""The picture of a study: distributions and convergence of the means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.texts import AS_IT_IS, LABEL_WIDTH, on_lines
from tilth.studies.result import StudyResult
from tilth.studies.statistics import Statistics, running_mean

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLOUR, DARK, LINE = "#8fb3c9", "#1d3f58", "#c1121f"
MOST_PANELS = 6
"""Parameters and outcomes that are drawn, at most."""


def draw_outcomes(result: StudyResult) -> Figure:
    """Returns a row for each outcome: histogram, cumulative distribution, mean of the first n."""
    rows = list(zip(result.outcomes.values(), result.statistics, strict=True))[:MOST_PANELS]
    figure = _figure(10.5, 3.0 * len(rows))
    panels = figure.subplots(len(rows), 3, squeeze=False)
    for (outcomes, found), (histogram, cumulative, convergence) in zip(rows, panels, strict=True):
        numbers = outcomes[np.isfinite(outcomes)]
        for panel in (histogram, cumulative):
            _label(panel, "x", found.heading)
        _label(convergence, "y", f"mean of {found.heading}")
        histogram.set_ylabel("samples")
        cumulative.set_ylabel("share of samples")
        convergence.set_xlabel("samples")
        if not len(numbers):
            for panel in (histogram, cumulative, convergence):
                panel.text(0.5, 0.5, "no samples", ha="center", transform=panel.transAxes)
            continue
        _histogram(histogram, numbers, found)
        cumulative.step(
            np.sort(np.append(numbers, numbers.min())),
            np.arange(len(numbers) + 1) / len(numbers),
            where="post",
            color=DARK,
        )
        cumulative.set_ylim(0.0, 1.02)
        mean, error = running_mean(numbers)
        count = np.arange(1, len(numbers) + 1)
        convergence.plot(count, mean, color=DARK)
        convergence.fill_between(
            count, mean - error, mean + error, color=COLOUR, alpha=0.6, lw=0,
            label="± standard error",
        )  # fmt: skip
        convergence.legend(frameon=False, fontsize=8)
    return figure


def _histogram(panel: Axes, numbers: Floats, found: Statistics) -> None:
    from matplotlib.ticker import MaxNLocator

    bins: Any = "auto" if np.ptp(numbers) > 1e-9 * np.abs(numbers).max() else 1
    panel.hist(numbers, bins=bins, color=COLOUR, edgecolor="white")
    panel.axvline(found.mean, color=LINE, lw=1.4, label="mean")
    panel.yaxis.set_major_locator(MaxNLocator(integer=True))
    panel.legend(frameon=False, fontsize=8)


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _label(panel: Axes, axis: str, text: str) -> None:
    getattr(panel, f"set_{axis}label")(on_lines(text, LABEL_WIDTH - 16), **AS_IT_IS)
