# SPDX-License-Identifier: BSD-3-Clause
"""Fill: it is placed on the deformed ground without gap or overlap, and its weight arrives."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from staged_ground import (
    UNIT_WEIGHT,
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

from tilth import Model
from tilth.analysis.march import march_stages
from tilth.analysis.placement import settlement
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.arrays import Floats
from tilth.surface.tracked import TrackedSurface

CELL = 0.5
WIDTH, DEPTH = 8.0, 4.0
"""Of the ground [m]."""

every_basis = pytest.mark.parametrize("basis", ["linear", "gimp", "cpdi1", "cpdi2"])


def bank(
    lifts: int, *, young: float = 300.0, shift: float = 0.0, fill: int = 2, steps: int = 5,
    **body: Any,
) -> dict[str, Any]:  # fmt: skip
    """Soft ground that settles by half a metre under its weight, and lifts of 0.5 m on a part.

    shift: of the grid against the soil, in cells. fill: points per cell and direction of the lifts.
    """
    parts = [box("ground", [0.0, 0.0], [WIDTH, DEPTH], **body)]
    parts += [
        box(
            f"lift {i}", [0.0, DEPTH + CELL * i], [4.0 - CELL * i, DEPTH + CELL * (i + 1)],
            material="fill", points_per_cell=fill, surface={}, **body,
        )
        for i in range(lifts)
    ]  # fmt: skip
    base = plane("base", "y", 0.0)
    if shift:
        base = wall("base", [0.0, 0.0], [0.0, 1.0])
        for part in parts:
            number = part.pop("points_per_cell")
            part["spacing"] = CELL / number
    return entries(
        analysis={"kind": "plane_strain", "tolerance": 1e-11},
        grid={"cell_size": CELL, "origin": [0.0, -CELL * shift]},
        materials={"soil": elastic(young), "fill": elastic(3000.0)},
        bodies=parts,
        boundaries=[base, plane("left", "x", 0.0), plane("right", "x", WIDTH)],
        loads=[gravity(factor=[[0.0, 0.0], [1.0, 1.0]])],
        stages=[stage("ground", 5)]
        + [stage(f"lift {i}", steps, activate=[f"lift {i}"]) for i in range(lifts)],
    )


@pytest.mark.slow
@every_basis
@pytest.mark.parametrize("shift", [0.0, 1.0 / 3.0])
def test_weight_of_each_lift_arrives_at_the_base(basis: str, shift: float) -> None:
    """Step by step in equal parts, although the fill settles, and exactly at each stage's end."""
    case = bank(3, shift=shift, basis=basis)
    analysis, _, results = march(case)
    carried = np.array([result.resultant("base")[1] for result in results])[4:]
    ends = carried[::5]
    weight = UNIT_WEIGHT * CELL * np.array([4.0, 3.5, 3.0])
    assert ends[0] == pytest.approx(UNIT_WEIGHT * WIDTH * DEPTH, rel=1e-8)
    assert np.diff(ends) == pytest.approx(weight, rel=1e-7)
    for number in range(3):
        steps = np.diff(carried[5 * number + 1 : 5 * number + 6])
        assert steps == pytest.approx(steps.mean(), rel=1e-6)
    settled = by_number(analysis.simulation, "displacement")[:, 1].min()
    assert settled < -0.5


def gaps(simulation: Simulation, name: str) -> Floats:
    """Height of the lower faces of a body's lowest points above the tracked surfaces below them."""
    points = simulation.state.points
    own = points.of_body(name)
    lower = (points.position - points.half_length)[own, 1]
    x = points.position[own, 0]
    found = []
    for column in np.unique(np.round(x, 9)) + 1e-7:  # not on a boundary point
        bottom = lower[np.abs(x - column) < 1e-6].min()
        heights = []
        for other, surface in simulation.state.surfaces.items():
            if other != name:
                shape = surface.shape()
                start, end = shape.position[shape.cells[:, 0]], shape.position[shape.cells[:, 1]]
                across = (start[:, 0] - column) * (end[:, 0] - column) < 0.0
                start, end = start[across], end[across]
                part = (column - start[:, 0]) / (end - start)[:, 0]
                heights += list(start[:, 1] + part * (end - start)[:, 1])
        if heights:  # the outermost column may be beside the ground
            found.append(bottom - max(heights))
    return np.array(found)


@pytest.mark.slow
@every_basis
@pytest.mark.parametrize("fill", [2, 3])
def test_fill_has_no_gap_and_no_overlap(basis: str, fill: int) -> None:
    """Beside and above a heavy lift, on ground that settled by 0.3 m more below it.

    In the mean to 1 % of a cell, and to 5 % beside the lift.
    """
    case = bank(1, young=150.0, fill=fill, basis=basis)
    case["bodies"][0]["surface"] = {}
    case["bodies"][1]["shape"]["upper"] = [2.0, DEPTH + 2.0 * CELL]
    body = {"basis": basis, "points_per_cell": fill, "material": "fill", "surface": {}}
    beside, above = [2.0, DEPTH], [0.0, DEPTH + 2.0 * CELL]
    case["bodies"] += [
        box("beside", beside, [WIDTH, DEPTH + 2.0 * CELL], **body),
        box("all over", above, [WIDTH, DEPTH + 3.0 * CELL], **body),
    ]
    case["stages"] += [
        stage("beside", 4, activate=["beside"]),
        stage("all over", activate=["all over"]),
    ]
    found: dict[str, Floats] = {}

    def at_start(analysis: StagedAnalysis) -> None:
        name = analysis.simulation.setup.model.stage.name
        if name != "ground":
            found[name] = gaps(analysis.simulation, name) / CELL

    analysis = march_stages(Model.from_dict(case), at_start=at_start)
    ground = by_number(analysis.simulation, "position")[:, 1]
    assert np.ptp(ground[ground < 3.5]) > 0.2
    for name, gap in found.items():
        assert np.abs(gap).mean() < 0.01, name
        assert np.abs(gap).max() < 0.05, name


def test_the_tracked_surface_moves_with_the_fill() -> None:
    """A lift's outline is placed with its points, and keeps its area."""
    _, starts, _ = march(bank(2, steps=1))
    for number, area in enumerate((2.0, 1.75)):
        simulation = starts[f"lift {number}"]
        surface = simulation.state.surfaces[f"lift {number}"]
        assert isinstance(surface, TrackedSurface)
        assert surface.enclosed() == pytest.approx(area, rel=1e-2)


@pytest.mark.parametrize("f_bar", [False, True])
def test_fill_goes_into_an_excavated_pit(f_bar: bool) -> None:
    """Dug and filled with the same soil: the weight is the declared one again."""
    body = {"anti_locking": "f_bar" if f_bar else "none"}
    parts = [
        box("ground", [0.0, 0.0], [4.0, 1.0], **body),
        box("pit", [0.0, 1.0], [2.0, 2.0], **body),
        box("bank", [2.0, 1.0], [4.0, 2.0], **body),
        box("fill", [0.0, 1.0], [2.0, 2.0], **body),
    ]
    case = entries(
        bodies=parts,
        boundaries=[plane("base", "y", 0.0), plane("left", "x", 0.0), plane("right", "x", 4.0)],
        materials={"soil": elastic(2000.0)},
        stages=[
            stage("rest", 2), stage("dig", 2, deactivate=["pit"]),
            stage("fill", 2, activate=["fill"]), stage("dig again", 2, deactivate=["fill"]),
        ],
    )  # fmt: skip
    _, _, results = march(case)
    carried = [result.resultant("base")[1] for result in results]
    assert carried[1::2] == pytest.approx([160.0, 120.0, 160.0, 120.0], rel=1e-8)


def test_three_dimensions() -> None:
    """A square of fill on soft ground: its weight, and its bottom on the ground."""
    body = {"basis": "gimp"}
    parts = [
        box("ground", [0.0, 0.0, 0.0], [2.0, 2.0, 1.0], **body),
        box("first", [0.0, 0.0, 1.0], [1.0, 1.0, 1.5], **body),
        box("second", [0.0, 0.0, 1.5], [1.0, 1.0, 2.0], **body),
    ]
    sides = [(f"{axis}{at:g}", axis, at) for axis in "xy" for at in (0.0, 2.0)]
    case = entries(
        analysis={"kind": "3d", "tolerance": 1e-10},
        bodies=parts,
        boundaries=[plane("base", "z", 0.0), *(plane(*side) for side in sides)],
        loads=[gravity(3, [[0.0, 0.0], [1.0, 1.0]])],
        materials={"soil": elastic(500.0)},
        stages=[
            stage("ground", 2), stage("first", 2, activate=["first"]),
            stage("second", 2, activate=["second"]),
        ],
    )  # fmt: skip
    analysis, _, results = march(case)
    carried = [result.resultant("base")[2] for result in results]
    assert carried[1::2] == pytest.approx([80.0, 90.0, 100.0], rel=1e-8)
    points = analysis.simulation.state.points
    lowest = points.position[points.of_body("second"), 2].min()
    highest = points.position[points.of_body("first"), 2].max()
    assert lowest - highest == pytest.approx(0.25, abs=0.02)
    assert points.displacement[points.of_body("ground"), 2].min() < -0.02


@pytest.mark.parametrize("length", [4.0**-8, 4.0**8])
def test_the_ground_under_a_fill_settles_alike_in_any_unit_of_length(length: float) -> None:
    rows = np.array([[0.0, 0.1, 0.01], [0.3, 0.0, 0.03], [0.5, 0.4, 0.02], [0.2, 0.9, 0.05]])
    places = np.array([[0.1, 0.1], [0.3, 0.0], [5.0, 2.0]])
    found = settlement(length * rows, length * places)
    assert found.tolist() == (length * settlement(rows, places)).tolist()
    away = np.array([4.0, 0.0, 0.0])
    moved = settlement(rows + away, places + away[:2])
    np.testing.assert_allclose(moved, settlement(rows, places), rtol=1e-12)
