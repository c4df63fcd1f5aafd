# SPDX-License-Identifier: BSD-3-Clause
"""Chart and table of a strength reduction, and figures of its mechanism."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.output.safety_files import (
    COLLAPSE,
    EQUILIBRIUM,
    UNDECIDED,
    SafetySummary,
    whose_text,
)
from tilth.output.snapshot import Snapshot
from tilth.output.vtkhdf import Results
from tilth.report.blocks import Table
from tilth.report.charts import Chart, Line
from tilth.report.field_plots import draw_frames
from tilth.report.fields import with_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLASTIC_INCREMENT = "plastic_strain_increment"
"""Field of the mechanism: equivalent plastic strain since the start of the reduction [-]."""

FIELDS = (PLASTIC_INCREMENT, "displacement")
"""Those that are drawn on the mechanism."""

DRAWN_MOTION = 0.05
"""Largest displacement in a picture of the mechanism, over the smallest side of the soil."""

MECHANISM_NOTE = """The mechanism is the equilibrium with the greatest factor: displacement and
plastic strain since the start of the reduction. The displacements are magnified in the
pictures."""

MOST_DRAWN = 4.0
"""Largest displacement in the curve, over that beyond which connected soil has collapsed."""


def text_of(summary: SafetySummary) -> str:
    """Returns the factor of safety with its bracket, and the criterion, in two sentences.

    What is undecided is said so, with the bracket that is certain.
    """
    iterations = sum(trial.iterations for trial in summary.trials)
    return (
        f"{_found(summary)}, from {len(summary.trials)} trials with {iterations} Newton iterations "
        f"at time {summary.time:.6g}. Criterion: {summary.criterion}."
    )


def _found(summary: SafetySummary) -> str:
    whose = whose_text(summary.davis)
    if summary.is_decided:
        assert summary.above is not None
        return (
            f"Factor of safety {summary.factor:.4g}{whose}: between {summary.factor:.6g} "
            f"(equilibrium) and {summary.above:.6g} (collapse)"
        )
    return f"Factor of safety undecided{whose}: {summary.bracket}"


def safety_chart(summary: SafetySummary, length_unit: str) -> Chart:
    """Returns a chart of the largest displacement over the factor, with the bracket."""
    stable = sorted(
        (trial.factor, trial.displacement)
        for trial in summary.trials
        if trial.outcome == EQUILIBRIUM and trial.displacement is not None
    )
    limit = summary.largest_displacement
    factors, moved = np.transpose(stable)
    lines = [Line(factors, moved, EQUILIBRIUM)]
    for outcome, kind, colour in ((COLLAPSE, "crosses", 1), (UNDECIDED, "squares", 2)):
        own = [trial.factor for trial in summary.trials if trial.outcome == outcome]
        if own:
            lines.append(Line(np.array(own), np.full(len(own), limit), outcome, colour, kind))
    above = max(trial.factor for trial in summary.trials)
    return Chart(
        "Largest displacement over the factor of the strength",
        "factor of the strength [-]",
        with_unit("largest displacement", length_unit),
        lines,
        limits=(0.0, 1.1 * min(max(limit, float(moved.max())), MOST_DRAWN * limit)),
        across=[limit],
        span=(summary.factor, above if summary.above is None else summary.above),
    )


def trials_table(summary: SafetySummary, length_unit: str) -> Table:
    """Returns a table of all trials in the order of their factors."""
    heads = ["factor", "outcome", with_unit("largest displacement", length_unit), "iterations"]
    rows = [
        [
            f"{trial.factor:.6g}",
            trial.outcome,
            "" if trial.displacement is None else f"{trial.displacement:.5g}",
            str(trial.iterations),
        ]
        for trial in sorted(summary.trials, key=lambda trial: trial.factor)
    ]
    return Table(rows, heads, "Numbers: all trials")


def draw_mechanism(results: Results, *, axisymmetric: bool) -> dict[str, Figure]:
    """Returns figures of the displacement and the plastic strain, on the magnified mechanism."""
    drawn = mechanism(results)
    return {
        name.replace("_", " "): draw_frames([drawn], name, results.units, axisymmetric=axisymmetric)
        for name in FIELDS
    }


def mechanism(results: Results) -> Snapshot:
    """Returns the output of a strength reduction with its displacement magnified."""
    snapshot = results.snapshot(-1)
    moved = np.asarray(snapshot.point_fields["displacement"])
    largest = float(np.linalg.norm(moved, axis=1).max())
    side = float(np.ptp(snapshot.position, axis=0).min())
    magnified = DRAWN_MOTION * side / largest if largest > 0.0 else 1.0
    return replace(snapshot, position=snapshot.position + magnified * moved)
