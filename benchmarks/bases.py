# SPDX-License-Identifier: BSD-3-Clause
"""Error of the self-weight column with every basis: at equal points, and at equal processor time.

Prints the table of docs/theory/domains.md and, with --picture, draws its figure. All bases are run
in turn, one thread, on each grid; times are the medians of user processor time without imports,
on grids on which setting up the run is not most of it.
"""

from __future__ import annotations

import argparse
import os
import statistics
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tilth import _core
from tilth_verification.cases import example, varied
from tilth_verification.reference import AMPLE_COLUMN_ERROR
from tilth_verification.self_weight_column import BASES, GIMP, PROBLEM, solve

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
            "#59a14f",
            "#d1495b",
            "#f28e2b",
        ],
        strict=True,
    )
)
COINCIDE = ("GIMP, deformation_gradient", GIMP, "GIMP, left_stretch", "GIMP, corners")
MARKERS = ("o", "s", "D", "v")


def stress_errors(grids: list[int]) -> dict[str, list[float]]:
    """Errors [-] of the bases, one per grid."""
    return {
        name: [solve(varied(example(PROBLEM), changes), cells).stress_error for cells in grids]
        for name, changes in BASES.items()
    }


def user_times(grids: list[int], repeats: int) -> dict[str, list[float]]:
    """Median user times [s] of the bases, one per grid; all bases in turn."""
    times: dict[str, list[float]] = {name: [] for name in BASES}
    for cells in grids:
        found: dict[str, list[float]] = {name: [] for name in BASES}
        for _ in range(repeats):
            for name, changes in BASES.items():
                start = os.times().user
                solve(varied(example(PROBLEM), changes), cells)
                found[name].append(os.times().user - start)
        for name, each in found.items():
            times[name].append(statistics.median(each))
    return times


def at_time(errors: list[float], times: list[float], budget: float) -> float:
    """Error at this time [s], between the grids on lines in the logarithms."""
    increasing = np.maximum.accumulate(times)
    return float(np.exp(np.interp(np.log(budget), np.log(increasing), np.log(errors))))


def print_tables(grids: list[int], timed: list[int], errors: dict, times: dict) -> None:
    """Errors at equal points, times over GIMP's, and the errors at GIMP's time on a middle grid."""
    middle = len(timed) // 2
    budget = times[GIMP][middle]
    print("stress error on so many cells (2 x 2 points each)")
    print(f"| basis | {' | '.join(map(str, grids))} |")
    print("| --- |" + " --- |" * len(grids))
    for name in BASES:
        print(f"| {name} | {' | '.join(f'{e:.2e}' for e in errors[name])} |")
    print(f"\nuser time over {GIMP}'s; error in its time on {timed[middle]} cells, {budget:.2f} s")
    print(f"| basis | {' | '.join(map(str, timed))} | error |")
    print("| --- |" + " --- |" * (len(timed) + 1))
    for name in BASES:
        ratios = [of / gimp for of, gimp in zip(times[name], times[GIMP], strict=True)]
        error = at_time(errors[name][-len(timed) :], times[name], budget)
        print(f"| {name} | {' | '.join(f'{r:.2f}' for r in ratios)} | {error:.2e} |")


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
        of_timed = errors[name][-len(times[name]) :]
        right.loglog(times[name], of_timed, **style | {"linestyle": "-", "markevery": None})
    published = {cells: error for cells, error in AMPLE_COLUMN_ERROR.items() if cells in grids}
    left.loglog(
        *zip(*published.items(), strict=True), "k+", markersize=10.0, label="AMPLE, published"
    )
    left.set_xlabel("cells over the height")
    left.set_xticks(grids, [str(cells) for cells in grids])
    left.minorticks_off()
    left.set_ylabel("mean stress error over the base stress")
    timed = f"{grids[-len(times[GIMP])]} cells and more"
    right.set_xlabel(f"processor time, one thread [s]; {timed}")
    right.xaxis.set_major_formatter("{x:g}")
    right.xaxis.set_minor_formatter("{x:g}")
    for axes in (left, right):
        axes.grid(color="0.9", linewidth=0.6)
    figure.legend(loc="outside right center", fontsize=8.5, frameon=False, handlelength=3.2)
    figure.savefig(path, dpi=110)


def main() -> None:
    """Prints the tables and draws the figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--finest", type=int, default=1024, help="cells of the finest grid")
    parser.add_argument("--timed", type=int, default=256, help="cells of the coarsest timed one")
    parser.add_argument("--picture", type=Path, help="where to save the figure")
    arguments = parser.parse_args()
    _core.set_threads(1)
    grids = [8 * 2**k for k in range(20) if 8 * 2**k <= arguments.finest]
    timed = [cells for cells in grids if cells >= arguments.timed]
    errors, times = stress_errors(grids), user_times(timed, arguments.repeats)
    print_tables(grids, timed, errors, times)
    if arguments.picture:
        draw(arguments.picture, grids, errors, times)


if __name__ == "__main__":
    main()
