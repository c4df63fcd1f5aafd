# SPDX-License-Identifier: BSD-3-Clause
"""Several processes find the serial run's result: contact, rigid bodies, contact between bodies."""

from __future__ import annotations

import pytest
from body_contacts import two_blocks
from contact_terms import DRIVEN, FREE, pressed
from mpi_runs import assert_as_serial
from sand_footings import small_footing
from turned_blocks import turned_block

from tilth import Model

pytestmark = pytest.mark.slow
several = pytest.mark.parametrize("processes", [2, 3])


@several
@pytest.mark.parametrize(
    ("kind", "law", "way", "basis"),
    [
        ("plane_strain", "friction", FREE, "gimp"),
        ("plane_strain", "rough", DRIVEN, "cpdi2"),
        ("axisymmetric", "limited", DRIVEN, "gimp"),
        ("3d", "cut-off", FREE, "cpdi2"),
    ],
)
def test_a_rigid_body_on_a_block(kind: str, law: str, way: str, basis: str, processes: int) -> None:
    """On springs, with unknowns of its own, or driven; it touches the cells of all processes."""
    model = pressed(kind, law, way, basis=basis).setup.model
    assert_as_serial(model, processes, 2)


@several
def test_sand_that_creeps_beside_a_footing(processes: int) -> None:
    """In three of six steps, see `test_robustness_sand.py`."""
    assert_as_serial(small_footing(10), processes, 6)


@several
@pytest.mark.parametrize(("law", "basis"), [("friction", "gimp"), ("glued", "cpdi2")])
def test_contact_between_bodies(law: str, basis: str, processes: int) -> None:
    """Each body has nodes of its own, and a process may lack one of them."""
    assert_as_serial(Model.from_dict(two_blocks("plane_strain", law, basis)), processes, 2)


@several
@pytest.mark.parametrize("holder", ["held", "bonded"])
def test_a_block_that_turns_in_a_box(holder: str, processes: int) -> None:
    """The trace of its domains along the box is that of a serial run."""
    entries = turned_block("cpdi2", holder, 60.0, 4).to_dict()
    entries["materials"]["soil"]["density"] = 2.0
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -10.0]}]
    assert_as_serial(Model.from_dict(entries), processes)
