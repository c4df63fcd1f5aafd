# SPDX-License-Identifier: BSD-3-Clause
"""Columns of histories against each other, of one run or of several, as a figure for a paper."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from tilth.arrays import Flags, Floats
from tilth.errors import BadInput
from tilth.input_files import absolute
from tilth.output.folder import HISTORY, require_folder
from tilth.output.history import read_history
from tilth.plot.names import column_of
from tilth.report.texts import AS_IT_IS, LABEL_WIDTH, on_lines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
"""Of curves, told apart also by those who see few colours (M. Okabe, K. Ito)."""
STYLES = ("-", "--", "-.", ":")
SIZE = (5.2, 3.9)
"""Of a figure with lines [inch]."""


Scale = Literal["linear", "log", "root"]
"""How numbers are laid out along an axis: as they are, their logarithms or their square roots."""


def curve_figure(
    folders: Sequence[Path | str] | Path | str, x: str, y: str, *, scale: Scale = "linear"
) -> Figure:
    """Returns the figure of column ``y`` over column ``x`` of the histories of runs.

    Args:
        folders: of the runs, or of one; of several each has its curve, named after its folder.
        x: a column of ``history.csv``, with its unit or without.
        y: another one.
        scale: of ``x``; with "log" and "root" numbers below 0, and 0 with "log", are left out.

    Raises:
        BadInput: a folder holds no run, or its history no such column, or one without numbers that
            the scale shows.
    """
    from matplotlib.figure import Figure

    runs = [folders] if isinstance(folders, (str, Path)) else list(folders)
    names = _names([Path(run) for run in runs])
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.add_subplot()
    labels = ("", "")
    for number, (run, name) in enumerate(zip(runs, names, strict=True)):
        require_folder(Path(run))
        history = read_history(Path(run) / HISTORY)
        across, up = column_of(list(history), x), column_of(list(history), y)
        labels = labels if number else (across, up)
        shown = _shown(history[across], scale, x)
        axes.plot(
            history[across][shown],
            history[up][shown],
            color=COLOURS[number % len(COLOURS)],
            linestyle=STYLES[number // len(COLOURS) % len(STYLES)],
            linewidth=1.5,
            marker="." if len(history[up]) == 1 else "",
            label=f"run {name}",
        )
    if scale == "log":
        axes.set_xscale("log")
    elif scale == "root":
        axes.set_xscale("function", functions=(lambda t: np.sqrt(np.maximum(t, 0.0)), np.square))
        axes.set_xlim(left=0.0)
    finish_lines(axes, *labels)
    if len(runs) > 1:
        legend = axes.legend(fontsize=8, frameon=False)
        for text, name in zip(legend.get_texts(), names, strict=True):
            text.set(text=name, **AS_IT_IS)
    return figure


def finish_lines(axes: Axes, across: str, up: str) -> None:
    """Gives axes with lines their labels, and a grid behind the lines."""
    axes.set_xlabel(on_lines(across, LABEL_WIDTH), fontsize=9, **AS_IT_IS)
    axes.set_ylabel(on_lines(up, LABEL_WIDTH), fontsize=9, **AS_IT_IS)
    axes.tick_params(labelsize=8)
    axes.grid(color="0.9", linewidth=0.6)
    axes.set_axisbelow(True)


def _shown(values: Floats, scale: Scale, column: str) -> Flags:
    """Returns which numbers of a column a scale shows, shape (n,)."""
    shown: Flags = np.ones(len(values), dtype=bool)
    if scale == "log":
        shown = values > 0.0
    elif scale == "root":
        shown = values >= 0.0
    if not shown.any():
        what = f"has no positive number, which the scale {scale!r} needs"
        raise BadInput(what, "leave out --scale", key="history", value=column)
    return shown


def _names(folders: Sequence[Path]) -> list[str]:
    """Returns short names of runs: of their folders, with those above where these are the same."""
    short = [absolute(folder).name for folder in folders]
    if len(set(short)) == len(short):
        return short
    return [str(folder) for folder in folders]
