# SPDX-License-Identifier: BSD-3-Clause
"""Cost of every constitutive law, per point and Newton iteration, on one thread.

A block of soil is strained so that all points are in one region of the law: elastic, on a face, an
edge or the apex of the yield surface. All laws are timed in turn; the ratios are medians of those
to von Mises in the same round, as on a machine that others use, too, only these compare.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measure import machine

from tilth import Model, _core
from tilth.analysis.simulation import Simulation
from tilth.mpm.active_grid import Buffers, locate

sys.path.append(str(Path(__file__).parents[1] / "tests"))

from user_laws import BUILT_IN, ELASTIC, LAWS, material

PRESSURE = 100.0
"""Isotropic pressure at the start of the soils that need one."""

FRICTION = {"cohesion": 5.0, "friction_angle": 30.0, "dilation_angle": 10.0}
SOFTENING = {
    "residual_cohesion": 1.0, "residual_friction_angle": 20.0, "softening_strain": 10.0,
    "softening_length": 1.0,
}  # fmt: skip
CAM_CLAY = {
    "compression_index": 0.2, "swelling_index": 0.05, "critical_state_slope": 1.2,
    "shear_modulus": 400.0, "overconsolidation_ratio": 1.5,
}  # fmt: skip
FLUID = {"pore_fluid_bulk_modulus": 5000.0}

FRICTIONAL = {"model": "mohr_coulomb", **ELASTIC, **FRICTION}
CONE = {"model": "drucker_prager", **ELASTIC, **FRICTION, "fit": "compression"}
CLAY = {"model": "modified_cam_clay", **CAM_CLAY}

ROWS: list[tuple[dict[str, Any], str]] = [
    (BUILT_IN, "yields"),
    (BUILT_IN, "elastic"),
    ({"model": "hencky_elastic", **ELASTIC}, "elastic"),
    ({"model": "tresca", **ELASTIC, "undrained_shear_strength": 5.0}, "face"),
    ({"model": "tresca", **ELASTIC, "undrained_shear_strength": 5.0}, "edge"),
    *((FRICTIONAL, region) for region in ("elastic", "face", "edge", "apex")),
    *(({**FRICTIONAL, **SOFTENING}, region) for region in ("face", "edge", "apex")),
    *((CONE, region) for region in ("yields", "apex")),
    *((CLAY, region) for region in ("elastic", "yields")),
    *(({**FRICTIONAL, **FLUID}, region) for region in ("face", "edge")),
    ({**CONE, **FLUID}, "yields"),
    *(({**CLAY, **FLUID}, region) for region in ("elastic", "yields")),
]
"""Entries of each law, and the region of its points; von Mises first."""


CELLS = {"plane_strain": 100, "axisymmetric": 100, "3d": 16}
"""Cells a side, four or eight points in each."""

SHIFT = 0.3
"""Share of a cell by which the points are moved: grid lines cut their domains, as in a flow."""

TRIALS = 100_000
"""Random strains tried for a region, at most."""


def block(kind: str, basis: str, cells: int, soil: dict[str, Any]) -> Model:
    """A block of soil on cells of size 1."""
    dim = 3 if kind == "3d" else 2
    body = {
        "name": "block", "material": "soil", "basis": basis, "points_per_cell": 2,
        "shape": {"type": "box", "lower": [0.0] * dim, "upper": [float(cells)] * dim},
    }  # fmt: skip
    stress = [-PRESSURE] * 3 + [0.0] * (3 if dim == 3 else 1)
    needs = soil["model"] == "modified_cam_clay"
    start = {"stress": [{"type": "given", "body": "block", "stress": stress}]} if needs else {}
    fixed = {"type": "plane", "name": "base", "axis": "xyz"[dim - 1], "at": 0, "condition": "fixed"}
    return Model.from_dict(
        {
            "analysis": {"kind": kind},
            "grid": {"cell_size": 1.0},
            "materials": {"soil": soil},
            "bodies": [body],
            "boundaries": [fixed],
            "initial": start,
            "schedule": {"steps": 1},
        }
    )


class Row:
    """One law on one grid, at a displacement that brings all points to one region."""

    def __init__(self, model: Model, region: str) -> None:
        simulation = Simulation(model)
        self._material = model.materials["soil"]
        self.points = simulation.state.points
        self.points.position += SHIFT * simulation.state.grid.cell_size
        self.grid = locate(self.points, simulation.state.grid, Buffers())
        self.soil = simulation.soil_on(self.grid)
        dim = self.grid.grid.dim
        self.matrix = np.empty((len(self.grid.column), dim, dim))
        random = np.random.default_rng(1)
        for _ in range(TRIALS):
            gradient = np.zeros((3, 3))
            gradient[:dim, :dim] = random.normal(size=(dim, dim)) * 10.0 ** random.uniform(-5, -1)
            if region in self._regions(gradient):
                break
        else:
            raise SystemExit(f"no strain brings {self.name} to the region {region!r}")
        self.displacement = self.grid.position @ gradient[:dim, :dim].T
        self.soil.update(self.displacement)  # makes its arrays

    @property
    def name(self) -> str:
        """Name of the law."""
        law, softens = self.points.ranges[0].law, getattr(self._material, "softens", False)
        name = f"{law.name}, softening" if softens else law.name
        return name if law.source is None else f"{name}: {law.source.title}"

    def _regions(self, gradient: np.ndarray) -> tuple[str, ...]:
        """Where the stress of a point is after a displacement gradient (3, 3)."""
        range_, f = self.points.ranges[0], np.eye(3) + gradient
        start = 1.0 + self.points.elastic_deformation[0, 0]  # isotropic
        trial = 0.5 * np.log(start * np.linalg.eigvalsh(f @ f.T))[None]
        state, plastic, good = self.points.state[:1], np.zeros((1, 2)), np.zeros(1, dtype=bool)
        stress, elastic, tangent = np.empty((1, 3)), np.empty((1, 3)), np.empty((1, 3, 3))
        _core.principal_update(
            range_.law.core, range_.parameters, trial, plastic, state, state.copy(), stress,
            elastic, tangent, good,
        )  # fmt: skip
        if not good[0]:
            return ()
        if np.array_equal(elastic, trial):
            return ("elastic",)
        size = np.abs(stress).max() + 1.0
        equal = int(np.count_nonzero(np.diff(np.sort(stress[0])) < 1e-9 * size))
        return (("face", "yields"), ("edge", "yields"), ("apex",))[equal]

    def iterate(self) -> tuple[float, float]:
        """Seconds of the stress update, and of the whole iteration with force and stiffness."""
        start = time.process_time()
        self.soil.update(self.displacement)
        middle = time.process_time()
        self.soil.internal_force()
        self.matrix.fill(0.0)
        self.soil.add_stiffness(self.grid, self.matrix)
        return middle - start, time.process_time() - start


def user_rows(kind: str, basis: str, cells: int, folder: Path) -> Iterator[Row]:
    """The laws of the how-to that the compilers of this machine can make."""
    for law in LAWS:
        try:
            soil = material(law, folder)
        except pytest.skip.Exception as reason:
            print(f"without {law}: {reason}")
            continue
        yield Row(block(kind, basis, cells, soil), "yields")


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kind", default="plane_strain", choices=CELLS)
    parser.add_argument("--basis", default="gimp")
    parser.add_argument("--repeats", type=int, default=15)
    given = parser.parse_args()
    _core.set_threads(1)
    print(machine())
    of_kind = given.kind, given.basis, CELLS[given.kind]
    with tempfile.TemporaryDirectory() as folder:
        rows = [(Row(block(*of_kind, soil), region), region) for soil, region in ROWS]
        rows += [(row, "yields") for row in user_rows(*of_kind, Path(folder))]
        rounds = [[row.iterate() for row, _ in rows] for _ in range(given.repeats)]
    count = len(rows[0][0].points)
    print(f"{given.kind}, {given.basis}, {count:,} points; microseconds per point, one thread\n")
    print("| law | points | stress update | ratio | Newton iteration | ratio |")
    print("| --- | --- | --- | --- | --- | --- |")
    for number, (row, region) in enumerate(rows):
        cells = []
        for part in (0, 1):
            seconds = statistics.median(times[number][part] for times in rounds)
            ratio = statistics.median(times[number][part] / times[0][part] for times in rounds)
            cells += [f"{1e6 * seconds / count:.3f}", f"{ratio:.2f}"]
        print(f"| {row.name} | {region} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
