# SPDX-License-Identifier: BSD-3-Clause
"""Runs on several processes that `mpiexec` starts, to compare with the serial run.

The environment variable TILTH_MPI_PYTHON names a Python that has mpi4py, petsc4py and pytest, if
the one that runs the tests has not. Tests are then never skipped.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi_pool import pool_of

from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.arrays import Floats
from tilth.comm import Communicator, total

ROOT = Path(__file__).parents[1]
PYTHON = os.environ.get("TILTH_MPI_PYTHON") or sys.executable
LIMIT = 300.0
"""Seconds after which a run counts as blocked."""

SOURCES = [str(ROOT / "src")] if list((ROOT / "src" / "tilth").glob("_core*.so")) else []
"""The sources if they have a compiled core; without it the runs take what is installed."""

ENVIRONMENT = {
    "OMP_NUM_THREADS": "1",
    "OMP_WAIT_POLICY": "passive",
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "PYTHONPATH": os.pathsep.join([*SOURCES, str(ROOT / "tests")]),
}
"""Variables of all runs: more processes than cores are good, also of the superuser."""

BEGIN = "import json, sys\nfrom tilth.mpi import world\ncomm = world()\nresult = None\n"
END = "\nif comm.rank == 0:\n    json.dump(result, open(sys.argv[1], 'w'))\n"


@cache
def missing() -> str:
    """What a run on several processes lacks here; an empty text if it lacks nothing."""
    if shutil.which("mpiexec") is None:
        return "needs mpiexec"
    for module in ("mpi4py.MPI", "petsc4py.PETSc", "tilth._core", "pytest"):
        found = subprocess.run(
            [PYTHON, "-c", f"import {module}"], env={**os.environ, **ENVIRONMENT},
            capture_output=True, check=False,
        )  # fmt: skip
        if found.returncode:
            return f"{module} cannot be imported in {PYTHON} (see TILTH_MPI_PYTHON)"
    return ""


def require_processes() -> None:
    """Skips a test where several processes cannot run; fails if TILTH_MPI_PYTHON says they can."""
    if reason := missing():
        (pytest.fail if "TILTH_MPI_PYTHON" in os.environ else pytest.skip)(reason)


def run_python(source: str, processes: int) -> Any:
    """Runs Python text on some processes; returns what it left in `result` in process 0.

    In it, `comm` is the communicator of all processes. `result` must be of the types of JSON. With
    one process it runs without `mpiexec`. A test is skipped where several processes cannot run.
    """
    require_processes()
    return json.loads(pool_of(processes, PYTHON, ENVIRONMENT).run(BEGIN + source + END, LIMIT))


def run_model(model: Model, processes: int, steps: int = 1000) -> dict[str, Any]:
    """Computes the first steps of a model on some processes.

    Returns, as arrays: the forces of the boundaries by name, one step after the other (rows, dim),
    the positions of the points in the order of their numbers, the number of iterations of each
    step, the positions of the tracked surfaces by name, all energies after each step (rows, kinds;
    see `Energies`), and what was done to find the equilibrium
    of the starting state (iterations, residual before, change, largest stress, place).
    """
    return _run_model(json.dumps(model.to_dict()), processes, steps)


@cache
def _run_model(entries: str, processes: int, steps: int) -> dict[str, Any]:
    source = (
        "from mpi_runs import computed\nfrom tilth import Model\n"
        f"model = Model.from_dict(json.loads({json.dumps(entries)}))\n"
        f"result = computed(model, comm, {steps})\n"
    )
    found: dict[str, Any] = run_python(source, processes)
    return {
        "forces": {name: np.array(force) for name, force in found["forces"].items()},
        "position": np.array(found["position"]),
        "iterations": found["iterations"],
        "surfaces": {name: np.array(each) for name, each in found["surfaces"].items()},
        "energies": np.array(found["energies"]),
        "start": np.array(found["start"]),
    }


def computed(model: Model, comm: Communicator, steps: int) -> dict[str, Any]:
    """What `run_model` returns, as lists, in each process of a run."""
    analysis = StagedAnalysis(model)
    analysis.check()
    analysis.distribute(comm)
    start: list[float] = []
    if (told := analysis.begin()) is not None:
        start = [told.iterations, told.residual_before, told.change, told.largest, *told.place]
    forces: dict[str, list[list[float]]] = {}
    iterations, energies = [], []
    sums = Energies.at_start(analysis.setup, analysis.state)
    for _, result in analysis.steps():
        for name, force in result.forces.items():
            whole = total(comm, force[result.active.owned].sum(axis=0))
            forces.setdefault(name, []).append(whole.tolist())
        iterations.append(result.equilibrium.iterations)
        sums.add(result)
        energies.append(list(sums.values(analysis.setup, analysis.state, result.time).values()))
        if len(iterations) == steps:
            break
    simulation = analysis.simulation
    return {
        "forces": forces,
        "position": all_positions(simulation).tolist(),
        "iterations": iterations,
        "energies": energies,
        "surfaces": {
            each.name: each.position.tolist() for each in simulation.state.surface_shapes()
        },
        "start": start,
    }


def all_positions(simulation: Simulation) -> Floats:
    """The positions of the points of all processes, in the order of their numbers."""
    own = simulation.state.distribution.owned(simulation.state.points)
    parts = simulation.state.comm.gathered((own.point_id, own.position))
    number = np.concatenate([each for each, _ in parts])
    return np.asarray(np.concatenate([each for _, each in parts])[np.argsort(number)])


def assert_as_serial(model: Model, processes: int, steps: int = 1000, share: float = 1e-8) -> None:
    """Asserts that some processes find the serial run's forces, energies and motion of the points.

    Surfaces may differ by a hundred times as much in each stage: where they are beyond the points,
    the grid's nodes are hardly covered.

    share: largest difference of a force and of an energy relative to the largest one, and of a
        place relative to the size of all.
    """
    serial, found = run_model(model, 1, steps), run_model(model, processes, steps)
    assert len(found["iterations"]) == len(serial["iterations"])
    np.testing.assert_allclose(found["start"], serial["start"], rtol=share)
    largest = max((np.abs(force).max() for force in serial["forces"].values()), default=0.0)
    for name, force in serial["forces"].items():
        np.testing.assert_allclose(found["forces"][name], force, rtol=0, atol=share * largest)
    size = np.ptp(serial["position"], axis=0).max()
    np.testing.assert_allclose(found["position"], serial["position"], rtol=0, atol=share * size)
    most = np.abs(serial["energies"]).max()
    np.testing.assert_allclose(found["energies"], serial["energies"], rtol=0, atol=share * most)
    for name, position in serial["surfaces"].items():
        atol = 100.0 * share * size * max(len(model.stages), 1)
        np.testing.assert_allclose(found["surfaces"][name], position, rtol=0, atol=atol)
