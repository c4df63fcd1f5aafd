# SPDX-License-Identifier: BSD-3-Clause
"""Times whole runs and their parts; see benchmarks/README.md."""

from __future__ import annotations

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROBLEMS = {
    "cantilever, linear": 1.0,
    "cantilever, gimp": 1.5,
    "3D block, linear": 3.0,
}
"""Problem -> goal in microseconds per point and iteration, without the linear solve."""

PARTS = ("basis", "stress", "assembly", "solve", "rest")


def model_of(problem: str):
    """The declared model of a problem, with output of the last step only."""
    import tilth

    output = tilth.Output(checkpoint_every=0, report=False)
    basis = problem.rsplit(" ", 1)[1]
    if problem.startswith("cantilever"):
        return tilth.Model(
            title="AMPLE's end-loaded cantilever, 5,760 points",
            analysis=tilth.Analysis(kind="plane_strain", solver="superlu"),
            grid=tilth.Grid(cell_size=0.25),
            materials={"beam": tilth.HenckyElastic(young_modulus=12e6, poisson_ratio=0.2)},
            bodies=[
                tilth.Body(
                    name="beam", material="beam", basis=basis, points_per_cell=6,
                    shape=tilth.Box(lower=[0, 0], upper=[10, 1]),
                )
            ],
            boundaries=[
                tilth.PlaneBoundary(name="root", axis="x", at=0, condition="roller"),
                tilth.NodeBoundary(name="pin", at=[0, 0.5], condition="fixed"),
            ],
            loads=[tilth.PointForce(body="beam", at=[10, 0.5], force=[0, -1e5])],
            schedule=tilth.Schedule(steps=50, outputs=1),
            output=output,
        )  # fmt: skip
    return tilth.Model(
        title="3D von Mises block, 125,000 points",
        analysis=tilth.Analysis(kind="3d", tolerance=1e-6, solver="auto"),
        grid=tilth.Grid(cell_size=0.2),
        materials={
            "clay": tilth.VonMises(
                young_modulus=1e7, poisson_ratio=0.48, yield_stress=848.7, hardening_modulus=0
            )
        },
        bodies=[
            tilth.Body(
                name="clay", material="clay", basis=basis, points_per_cell=2,
                shape=tilth.Box(lower=[0, 0, 0], upper=[5, 5, 5]),
            )
        ],
        boundaries=[
            *(
                tilth.PlaneBoundary(name=axis, axis=axis, at=0, condition="roller")
                for axis in "xyz"
            ),
            tilth.PlaneBoundary(
                name="footing", axis="z", at=5, condition="prescribed",
                range={"x": [0, 0.6], "y": [0, 0.6]}, displacement={"z": -2e-4},
            ),
        ],
        schedule=tilth.Schedule(steps=2, outputs=1),
        output=output,
    )  # fmt: skip


def child(problem: str, threads: int) -> None:
    """Runs one problem in this process and prints what it took."""
    import tilth

    model = model_of(problem)
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, folder, threads=threads, quiet=True)
    work = {
        "points": len(result.points),
        "steps": result.steps,
        "iterations": result.iterations,
        "wall": result.seconds,
        "processor": result.processor_seconds,
    }
    print(json.dumps(work))


def spawn(command: list[str]) -> tuple[float, str]:
    """Runs a command; returns its processor time, user and system, [s] and what it printed."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    printed = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        sys.exit(f"{' '.join(command)} ended with exit code {process.returncode}")
    return usage.ru_utime + usage.ru_stime, printed


def run_once(problem: str, threads: int) -> dict:
    processor, printed = spawn([sys.executable, __file__, "--child", problem, str(threads)])
    return {"whole": processor, **json.loads(printed)}


def machine_rates() -> tuple[float, float]:
    """Rate of a matrix product [Gflop/s] and of a triad [GB/s] on one thread."""
    import numpy as np

    a = np.random.default_rng(0).random((1200, 1200))
    product = min(_timed(lambda: a @ a) for _ in range(5))
    x, y, z = (np.ones(20_000_000) for _ in range(3))

    def triad() -> None:
        np.multiply(y, 3.0, out=x)
        np.add(x, z, out=x)

    passes = min(_timed(triad) for _ in range(5))
    return 2e-9 * 1200**3 / product, 5 * 8e-9 * len(x) / passes


def _timed(function) -> float:
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def work_per_point(problem: str) -> dict[str, tuple[float, float]]:
    """Floating-point operations and bytes per point that each part must do, by counting.

    n nodes per point, dim directions; the stress count takes the spectral decomposition with 4
    sweeps of Jacobi rotations in 3D (one rotation in 2D) and 3 logarithms of 20 operations.
    """
    dim, n = (3, 8) if problem.startswith("3D") else (2, 4)
    response = 37 if dim == 3 else 24
    rotation = 4 * 3 * 40 if dim == 3 else 40
    basis = (n * (dim + 1) * dim, 8 * (n * (dim + 1) + 2 * dim))
    stress = (
        2 * dim * dim * n + 120 + rotation + 60 + 150,
        8 * (dim * n + 6 + 2 + 9 + 6 + 2 + 1 + response),
    )
    force = 2 * dim * dim * n + 3 * dim**3
    # the blocks (i, k) with i <= k, dim (dim + 1) / 2 of them: of a symmetric tangent
    stiffness = 2 * dim * dim * n + 5 * dim**4 + dim**3 * (dim + 1) * n * (1 + n / dim)
    assembly = (force + stiffness, 2 * 8 * (dim * n + response + 1))
    return {"basis": basis, "stress": stress, "assembly": assembly}


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--child", nargs=2, metavar=("PROBLEM", "THREADS"))
    arguments = parser.parse_args()
    os.environ["OMP_WAIT_POLICY"] = "passive"
    os.environ["MKL_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    if arguments.child:
        child(arguments.child[0], int(arguments.child[1]))
        return
    version = [str(Path(sys.executable).with_name("tilth")), "--version"]
    start_up = statistics.median(spawn(version)[0] for _ in range(arguments.repeats))
    flops, bandwidth = machine_rates()
    print(f"start-up (tilth --version): {start_up:.2f} s")
    print(f"matrix product {flops:.0f} Gflop/s, triad {bandwidth:.1f} GB/s, one thread\n")
    unit = "microseconds per point and Newton iteration"
    print(f"one thread, {unit}; total = processor time of the run less start-up and solve")
    heads = ("points", "its", "total", "goal", *PARTS)
    print(f"{'problem':<20}" + "".join(f"{head:>10}" for head in heads))
    for problem, goal in PROBLEMS.items():
        runs = [run_once(problem, 1) for _ in range(arguments.repeats)]
        both = [run_once(problem, 2) for _ in range(arguments.repeats)]
        report(problem, goal, start_up, runs, both, flops, bandwidth)


def report(
    problem: str,
    goal: float,
    start_up: float,
    runs: list[dict],
    both: list[dict],
    flops: float,
    bandwidth: float,
) -> None:
    """Prints the rows of one problem."""
    one = runs[0]
    unit = 1e6 / (one["points"] * one["iterations"])
    totals = [run["whole"] - start_up - run["processor"]["solve"] for run in runs]
    parts = [statistics.median(run["processor"][part] for run in runs) for part in PARTS]
    cells = [f"{one['points']:,}", str(one["iterations"])]
    cells += [f"{statistics.median(totals) * unit:.2f}", f"{goal:.1f}"]
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
        wall = [statistics.median(run["wall"][part] for run in group) for group in (runs, both)]
        ratios.append(f"{part} {wall[0] / wall[1]:.2f}")
    print(f"    one thread over two, wall clock: {', '.join(ratios)}\n")


if __name__ == "__main__":
    main()
