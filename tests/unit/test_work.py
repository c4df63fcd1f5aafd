# SPDX-License-Identifier: BSD-3-Clause
"""The work of boundaries in a run is what an elastic body stores; friction takes its part."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest
from contact_terms import DRIVEN, pressed
from implicit_blocks import flat, implicit
from small_problems import block_entries, plane

from tilth import Model
from tilth.analysis.simulation import Simulation

LID = plane("lid", "y", 2.0, condition="prescribed", displacement={"y": -0.2})
BASE = plane("base", "y", 0.0)
ON_NODES = [BASE, plane("left", "x", 0.0), LID]
BETWEEN = [
    BASE,
    plane("right", "x", 2.0, condition="prescribed", displacement={"x": 0.05}),
    LID,
    implicit("wall", flat([0.12, 0.0], [1.0, 0.0]), "roller", displacement={"x": 0.1}),
]
"""In cells of the size of the block the wall acts on nodes that the right side moves."""


def error(boundaries: list[dict[str, Any]], steps: int, cell: float) -> float:
    """Work of all boundaries over the elastic energy at the end, less 1."""
    entries = block_entries("plane_strain", "linear", boundaries=boundaries)
    lower = [0.12 if boundaries is BETWEEN else 0.0, 0.0]
    entries["grid"] = {"cell_size": cell}
    body = entries["bodies"][0]
    del body["points_per_cell"]
    body |= {"points": [4, 4], "shape": {"type": "box", "lower": lower, "upper": [2.0, 2.0]}}
    entries["schedule"] = {"steps": steps}
    simulation = Simulation(Model.from_dict(entries))
    times = [step / steps for step in range(steps + 1)]
    work = sum(simulation.advance(before, after).work for before, after in pairwise(times))
    return work / simulation.state.points.stored_energy() - 1.0


@pytest.mark.parametrize("cell", [1.0, 2.0])
def test_work_of_a_moved_plane_is_stored(cell: float) -> None:
    """Second order in the step: half the sum of the reactions at its start and at its end."""
    coarse, fine = (error(ON_NODES, steps, cell) for steps in (4, 8))
    assert abs(fine) < 1e-3
    assert coarse / fine == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize("cell", [1.0, 2.0])
def test_work_of_a_wall_on_nodes_that_others_hold_is_stored(cell: float) -> None:
    """What holds the other nodes of the wall's cells bears a part of its force, from its start."""
    assert abs(error(BETWEEN, 16, cell)) < 1e-3


@pytest.mark.parametrize("law", ["bonded", "glued", "smooth", "friction"])
def test_only_sliding_against_friction_dissipates(law: str) -> None:
    """What sticks gives its work back, and what is smooth takes none."""
    work = pressed("plane_strain", law, DRIVEN).advance(0.0, 0.25).friction_work
    assert work > 0.0 if law == "friction" else work == 0.0
