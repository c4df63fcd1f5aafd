# SPDX-License-Identifier: BSD-3-Clause
"""Every goal of speed and memory with what is measured; see benchmarks/README.md."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import solvers
from measure import CaseRun, machine, machine_rates, median, run_case, start_up, triad_rate
from peers import ample
from problems import block, cantilever, column
from solvers import by_multigrid, last_system, slope_points
from threads import ratios

from tilth import _core
from tilth.analysis.simulation import Simulation
from tilth_verification.cases import example

GROWTH = [16, 25, 32]
"""Cells along an edge of the blocks whose times are compared; 64 more with --long."""

LONGEST, LARGEST = 64, 108
KERNELS = ("basis", "stress", "assembly")
LARGE, LARGE_LIMIT = 10_000_000, 24.0
"""Points, and the memory that they may take [GB]."""


@dataclass(frozen=True)
class Row:
    """One line of the table; `limit` is a most, or a least where `at_least`."""

    what: str
    limit: float
    measured: float
    unit: str
    note: str = ""
    at_least: bool = False

    def __str__(self) -> str:
        met = self.measured >= self.limit if self.at_least else self.measured <= self.limit
        goal = f"{'>=' if self.at_least else '<='} {self.limit:g}"
        return (
            f"{self.what:<46}{goal:>9} {self.measured:>9.4g} {self.unit:<6}"
            f"{'yes' if met else 'no':<4} {self.note}"
        )


@dataclass
class Measurements:
    """The runs that several goals share, each taken when first asked for."""

    repeats: int
    long: bool
    largest: bool
    blocks: dict[int, list[CaseRun]] = field(default_factory=dict)

    @cached_property
    def start(self) -> float:
        """User time of `tilth --version` [s]."""
        return median([usage.user for usage in start_up(self.repeats)])

    @cached_property
    def cantilevers(self) -> dict[str, list[CaseRun]]:
        return {
            basis: [run_case(cantilever(basis), 1) for _ in range(self.repeats)]
            for basis in ("linear", "gimp")
        }

    def block(self, cells: int) -> list[CaseRun]:
        """Runs of the elastic block; the largest is run once."""
        if cells not in self.blocks:
            repeats = 1 if cells >= LONGEST else self.repeats
            self.blocks[cells] = [run_case(block(cells), 1) for _ in range(repeats)]
        return self.blocks[cells]

    @property
    def growth(self) -> list[int]:
        return [*GROWTH, LONGEST] if self.long else GROWTH


def per_iteration(run: CaseRun) -> float:
    """User time of the load steps for each Newton iteration [s]."""
    return float(run.done["user_in_steps"] / run.done["iterations"])


def kernels(run: CaseRun) -> float:
    """Processor time of basis, stress and assembly per point and iteration [us]."""
    time = sum(run.done["processor"][part] for part in KERNELS)
    return float(1e6 * time / run.done["iterations"] / run.done["points"])


def matrix_bytes(done: dict[str, Any], dim: int = 3) -> int:
    """Values and columns of the node blocks."""
    return int(done["matrix_blocks"] * (8 * dim * dim + 4))


def whole_runs(measured: Measurements) -> Iterator[Row]:
    """Newton iteration of the block, cantilever and column from beginning to end."""
    blocks = measured.block(25)
    yield Row(
        "3D block, 125,000 points, Newton iteration", 0.4,
        median([per_iteration(run) for run in blocks]), "s",
        f"user time, {blocks[0].done['iterations']} iterations",
    )  # fmt: skip
    runs = measured.cantilevers["linear"]
    done = runs[0].done
    yield Row(
        "cantilever, 5,760 points, 50 steps, whole run", 1.0,
        median([run.usage.user for run in runs]) - measured.start, "s",
        f"user time less start-up; {done['iterations']} iterations; AMPLE about "
        f"{ample.cantilever_seconds(done['points'], done['iterations']):.0f} s by its time per "
        "point for as many",
    )  # fmt: skip
    columns = [run_case(column(), 2) for _ in range(measured.repeats)]
    yield Row(
        "self-weight column, 8,192 cells, 40 steps", 15.0,
        median([run.usage.wall for run in columns]), "s",
        f"wall, 2 threads; user {median([run.usage.user for run in columns]):.1f} s, "
        f"{columns[0].done['iterations']} iterations; AMPLE {ample.COLUMN_SECONDS[8192]:.0f} s",
    )  # fmt: skip


def footing(measured: Measurements) -> Iterator[Row]:
    """The example as it stands, with all its output."""
    run = run_case(example("square_footing"), 2)
    yield Row(
        "square footing, 125,000 points, 200 steps", 240.0, run.usage.wall, "s",
        f"wall, 2 threads; user {run.usage.user:.0f} s, {run.done['steps']} steps, "
        f"{run.done['iterations']} iterations",
    )  # fmt: skip


def kernel_rows(measured: Measurements) -> Iterator[Row]:
    """Basis, stress and assembly on one thread."""
    goals = {
        "2D linear": (0.5, measured.cantilevers["linear"]),
        "2D GIMP": (1.0, measured.cantilevers["gimp"]),
        "3D linear, 8 points a cell": (1.5, measured.block(25)),
    }
    for name, (limit, runs) in goals.items():
        yield Row(
            f"kernels {name}", limit, median([kernels(run) for run in runs]), "us",
            "per point and iteration, processor time",
        )  # fmt: skip


def growth_rows(measured: Measurements) -> Iterator[Row]:
    """Time per iteration and point, and iterations of multigrid, over the size."""
    times = {}
    for cells in measured.growth:
        runs = measured.block(cells)
        done = runs[0].done
        times[cells] = 1e6 * median([per_iteration(run) for run in runs]) / done["points"]
        solutions = max(1, done["linear_solutions"])
        print(
            f"    {cells}^3 cells, {done['points']:,} points: {times[cells]:.2f} us user time per "
            f"iteration and point, {done['linear_iterations'] / solutions:.1f} multigrid "
            f"iterations a solution, {1e-6 * done['peak']:,.0f} MB"
        )
    yield Row(
        f"growth, {measured.growth[0]}^3 to {measured.growth[-1]}^3 cells, most over least",
        1.25, max(times.values()) / min(times.values()), "",
        "" if measured.long else f"to {LONGEST}^3 with --long",
    )  # fmt: skip


def thread_rows(measured: Measurements) -> Iterator[Row]:
    """One thread over two by the clock: cores that others use, too, spoil it."""
    for name, points, part, _, ratio, best in ratios():
        yield Row(
            f"two threads, {name} {part}", 1.7, ratio, "",
            f"{points:,} points, best pair {best:.2f}", at_least=True,
        )  # fmt: skip


def memory_rows(measured: Measurements) -> Iterator[Row]:
    """Peaks of the process; what each further point takes, from two sizes."""
    sizes = measured.growth[-2:] + ([LARGEST] if measured.largest else [])
    small, large = (measured.block(cells)[0].done for cells in sizes[-2:])
    points = large["points"]

    def per_point(bytes_of: Callable[[dict[str, Any]], float]) -> float:
        return (bytes_of(large) - bytes_of(small)) / (points - small["points"])

    everything = per_point(lambda done: done["peak"])
    matrix, copies = per_point(matrix_bytes), per_point(lambda done: done["multigrid"])
    yield Row(
        "memory per point without the matrix", 1.0, 1e-3 * (everything - matrix - copies), "kB",
        f"peaks of {points:,} and {small['points']:,} points, 3D linear; without multigrid, too",
    )  # fmt: skip
    yield Row(
        f"memory of {points:,} points", LARGE_LIMIT * points / LARGE, 1e-9 * large["peak"], "GB",
        f"all of the process; the goal is {LARGE_LIMIT:g} GB for {LARGE:,} points",
    )  # fmt: skip
    nodes = large["nodes"]
    print(
        f"    byte a point (a node): matrix {matrix:.0f} ({matrix_bytes(large) / nodes:.0f}), "
        f"multigrid {copies:.0f} ({large['multigrid'] / nodes:.0f}), all {everything:.0f}; "
        f"{points / nodes:.2f} points a node"
    )
    each = large["bytes_per_point"]
    print(f"    points' arrays that are kept: {sum(each.values()):.0f} byte a point: ", end="")
    print(", ".join(f"{name} {size:.0f}" for name, size in each.items() if size))


def solve_rows(measured: Measurements) -> Iterator[Row]:
    """Linear systems of the elastic block, full and with a slope through its cells, to 1e-8."""
    model = solvers.block(25, None)
    systems = {
        "full cells": (0.12, last_system(Simulation(model))),
        "slope": (0.25, last_system(Simulation(model, slope_points(model)))),
    }
    iterations, times = {}, {}
    for name, (limit, system) in systems.items():
        found: dict[int, list[float]] = {1: [], 2: []}
        for _ in range(4 * measured.repeats + 1):
            for threads, each in found.items():
                _core.set_threads(threads)
                parts, iterations[name] = by_multigrid(*system)
                each.append(sum(parts))
        times[name] = found
        yield Row(
            f"linear solve, 25^3, {name}", limit, median(found[2]), "s",
            f"wall with set-up, 2 threads, best {min(found[2]):.3f}, {iterations[name]} iterations",
        )  # fmt: skip
    yield Row(
        "iterations, slope over full cells", 1.3, iterations["slope"] / iterations["full cells"], ""
    )
    triad = [triad_rate(2) / triad_rate(1) for _ in range(measured.repeats)]
    pairs = [one / two for one, two in zip(*times["full cells"].values(), strict=True)]
    yield Row(
        "two threads, linear solve, full cells", median(triad), median(pairs), "",
        f"best pair {max(pairs):.2f}; the limit is that of a triad", at_least=True,
    )  # fmt: skip


SECTIONS: dict[str, Callable[[Measurements], Iterator[Row]]] = {
    "whole": whole_runs,
    "footing": footing,
    "kernels": kernel_rows,
    "solve": solve_rows,
    "growth": growth_rows,
    "threads": thread_rows,
    "memory": memory_rows,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--footing", action="store_true", help="square footing, too: minutes")
    parser.add_argument("--long", action="store_true", help=f"{LONGEST}^3 cells, too: minutes")
    parser.add_argument(
        "--largest", action="store_true", help=f"memory with {LARGEST}^3 cells, too: minutes"
    )
    parser.add_argument("--only", nargs="+", choices=list(SECTIONS), help="these parts alone")
    arguments = parser.parse_args()
    chosen = arguments.only or [name for name in SECTIONS if name != "footing" or arguments.footing]
    measured = Measurements(arguments.repeats, arguments.long, arguments.largest)
    flops, bandwidth = machine_rates()
    print(machine())
    print(f"matrix product {flops:.0f} Gflop/s, triad {bandwidth:.1f} GB/s, one thread")
    print(
        f"start-up (tilth --version): {measured.start:.2f} s user time; one thread if not said "
        f"otherwise; medians of {arguments.repeats}\n"
    )
    print(f"{'goal':<46}{'':>9} {'measured':>9} {'':<6}{'met':<4}")
    for name in chosen:
        for row in SECTIONS[name](measured):
            print(row, flush=True)
    sys.stdout.flush()


if __name__ == "__main__":
    main()
