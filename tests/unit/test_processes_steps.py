# SPDX-License-Identifier: BSD-3-Clause
"""`tilth.steps` on several processes: a changed load, and a loop that one of them leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mpi_runs import require_processes, run_python
from small_problems import block_entries, material_entries, rollers, weight

import tilth
from tilth.output.lock import holder_of

pytestmark = pytest.mark.slow

SOURCE = """
import tilth
model = tilth.Model.from_dict(json.loads({entries!r}))
for step in tilth.steps(model, {folder!r}):
    force = step.force("low y").tolist()
    if step.number == 2:
        step.change_load("weight", [(1.0, 0.5)])
    if step.number == 4 and comm.rank == comm.size - 1:
        break
number = step.point_id.tolist()
assert step.field("cauchy_stress").shape == (len(number), 6)
result = [step.number, force, sorted(sum(comm.gathered(number), []))]
if comm.rank == 0:
    assert (step.history.rows, step.row["height"]) == (5, step.history["height"][-1])
resumed = tilth.resume({folder!r}, quiet=True)
assert resumed.finished
"""


@pytest.mark.parametrize("processes", [2, 3])
def test_processes_change_a_load_and_stop_together(processes: int, tmp_path: Path) -> None:
    require_processes()
    entries: dict[str, Any] = block_entries(
        "plane_strain", "gimp", boundaries=rollers("plane_strain", 6.0)
    )
    entries["bodies"][0]["shape"]["upper"] = [6.0, 4.0]
    entries["materials"]["soil"] = material_entries("von_mises")
    entries["loads"] = [weight("plane_strain", 4.0) | {"name": "weight"}]
    entries["analysis"]["solver"] = "auto"
    entries["schedule"], entries["output"] = {"steps": 6}, {"report": False}
    entries["track"] = [{"name": "height", "quantity": "top_height", "of": "domains"}]
    found = {}
    for count in (1, processes):
        folder = tmp_path / str(count)
        source = SOURCE.format(entries=json.dumps(entries), folder=str(folder))
        found[count] = run_python(source, count)
        assert holder_of(folder) is None
    (step, force, numbers), (step_again, force_again, numbers_again) = found.values()
    assert step == step_again == 4
    assert numbers == numbers_again == list(range(len(numbers)))
    np.testing.assert_allclose(force_again, force, rtol=1e-8)
    one, other = (tilth.open(tmp_path / str(count)) for count in (1, processes))
    np.testing.assert_allclose(other.history["height"], one.history["height"], rtol=1e-8)
    np.testing.assert_allclose(other.points(), one.points(), rtol=1e-7)
