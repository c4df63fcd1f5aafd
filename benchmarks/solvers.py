# SPDX-License-Identifier: BSD-3-Clause
"""Linear solvers on tilth's own matrices: multigrid beside the direct solvers installed.

Run it with `python benchmarks/solvers.py [REPEATS]`. For each matrix: unknowns, and per solver the
wall time of set-up (all that is done once a step), of taking one matrix, and of one solve to
1e-8 (direct solvers: to round-off), medians of repeats, and the iterations.
"""

from __future__ import annotations

import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.mpm.initial_points import initial_points
from tilth.mpm.points import MaterialPoints
from tilth.solvers import SOLVERS, LinearSolver, LinearSystem, Multigrid, StepSolver, linear_solver

TOLERANCE = 1e-8
SUPERLU_UP_TO = 30_000  # unknowns in 3D: beyond, one factorisation takes minutes


class Keeper(LinearSolver):
    """Solves by multigrid and keeps the last system."""

    def __init__(self, dimension: int) -> None:
        self._inner = linear_solver("multigrid", dimension, 0, print)
        self.system: LinearSystem | None = None
        self.right_side = np.zeros(0)

    def begin(self, system: LinearSystem) -> StepSolver:
        keeper, solver = self, self._inner.begin(system)

        class Keeping(StepSolver):
            def renew(self) -> None:
                solver.renew()

            def solve(self, right_side: Floats, tolerance: float) -> Floats:
                keeper.system, keeper.right_side = system, right_side.copy()
                return solver.solve(right_side, tolerance)

        return Keeping(self._inner, system, self._inner.direct, large=True)


def block(n: int, anti_locking: str | None = "f_bar", yield_stress: float | None = None) -> Model:
    """A block of n^3 cells with eight points each, nu 0.48, on rollers."""
    size = 1.0
    soil: dict[str, Any] = {"young_modulus": 1e7, "poisson_ratio": 0.48, "density": 2000.0}
    soil["model"] = "hencky_elastic"
    boundaries = [
        {"type": "plane", "name": f"{axis} {at}", "axis": axis, "at": at, "condition": "roller"}
        for axis, at in [("x", 0.0), ("y", 0.0), ("z", 0.0), ("x", size), ("y", size)]
    ]
    if yield_stress is not None:
        soil |= {"model": "von_mises", "yield_stress": yield_stress, "hardening_modulus": 0.0}
        width = round(0.25 * n) / n
        boundaries.append(
            {"type": "plane", "name": "footing", "axis": "z", "at": size, "condition": "prescribed",
             "range": {"x": [0.0, width], "y": [0.0, width]}, "displacement": {"z": -0.004}}
        )  # fmt: skip
    body = {
        "name": "block", "material": "soil", "basis": "linear", "points_per_cell": 2,
        "shape": {"type": "box", "lower": [0.0] * 3, "upper": [size] * 3},
    }  # fmt: skip
    if anti_locking is not None:
        body["anti_locking"] = anti_locking
    return Model.from_dict(
        {
            "analysis": {"kind": "3d"},
            "grid": {"cell_size": size / n},
            "materials": {"soil": soil},
            "bodies": [body],
            "boundaries": boundaries,
            "loads": [{"type": "body_force", "acceleration": [0.0, 0.0, -9.81]}],
            "schedule": {"steps": 8},
        }
    )


def slope_points(model: Model) -> MaterialPoints:
    """The points of the block below an inclined plane, each a little off its regular place."""
    points = initial_points(model)
    jitter = np.random.default_rng(0).uniform(-0.15, 0.15, points.position.shape)
    position = points.position + jitter * points.half_length
    x, y, z = position.T
    kept = z < 0.75 - 0.5 * (x - 0.5) - 0.2 * (y - 0.5)
    range_ = replace(points.ranges[0], stop=int(kept.sum()))
    return MaterialPoints.undeformed(
        [range_], position[kept], points.volume[kept], points.half_length[kept]
    )


def last_system(simulation: Simulation, steps: int = 1) -> tuple[LinearSystem, Floats]:
    keeper = Keeper(simulation.setup.model.dimension)
    simulation.services.solver = keeper
    schedule = simulation.setup.model.schedule
    for step in range(steps):
        simulation.advance(schedule.regular_time(step), schedule.regular_time(step + 1))
    assert keeper.system is not None
    return keeper.system, keeper.right_side


def problems() -> Iterator[tuple[str, LinearSystem, Floats]]:
    for n in (16, 25, 40):
        yield f"block {n}^3", *last_system(Simulation(block(n, None)))
    yield "block 25^3, F-bar", *last_system(Simulation(block(25)))
    model = block(25, None)
    yield "slope 25^3", *last_system(Simulation(model, slope_points(model)))
    yield "footing 16^3, plastic", *last_system(Simulation(block(16, yield_stress=1e5)), steps=8)


def timed(action: Callable[[], Any]) -> tuple[float, Any]:
    start = time.perf_counter()
    result = action()
    return time.perf_counter() - start, result


def by_multigrid(system: LinearSystem, right_side: Floats) -> tuple[list[float], int]:
    first, solver = timed(lambda: Multigrid(system.active, system.constrained))
    second, _ = timed(lambda: solver.fill(system.blocks, system.exact_nodes))
    third, solution = timed(lambda: solver.solve(right_side, TOLERANCE))
    return [first, second, third], solution.iterations


def by_direct(name: str, system: LinearSystem, right_side: Floats) -> tuple[list[float], int]:
    fresh = LinearSystem(system.active, system.constrained)
    fresh.blocks = system.blocks
    solver = SOLVERS[name]()
    first, free = timed(lambda: fresh.free)
    second, _ = timed(lambda: solver.setup(fresh.matrix()))
    third, solution = timed(lambda: solver.solve(right_side.ravel()[free]))
    return [first, second, third], solution.iterations


def main() -> None:
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    print(f"{platform.machine()}, {platform.processor() or 'processor unknown'}, "
          f"{_core.threads()} threads, medians of {repeats}; seconds")  # fmt: skip
    print(f"{'matrix':24}{'unknowns':>9}  {'solver':10}{'set-up':>8}{'matrix':>8}{'solve':>8}"
          f"{'sum':>8}{'iterations':>12}")  # fmt: skip
    for name, system, right_side in problems():
        unknowns = int((~system.constrained).sum())
        direct = [solver for solver in SOLVERS if SOLVERS[solver].available()]
        direct.remove("banded")  # no matrix here is a narrow band
        if unknowns > SUPERLU_UP_TO:
            direct.remove("superlu")
        for solver in ["multigrid", *direct]:
            runs = []
            for _ in range(1 if solver == "superlu" else repeats):
                if solver == "multigrid":
                    runs.append(by_multigrid(system, right_side))
                else:
                    runs.append(by_direct(solver, system, right_side))
            parts = [
                statistics.median(part) for part in zip(*(run[0] for run in runs), strict=True)
            ]
            total = statistics.median(sum(run[0]) for run in runs)
            print(f"{name:24}{unknowns:9}  {solver:10}" + "".join(f"{t:8.3f}" for t in parts)
                  + f"{total:8.3f}{runs[0][1]:12}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
