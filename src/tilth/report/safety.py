# SPDX-License-Identifier: BSD-3-Clause
"""Figures of a strength reduction: displacement over the factor, and the mechanism."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from tilth.output.safety_files import SafetySummary
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


def text_of(summary: SafetySummary) -> str:
    """Returns the factor of safety with its bracket, and the criterion, in two sentences."""
    iterations = sum(trial[2] for trial in summary.trials)
    return (
        f"Factor of safety {summary.factor:.4g}: between {summary.factor:.6g} (equilibrium) and "
        f"{summary.above:.6g} (none), from {len(summary.trials)} trials with {iterations} Newton "
        f"iterations at time {summary.time:.6g}. Criterion: {summary.criterion}."
    )


def draw_safety_curve(summary: SafetySummary, length_unit: str) -> Figure:
    """Returns a plot of the largest displacement over the factor, with the bracket."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.4, 3.4), layout="constrained")
    axes = figure.add_subplot()
    stable = sorted((f, u) for f, u, _, failure in summary.trials if u is not None and not failure)
    failed = [factor for factor, _, _, failure in summary.trials if failure]
    limit = summary.largest_displacement
    axes.plot(*np.transpose(stable), "o-", color=LINE, markersize=4, label="equilibrium")
    axes.plot(failed, [limit] * len(failed), "x", color="#c0392b", label="no equilibrium")
    axes.axhline(limit, color="0.6", linewidth=0.8, linestyle="--")
    axes.axvspan(summary.factor, summary.above, color="#e9c46a", alpha=0.5, linewidth=0)
    axes.set_ylim(0.0, 1.1 * limit)
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
