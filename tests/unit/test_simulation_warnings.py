# SPDX-License-Identifier: BSD-3-Clause
"""What a simulation warns of before and while it runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import block_entries, plane

from tilth import Model
from tilth.analysis.run_warnings import JUMP, NO_JUMP, RunWarnings
from tilth.analysis.simulation import Simulation


@pytest.mark.parametrize(
    ("boundary", "tracked", "words"),
    [
        ({"y": -0.4}, None, None),
        ({"y": -0.6}, None, "'top' moves by up to 0.6 along y, 0.6 of a cell"),
        ({"y": 0.6}, None, "nodes at y = 2 throughout: it loses the material"),
        ({"y": -0.1}, "reaction", None),
        ({"y": -0.11}, "reaction", "0.11 of a cell, but it acts on the nodes at y = 2"),
        ({"y": 0.2}, "moment", "tracked forces are wrong: by 3.5, 7 and 23 %"),
        ({"x": 0.3}, "reaction", None),  # along the plane
        ({"x": 0.3, "range": {"x": [0, 1]}}, "reaction", "0.3 along x"),  # out of its range
    ],
)
def test_planes_that_move_away_from_their_nodes_are_named(
    boundary: dict[str, Any], tracked: str | None, words: str | None
) -> None:
    """The whole motion counts, by the table; a force tracked anywhere is wrong before the rest."""
    ranges = {key: boundary[key] for key in ("range",) if key in boundary}
    motion = {axis: 0.5 * value for axis, value in boundary.items() if axis != "range"}
    top = plane("top", "y", 2.0, condition="prescribed", displacement=motion, **ranges)
    top["factor"] = [[0.0, 0.0], [1.0, 2.0]]
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "linear", boundaries=[top, *sides])
    entries["track"] = [{"name": "u", "quantity": "displacement", "at": [1, 1], "component": "y"}]
    if tracked is not None:
        about = {"about": [0, 0], "component": "z"} if tracked == "moment" else {"component": "y"}
        entries["track"] += [{"name": "R", "quantity": tracked, "boundary": "base", **about}]
    warnings = [
        text
        for text in Simulation(Model.from_dict(entries)).services.warnings.texts
        if "'top'" in text
    ]
    assert len(warnings) == (words is not None)
    assert all(words in text and 'type = "implicit"' in text for text in warnings if words)
    assert all(text.startswith("boundaries[0].displacement: ") for text in warnings)


def test_a_node_that_moves_away_from_its_place_is_named() -> None:
    node = {"name": "pin", "type": "node", "at": [1, 2], "condition": "prescribed"}
    node["displacement"] = {"x": 0.05, "y": -0.2}
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "linear", boundaries=[node, *sides])
    entries["track"] = [{"name": "R", "quantity": "reaction", "boundary": "pin", "component": "y"}]
    found = Simulation(Model.from_dict(entries)).services.warnings.texts
    assert any("0.2 along y, 0.2 of a cell, but it acts on the node at (1, 2)" in t for t in found)


def test_a_boundary_away_from_all_material_is_named() -> None:
    far = plane("far", "y", 7.0)
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "linear", boundaries=[far, *sides])
    entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -0.1]}]
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    assert simulation.services.warnings.texts == [
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
    simulation.services.warnings.bounds({"floor": 1, "cap": 1})
    assert len(simulation.services.warnings.texts) == 3


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
    assert (
        any("'base' with form = \"band\"" in text for text in simulation.services.warnings.texts)
        == warned
    )


@pytest.mark.parametrize(
    ("times", "cells", "warned"),
    [(1.1 * JUMP, 2.0 * NO_JUMP, True), (0.9 * JUMP, 1.0, False), (1e3, 0.5 * NO_JUMP, False)],
)
def test_soil_that_moves_far_further_than_what_drives_it_is_named(
    times: float, cells: float, warned: bool
) -> None:
    simulation = pressed_block()
    moved = np.zeros_like(simulation.state.points.position)
    moved[3] = [0.0, cells * simulation.state.grid.cell_size[1]]
    run_warnings = RunWarnings()
    driven = float(moved.max()) / times
    run_warnings.jump(
        moved, driven, simulation.state.points, simulation.state.grid.cell_size, 0.5, False
    )
    assert any("material point 3" in text for text in run_warnings.texts) == warned
    again = RunWarnings()
    again.jump(moved, driven, simulation.state.points, simulation.state.grid.cell_size, 0.5, True)
    assert len(again.texts) == warned
    assert not any("predictor" in text for text in again.texts)


@pytest.mark.parametrize(("load", "warned"), [(False, True), (True, False)])
def test_jumps_are_looked_for_where_boundaries_alone_drive_the_soil(
    load: bool, warned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tilth.analysis.run_warnings.JUMP", 0.5)
    simulation = pressed_block(load)
    simulation.advance(0.0, 1.0)
    assert (
        any("as far as any boundary" in text for text in simulation.services.warnings.texts)
        == warned
    )


def pressed_block(load: bool = False) -> Simulation:
    """A block whose top moves down by a twentieth of it, with a body force or without."""
    top = implicit("top", flat([0.0, 2.0], [0.0, -1.0]), "roller", displacement={"y": -0.1})
    sides = [plane("base", "y", 0.0), plane("left", "x", 0.0)]
    entries = block_entries("plane_strain", "gimp", boundaries=[top, *sides])
    if load:
        entries["loads"] = [{"type": "body_force", "acceleration": [0.0, -0.1]}]
    return Simulation(Model.from_dict(entries))
