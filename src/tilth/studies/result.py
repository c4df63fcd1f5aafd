# SPDX-License-Identifier: BSD-3-Clause
"""What a study has found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tilth.arrays import Floats
from tilth.studies.statistics import Statistics


@dataclass(frozen=True)
class StudyResult:
    """A study all of whose samples were run.

    Attributes:
        folder: where study.csv, statistics.csv, study.html and the samples are.
        numbers: of the samples, from 1, shape (n,).
        values: of the entries that vary, by column of the table, each of length n.
        outcomes: by column of the table, each of shape (n,), not a number where there is none.
        reasons: why samples failed, by their numbers.
        statistics: of each outcome.
    """

    folder: Path
    numbers: Sequence[int]
    values: dict[str, list[Any]]
    outcomes: dict[str, Floats]
    reasons: dict[int, str]
    statistics: Sequence[Statistics]

    def __repr__(self) -> str:
        lines = [
            f"<StudyResult: {len(self.numbers)} samples, {len(self.reasons)} failed, "
            f"in {self.folder}",
            *(
                f"  {s.name}: mean {s.mean:.6g} {s.unit}, "
                f"standard deviation {s.standard_deviation:.6g}"
                for s in self.statistics
            ),
        ]
        return "\n".join(line.rstrip() for line in lines) + ">"
