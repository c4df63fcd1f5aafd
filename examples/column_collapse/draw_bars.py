# SPDX-License-Identifier: BSD-3-Clause
"""Draws bars.png: the profile of the aluminium bars while they collapse, and at the end: 5 min."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tilth.analysis.march import initial_position, march
from tilth_verification.cases import example
from tilth_verification.column_collapse import BARS, PROBLEM

TIMES = (0.0, 0.1, 0.15, 0.2, 0.3)
"""Of the profiles before the last one [s]."""


def profile(points, cell):
    """The highest edge of the domains in each cell's width: middles and heights [m]."""
    number = np.floor(points.position[:, 0] / cell).astype(int)
    upper = points.position[:, 1] + points.half_length[:, 1]
    height = np.full(number.max() + 1, np.nan)
    np.fmax.at(height, number, upper)
    return cell * (np.arange(len(height)) + 0.5), height


def draw(lines, points, file):
    """Profiles by their times, and the points at the end, coloured by their layers at the start."""
    figure = Figure(figsize=(8.0, 2.9), layout="constrained")
    axes = figure.subplots()
    layer = np.floor(initial_position(points)[:, 1] / 0.02) % 2
    for which, colour in ((0, "#d8b070"), (1, "#a07840")):
        axes.plot(*points.position[layer == which].T, ".", color=colour, markersize=1.6)
    for number, (time, line) in enumerate(lines.items()):
        last = number == len(lines) - 1
        shade = "#12304f" if last else str(0.75 - 0.13 * number)
        axes.plot(*line, color=shade, linewidth=1.8 if last else 0.9, label=f"{time:.2f} s")
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    axes.legend(frameon=False, fontsize=8)
    figure.savefig(file, dpi=110)


if __name__ == "__main__":
    model = example(PROBLEM, BARS)
    cell = float(model.cell_size[0])
    lines = {}

    def after_step(simulation, result, time):
        due = [t for t in TIMES if t <= time and t not in lines]
        if due:
            lines[due[-1]] = profile(simulation.state.points, cell)

    points = march(model, after_step).points
    lines[model.schedule.end] = profile(points, cell)
    draw(lines, points, Path(__file__).with_name("bars.png"))
