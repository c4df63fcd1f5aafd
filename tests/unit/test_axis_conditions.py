# SPDX-License-Identifier: BSD-3-Clause
"""Where the axis of symmetry holds the soil, and which boundaries contradict it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from implicit_blocks import flat, implicit
from small_problems import BASES, affine, block_entries, off_lines, plane

from tilth import BadInput, Model
from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.boundaries import Conditions
from tilth.boundaries.step.conditions import AXIS

pytestmark = pytest.mark.slow

every_basis = pytest.mark.parametrize("basis", BASES)


# --- hollow bodies ------------------------------------------------------------------------------


def ring(basis: str, hole: float, shift: float = 0.0, **more: Any) -> dict[str, Any]:
    """A ring of clay one wide in cells of 0.25, pushed inwards by its outer wall."""
    entries = block_entries("axisymmetric", basis, "von_mises", schedule={"steps": 60}, **more)
    entries["grid"]["cell_size"] = 0.25
    entries["materials"]["soil"].update(poisson_ratio=0.45, yield_stress=10.0)
    body = entries["bodies"][0]
    body.pop("points_per_cell")
    body["shape"] = {"type": "box", "lower": [hole, 0.0], "upper": [hole + 1.0, 0.5]}
    body.update(points=[8, 4], anti_locking="f_bar")
    wall = flat([hole + 1.0, 0.0], [-1.0, 0.0])
    entries["boundaries"] = [
        implicit("wall", wall, displacement={"x": -0.1}),
        plane("base", "y", 0.0),
        plane("top", "y", 0.5),
    ]
    return off_lines(entries, shift)


@every_basis
@pytest.mark.parametrize("hole", [0.02, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("shift", [0.0, 0.37])
def test_a_hollow_body_is_not_touched(basis: str, hole: float, shift: float) -> None:
    """Also where the nodes on the axis belong to cells with soil."""
    simulation = Simulation(Model.from_dict(ring(basis, hole, shift)))
    active = simulation.check()
    declared = Conditions.gather(simulation.state.boundaries, active, 0.0, 1.0)
    assert not (simulation.state.axis.constrain(active, declared).conditions.boundary == AXIS).any()
    result = simulation.advance(0.0, 1.0 / 60.0)
    assert len(simulation.state.axis.height) == 0
    free = Simulation(Model.from_dict(ring(basis, hole, shift)))
    free.state.axis._rows = None
    other = free.advance(0.0, 1.0 / 60.0)
    assert np.array_equal(result.equilibrium.displacement, other.equilibrium.displacement)


@every_basis
@pytest.mark.parametrize("shift", [0.0, 0.37, 0.9])
def test_soil_that_flows_to_the_axis_stays_there(basis: str, shift: float) -> None:
    """A hole of 0.2 in a ring that is squeezed to less than its volume: it closes, and fills up."""
    holds: list[bool] = []

    def look(simulation: Simulation, result: Any, time: float) -> None:
        holds.append(len(simulation.state.axis.heights(result.active)[0]) == 3)

    points = march(Model.from_dict(ring(basis, 0.2, shift)), look).state.points
    first = holds.index(True)
    assert all(holds[first:])
    closed = 60 * (1.2 - (1.2**2 - 0.2**2) ** 0.5) / 0.1
    assert closed < first < 2.0 * closed
    assert points.position[:, 0].min() > 0.0
    assert points.volume.sum() == pytest.approx(np.pi * 1.1**2 * 0.5, rel=0.015)


def test_the_axis_takes_hold_of_oblique_lattices() -> None:
    """The sub-cells of a polygon on a shifted grid end up to half a spacing before the axis."""
    for shift in (0.1, 0.2, 0.3, 0.45):
        entries = block_entries("axisymmetric", "gimp", boundaries=[plane("base", "y", 0.0)])
        vertices = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]
        entries["bodies"][0]["shape"] = {"type": "polygon", "vertices": vertices}
        simulation = Simulation(Model.from_dict(off_lines(entries, shift)))
        active = simulation.check()
        assert simulation.state.axis.heights(active)[1].tolist() == [0.0, 1.0, 2.0]


# --- bodies on the axis ---------------------------------------------------------------------------


def test_a_ring_that_a_cone_has_pushed_aside_leaves_the_axis() -> None:
    """It has no hole, but the axis beside it is in the cone; below the tip the axis holds on."""
    entries = block_entries("axisymmetric", "gimp", boundaries=[plane("base", "y", 0.0)])
    entries["bodies"][0]["shape"] = {
        "type": "polygon", "vertices": [[0, 0], [4, 0], [4, 6], [1.5, 6], [0, 3]]
    }  # fmt: skip
    cone = {"type": "polyline", "vertices": [[-1.5, 6], [0, 3], [1.5, 6]], "soil": "right"}
    entries["boundaries"].append(implicit("cone", cone))
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    points = simulation.state.points
    innermost = np.flatnonzero(points.position[:, 0] < 0.5)
    top = innermost[points.position[innermost, 1].argmax()]
    radius, height = 1.0, 4.6
    stretch = radius / points.position[top, 0]
    points.position[top] = [radius, height]
    points.deformation_gradient[top] = np.diag([stretch, stretch**-2, stretch])
    active = simulation.locate(0.0)
    declared = Conditions.gather(simulation.state.boundaries, active, 0.0, 0.0)

    def held(boundaries: list[Any]) -> list[float]:
        conditions = simulation.state.axis.constrain(active, declared, boundaries).conditions
        on_axis = (conditions.boundary[:, 0] == AXIS) & (active.position[:, 0] == 0.0)
        return sorted(active.position[on_axis, 1].tolist())

    assert held([]) == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    assert held(simulation.state.implicit) == [0.0, 1.0, 2.0, 3.0]


# --- contradictions -----------------------------------------------------------------------------

BLOCK: dict[str, Any] = {"type": "box", "lower": [0.0, 0.0], "upper": [2.0, 2.0]}
BASE = plane("base", "y", 0.0)
OUT = {"displacement": {"x": 0.1, "y": -0.1}}
TABLE = {"factor": [[0.0, 0.0], [0.4, 0.0], [0.5, 1.0], [0.6, 0.0], [1.0, 0.0]]}
LEAVING: dict[str, tuple[dict[str, Any], float]] = {
    "a plane across": (plane("push", "y", 2.0, condition="prescribed", **OUT), 0.0),
    "a plane across, off the lines": (plane("push", "y", 2.0, condition="prescribed", **OUT), 0.37),
    "the line itself": (
        plane("push", "x", 0.0, condition="prescribed", displacement={"x": 0.1}), 0.0
    ),
    "a node": (
        {
            "type": "node", "name": "push", "at": [0.0, 1.0], "condition": "prescribed",
            "displacement": {"x": -1e-9},
        },
        0.0,
    ),
    "in the middle of the schedule": (
        plane("push", "y", 2.0, condition="prescribed", **OUT, **TABLE), 0.0
    ),
    "a rough plate": (implicit("push", flat([0, 2], [0, -1]), "fixed", **OUT), 0.0),
    "a rough plate inside a cell": (
        implicit("push", flat([0, 1.9], [0, -1]), "fixed", **OUT, **TABLE), 0.37
    ),
    "a wall on the axis": (
        implicit("push", flat([0, 0], [1, 0]), displacement={"x": 0.1}), 0.0
    ),
}  # fmt: skip


@pytest.mark.parametrize(("boundary", "shift"), list(LEAVING.values()), ids=list(LEAVING))
def test_soil_cannot_leave_the_axis(boundary: dict[str, Any], shift: float) -> None:
    entries = block_entries("axisymmetric", "gimp", boundaries=[BASE, boundary])
    entries["bodies"][0]["shape"] = BLOCK
    with pytest.raises(BadInput, match="soil cannot leave the axis of symmetry") as error:
        Simulation(Model.from_dict(off_lines(entries, shift))).check()
    assert "boundary 'push' prescribes a radial displacement at the point (0, " in str(error.value)
    assert error.value.key == "boundaries[1]"
    assert error.value.exit_code == 2


BALL = {"type": "circle", "centre": [0.0, 2.5], "radius": 1.0, "soil": "outside"}
STAYING: dict[str, dict[str, Any]] = {
    "beside it": plane(
        "push", "y", 2.0, condition="prescribed", displacement={"x": 0.1}, range={"x": [1, 2]}
    ),
    "a smooth plate": implicit("push", flat([0, 2], [0, -1]), **OUT),
    "a rough plate": implicit("push", flat([0, 2], [0, -1]), "fixed", displacement={"y": -0.1}),
    "a ball that grows": implicit("push", BALL, "fixed", radius_change=0.1),
    "a smooth cone": implicit(
        "push",
        {"type": "polyline", "vertices": [[3.0, 3.0], [0.0, 1.8]], "soil": "left"},
        displacement={"y": -0.1},
    ),
}


@pytest.mark.parametrize("boundary", list(STAYING.values()), ids=list(STAYING))
@pytest.mark.parametrize("shift", [0.0, 0.37])
def test_what_leaves_soil_on_the_axis_is_accepted(boundary: dict[str, Any], shift: float) -> None:
    entries = block_entries("axisymmetric", "gimp", boundaries=[BASE, boundary])
    entries["bodies"][0]["shape"] = BLOCK
    Simulation(Model.from_dict(off_lines(entries, shift))).check()


@pytest.mark.parametrize("shift", [0.0, 0.37])
def test_an_affine_motion_keeps_the_axis(shift: float) -> None:
    entries = block_entries("axisymmetric", "gimp", boundaries=[affine(np.diag([1.5, 0.6]))])
    simulation = Simulation(Model.from_dict(off_lines(entries, shift)))
    simulation.check()
    simulation.advance(0.0, 1.0)
    assert len(simulation.state.axis.height) == 0, "all nodes are constrained already"


def test_a_hollow_body_may_move_radially() -> None:
    entries = ring("gimp", 0.25)
    push = plane("push", "y", 0.5, condition="prescribed", displacement={"x": 0.1, "y": 0.0})
    entries["boundaries"] = [BASE, push]
    Simulation(Model.from_dict(entries)).check()


def test_other_kinds_of_analysis_have_no_axis() -> None:
    for kind in ("plane_strain", "3d"):
        simulation = Simulation(Model.from_dict(block_entries(kind, "gimp")))
        active = simulation.check()
        assert len(simulation.state.axis.heights(active)[0]) == 0
