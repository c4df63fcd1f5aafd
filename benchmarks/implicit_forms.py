# SPDX-License-Identifier: BSD-3-Clause
"""Surface and band form of the implicit boundary method: error, condition number and time.

A homogeneous stretch of a block of GIMP points, constrained on all sides by implicit boundaries off
the grid lines. Prints, for each width of the band, the greatest stress error in units of delta / h
times the stress, the condition number of the first step's matrix, and the time of the boundary
terms of one step. Run it with `python benchmarks/implicit_forms.py`.
"""

from __future__ import annotations

import time

import numpy as np
import scipy.sparse as sp

from tilth import Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.boundaries import ImplicitConstraints
from tilth.mpm.active_grid import Buffers, locate
from tilth.terms.balance import Balance
from tilth.terms.ghost import ghost_faces
from tilth.terms.linear import LinearForces
from tilth.terms.soil_forces import SoilForces

CELLS = 4
STRAIN = 1e-3


def block(kind: str, form: str, delta: float) -> Model:
    """A block of `CELLS` cells a side, stretched along x, cells of size 1."""
    dim = 3 if kind == "3d" else 2
    lower = np.full(dim, 0.37) + 0.1 * np.arange(dim)
    boundaries = []
    for k in range(dim):
        for end, sign in ((0.0, 1.0), (float(CELLS), -1.0)):
            centre = lower + 0.5 * CELLS
            centre[k] = lower[k] + end
            boundary = {
                "type": "implicit",
                "name": f"{'xyz'[k]} {end:g}",
                "geometry": {
                    "type": "footing",
                    "centre": centre.tolist(),
                    "normal": (sign * np.eye(dim)[k]).tolist(),
                    "width": float(CELLS) if dim == 2 else [float(CELLS)] * 2,
                },
                "condition": "roller",
                "form": form,
                "delta": delta,
            }
            if dim == 3:
                boundary["geometry"]["along"] = np.eye(3)[(k + 1) % 3].tolist()
            if k == 0 and end:
                boundary["displacement"] = {"x": STRAIN * CELLS}
            boundaries.append(boundary)
    return Model.from_dict(
        {
            "analysis": {"kind": kind, "tolerance": 1e-11},
            "grid": {"cell_size": 1.0},
            "materials": {
                "soil": {"model": "hencky_elastic", "young_modulus": 1.0, "poisson_ratio": 0.3}
            },
            "bodies": [
                {
                    "name": "block",
                    "material": "soil",
                    "shape": {
                        "type": "box",
                        "lower": lower.tolist(),
                        "upper": (lower + CELLS).tolist(),
                    },
                    "basis": "gimp",
                    "points": [2 * CELLS] * dim,
                }
            ],
            "boundaries": boundaries,
            "schedule": {"steps": 1},
        }
    )


def stress_error(model: Model) -> float:
    """Greatest error of the Cauchy stress over its size."""
    points = march(model).state.points
    lame, shear = 0.3 / (1.3 * 0.4), 1.0 / 2.6
    strain = np.log1p(STRAIN)
    exact = (lame * strain + 2.0 * shear * strain * np.array([1, 0, 0, 0, 0, 0])
             - lame * strain * np.array([0, 0, 0, 1, 1, 1])) / (1.0 + STRAIN)  # fmt: skip
    return float(np.abs(points.stress - exact).max() / exact.max())


def condition_and_time(model: Model) -> tuple[float, float]:
    """Condition number of the first matrix, and the seconds of the boundary terms."""
    simulation = Simulation(model)
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    start = time.perf_counter()
    for _ in range(5):
        constraints = ImplicitConstraints.gather(
            simulation.state.implicit,
            simulation.state.points,
            active,
            simulation.setup.kind,
            0.0,
            1.0,
        )
        couplings = constraints.couplings()
    seconds = (time.perf_counter() - start) / 5
    constrained = np.zeros((active.nodes, active.grid.dim), dtype=bool)
    faces = ghost_faces(
        simulation.soil_on(active), constrained, 0.005, constraints.exterior_nodes()
    )
    linear = LinearForces([*couplings, *(each.coupling() for each in faces)])
    balance = Balance(active, [SoilForces(simulation.soil_on(active)), linear])
    active, still = balance.active, np.zeros((active.nodes, active.grid.dim))
    x, matrix_of = balance.at(still), balance.space.matrix()
    balance.evaluate(x)
    balance.linearise(x, matrix_of)
    blocks = matrix_of["u", "u"].values
    size = active.nodes * active.grid.dim
    matrix = sp.bsr_matrix((blocks, active.column, active.row_start), shape=(size, size))
    eigenvalues = np.abs(np.linalg.eigvalsh(0.5 * (matrix + matrix.T).toarray()))
    return float(eigenvalues.max() / eigenvalues.min()), seconds


if __name__ == "__main__":
    print("| kind | delta / h | form | error / (delta / h) | condition | boundary terms |")
    print("| --- | --- | --- | --- | --- | --- |")
    for kind in ("plane_strain", "3d"):
        for delta in (1e-1, 1e-2, 1e-3, 1e-4):
            for form in ("surface", "band"):
                model = block(kind, form, delta)
                error = stress_error(model) / delta
                condition, seconds = condition_and_time(model)
                print(
                    f"| {kind} | {delta:g} | {form} | {error:.2f} | {condition:.1e} "
                    f"| {1e3 * seconds:.1f} ms |"
                )
