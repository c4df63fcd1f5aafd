# SPDX-License-Identifier: BSD-3-Clause
"""Runs a model and prints what it took, as one line of JSON: `run_case.py MODEL.json THREADS`.

`user_in_steps` [s] is the user time of the load steps alone, `linear_iterations` the sum over all
multigrid solutions, `last` the tracked quantities at the end, `bytes_per_point` the size of the
points' arrays, `multigrid` that of its levels, `peak` the largest memory of the process [byte].
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from own_process import peak_memory, user_seconds

import tilth
from tilth import Model
from tilth.analysis.simulation import Simulation
from tilth.solvers import Multigrid


class Watch:
    """Counts the time of load steps, and the iterations of multigrid, while a run goes on."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.solutions = self.iterations = self.nodes = self.entries = self.multigrid = 0
        advance, solve = Simulation.advance, Multigrid.solve

        def timed_advance(simulation: Simulation, *arguments: Any) -> Any:
            before = user_seconds()
            try:
                result = advance(simulation, *arguments)
            finally:
                self.seconds += user_seconds() - before
            self.nodes, self.entries = result.active.nodes, len(result.active.column)
            return result

        def counted_solve(solver: Multigrid, *arguments: Any) -> Any:
            solution = solve(solver, *arguments)
            self.solutions += 1
            self.iterations += solution.iterations
            self.multigrid = solver.bytes
            return solution

        Simulation.advance = timed_advance
        Multigrid.solve = counted_solve


def main() -> None:
    model = Model.from_dict(json.loads(Path(sys.argv[1]).read_text()))
    watch = Watch()
    with tempfile.TemporaryDirectory() as folder:
        result = tilth.run(model, folder, threads=int(sys.argv[2]), overwrite=True, quiet=True)
        last = {name: column[-1] for name, column in result.history.items()}
    points = len(result.points)
    done = {
        "points": points,
        "nodes": watch.nodes,
        "matrix_blocks": watch.entries,
        "multigrid": watch.multigrid,
        "steps": result.steps,
        "iterations": result.iterations,
        "user_in_steps": watch.seconds,
        "linear_solutions": watch.solutions,
        "linear_iterations": watch.iterations,
        "peak": peak_memory(),
        "wall": result.seconds,
        "processor": result.processor_seconds,
        "last": last,
        "bytes_per_point": {
            name: array.nbytes / points for name, array in result.points.arrays().items()
        },
    }
    print(json.dumps(done))


if __name__ == "__main__":
    main()
