# SPDX-License-Identifier: BSD-3-Clause
"""What a simulation warns of before and while it runs."""

from __future__ import annotations

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import block_entries, plane

from tilth import Model
from tilth.analysis.run_warnings import JUMP, NO_JUMP, RunWarnings
from tilth.analysis.simulation import Simulation


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
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -0.1]}]
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    assert simulation.warnings == [
        "boundary 'far' touches no node of a cell with material: the nearest one is 5 away; "
        "correct its position (boundaries[0]), or leave it out"
    ]


@pytest.mark.parametrize("name", ["cap", "floor"])
def test_no_name_of_a_boundary_silences_another_warning(name: str) -> None:
    far = plane(name, "y", 7.0)
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "gimp", boundaries=[far, *sides])
    entries["bodies"][0]["points_per_cell"] = 1
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -0.1]}]
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    simulation.run_warnings.bounds({"floor": 1, "cap": 1})
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


@pytest.mark.parametrize(
    ("times", "cells", "warned"),
    [(1.1 * JUMP, 2.0 * NO_JUMP, True), (0.9 * JUMP, 1.0, False), (1e3, 0.5 * NO_JUMP, False)],
)
def test_soil_that_moves_far_further_than_what_drives_it_is_named(
    times: float, cells: float, warned: bool
) -> None:
    simulation = pressed_block()
    moved = np.zeros_like(simulation.points.position)
    moved[3] = [0.0, cells * simulation.grid.cell_size[1]]
    run_warnings = RunWarnings()
    driven = float(moved.max()) / times
    run_warnings.jump(moved, driven, simulation.points, simulation.grid.cell_size, 0.5)
    assert any("material point 3" in text for text in run_warnings.texts) == warned


@pytest.mark.parametrize(("load", "warned"), [(False, True), (True, False)])
def test_jumps_are_looked_for_where_boundaries_alone_drive_the_soil(
    load: bool, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tilth.analysis.run_warnings.JUMP", 0.5)
    simulation = pressed_block(load)
    simulation.advance(0.0, 1.0)
    assert any("as far as any boundary" in text for text in simulation.warnings) == warned


def pressed_block(load: bool = False) -> Simulation:
    """A block whose top moves down by a twentieth of it, with a body force or without."""
    top = implicit("top", flat([0.0, 2.0], [0.0, -1.0]), "roller", displacement={"y": -0.1})
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "gimp", boundaries=[top, *sides])
    if load:
        entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -0.1]}]
    return Simulation(Model.from_dict(entries))
