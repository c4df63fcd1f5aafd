# SPDX-License-Identifier: BSD-3-Clause
"""Free rigid bodies in the search for the equilibrium of the starting state."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from clay_boxes import clay_box
from free_bodies import falling
from resumed_runs import assert_same_results, run_until

from tilth import Model, resume, run
from tilth.analysis.advance import begin_motion
from tilth.analysis.initial_equilibrium import InitialEquilibrium, find_initial_equilibrium
from tilth.analysis.simulation import Simulation

GRAVITY, MASS = 10.0, 100.0
ALWAYS = [[0.0, 1.0], [1.0, 1.0]]
BOTH = ["plane_strain", "3d"]


def ground(
    kind: str, gap: float = 0.0, top: float = 0.0, cell: float = 0.25, **body: Any
) -> dict[str, Any]:
    """Clay at rest and a ball above its middle whose height and rotation are free.

    gap: between them. top: of the soil; on a grid line the stress at rest is in equilibrium.
    """
    across = ["x", "y"] if kind == "3d" else ["x"]
    centre = [0.0] * len(across) + [top + 0.5 + gap]
    return {
        **clay_box(kind, 0.45, top),
        "analysis": {"kind": kind, "tolerance": 1e-8},
        "grid": {"cell_size": cell if kind != "3d" else 2.0 * cell},
        "rigid_bodies": [
            {"name": "ball", "centre": centre, "displacement": dict.fromkeys(across, 0.0),
             "rotation": 0.0 if kind != "3d" else {"x": 0.0, "y": 0.0, "z": 0.0},
             "geometry": {"type": "sphere" if kind == "3d" else "circle", "centre": centre,
                          "radius": 0.5, "soil": "outside"},
             "contact": {"normal": "unilateral", "tangential": "friction", "friction": 0.3},
             **body}
        ],
        "loads": [
            {"type": "body_force", "acceleration": [0.0] * len(across) + [-GRAVITY],
             "factor": ALWAYS}
        ],
        "initial": {"stress": [{"type": "k0", "body": "ground", "K0": 0.6}]},
        "schedule": {"steps": 2},
    }  # fmt: skip


def in_hole(**body: Any) -> dict[str, Any]:
    """The lower half of the circle is in the ground, in place from the start."""
    entries = ground("plane_strain", gap=-0.5, wished_in_place=True, **body)
    angles = np.linspace(2.0 * np.pi, np.pi, 25)[1:-1]
    arc = [[0.5 * np.cos(a), 0.5 * np.sin(a)] for a in angles]
    outline = [[-1, -1], [1, -1], [1, 0], [0.5, 0], *arc, [-0.5, 0], [-1, 0]]
    entries["bodies"][0]["shape"] = {"type": "polygon", "vertices": outline}
    return entries


def found(entries: dict[str, Any]) -> tuple[Simulation, InitialEquilibrium]:
    """The equilibrium at the start; the soil has kept its place."""
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    before = simulation.state.points.position[simulation.state.points.in_order].copy()
    report = find_initial_equilibrium(simulation)
    after = simulation.state.points.position[simulation.state.points.in_order]
    assert before.tobytes() == after.tobytes()
    return simulation, report


def force(dim_up: int, value: Any) -> dict[str, Any]:
    return {"force": {"xyz"[dim_up]: value}}


@pytest.mark.parametrize("value", [0.0, -500.0], ids=["none", "grows"])
@pytest.mark.parametrize("gap", [0.0, 0.1])
@pytest.mark.parametrize("kind", BOTH)
def test_a_body_without_a_force_stays_where_it_is(kind: str, gap: float, value: float) -> None:
    """The stress at rest is in equilibrium to the last bit; the force begins with the first step.

    The ball comes down to where its lowest quadrature point meets the soil, and settles.
    """
    up = 2 if kind == "3d" else 1
    simulation, report = found(ground(kind, gap, **force(up, value)))
    assert report.iterations == 0
    ball = simulation.state.bodies[0]
    assert not ball.displacement.any()
    assert not ball.force.any()
    simulation.advance(0.0, 0.5)
    assert ball.force[up] == pytest.approx(-0.5 * value, rel=1e-6)
    if value == 0.0:
        assert not ball.displacement.any()
    else:
        assert ball.displacement[up] == pytest.approx(-gap, abs=5e-3)


@pytest.mark.parametrize("kind", BOTH)
def test_soil_that_finds_its_equilibrium_leaves_a_body_without_a_force(kind: str) -> None:
    up = 2 if kind == "3d" else 1
    simulation, report = found(ground(kind, top=-0.1, **force(up, 0.0)))
    assert report.iterations > 0
    assert report.residual_after < 1e-8
    ball = simulation.state.bodies[0]
    assert not ball.displacement.any()
    assert np.abs(ball.force).max() < 1e-3
    simulation.advance(0.0, 1.0)
    assert np.abs(simulation.state.points.displacement).max() < 1e-7


@pytest.mark.parametrize("initial", ["k0", "gravity"])
@pytest.mark.parametrize("top", [0.0, -0.1])
@pytest.mark.parametrize("kind", BOTH)
def test_a_body_with_weight_rests_where_it_is(kind: str, top: float, initial: str) -> None:
    """Its motion is put back with the soil; a step under the same loads moves nothing."""
    entries = ground(kind, top=top, mass=MASS)
    if initial == "gravity":
        entries["initial"] = {"stress": [{"type": "gravity", "body": "ground", "steps": 3}]}
    simulation, report = found(entries)
    ball, up = simulation.state.bodies[0], 2 if kind == "3d" else 1
    assert report.residual_after < 1e-8
    assert not ball.displacement.any()
    assert np.array_equal(ball.rotation, np.eye(up + 1))
    assert ball.force[up] == pytest.approx(GRAVITY * MASS, rel=1e-6)
    result = simulation.advance(0.0, 1.0)
    assert result.equilibrium.iterations == 0
    assert np.abs(simulation.state.points.displacement).max() < 1e-12
    assert np.abs(ball.displacement).max() < 1e-12


def test_a_body_with_weight_comes_down_on_the_soil() -> None:
    simulation, _ = found(ground("plane_strain", gap=0.1, mass=MASS))
    ball = simulation.state.bodies[0]
    assert ball.displacement[1] == pytest.approx(-0.1, abs=0.01 * 0.25)
    assert ball.force[1] == pytest.approx(GRAVITY * MASS, rel=1e-6)
    assert simulation.advance(0.0, 1.0).equilibrium.iterations == 0


def test_what_a_spring_holds_stays_where_it_has_come_to() -> None:
    """The force of the spring is that of its extension; the rest of the weight is on the soil."""
    stiffness = 1e5
    body = {"mass": MASS, "springs": {"y": stiffness}}
    simulation, _ = found(ground("plane_strain", **body))
    ball = simulation.state.bodies[0]
    assert ball.displacement[1] < 0.0
    total = ball.force[1] - stiffness * ball.displacement[1]
    assert total == pytest.approx(GRAVITY * MASS, rel=1e-6)


@pytest.mark.parametrize("mass", [0.0, 400.0])
def test_a_body_in_place_in_the_soil(mass: float) -> None:
    """Without weight it bears nothing, so that the hole stands by itself."""
    body = {"mass": mass} if mass else {"force": {"y": 0.0}}
    simulation, report = found(in_hole(**body))
    ball = simulation.state.bodies[0]
    assert report.residual_after < 1e-8
    assert not ball.displacement.any()
    assert ball.force[1] == pytest.approx(GRAVITY * mass, abs=1e-3)
    simulation.advance(0.0, 1.0)
    assert np.abs(simulation.state.points.displacement).max() < 1e-6


@pytest.mark.parametrize("gap", [0.03, 0.5])
def test_a_body_with_inertia_that_falls_takes_no_part(gap: float) -> None:
    entries = falling("plane_strain", gap=gap)
    entries["initial"] = {"stress": [{"type": "k0", "body": "soil", "K0": 1.0}]}
    simulation, report = found(entries)
    ball = simulation.state.bodies[0]
    assert report.residual_after < 1e-8
    assert not ball.displacement.any()
    simulation.advance(0.0, 0.005)
    fall = 0.005 * 1.0 + 0.5 * GRAVITY * 0.005**2
    assert ball.displacement[1] == pytest.approx(-fall, rel=1e-9)


@pytest.mark.parametrize("kind", BOTH)
def test_resumed_after_the_first_step(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = ground(kind, top=-0.1, mass=MASS, force={"z" if kind == "3d" else "y": -500.0})
    model = Model.from_dict({**entries, "output": {"report": False}})
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "part", 1, monkeypatch)
    resume(tmp_path / "part", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "part")


@pytest.mark.parametrize("size", [0.2, 1e-3])
@pytest.mark.parametrize("kind", BOTH)
def test_a_body_that_rests_begins_with_no_acceleration(kind: str, size: float) -> None:
    """Gaps are measured in another way below a body with inertia, but it has not moved for that."""
    entries = ground(kind, top=-0.1, mass=MASS)
    entries["units"] = {"time": "s"}
    entries["analysis"]["inertia"] = {"scheme": "newmark"}
    entries["schedule"] = {"end": size, "steps": 1}
    simulation, _ = found(entries)
    assert simulation.state.declared_dynamics is not None
    begin_motion(simulation.setup, simulation.state, simulation.services, 0.0, size)
    assert np.abs(simulation.state.points.motion[:, 1]).max() < 0.05 * GRAVITY


def test_soil_that_a_bilateral_law_will_hold_begins_with_no_acceleration() -> None:
    """The gaps between the points of a circle and flat soil are closed in the steps that follow."""
    law = {"normal": "bilateral", "tangential": "friction", "friction": 0.3}
    entries = ground("plane_strain", top=-0.1, gap=1e-3, contact=law)
    entries["rigid_bodies"][0]["displacement"]["y"] = -0.01
    del entries["initial"], entries["loads"]
    entries["units"] = {"time": "s"}
    entries["analysis"]["inertia"] = {"scheme": "newmark"}
    entries["schedule"] = {"end": 0.1, "steps": 1}
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    assert simulation.state.declared_dynamics is not None
    begin_motion(simulation.setup, simulation.state, simulation.services, 0.0, 0.1)
    assert np.abs(simulation.state.points.motion[:, 1]).max() < 1e-6
