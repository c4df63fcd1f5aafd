# SPDX-License-Identifier: BSD-3-Clause
"""Share of the implicit boundaries in the time of a Newton iteration: 125,000 points in 3D.

A cube of 25 cells a side with 8 points each, under its weight between smooth implicit planes off
the grid lines. Prints the parts of one load step, and what its boundary terms cost beside one
Newton iteration: once with the linear solve and once without. Run it with
`python benchmarks/implicit_boundaries.py [CELLS]`.
"""

from __future__ import annotations

import os
import sys

from tilth import Model, _core
from tilth.analysis.simulation import Simulation

CELLS = int(sys.argv[1]) if len(sys.argv) > 1 else 25
LOWER = (0.37, 0.21, 0.43)


def cube(cells: int) -> Model:
    """The cube on cells of size 1."""
    upper = [low + cells for low in LOWER]
    boundaries = []
    for k, axis in enumerate("xyz"):
        for place, sign in ((LOWER, 1.0), (upper, -1.0)):
            if k == 2 and sign < 0.0:
                continue  # the upper face is free
            normal = [0.0, 0.0, 0.0]
            normal[k] = sign
            geometry = {"type": "plane", "point": list(place), "normal": normal}
            name = f"{axis} {sign:+g}"
            boundaries.append(
                {"type": "implicit", "name": name, "geometry": geometry, "condition": "roller"}
            )
    soil = {"model": "hencky_elastic", "young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1e3}
    body = {
        "name": "cube",
        "material": "soil",
        "shape": {"type": "box", "lower": list(LOWER), "upper": upper},
        "basis": "linear",
        "points": [2 * cells] * 3,
    }
    return Model.from_dict(
        {
            "analysis": {"kind": "3d"},
            "grid": {"cell_size": 1.0},
            "materials": {"soil": soil},
            "bodies": [body],
            "boundaries": boundaries,
            "loads": [{"type": "body_force", "acceleration": [0.0, 0.0, -10.0]}],
            "schedule": {"steps": 10},
        }
    )


if __name__ == "__main__":
    threads = int(os.environ.get("OMP_NUM_THREADS", len(os.sched_getaffinity(0))))
    _core.set_threads(threads)
    simulation = Simulation(cube(CELLS))
    simulation.advance(0.0, 0.1)  # makes the quadrature points
    simulation.services.timers.wall.clear()
    result = simulation.advance(0.1, 0.2)
    wall = simulation.services.timers.wall
    iterations = result.equilibrium.iterations
    iteration = (wall["stress"] + wall["assembly"]) / iterations
    solve = wall["solve"] / iterations
    touching = sum(len(boundary.carried) for boundary in simulation.state.implicit)
    print(f"{len(simulation.state.points)} points, {touching} quadrature points, {threads} threads")
    print(f"{iterations} Newton iterations; seconds: ", end="")
    print(", ".join(f"{name} {seconds:.3f}" for name, seconds in wall.items()))
    share = wall["boundaries"] / iterations
    print(f"boundary terms: {1e3 * wall['boundaries']:.1f} ms a step, ", end="")
    print(f"{1e3 * share:.1f} ms an iteration")
    print(f"share of an iteration with the solve ({iteration + solve:.2f} s): ", end="")
    print(f"{100 * share / (share + iteration + solve):.1f} %")
    print(f"share without it ({iteration:.2f} s): {100 * share / (share + iteration):.1f} %")
