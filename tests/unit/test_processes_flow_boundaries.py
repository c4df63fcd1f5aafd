# SPDX-License-Identifier: BSD-3-Clause
"""Water that flows through boundaries on several processes as on one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpi_runs import require_processes, run_python

pytestmark = pytest.mark.slow

SOURCE = """
sys.path.insert(0, {tests!r} + "/contract")
from test_flow_boundaries import drained_all_over
from consolidating import with_flow
from mpi_runs import all_positions
from tilth.analysis.simulation import Simulation
entries, flow = drained_all_over({kind!r})
axis = "z" if {kind!r} == "3d" else "y"
inside = {{"name": "inside", "type": "plane", "axis": axis, "at": 2.0}}
flow.append({{**inside, "condition": "flux", "flux": 0.3}})
entries["analysis"]["solver"] = {solver!r}
simulation = Simulation(with_flow(entries, flow))
simulation.locate(0.0)
simulation.distribute(comm)
found = []
for step in range(4):
    told = simulation.advance(0.1 * step, 0.1 * (step + 1))
    found.append([told.discharge(each["name"]) for each in flow])
found.append(simulation.state.pore_pressure.drained.tolist())
result = [all_positions(simulation).tolist(), found]
"""


@pytest.mark.parametrize(
    ("kind", "processes"), [("plane_strain", 2), ("axisymmetric", 2), ("3d", 3)]
)
def test_processes_find_what_one_does(
    kind: str, processes: int, request: pytest.FixtureRequest
) -> None:
    """A pressure and a flux on planes of the grid, a flux on a geometry, a drained surface."""
    require_processes()
    tests = str(request.config.rootpath / "tests")
    found: list[Any] = [
        run_python(SOURCE.format(tests=tests, kind=kind, solver=solver), count)
        for solver, count in (("superlu", 1), ("mumps", processes))
    ]
    for one, other in zip(*found, strict=True):
        scale = np.abs(one).max()
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-8 * scale)
