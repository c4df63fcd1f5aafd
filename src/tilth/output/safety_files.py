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
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from tilth.errors import BadInput
from tilth.input_files import require_file
from tilth.model.davis import DavisForm
from tilth.output.disk import writing
from tilth.output.files import RESTORE, write_durably
from tilth.output.folder import SafetyFiles, safety_files

if TYPE_CHECKING:
    from tilth.model import Model

EQUILIBRIUM, COLLAPSE, UNDECIDED, DEFERRED = "equilibrium", "collapse", "undecided", "deferred"
OUTCOMES = (EQUILIBRIUM, COLLAPSE, UNDECIDED, DEFERRED)
"""What a trial showed; a deferred one began too far below to show anything."""

TO_DECIDE = "smaller cells, a small cohesion or a wider tolerance may decide it"
"""Remedy where a factor is undecided."""


class StoredTrial(NamedTuple):
    """A factor that was tried.

    Attributes:
        factor: of the strength [-].
        displacement: largest displacement of a point [length]; None without a solution.
        iterations: of Newton's method.
        outcome: one of `OUTCOMES`.
        reason: why there is no equilibrium; "" if there is one.
    """

    factor: float
    displacement: float | None
    iterations: int
    outcome: str
    reason: str


@dataclass(frozen=True)
class SafetySummary:
    """What is stored of a strength reduction.

    Attributes:
        factor: greatest factor with an equilibrium [-].
        above: least one with a collapse above it [-]; None if none was found.
        tolerance: greatest difference of the two that was asked for [-].
        undecided: factors between them that showed neither, increasing [-].
        time: of the schedule.
        criterion: what counts as equilibrium and as collapse.
        largest_displacement: beyond which connected soil has collapsed [length].
        trials: in the order in which they were made.
        davis: form of Davis' associated equivalent whose factor it is; None of the soil itself.
    """

    factor: float
    above: float | None
    tolerance: float
    undecided: Sequence[float]
    time: float
    criterion: str
    largest_displacement: float
    trials: Sequence[StoredTrial]
    davis: str | None = None

    @property
    def is_decided(self) -> bool:
        """Whether the two factors are as close to each other as was asked for."""
        return self.above is not None and self.above - self.factor <= self.tolerance * (1.0 + 1e-9)

    @property
    def bracket(self) -> str:
        """What is certain, in words."""
        return bracket_text(self.factor, self.above, self.undecided)


def whose_text(davis: str | None) -> str:
    """Returns words on the soil whose factor it is, to follow it; "" for the soil itself.

    davis: form of Davis' associated equivalent.
    """
    return "" if davis is None else f", of Davis' associated equivalent, form {davis}"


def bracket_text(factor: float, above: float | None, undecided: Sequence[float]) -> str:
    """Returns words on what is certain of a factor that is undecided; see `SafetySummary`."""
    upper = ", no collapse found above it" if above is None else f" and {above:.6g} (collapse)"
    return (
        f"between {factor:.6g} (equilibrium){upper}; undecided trials between them: "
        f"{len(undecided)}"
    )


def write_safety(
    folder: Path, summary: SafetySummary, length_unit: str, files: SafetyFiles
) -> None:
    """Writes table and summary; raises `AnalysisFailed` if that is impossible."""
    unit = f" [{length_unit}]" if length_unit else ""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["factor", f"largest displacement{unit}", "iterations", "outcome", "reason"])
    for trial in summary.trials:
        moved = "nan" if trial.displacement is None else repr(trial.displacement)
        table.writerow([repr(trial.factor), moved, trial.iterations, trial.outcome, trial.reason])
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
        trials = [_trial(*each) for each in entries.pop("trials")]
        undecided = tuple(map(float, entries.pop("undecided")))
        summary = SafetySummary(**entries, undecided=undecided, trials=trials)
        numbers = (summary.factor, summary.tolerance, summary.time, *undecided)
        above = () if summary.above is None else (summary.above,)
        if not all(map(math.isfinite, (*numbers, *above))):
            raise ValueError("a number is not finite")
        if summary.davis not in (None, *get_args(DavisForm)):
            raise ValueError(f"unknown form {summary.davis!r} of Davis' equivalent")
    except (OSError, ValueError, TypeError, KeyError, RecursionError) as error:
        raise BadInput(f"{file} cannot be read: {error}", RESTORE) from error
    return summary


def undecided_factors(model: Model, folder: Path) -> dict[str, str]:
    """Returns what is certain of each factor of a stage that is undecided, by the stage's name.

    Of those in the folder of a run of the model; raises `BadInput` as `read_safety`.
    """
    found = {}
    for index, stage in (each for one in model.of_stages for each in one.stage.reductions):
        if (folder / safety_files(index).summary).exists():
            summary = read_safety(folder, index)
            if not summary.is_decided:
                found[stage.name] = summary.bracket
    return found


def _trial(factor: Any, moved: Any, iterations: Any, outcome: Any, reason: Any) -> StoredTrial:
    if outcome not in OUTCOMES:
        raise ValueError(f"a trial has the unknown outcome {outcome!r}")
    displacement = None if moved is None else float(moved)
    return StoredTrial(float(factor), displacement, int(iterations), outcome, str(reason))
