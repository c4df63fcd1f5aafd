# SPDX-License-Identifier: BSD-3-Clause
"""What stays as it was when a stage changes materials, the grid, loads or boundaries."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from staged_ground import (
    WHOLE,
    at_rest,
    at_start_of,
    box,
    by_number,
    elastic,
    entries,
    gravity,
    march,
    plane,
    stage,
    wall,
)

from tilth import BadInput, Model
from tilth.analysis.march import march as march_unstaged
from tilth.arrays import Floats

every_basis = pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1", "cpdi2"])
f_bar_or_not = pytest.mark.parametrize("anti_locking", ["none", "f_bar"])


def squeezed(**body: Any) -> dict[str, Any]:
    """A block 2 m wide, squeezed by a tenth between smooth plates and held there: J is not 1."""
    block = box("block", [0.0, 0.0], [2.0, 1.0], **body)
    push = {"condition": "prescribed", "displacement": {"y": -0.1}}
    return entries(
        bodies=[block],
        boundaries=[
            plane("base", "y", 0.0), plane("left", "x", 0.0), plane("top", "y", 1.0, **push),
        ],
        loads=[],
        materials={"soil": elastic(), "stiff": elastic(5e4, 0.1), "soft": elastic(1e3, 0.4)},
        stages=[stage("squeeze", 2), stage("exchange", 2, materials={"soil": "stiff"})],
    )  # fmt: skip


@every_basis
@f_bar_or_not
@pytest.mark.parametrize("new", ["stiff", "soft"])
def test_another_stiffness_alone_releases_nothing(basis: str, anti_locking: str, new: str) -> None:
    """At a volume far from the initial one too: stress and forces are as without the exchange."""
    case = squeezed(basis=basis, anti_locking=anti_locking)
    starts = []
    for materials in ({}, {"soil": new}):
        case["stages"][1]["materials"] = materials
        analysis, _ = at_start_of(case, "exchange")
        starts.append(analysis.simulation)
    plain, exchanged = starts
    volume = plain.state.points.volume / plain.state.points.initial_volume
    assert volume.min() < 0.95
    size = np.abs(by_number(plain, "stress")).max()
    assert np.abs(by_number(exchanged, "stress") - by_number(plain, "stress")).max() < 1e-12 * size
    forces = []
    for simulation in starts:
        force = simulation.state.released.force
        forces.append(force[np.abs(force).max(axis=1) > 1e-9 * size])
    assert np.abs(forces[1] - forces[0]).max(initial=0.0) < 1e-9 * size
    moduli = exchanged.state.points.elastic_moduli().young
    assert moduli.min() > 4e4 if new == "stiff" else moduli.max() < 2e3


@every_basis
@f_bar_or_not
def test_another_stiffness_moves_nothing_and_then_acts(basis: str, anti_locking: str) -> None:
    """Soil at rest stays where it is; a later pressure meets the new stiffness."""
    body = {"basis": basis, "anti_locking": anti_locking}
    push = {
        "type": "surface", "name": "push", "body": "column", "start": [1.0, 2.0], "end": [0.0, 2.0],
        "pressure": 1.0,
    }  # fmt: skip
    stages = [
        stage("rest"), stage("exchange", 2, materials={"soil": "stiff"}),
        stage("push", activate=["push"]),
    ]  # fmt: skip
    case = column([gravity(), push], stages, **body)
    case["materials"] = {"soil": elastic(1e5), "stiff": elastic(4e5, 0.1)}
    case["initial"] = {"stress": [at_rest("column", 2.0)]}
    analysis, starts, _ = march(case)
    moved = by_number(starts["exchange"], "displacement")
    assert np.abs(moved).max() < 1e-13
    modulus = 4e5 * 0.9 / (1.1 * 0.8)
    height = by_number(starts["rest"], "position")[:, 1]
    settled = -by_number(analysis.simulation, "displacement")[:, 1]
    assert settled == pytest.approx(height / modulus, rel=1e-3)


LOAD = 0.5
"""Pressure on the column [kPa], small for a strain that needs no correction."""
PORE_FLUID = 1e6
"""Bulk modulus of the pore fluid [kPa], a hundred times that of the soil and more."""


def consolidating(second: dict[str, Any], **body: Any) -> dict[str, Any]:
    """A column that is loaded without drainage and then has another material."""
    column = box("column", [0.0, 0.0], [0.5, 4.0], surface={}, **body)
    strong = {"model": "mohr_coulomb", "cohesion": 1e4, "friction_angle": 30.0} | {
        "dilation_angle": 0.0, "young_modulus": 1e3, "poisson_ratio": 0.2, "density": 2.0,
    }  # fmt: skip
    push = {
        "type": "surface", "name": "push", "body": "column", "start": [0.5, 4.0], "end": [0.0, 4.0],
        "pressure": LOAD,
    }  # fmt: skip
    return entries(
        bodies=[column],
        boundaries=[plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 0.5)],
        loads=[push],
        materials={
            "soil": {**strong, "pore_fluid_bulk_modulus": PORE_FLUID},
            "second": {**strong, **second},
        },
        stages=[stage("load", 4), stage("later", 8, materials={"soil": "second"})],
    )


@pytest.mark.slow
@every_basis
@f_bar_or_not
def test_drained_soil_takes_over_the_effective_stress(basis: str, anti_locking: str) -> None:
    """The excess pore pressure is released: the column consolidates as if loaded with drainage."""
    case = consolidating({}, basis=basis, anti_locking=anti_locking)
    analysis, starts, _ = march(case)
    loaded, drained = starts["load"], analysis.simulation
    pressure = loaded.state.points.state_variable("excess_pore_pressure")
    modulus = 1e3 * 0.8 / (1.2 * 0.6)
    share = PORE_FLUID / (PORE_FLUID + modulus)
    assert pressure == pytest.approx(LOAD * share, rel=2e-3)
    released = starts["later"].state.released.force.sum(axis=0)
    assert released == pytest.approx([0.0, 0.5 * LOAD * share], abs=1e-3 * LOAD)
    stretch = 1.0
    for _ in range(50):  # M ln(s) / s = -q in closed form
        stretch = float(np.exp(-LOAD * stretch / modulus))
    strain = drained.state.points.deformation_gradient[:, 1, 1] - 1.0
    assert strain == pytest.approx(stretch - 1.0, rel=5e-3)
    assert drained.state.points.stress[:, 1] == pytest.approx(-LOAD, rel=5e-3)


@f_bar_or_not
def test_an_excess_pore_pressure_stays_in_another_undrained_soil(anti_locking: str) -> None:
    second = {"pore_fluid_bulk_modulus": PORE_FLUID, "young_modulus": 2e3, "cohesion": 2e4}
    analysis, starts, _ = march(consolidating(second, anti_locking=anti_locking))
    pressures, stresses = (
        [getter(simulation) for simulation in (starts["load"], analysis.simulation)]
        for getter in (_pore_pressure, lambda simulation: by_number(simulation, "stress"))
    )
    assert pressures[1] == pytest.approx(pressures[0], rel=1e-8)
    assert stresses[1] == pytest.approx(stresses[0], abs=1e-8 * LOAD)
    assert np.abs(starts["later"].state.released.force).max(initial=0.0) < 1e-8 * LOAD


def _pore_pressure(simulation: Any) -> Floats:
    points = simulation.state.points
    return points.state_variable("excess_pore_pressure")[points.in_order]


GIVEN = [-60.0, -100.0, -70.0, 0.0]
"""Stress of a block in equilibrium with loads on its edges [kPa]."""


def stressed(basis: str, grid: dict[str, Any], young: float = 1e4) -> dict[str, Any]:
    """A block of 2 x 1 m with uniform stress: rollers on two sides, pressure on the others."""
    block = box("block", [0.0, 0.0], [2.0, 1.0], basis=basis, surface={}, points_per_cell=4)
    corners = [([2.0, 0.0], [2.0, 1.0], 60.0), ([2.0, 1.0], [0.0, 1.0], 100.0)]
    pressure = [
        {"type": "surface", "name": f"p{i}", "body": "block", "start": start, "end": end}
        | {"pressure": size, "factor": WHOLE}
        for i, (start, end, size) in enumerate(corners)
    ]
    return entries(
        bodies=[block],
        materials={"soil": elastic(young)},
        boundaries=[wall("base", [0.0, 0.0], [0.0, 1.0]), wall("left", [0.0, 0.0], [1.0, 0.0])],
        loads=pressure,
        initial={
            "stress": [{"type": "given", "body": "block", "stress": GIVEN}],
            "equilibrium": False,
        },
        stages=[stage("rest"), stage("other grid", grid=grid)],
    )


GRIDS = {
    "finer": {"cell_size": 0.25},
    "shifted": {"cell_size": 0.5, "origin": [0.17, 0.21]},
    "finer and shifted": {"cell_size": [0.25, 0.2], "origin": [0.1, 0.07]},
}


@pytest.mark.slow
@pytest.mark.parametrize("grid", GRIDS)
@every_basis
def test_another_grid_keeps_the_stress(basis: str, grid: str) -> None:
    """The change of the stress is that of an analysis that begins with it on this grid.

    A uniform stress is in equilibrium where the block rests on grid lines, and with GIMP, whose
    domains fill the block exactly, to 2 % elsewhere. The motion is of the order of this strain.
    """
    staged = stressed(basis, GRIDS[grid])
    at_once = stressed(basis, GRIDS[grid])
    at_once["grid"] = GRIDS[grid]
    at_once["bodies"][0] |= {"points": [16, 8]}
    at_once["bodies"][0].pop("points_per_cell")
    at_once["stages"] = at_once["stages"][:1]
    change, moved = [], []
    for case in (staged, at_once):
        analysis, _, _ = march(case)
        simulation = analysis.simulation
        change.append(np.abs(by_number(simulation, "stress")[:, :4] - GIVEN).max() / 100.0)
        moved.append(np.abs(by_number(simulation, "displacement")).max())
    assert simulation.state.grid.cell_size[0] == np.ravel(GRIDS[grid]["cell_size"])[0]
    assert change[0] < 1.1 * change[1] + 1e-4
    assert moved[0] < 1.1 * moved[1] + 5e-4 * 100.0 / 1e4  # the slip of walls
    if basis == "gimp" or grid == "finer":
        assert change[0] < (2e-2 if grid != "finer" else 1e-4)


@pytest.mark.parametrize(("cell_size", "warned"), [(0.5, False), (0.25, False), (0.125, True)])
def test_a_grid_with_too_few_points_is_warned_of(cell_size: float, warned: bool) -> None:
    """The points are 0.125 m apart."""
    analysis, _ = at_start_of(stressed("gimp", {"cell_size": cell_size}), "other grid")
    found = [text for text in analysis.simulation.services.warnings.texts if "'block' are" in text]
    assert len(found) == warned
    if warned:
        assert "stages[1].grid.cell_size: the points of 'block' are 0.125 x 0.125 apart" in found[0]


def test_displacement_and_plastic_strain_begin_again() -> None:
    """Only what is reset does, and nothing else changes."""
    case = squeezed()
    weak = {"model": "tresca", "undrained_shear_strength": 5.0} | elastic()
    weak["model"] = "tresca"
    case["materials"]["soil"] = weak
    results = {}
    for reset in ((), ("displacement",), ("plastic_strain",), ("displacement", "plastic_strain")):
        case["stages"] = [stage("squeeze", 4), stage("hold", reset=list(reset))]
        analysis, _, _ = march(case)
        results[reset] = simulation = analysis.simulation
        moved = np.abs(by_number(simulation, "displacement")).max()
        plastic = by_number(simulation, "plastic")[:, 0]
        assert (moved < 1e-3) == ("displacement" in reset)
        assert (plastic.max() < 1e-3) == ("plastic_strain" in reset)
        for name in ("position", "stress"):
            same = by_number(results[()], name)
            assert by_number(simulation, name) == pytest.approx(same, rel=1e-9, abs=1e-9)


def column(
    loads: list[dict[str, Any]], stages: list[dict[str, Any]], **body: Any
) -> dict[str, Any]:
    return entries(
        bodies=[box("column", [0.0, 0.0], [1.0, 2.0], surface={}, **body)],
        boundaries=[plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 1.0)],
        materials={"soil": elastic(1e6)},
        loads=loads,
        stages=stages,
    )


def test_loads_go_on_and_go_down() -> None:
    """The base carries, step by step, what the tables of all stages say."""
    push = {
        "type": "surface", "name": "push", "body": "column", "start": [1.0, 2.0], "end": [0.0, 2.0],
        "pressure": 7.0,
    }  # fmt: skip
    pull = {
        "type": "point_force", "name": "pull", "body": "column", "at": [0.5, 2.0],
        "force": [0.0, 3.0],
    }  # fmt: skip
    stages = [
        stage("weight"),
        stage("push", 2, activate=["push"]),
        stage("both", 2, activate=["pull"], factors={"push": [[0.0, 1.0], [1.0, 3.0]]}),
        stage("hold", 1),
        stage("off", 2, deactivate=["push"]),
        stage("slowly", 2, deactivate=["pull"], factors={"pull": [[0.0, 1.0], [0.5, 0.8]]}),
        stage("none"),
    ]
    _, _, results = march(column([gravity(), push, pull], stages))
    pushes = [0.0, 0.5, 1.0, 2.0, 3.0, 3.0, 1.5, 0.0, 0.0, 0.0, 0.0]
    pulls = [0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.8, 0.8, 0.0]
    expected = 40.0 + 7.0 * np.array(pushes) - 3.0 * np.array(pulls)
    carried = [result.resultant("base")[1] for result in results]
    assert carried == pytest.approx(expected, rel=5e-6)


@pytest.mark.parametrize("implicit", [False, True])
def test_a_moving_boundary_goes_on_where_it_was(implicit: bool) -> None:
    """In stages with pauses it does what it does in one schedule: no jump, the same reaction."""
    push = {"condition": "prescribed", "displacement": {"y": -2e-5}}
    top = plane("top", "y", 2.0, **push)
    if implicit:
        push = {"displacement": {"y": -2e-5}}
        top = wall("top", [0.0, 2.0], [0.0, -1.0], **push)
    stages = [
        stage("one", 2),
        stage("pause", 2),
        stage("two", 2, factors={"top": [[0.0, 1.0], [1.0, 2.0]]}),
    ]
    case = column([], stages)
    case["bodies"][0].pop("surface")
    case["boundaries"].append(top)
    _, _, results = march(case)
    force = np.array([result.resultant("top")[1] for result in results])
    steps = np.array([np.abs(result.equilibrium.displacement).max() for result in results])
    whole = {**case, "schedule": {"steps": 6, "end": 3.0}}
    whole.pop("stages")
    whole["boundaries"] = [*case["boundaries"][:-1], dict(top)]
    whole["boundaries"][-1]["factor"] = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 2.0]]
    expected: list[float] = []
    march_unstaged(
        Model.from_dict(whole),
        lambda _, result, time: expected.append(result.resultant("top")[1]),
    )
    assert force == pytest.approx(expected, rel=1e-5)
    assert steps[2:4] == pytest.approx(0.0, abs=1e-9)
    assert steps[4:] == pytest.approx(1e-5, rel=0.1)


def test_soil_at_rest_does_not_notice_a_stage() -> None:
    """A stage that changes nothing moves nothing, and has no forces to release."""
    case = column([gravity()], [stage("rest"), stage("nothing"), stage("nothing again", 3)])
    case["initial"] = {"stress": [at_rest("column", 2.0)]}
    analysis, starts, _ = march(case)
    for name in ("nothing", "nothing again"):
        assert np.abs(starts[name].state.released.force).max(initial=0.0) < 1e-10 * 40.0
    assert np.abs(by_number(analysis.simulation, "displacement")).max() < 1e-14


def test_a_load_goes_with_its_body() -> None:
    """Both are removed in one stage: nothing is left of the load, whose force is released too."""
    push = {
        "type": "surface", "name": "push", "body": "top", "start": [1.0, 3.0], "end": [0.0, 3.0],
        "pressure": 7.0,
    }  # fmt: skip
    stages = [stage("push", 2), stage("dig", 2, deactivate=["top", "push"])]
    case = column([gravity(), push], stages)
    case["bodies"].append(box("top", [0.0, 2.0], [1.0, 3.0], surface={}))
    _, starts, results = march(case)
    released = starts["dig"].state.released.force.sum(axis=0)
    assert released == pytest.approx([0.0, -27.0], abs=1e-3)
    carried = [result.resultant("base")[1] for result in results]
    assert carried[1:] == pytest.approx([67.0, 53.5, 40.0], rel=1e-5)


def test_a_grid_cannot_follow_a_boundary_that_is_removed() -> None:
    stages = [stage("push"), stage("free", deactivate=["top"])]
    case = column([], stages)
    case["boundaries"] = [
        wall("base", [0.0, 0.0], [0.0, 1.0]), wall("left", [0.0, 0.0], [1.0, 0.0]),
        wall("top", [0.0, 2.0], [0.0, -1.0], displacement={"y": -0.1}),
    ]  # fmt: skip
    case["grid"]["follow"] = {"boundary": "top", "place": [0.0, 2.0], "axes": ["y"]}
    with pytest.raises(BadInput, match="follows the boundary 'top', which does not act"):
        Model.from_dict(case)
