# SPDX-License-Identifier: BSD-3-Clause
"""Three reference problems with each basis, one grid each: error, iterations, processor time.

strip_footing on cells of 0.1 m with F-bar, pressure_cantilever (the softest beam) on cells of
0.25 m, rigid_footing_elastic on cells of 0.05 m. The linear basis has a second row with more points
per cell where points that cross cells spoil it. The time is that of the whole process, user and
system, on one thread; set OMP_NUM_THREADS and OPENBLAS_NUM_THREADS to 1 for it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial
from typing import Any
from unittest.mock import patch

import numpy as np

from tilth import _core
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth_verification import pressure_cantilever, rigid_footing_elastic, strip_footing
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.reference import rigid_footing_elastic as elastic_elements

MORE_POINTS = 6
"""Per cell and direction, in the second rows of the linear basis."""


def strip(basis: str) -> tuple[float, str]:
    """P / c at 2 mm."""
    _, pressure = strip_footing.press("case.toml", {"bodies.0.basis": basis})
    return float(pressure[-1]), f"{pressure[-1] / strip_footing.LIMIT - 1.0:+.2%}"


def cantilever(basis: str, points: int = 4) -> tuple[float, str]:
    """Displacement y of the end face's middle [m]; its distance to the reference."""
    model = with_basis(pressure_cantilever.finer(pressure_cantilever.MODULI[-1], 0.25), basis)
    bending = pressure_cantilever.bend(varied(model, {"bodies.0.points_per_cell": points}))
    return float(bending.end[1]), f"{bending.distance:.2%}, balance {bending.balance:.1e}"


def rigid(basis: str, points: int = 2) -> tuple[float, str]:
    """Force over Young's modulus at 0.3 m [m]; the worst of the curve."""
    problem = rigid_footing_elastic
    model = with_basis(example(problem.PROBLEM, "narrowing.toml"), basis)
    settlement, force, _ = problem.press(model, 0.05, 0.3, points=points)
    exact = elastic_elements()
    error = force / np.interp(settlement, exact.settlement, exact.force) - 1.0
    return float(force[-1]), f"{error[np.abs(error).argmax()]:+.2%}"


def row(name: str, run: Callable[[], tuple[float, str]]) -> None:
    """Runs one problem and prints its row."""
    counts: list[int] = []
    advance = Simulation.advance

    def counting(self: Simulation, *arguments: Any) -> StepResult:
        result = advance(self, *arguments)
        counts.append(result.equilibrium.iterations)
        return result

    start = time.process_time()
    with patch.object(Simulation, "advance", counting):
        value, error = run()
    seconds = time.process_time() - start
    print(f"{name:<34}{value:>10.4f}  {error:<28}{len(counts):>6}{sum(counts):>12}{seconds:>8.1f}")


def main() -> None:
    """Prints one row per problem and basis."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    _core.set_threads(1)
    heads = f"{'problem, basis':<34}{'result':>10}  {'error':<28}"
    print(f"{heads}{'steps':>6}{'iterations':>12}{'s':>8}")
    for basis in BASES:
        row(f"strip_footing, {basis}", partial(strip, basis))
    for name, problem in (("pressure_cantilever", cantilever), ("rigid_footing_elastic", rigid)):
        for basis in BASES:
            row(f"{name}, {basis}", partial(problem, basis))
        more = f"{name}, linear, {MORE_POINTS}"
        row(more, partial(problem, "linear", MORE_POINTS))


if __name__ == "__main__":
    main()
