# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water on several processes as on one, through the stages of an analysis."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from mpi_runs import require_processes, run_python

pytestmark = pytest.mark.slow

SOURCE = """
sys.path.insert(0, {tests!r} + "/unit")
from test_flow_stages import *
from tilth.analysis.gathering import collected
entries = entries_of({kind!r})
entries["analysis"]["solver"] = {solver!r}
entries["flow"] |= {{"scheme": {scheme!r}, "largest_error": 1e3}}
analysis = StagedAnalysis(Model.from_dict(entries))
analysis.begin()
analysis.simulation.locate(0.0)
analysis.distribute(comm)
for _ in analysis.steps():
    pass
points = collected(analysis.simulation).state.points
number = np.argsort(points.point_id)
result = [points.displacement[number].tolist(), points.water[number].tolist()]
"""


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
@pytest.mark.parametrize(
    ("solver", "processes", "scheme"), [("mumps", 2, "backward_euler"), ("multigrid", 3, "bdf2")]
)
def test_processes_find_what_one_does(
    kind: str, solver: str, processes: int, scheme: str, request: pytest.FixtureRequest
) -> None:
    require_processes()
    tests = str(request.config.rootpath / "tests")
    one, other = (
        run_python(SOURCE.format(tests=tests, kind=kind, solver=name, scheme=scheme), count)
        for name, count in (("superlu", 1), (solver, processes))
    )
    for alone, shared in zip(one, other, strict=True):
        expected: Any = np.array(alone)
        scale = np.abs(expected).max(axis=0)
        assert (np.abs(np.array(shared) - expected) <= 1e-6 * scale + 1e-12).all()
