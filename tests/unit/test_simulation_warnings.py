# SPDX-License-Identifier: BSD-3-Clause
"""What a simulation warns of before and while it runs."""

from __future__ import annotations

import pytest
from implicit_blocks import flat, implicit
from small_problems import block_entries, plane

from tilth import Model
from tilth.simulation import Simulation


@pytest.mark.parametrize(("motion", "warned"), [(-0.4, False), (-0.6, True), (0.6, True)])
def test_planes_that_lose_their_material_are_named(motion: float, warned: bool) -> None:
    top = plane("top", "y", 2.0, condition="prescribed", displacement={"y": motion})
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "linear", boundaries=[top, *sides])
    warnings = Simulation(Model.from_dict(entries)).warnings
    assert any("'top' moves by up to 0.6" in text for text in warnings) == warned


def test_a_boundary_away_from_all_material_is_named() -> None:
    far = plane("far", "y", 7.0)
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "linear", boundaries=[far, *sides])
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    assert simulation.warnings == ["boundary 'far' touches no node of a cell with material"]


@pytest.mark.parametrize("name", ["cap", "floor"])
def test_no_name_of_a_boundary_silences_another_warning(name: str) -> None:
    far = plane(name, "y", 7.0)
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "gimp", boundaries=[far, *sides])
    entries["bodies"][0]["points_per_cell"] = 1
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    simulation._note_bounds({"floor": 1, "cap": 1})
    assert len(simulation.warnings) == 3


@pytest.mark.parametrize(
    ("form", "normal", "moves", "warned"),
    [
        ("band", [0.0, 1.0], False, False),
        ("band", [0.0, 1.0], True, True),
        ("band", [0.6, 0.8], False, True),
        ("surface", [0.6, 0.8], True, False),
    ],
)
def test_a_band_that_locks_the_soil_beside_it_is_named(
    form: str, normal: list[float], moves: bool, warned: bool
) -> None:
    motion = {"displacement": {"y": 0.1}} if moves else {}
    base = implicit("base", flat([0.0, 0.0], normal), "fixed", form=form, **motion)
    entries = block_entries("plane_strain", "gimp", boundaries=[base])
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    assert any("'base' with form = \"band\"" in text for text in simulation.warnings) == warned
