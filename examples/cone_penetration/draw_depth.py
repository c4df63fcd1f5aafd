# SPDX-License-Identifier: BSD-3-Clause
"""Draws depth.png, N_kt of the deep cone against its depth in clays of I_r 100 and 300: 15 min."""

from pathlib import Path

from matplotlib.figure import Figure

from tilth_verification.cases import example
from tilth_verification.closed_forms.limit_loads import cone_factor
from tilth_verification.cone_penetration import (
    FARTHER,
    PROBLEM,
    SOFT,
    STIFF,
    WINDOW,
    cone_resistance,
    penetrate,
    stiff_clay,
)


def draw(curves, file):
    """The forces of the steps and means of them, with the formula for each clay.

    curves: of N_kt, by I_r.
    """
    figure = Figure(figsize=(7.2, 4.4), layout="constrained")
    axes = figure.subplots()
    for (rigidity, curve), colour in zip(curves.items(), ("#3b6ea5", "#c0392b"), strict=True):
        axes.plot(curve.displacement, curve.force, color=colour, linewidth=0.6, alpha=0.6)
        quarters = range(2, round(curve.displacement[-1] / WINDOW) + 1)
        means = [cone_resistance(curve, n * WINDOW) for n in quarters]
        middles = [(n - 0.5) * WINDOW for n in quarters]
        axes.plot(middles, means, "o", color=colour, markersize=4, label=f"I_r {rigidity:g}")
        axes.axhline(cone_factor(rigidity), color=colour, linestyle=(0, (4, 3)), linewidth=1.0)
    axes.plot([], [], color="0.4", linestyle=(0, (4, 3)), label="3.4 + 1.6 ln I_r")
    axes.set_xlabel("depth of the shoulder below the hole [diameters]")
    axes.set_ylabel("N_kt [-]")
    axes.set_xlim(0.0, FARTHER)
    axes.set_ylim(0.0, 14.0)
    axes.grid(color="0.9")
    axes.legend(loc="lower right", frameon=False)
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    soft = penetrate(example(PROBLEM, "contact.toml"), 6, FARTHER)
    stiff = penetrate(stiff_clay(), 6, FARTHER)
    draw({SOFT: soft, STIFF: stiff}, Path(__file__).with_name("depth.png"))
