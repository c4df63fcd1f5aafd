# SPDX-License-Identifier: BSD-3-Clause
"""Times whole runs and their parts; see benchmarks/README.md."""

from __future__ import annotations

import argparse

from measure import CaseRun, machine, machine_rates, median, run_case, start_up
from problems import block, cantilever

from tilth import Model

PROBLEMS = {
    "cantilever, linear": 1.0,
    "cantilever, gimp": 1.5,
    "3D block, linear": 3.0,
}
"""Problem -> goal in microseconds per point and iteration, without the linear solve."""

PARTS = ("basis", "stress", "assembly", "solve", "other")


def model_of(problem: str) -> Model:
    """The declared model of a problem, with output of the last step only."""
    basis = problem.rsplit(" ", 1)[1]
    if problem.startswith("cantilever"):
        return cantilever(basis)
    return block(basis=basis, yield_stress=848.7)


def work_per_point(problem: str) -> dict[str, tuple[float, float]]:
    """Floating-point operations and bytes per point that each part must do, by counting.

    n nodes per point, dim directions; the stress count takes the spectral decomposition with 4
    sweeps of Jacobi rotations in 3D (one rotation in 2D) and 3 logarithms of 20 operations.
    """
    dim, n = (3, 8) if problem.startswith("3D") else (2, 4)
    response = 36 if dim == 3 else 23
    kept = 4 * dim if problem.endswith("gimp") else dim  # numbers of a point's basis
    rotation = 4 * 3 * 40 if dim == 3 else 40
    products = n * (dim + 1)  # of the basis, in each kernel
    basis = (2 * dim, 8 * (2 * dim + kept))
    stress = (
        products + 2 * dim * dim * n + 120 + rotation + 60 + 150,
        8 * (kept + 6 + 2 + 6 + 2 + response),
    )
    force = products + 2 * dim * dim * n + 3 * dim**3
    # the blocks (i, k) with i <= k, dim (dim + 1) / 2 of them: of a symmetric tangent
    stiffness = products + 2 * dim * dim * n + 5 * dim**4 + dim**3 * (dim + 1) * n * (1 + n / dim)
    assembly = (force + stiffness, 2 * 8 * (kept + response + 1))
    return {"basis": basis, "stress": stress, "assembly": assembly}


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    print(machine())
    first = median([usage.processor for usage in start_up(repeats)])
    flops, bandwidth = machine_rates()
    print(f"start-up (tilth --version): {first:.2f} s; medians of {repeats}")
    print(f"matrix product {flops:.0f} Gflop/s, triad {bandwidth:.1f} GB/s, one thread\n")
    unit = "microseconds per point and Newton iteration"
    print(f"one thread, {unit}; total = processor time of the run less start-up and solve")
    heads = ("points", "its", "total", "goal", *PARTS)
    print(f"{'problem':<20}" + "".join(f"{head:>10}" for head in heads))
    for problem, goal in PROBLEMS.items():
        runs = [run_case(model_of(problem), 1) for _ in range(repeats)]
        both = [run_case(model_of(problem), 2) for _ in range(repeats)]
        report(problem, goal, first, runs, both, flops, bandwidth)


def report(
    problem: str,
    goal: float,
    first: float,
    runs: list[CaseRun],
    both: list[CaseRun],
    flops: float,
    bandwidth: float,
) -> None:
    """Prints the rows of one problem; `first` is the time of the start-up."""
    one = runs[0].done
    unit = 1e6 / (one["points"] * one["iterations"])
    totals = [run.usage.processor - first - run.done["processor"]["solve"] for run in runs]
    parts = [median([run.done["processor"][part] for run in runs]) for part in PARTS]
    cells = [f"{one['points']:,}", str(one["iterations"])]
    cells += [f"{median(totals) * unit:.2f}", f"{goal:.1f}"]
    cells += [f"{part * unit:.3f}" for part in parts]
    print(f"{problem:<20}" + "".join(f"{cell:>10}" for cell in cells))
    evaluations = (one["iterations"] + one["steps"]) / one["iterations"]
    times = dict(zip(PARTS, parts, strict=True))
    for part, (operations, traffic) in work_per_point(problem).items():
        each = {"basis": one["steps"] / one["iterations"], "stress": evaluations}.get(part, 1.0)
        limit = each * max(operations / flops, traffic / bandwidth) * 1e-3
        print(
            f"    {part:<10} {operations:6.0f} flop {traffic:6.0f} byte a call: limit "
            f"{limit:.3f}, measured {times[part] * unit:.3f}, share "
            f"{limit / (times[part] * unit):.2f}"
        )
    ratios = []
    for part in ("basis", "stress", "assembly"):
        wall = [median([run.done["wall"][part] for run in group]) for group in (runs, both)]
        ratios.append(f"{part} {wall[0] / wall[1]:.2f}")
    print(f"    one thread over two, wall clock: {', '.join(ratios)}\n")


if __name__ == "__main__":
    main()
