# SPDX-License-Identifier: BSD-3-Clause
"""One thread against two: basis, stress and assembly in turn, ratios pair by pair."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt
from problems import block, cantilever

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.mpm.active_grid import Buffers, locate
from tilth_verification.cases import varied

ROUNDS, CALLS = 15, 6


def parts_of(simulation: Simulation) -> dict[str, Callable[[], object]]:
    """The three parts on the first step of a simulation, ready to be called again and again."""
    points, buffers = simulation.state.points, Buffers()
    active = locate(points, simulation.state.grid, buffers)
    soil = simulation.soil_on(active)
    displacement = 1e-4 * active.position
    blocks = np.empty((len(active.column), active.grid.dim, active.grid.dim))

    def basis() -> object:
        return locate(points, simulation.state.grid, buffers).block_positions

    def stress() -> None:
        soil.update(displacement)

    def assembly() -> None:
        soil.internal_force()
        blocks.fill(0.0)
        soil.add_stiffness(active, blocks)

    return {"basis": basis, "stress": stress, "assembly": assembly}


def seconds(part: Callable[[], object]) -> float:
    """Wall-clock time of one call [s], the mean of a few."""
    start = time.perf_counter()
    for _ in range(CALLS):
        part()
    return (time.perf_counter() - start) / CALLS


def problems() -> dict[str, Model]:
    return {
        "2D linear": varied(cantilever("linear"), {"grid.cell_size": 0.0625}),
        "2D GIMP": varied(cantilever("gimp"), {"grid.cell_size": 0.0625}),
        "3D linear": block(yield_stress=848.7),
    }


def ratios() -> Iterator[tuple[str, int, str, tuple[float, float], float, float]]:
    """Yields problem, points, part, time of a call with one and two threads [s], and the ratio.

    The ratio is the median of the pairs; the best pair comes last. The last part of a problem is
    the sum of the others.
    """
    for name, model in problems().items():
        simulation = Simulation(model)
        total = np.zeros((2, ROUNDS))
        for part, call in parts_of(simulation).items():
            call()
            times = np.zeros((2, ROUNDS))
            for turn in range(ROUNDS):
                for threads in (1, 2):
                    _core.set_threads(threads)
                    times[threads - 1, turn] = seconds(call)
            total += times
            yield name, len(simulation.state.points), part, *compared(times)
        yield name, len(simulation.state.points), "all three", *compared(total)


def compared(times: npt.NDArray[np.float64]) -> tuple[tuple[float, float], float, float]:
    """Returns the medians of each row, that of the pairs' ratios, and the best of these."""
    one, two = times
    pairs = one / two
    return (float(np.median(one)), float(np.median(two))), float(np.median(pairs)), max(pairs)


def main() -> None:
    """Prints microseconds per point with one and two threads, and the ratio of the pairs."""
    print("microseconds per point and call, wall clock; ratio one over two: median (best)")
    for name, points, part, both, ratio, best in ratios():
        one, two = (1e6 / points * found for found in both)
        print(f"{name:<10}{points:>9,}  {part:<9} {one:.3f}  {two:.3f}  {ratio:.2f} ({best:.2f})")


if __name__ == "__main__":
    main()
