# SPDX-License-Identifier: BSD-3-Clause
"""Figures of a strength reduction: displacement over the factor, and the mechanism."""

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
from tilth.output.vtkhdf import Results
from tilth.report.field_plots import draw_frames
from tilth.report.fields import with_unit
from tilth.report.history_plots import LINE
from tilth.report.texts import AS_IT_IS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PLASTIC_INCREMENT = "plastic_strain_increment"
"""Field of the mechanism: equivalent plastic strain since the start of the reduction [-]."""

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


def draw_safety_curve(summary: SafetySummary, length_unit: str) -> Figure:
    """Returns a plot of the largest displacement over the factor, with the bracket."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.add_subplot()
    stable = sorted(
        (trial.factor, trial.displacement)
        for trial in summary.trials
        if trial.outcome == EQUILIBRIUM and trial.displacement is not None
    )
    limit = summary.largest_displacement
    axes.plot(*np.transpose(stable), "o-", color=LINE, markersize=4, label=EQUILIBRIUM)
    for outcome, marker, colour in ((COLLAPSE, "x", "#c0392b"), (UNDECIDED, "s", "#8d6e00")):
        factors = [trial.factor for trial in summary.trials if trial.outcome == outcome]
        if factors:
            axes.plot(factors, [limit] * len(factors), marker, color=colour, label=outcome)
    axes.axhline(limit, color="0.6", linewidth=0.8, linestyle="--")
    above = axes.get_xlim()[1] if summary.above is None else summary.above
    axes.axvspan(summary.factor, above, color="#e9c46a", alpha=0.5, linewidth=0)
    largest = min(max(limit, *(moved for _, moved in stable)), MOST_DRAWN * limit)
    axes.set_ylim(0.0, 1.1 * largest)
    axes.set_xlabel("factor of the strength [-]", fontsize=9)
    axes.set_ylabel(with_unit("largest displacement", length_unit), fontsize=9, **AS_IT_IS)
    axes.tick_params(labelsize=8)
    axes.legend(fontsize=8)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)
    return figure


def draw_mechanism(results: Results, *, axisymmetric: bool) -> dict[str, Figure]:
    """Returns figures of the displacement and the plastic strain, on the magnified mechanism."""
    snapshot = results.snapshot(-1)
    moved = np.asarray(snapshot.point_fields["displacement"])
    largest = float(np.linalg.norm(moved, axis=1).max())
    side = float(np.ptp(snapshot.position, axis=0).min())
    magnified = DRAWN_MOTION * side / largest if largest > 0.0 else 1.0
    drawn = replace(snapshot, position=snapshot.position + magnified * moved)
    return {
        name.replace("_", " "): draw_frames([drawn], name, results.units, axisymmetric=axisymmetric)
        for name in (PLASTIC_INCREMENT, "displacement")
    }
