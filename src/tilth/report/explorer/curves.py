# SPDX-License-Identifier: BSD-3-Clause
"""All columns over steps, as numbers inside the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tilth.arrays import Floats
from tilth.report.explorer.packing import Blobs
from tilth.report.motion_plots import Curve
from tilth.report.stage_marks import Span

LARGEST_CURVES = 3_000_000
"""Characters of their numbers, at most; else rows are left out evenly."""


def pack_curves(
    tables: Sequence[Mapping[str, Floats]],
    curves: Sequence[Curve],
    spans: Sequence[Span],
    time_unit: str,
    blobs: Blobs,
) -> dict[str, Any]:
    """Returns the description of all columns of tables with a row per step.

    ``curves`` are forces against displacements; the first is what the page shows first. Else it is
    the first tracked quantity against time.
    """
    table: dict[str, Floats] = {}
    for each in tables:
        for name, values in each.items():
            heading = f"time [{time_unit}]" if name == "time" and time_unit else name
            table.setdefault(heading, values)
    pairs = []
    for curve in curves:
        for name, values in (
            (curve.motion_label, curve.motion),
            (curve.reaction_label, curve.reaction),
        ):
            table.setdefault(name, np.asarray(values))
        pairs.append([curve.motion_label, curve.reaction_label])
    rows = min(len(values) for values in table.values())
    names = list(table)
    if not pairs:
        own = ("step", "time", "iterations", "stage_time")
        tracked = [name for name in names if name.split(" [")[0] not in own]
        first = next(name for name in names if name.split(" [")[0] == "time")
        pairs = [[first, (tracked or ["iterations"])[0]]]
    every = 1
    while True:
        chosen = np.unique(np.append(np.arange(0, rows, every), max(rows - 1, 0)))[:rows]
        own_blobs = Blobs()
        columns = [own_blobs.exact(table[name][chosen], "<f8") for name in names]
        if own_blobs.size <= LARGEST_CURVES or len(chosen) <= 2:
            break
        every *= 2
    numbers = [blobs.include(text) for text in own_blobs.texts]
    return {
        "names": names,
        "rows": len(chosen),
        "steps": rows,
        "columns": [numbers[column] for column in columns],
        "pairs": pairs,
        "stages": [[name, begin, end] for name, begin, end in spans],
    }
