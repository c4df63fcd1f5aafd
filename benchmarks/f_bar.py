# SPDX-License-Identifier: BSD-3-Clause
"""What F-bar adds to the kernels of a Newton iteration: stress update and assembly, one thread.

Times both formulations in turn on the same points and prints the median of the ratios pair by pair
(on a machine that others use, too, only pairs compare). Assembly takes 1.2 to 1.4 times as long in
3D and 1.7 times in 2D. The matrix has the same pattern and the same number of entries with and
without.
"""

from __future__ import annotations

import argparse
import statistics
import time

import numpy as np

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.mpm.active_grid import Buffers, locate

PROBLEMS = {
    "2D linear": ("plane_strain", "linear", 100, 2),
    "2D GIMP": ("plane_strain", "gimp", 100, 2),
    "axisymmetric linear": ("axisymmetric", "linear", 100, 2),
    "3D linear": ("3d", "linear", 25, 2),
    "3D GIMP": ("3d", "gimp", 12, 2),
}
"""Problem -> kind, basis, cells a side, points per cell and direction."""


def block(kind: str, basis: str, cells: int, points: int, anti_locking: str) -> Model:
    """A block of nearly incompressible soil on cells of size 1."""
    dim = 3 if kind == "3d" else 2
    soil = {
        "model": "von_mises",
        "young_modulus": 1e7,
        "poisson_ratio": 0.48,
        "yield_stress": 848.7,
        "hardening_modulus": 0.0,
    }
    body = {
        "name": "block",
        "material": "soil",
        "shape": {"type": "box", "lower": [0.0] * dim, "upper": [float(cells)] * dim},
        "basis": basis,
        "points_per_cell": points,
        "anti_locking": anti_locking,
    }
    fixed = {"type": "plane", "name": "base", "axis": "xyz"[dim - 1], "at": 0, "condition": "fixed"}
    return Model.from_dict(
        {
            "analysis": {"kind": kind},
            "grid": {"cell_size": 1.0},
            "materials": {"soil": soil},
            "bodies": [body],
            "boundaries": [fixed],
            "schedule": {"steps": 1},
        }
    )


class Kernels:
    """One formulation on one grid, at a displacement that makes some points yield."""

    def __init__(self, model: Model) -> None:
        simulation = Simulation(model)
        self.grid = locate(simulation.state.points, simulation.state.grid, Buffers())
        self.soil = simulation.soil_on(self.grid)
        self.displacement = 2e-4 * np.sin(self.grid.position)
        self.matrix = np.empty((len(self.grid.column), *2 * (self.grid.grid.dim,)))
        self.iterate()

    def iterate(self) -> tuple[float, float]:
        """Seconds of the stress update and of the assembly (internal force and stiffness)."""
        start = time.perf_counter()
        self.soil.update(self.displacement)
        middle = time.perf_counter()
        self.soil.internal_force()
        self.matrix.fill(0.0)
        self.soil.add_stiffness(self.grid, self.matrix)
        return middle - start, time.perf_counter() - middle


def main() -> None:
    """Prints one row per problem."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=15)
    repeats = parser.parse_args().repeats
    _core.set_threads(1)
    print("microseconds per point and iteration with F-bar; medians of the ratios to without")
    heads = ("points", "stress", "ratio", "assembly", "ratio", "both", "ratio")
    print(f"{'problem':<20}" + "".join(f"{head:>10}" for head in heads))
    for name, (kind, basis, cells, points) in PROBLEMS.items():
        plain, f_bar = (
            Kernels(block(kind, basis, cells, points, way)) for way in ("none", "f_bar")
        )
        pairs = [(plain.iterate(), f_bar.iterate()) for _ in range(repeats)]
        count = len(f_bar.soil.points)
        row = f"{name:<20}{count:>10,}"
        for part in (lambda times: times[0], lambda times: times[1], sum):
            seconds = statistics.median(part(fast) for _, fast in pairs)
            ratio = statistics.median(part(after) / part(before) for before, after in pairs)
            row += f"{1e6 * seconds / count:>10.3f}{ratio:>10.2f}"
        print(row)


if __name__ == "__main__":
    main()
