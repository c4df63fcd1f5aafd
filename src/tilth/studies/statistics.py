# SPDX-License-Identifier: BSD-3-Clause
"""Statistics of the outcomes of a study."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np

from tilth.arrays import Floats
from tilth.output.disk import writing
from tilth.output.files import write_durably
from tilth.report.fields import with_unit

QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True)
class Statistics:
    """Statistics of one outcome over the samples that have it.

    Attributes:
        name, unit: of the outcome.
        count: number of samples that have it.
        without: number of samples that were run and do not have it.
        mean, standard_deviation: of the outcomes; the latter with count - 1.
        standard_error: of the mean.
        smallest, largest: outcomes.
        quantiles: at `QUANTILES`.
        worst, worst_sample: the worst outcome and the number of its sample, the first one if there
            are several.

    What cannot be computed is "not a number"; the worst sample is None then.
    """

    name: str
    unit: str
    count: int
    without: int
    mean: float
    standard_deviation: float
    standard_error: float
    smallest: float
    largest: float
    quantiles: tuple[float, ...]
    worst: float
    worst_sample: int | None

    @property
    def heading(self) -> str:
        """Name with the unit in brackets, if there is one."""
        return with_unit(self.name, self.unit)


def statistics(
    name: str,
    unit: str,
    numbers: Sequence[int],
    outcomes: Floats,
    worst: Literal["largest", "smallest"],
) -> Statistics:
    """Returns the statistics of an outcome.

    Args:
        numbers: of the samples, shape (n,).
        outcomes: of the samples, shape (n,), not a number where there is none.
        worst: which outcome is the worst.
    """
    there = np.flatnonzero(np.isfinite(outcomes))
    found, count = outcomes[there], len(there)
    if not count:
        nan = math.nan
        none = (nan,) * len(QUANTILES)
        return Statistics(name, unit, 0, len(outcomes), nan, nan, nan, nan, nan, none, nan, None)
    deviation = float(found.std(ddof=1)) if count > 1 else math.nan
    place = int(np.argmax(found) if worst == "largest" else np.argmin(found))
    return Statistics(
        name=name,
        unit=unit,
        count=count,
        without=len(outcomes) - count,
        mean=float(found.mean()),
        standard_deviation=deviation,
        standard_error=deviation / math.sqrt(count),
        smallest=float(found.min()),
        largest=float(found.max()),
        quantiles=tuple(float(q) for q in np.quantile(found, QUANTILES)),
        worst=float(found[place]),
        worst_sample=numbers[int(there[place])],
    )


def running_mean(outcomes: Floats) -> tuple[Floats, Floats]:
    """Returns the means of the first 1, 2, ... n outcomes and their standard errors, each (n,).

    The first standard error is not a number.
    """
    count = np.arange(1, len(outcomes) + 1)
    shift = outcomes[0] if len(outcomes) else 0.0  # the variance of large numbers cancels
    moved = outcomes - shift
    mean = np.cumsum(moved) / count
    squares = np.maximum(np.cumsum(moved**2) - count * mean**2, 0.0)
    error = np.full(len(outcomes), np.nan)
    error[1:] = np.sqrt(squares[1:] / (count[1:] - 1) / count[1:])
    return mean + shift, error


def write_statistics(path: Path, rows: Sequence[Statistics]) -> None:
    """Writes a row for each outcome; raises `AnalysisFailed` if that is impossible."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    names = [each.name for each in fields(Statistics)]
    at = names.index("quantiles")
    heads = [f"quantile {q:g}" for q in QUANTILES]
    words = [name.replace("_", " ") for name in names]
    table.writerow([*words[:at], *heads, *words[at + 1 :]])
    for row in rows:
        cells = list(asdict(row).values())
        table.writerow(
            [
                repr(c) if isinstance(c, float) else c
                for c in (*cells[:at], *cells[at], *cells[at + 1 :])
            ]
        )
    with writing(path):
        write_durably(path, text.getvalue().encode())
