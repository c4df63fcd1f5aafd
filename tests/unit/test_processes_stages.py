# SPDX-License-Identifier: BSD-3-Clause
"""Several processes find the serial run's result: stages, and the factor of safety."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from mpi_runs import assert_as_serial, run_python
from staged_ground import box, elastic, entries, plane
from staged_problems import KINDS, staged_entries

from tilth import Model

pytestmark = pytest.mark.slow
several = pytest.mark.parametrize("processes", [2, 3])


@several
@pytest.mark.parametrize("kind", KINDS)
def test_soil_is_dug_placed_and_exchanged(kind: str, processes: int) -> None:
    """In five stages, with loads on surfaces, released forces, implicit walls and two grids."""
    assert_as_serial(Model.from_dict(staged_entries(kind)), processes)


REDUCTION = """
from tilth import Model
from tilth.analysis.safety import strength_reduction
from tilth.analysis.staged import StagedAnalysis
model = Model.from_dict(ENTRIES)
analysis = StagedAnalysis(model)
analysis.check()
analysis.distribute(comm)
for _ in analysis.steps():
    pass
found = strength_reduction(analysis.simulation, analysis.clock.time)
again = strength_reduction(analysis.simulation, analysis.clock.time)
assert [trial.factor for trial in again.trials] == [trial.factor for trial in found.trials]
result = {
    "factors": [found.factor, found.above],
    "trials": [[trial.factor, trial.in_equilibrium] for trial in found.trials],
    "lengths": [found.elastic_displacement, found.largest_displacement],
    "displacement": found.displacement.tolist(),
    "plastic_strain": found.plastic_strain.tolist(),
}
"""


def slope() -> dict[str, Any]:
    """A steep clay slope and its hard base, a body of its own, in cells of 0.5 m."""
    clay = {
        "model": "tresca", "young_modulus": 1e4, "poisson_ratio": 0.3, "density": 2.0,
        "undrained_shear_strength": 14.0,
    }  # fmt: skip
    shape = {"type": "polygon", "vertices": [[0.0, 1.0], [5.0, 1.0], [3.0, 3.0], [0.0, 3.0]]}
    return entries(
        materials={"clay": clay, "soil": elastic()},
        bodies=[
            box("base", [0.0, 0.0], [6.0, 1.0]),
            {**box("slope", [0.0, 0.0], [1.0, 1.0]), "shape": shape, "material": "clay"},
        ],
        boundaries=[
            plane("below", "y", 0.0, condition="fixed"), plane("left", "x", 0.0),
            plane("right", "x", 6.0),
        ],
        schedule={"steps": 1},
    )  # fmt: skip


@several
def test_the_factor_of_safety(processes: int) -> None:
    """Twice, from the same state; not every process has soil of both bodies."""
    source = REDUCTION.replace("ENTRIES", repr(slope()))
    serial, found = run_python(source, 1), run_python(source, processes)
    assert found["factors"] == serial["factors"]
    assert found["trials"] == serial["trials"]
    np.testing.assert_allclose(found["lengths"], serial["lengths"], rtol=1e-10)
    for name in ("displacement", "plastic_strain"):
        largest = np.abs(serial[name]).max()
        assert largest > 0.0
        np.testing.assert_allclose(found[name], serial[name], rtol=0, atol=1e-5 * largest)


FAILURE = """
from mpi_runs import computed
from tilth import AnalysisFailed, Model
try:
    computed(Model.from_dict(ENTRIES), comm, 100)
except AnalysisFailed as error:
    result = str(error)
"""


def test_a_failed_step_is_told_as_by_the_serial_run() -> None:
    """With the worst point, wherever it is, and the likely causes.

    But for the residuals of an iteration that does not converge, which round-off changes.
    """
    failing = slope()
    failing["materials"]["clay"]["undrained_shear_strength"] = 0.1
    failing["analysis"]["maximum_iterations"] = 2
    failing["schedule"] = {"steps": 2, "minimum_step": 0.05}
    failing["loads"][0]["factor"] = [[0.0, 0.0], [1.0, 1.0]]
    source = FAILURE.replace("ENTRIES", repr(failing))
    serial, found = (
        re.sub("relative residuals: .*?;", "", run_python(source, each)) for each in (1, 3)
    )
    assert "worst point" in serial
    assert found == serial


SAFETY = """
import os
from pathlib import Path
from tilth import Model
from tilth.analysis.safety_run import safety
folder = Path(comm.gathered(os.getcwd())[0]) / "out"
found = safety(Model.from_dict(ENTRIES), folder, quiet=True)
result = [found.factor, found.above, sorted(each.name for each in folder.glob("safety*"))]
"""


def test_the_files_of_a_factor_of_safety() -> None:
    """Of a run by several processes, whose checkpoint they share out again."""
    source = SAFETY.replace("ENTRIES", repr({**slope(), "output": {"report": False}}))
    found = run_python(source, 2)
    assert found == run_python(source, 1)
    assert found[2] == ["safety.csv", "safety.json", "safety.png", "safety.vtkhdf"]
