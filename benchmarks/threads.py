# SPDX-License-Identifier: BSD-3-Clause
"""One thread against two: basis, stress and assembly in turn, ratios pair by pair."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable

os.environ["OMP_WAIT_POLICY"] = "passive"

import numpy as np
from core import model_of

from tilth import _core
from tilth.grid import Buffers, locate
from tilth.simulation import Simulation

ROUNDS, CALLS = 15, 6


def parts_of(simulation: Simulation) -> dict[str, Callable[[], object]]:
    """The three parts on the first step of a simulation, ready to be called again and again."""
    soil, buffers = simulation.soil, Buffers()
    active = locate(soil.points, simulation.grid, buffers)
    soil.begin_step()
    displacement = 1e-4 * active.position
    blocks = np.empty((len(active.column), active.grid.dim, active.grid.dim))

    def basis() -> object:
        return locate(soil.points, simulation.grid, buffers).block_positions

    def stress() -> None:
        soil.update(active, displacement)

    def assembly() -> None:
        soil.internal_force(active)
        soil.stiffness(active, blocks)

    return {"basis": basis, "stress": stress, "assembly": assembly}


def seconds(part: Callable[[], object]) -> float:
    """Wall-clock time of one call [s], the mean of a few."""
    start = time.perf_counter()
    for _ in range(CALLS):
        part()
    return (time.perf_counter() - start) / CALLS


def main() -> None:
    """Prints microseconds per point with one and two threads, and the ratio of the pairs."""
    problems = {
        "2D linear": ("cantilever, linear", 0.0625),
        "2D gimp": ("cantilever, gimp", 0.0625),
        "3D linear": ("3D block, linear", 0.2),
    }
    print("microseconds per point and call, wall clock; ratio one over two: median (best)")
    for name, (problem, cell_size) in problems.items():
        model = model_of(problem)
        entries = model.to_dict()
        entries["grid"]["cell_size"] = cell_size
        simulation = Simulation(type(model).from_dict(entries))
        points = len(simulation.points)
        for part, call in parts_of(simulation).items():
            call()
            times: dict[int, list[float]] = {1: [], 2: []}
            for _ in range(ROUNDS):
                for threads, found in times.items():
                    _core.set_threads(threads)
                    found.append(seconds(call))
            ratios = [one / two for one, two in zip(times[1], times[2], strict=True)]
            one, two = (1e6 / points * statistics.median(found) for found in times.values())
            print(
                f"{name:<10}{points:>9,}  {part:<9} {one:.3f}  {two:.3f}  "
                f"{statistics.median(ratios):.2f} ({max(ratios):.2f})"
            )


if __name__ == "__main__":
    main()
