# SPDX-License-Identifier: BSD-3-Clause
"""The files of a strength reduction: its trials as a table, and a summary for programs."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.output.disk import writing
from tilth.output.files import RESTORE, write_durably
from tilth.output.folder import SafetyFiles, safety_files


@dataclass(frozen=True)
class SafetySummary:
    """What is stored of a strength reduction.

    Attributes:
        factor, above: greatest factor with an equilibrium, and least one without above it [-].
        time: of the schedule.
        criterion: what counts as no equilibrium.
        largest_displacement: that still counts as equilibrium [length].
        trials: factor [-], largest displacement [length], iterations, and why there is no
            equilibrium ("" if there is one) of each trial. A displacement without a solution is
            None.
    """

    factor: float
    above: float
    time: float
    criterion: str
    largest_displacement: float
    trials: Sequence[tuple[float, float | None, int, str]]


def write_safety(
    folder: Path, summary: SafetySummary, length_unit: str, files: SafetyFiles
) -> None:
    """Writes table and summary; raises `AnalysisFailed` if that is impossible."""
    unit = f" [{length_unit}]" if length_unit else ""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["factor", f"largest displacement{unit}", "iterations", "equilibrium", "reason"])
    for factor, moved, iterations, failure in summary.trials:
        found = "no" if failure else "yes"
        shown = "nan" if moved is None else repr(moved)
        table.writerow([repr(factor), shown, iterations, found, failure])
    for name, content in (
        (files.table, text.getvalue()),
        (files.summary, json.dumps(asdict(summary), indent=1)),
    ):
        with writing(folder / name):
            write_durably(folder / name, content.encode())


def read_safety(folder: Path, index: int | None = None) -> SafetySummary:
    """Returns the summary in the folder of a run; raises `BadInput` if it cannot be read.

    index: as in `safety_files`.
    """
    file = folder / safety_files(index).summary
    try:
        require_file(file)
        entries: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        trials = [
            (float(factor), None if moved is None else float(moved), int(iterations), str(failure))
            for factor, moved, iterations, failure in entries.pop("trials")
        ]
        summary = SafetySummary(**entries, trials=trials)
        if not all(map(math.isfinite, (summary.factor, summary.above, summary.time))):
            raise ValueError("a number is not finite")
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise BadInput(f"{file} cannot be read: {error}", RESTORE) from error
    return summary
