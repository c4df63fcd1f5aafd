# SPDX-License-Identifier: BSD-3-Clause
"""Charts of a study: distributions, convergence of the means, dependence on parameters."""

from __future__ import annotations

from typing import Any

import numpy as np

from tilth.model import Study
from tilth.report.charts import WARNING, Chart, Line
from tilth.studies.pictures import MOST_PANELS
from tilth.studies.result import StudyResult
from tilth.studies.statistics import running_mean


def outcome_charts(result: StudyResult) -> list[Chart]:
    """Returns histogram, cumulative distribution and mean of the first n of each outcome."""
    found: list[Chart] = []
    rows = list(zip(result.outcomes.values(), result.statistics, strict=True))[:MOST_PANELS]
    for outcomes, statistics in rows:
        numbers = outcomes[np.isfinite(outcomes)]
        if not len(numbers):
            continue
        name = statistics.heading
        bins: Any = "auto" if np.ptp(numbers) > 1e-9 * np.abs(numbers).max() else 1
        counts, edges = np.histogram(numbers, bins=bins)
        found.append(
            Chart(
                f"Histogram of {name}; red: the mean",
                f"{name}; red: the mean",
                "samples",
                [Line(edges, counts.astype(np.float64), kind="bars")],
                whole="y",
                upright=[(statistics.mean, WARNING)],
            )
        )
        steps = np.repeat(np.sort(numbers), 2)
        share = np.repeat(np.arange(len(numbers) + 1) / len(numbers), 2)[1:-1]
        found.append(
            Chart(
                f"Cumulative distribution of {name}",
                name,
                "share of samples",
                [Line(steps, share)],
                limits=(0.0, 1.02),
            )
        )
        mean, error = running_mean(numbers)
        count = np.arange(1, len(numbers) + 1, dtype=np.float64)
        band = Line(count, mean - error, "\N{PLUS-MINUS SIGN} standard error", kind="band",
                    upper=mean + error)  # fmt: skip
        found.append(
            Chart(
                f"Mean of the first samples: {name}",
                "samples",
                f"mean of {name}",
                [band, Line(count, mean)],
                whole="x",
            )
        )
    return found


def dependence_charts(asked: Study, result: StudyResult) -> list[Chart]:
    """Returns outcomes against parameters that have numbers which matter as such.

    Seeds are left out, and lists and texts. Values of samples without the outcome are red lines.
    """
    columns = [
        (entry.column, np.array(result.values[entry.column], dtype=np.float64))
        for entry in asked.vary
        if not entry.new_seed
        and not entry.key.endswith("seed")
        and all(_is_number(value) for value in result.values[entry.column])
        and len(set(result.values[entry.column])) > 1
    ][:MOST_PANELS]
    rows = list(zip(result.outcomes.values(), result.statistics, strict=True))[:MOST_PANELS]
    found = []
    for outcomes, statistics in rows:
        there = np.isfinite(outcomes)
        for name, values in columns:
            without = "" if there.all() else "; red: values of samples without the outcome"
            found.append(
                Chart(
                    f"{statistics.heading} against {name}",
                    name + without,
                    statistics.heading,
                    [Line(values[there], outcomes[there], kind="dots")],
                    upright=[(float(value), WARNING) for value in values[~there]],
                )
            )
    return found


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
