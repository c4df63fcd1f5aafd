# SPDX-License-Identifier: BSD-3-Clause
"""Error of the self-weight column with every basis: at equal points, and at equal processor time.

Prints the table of docs/theory/domains.md and, with --picture, draws its figure. All bases are run
in turn, one thread, on each grid; times are the medians of user processor time without imports.
"""

from __future__ import annotations

import argparse
import os
import statistics
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tilth import _core
from tilth.verification.cases import example, varied
from tilth.verification.reference import AMPLE_COLUMN_ERROR
from tilth.verification.self_weight_column import BASES, GIMP, PROBLEM, solve

COLOURS = dict(
    zip(
        BASES,
        [
            "#333333",
            "#b07aa1",
            "#9c755f",
            "#76b7b2",
            "#1f4e79",
            "#4e9ad1",
            "#86bcb6",
            "#d1495b",
            "#f28e2b",
        ],
        strict=True,
    )
)
COINCIDE = ("GIMP, deformation_gradient", GIMP, "GIMP, left_stretch", "GIMP, corners")
MARKERS = ("o", "s", "D", "v")


def measured(grids: list[int], repeats: int) -> tuple[dict, dict]:
    """Errors [-] and median user times [s] of the bases on the grids: {name: [one per grid]}."""
    errors = {name: [] for name in BASES}
    times = {name: [] for name in BASES}
    for cells in grids:
        found = {name: [] for name in BASES}
        for _ in range(repeats):
            for name, changes in BASES.items():
                start = os.times().user
                outcome = solve(varied(example(PROBLEM), changes), cells)
                found[name].append(os.times().user - start)
                if len(found[name]) == 1:
                    errors[name].append(outcome.stress_error)
        for name, each in found.items():
            times[name].append(statistics.median(each))
    return errors, times


def at_time(errors: list[float], times: list[float], budget: float) -> float:
    """Error at this time [s], between the grids on lines in the logarithms."""
    increasing = np.maximum.accumulate(times)
    return float(np.exp(np.interp(np.log(budget), np.log(increasing), np.log(errors))))


def print_tables(grids: list[int], errors: dict, times: dict, reference: int) -> None:
    """Errors at equal points, times over GIMP's, and the error at GIMP's time on one grid."""
    budget = times[GIMP][grids.index(reference)]
    print("stress error on so many cells (2 x 2 points each)")
    print(f"| basis | {' | '.join(map(str, grids))} |")
    print("| --- |" + " --- |" * len(grids))
    for name in BASES:
        print(f"| {name} | {' | '.join(f'{e:.2e}' for e in errors[name])} |")
    print(f"\nuser time [s], that over {GIMP}'s, error in its time on {reference} cells")
    print(f"| basis | {grids[-1]} cells | ratio | error at {budget:.2f} s |")
    print("| --- | --- | --- | --- |")
    for name in BASES:
        last = times[name][-1]
        error = at_time(errors[name], times[name], budget)
        print(f"| {name} | {last:.2f} | {last / times[GIMP][-1]:.2f} | {error:.2e} |")


def draw(path: Path, grids: list[int], errors: dict, times: dict) -> None:
    """Errors over the number of cells, and over the processor time, in one figure."""
    figure = Figure(figsize=(10.4, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    for name in BASES:
        style = {"color": COLOURS[name], "linewidth": 1.4, "markersize": 4.0, "marker": "o"}
        if name in COINCIDE:  # one line, on which all four must be seen
            place = COINCIDE.index(name)
            style |= {"linestyle": (2.5 * place, (2.5, 7.5)), "linewidth": 2.2}
            style |= {"marker": MARKERS[place], "markevery": (place, len(COINCIDE))}
        elif name == "CPDI2":  # the same as CPDI1
            style |= {"linestyle": (0, (4, 3)), "marker": "x", "markersize": 6.0, "zorder": 3}
        left.loglog(grids, errors[name], label=name, **style)
        right.loglog(times[name], errors[name], **style)
    published = {cells: error for cells, error in AMPLE_COLUMN_ERROR.items() if cells in grids}
    left.loglog(
        *zip(*published.items(), strict=True), "k+", markersize=10.0, label="AMPLE, published"
    )
    left.set_xlabel("cells over the height")
    left.set_xticks(grids, [str(cells) for cells in grids])
    left.minorticks_off()
    left.set_ylabel("mean stress error over the base stress")
    right.set_xlabel("processor time, one thread [s]")
    for axes in (left, right):
        axes.grid(color="0.9", linewidth=0.6)
    figure.legend(loc="outside right center", fontsize=8.5, frameon=False, handlelength=3.2)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Prints the tables and draws the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--finest", type=int, default=1024, help="cells of the finest grid")
    parser.add_argument("--reference", type=int, default=256, help="cells of the equal time")
    parser.add_argument("--picture", type=Path, help="where to save the figure")
    arguments = parser.parse_args()
    _core.set_threads(1)
    grids = [8 * 2**k for k in range(20) if 8 * 2**k <= arguments.finest]
    errors, times = measured(grids, arguments.repeats)
    print_tables(grids, errors, times, arguments.reference)
    if arguments.picture:
        draw(arguments.picture, grids, errors, times)


if __name__ == "__main__":
    main()
