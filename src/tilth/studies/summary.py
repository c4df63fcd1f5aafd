# SPDX-License-Identifier: BSD-3-Clause
"""What `tilth study` prints at the end."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from tilth.errors import visible
from tilth.studies.result import StudyResult
from tilth.studies.statistics import Statistics

MOST_REASONS = 10
"""Samples that failed which are named, at most; all are in study.csv."""


def print_study(result: StudyResult) -> None:
    """Prints the statistics of each outcome, the worst case, and the samples that failed."""
    console = Console(highlight=False)
    for found in result.statistics:
        console.print(Text(visible(_line(found))), soft_wrap=True)
    count, failed = len(result.numbers), len(result.reasons)
    if not failed:
        console.print(f"all {count} samples are done")
        return
    console.print(f"{failed} of {count} samples failed:")
    for number, reason in list(result.reasons.items())[:MOST_REASONS]:
        console.print(Text(visible(f"  sample {number}: {reason}")), soft_wrap=True)
    if failed > MOST_REASONS:
        console.print(f"  ... and {failed - MOST_REASONS} more, in study.csv")


def _line(found: Statistics) -> str:
    """Returns the statistics of an outcome in one line."""
    name = found.heading
    if found.worst_sample is None:
        return f"{name}: no sample has it"
    line = f"{name}: {found.count} samples, mean {found.mean:.5g}"
    if found.count > 1:
        line += f" (standard error {found.standard_error:.2g})"
        line += f", standard deviation {found.standard_deviation:.5g}"
    line += f", from {found.smallest:.5g} to {found.largest:.5g}"
    return f"{line}; worst: {found.worst:.5g} in sample {found.worst_sample}"
