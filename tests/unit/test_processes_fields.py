# SPDX-License-Identifier: BSD-3-Clause
"""A second field on several processes as on one."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from mpi_runs import require_processes, run_python

pytestmark = pytest.mark.slow

SOURCE = """
sys.path.insert(0, {tests!r} + "/contract")
from test_second_field import *
from tilth.analysis.gathering import collected
scalar = block_scalar(nonlinear=0.02, source=1e-3)
entries = block({kind!r}, {solver!r}, loads=[
    {{"type": "body_force", "acceleration": [0.5] * (dimension({kind!r}) - 1) + [-2.0]}}])
simulation = with_scalar(Model.from_dict(entries), scalar)
simulation.locate(0.0)
simulation.distribute(comm)
advanced(simulation, 0, 4)
whole = collected(simulation).state
number = np.argsort(whole.points.point_id)
arrays = whole.arrays()
key = np.argsort(arrays["field p.key"])
result = [whole.points.displacement[number].tolist(),
          arrays["field p.value"][key].tolist(), simulation.services.solver.summary]
"""


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize("solver", ["mumps", "multigrid"])
@pytest.mark.parametrize("processes", [2, 3])
def test_processes_find_what_one_does(
    kind: str, solver: str, processes: int, request: pytest.FixtureRequest
) -> None:
    require_processes()
    tests = str(request.config.rootpath / "tests")
    found: list[Any] = [
        run_python(SOURCE.format(tests=tests, kind=kind, solver=name), count)
        for name, count in (("superlu", 1), (solver, processes))
    ]
    for one, other in zip(*(each[:2] for each in found), strict=True):
        scale = np.abs(one).max()
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-6 * scale)
    assert solver in found[1][2], json.dumps(found[1][2])
