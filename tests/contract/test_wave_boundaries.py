# SPDX-License-Identifier: BSD-3-Clause
"""Moving bases and absorbing boundaries: tangent, impedance, forces at rest, records, resume."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from contact_terms import next_balance

from tilth import Model
from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation
from tilth.analysis.staged import StagedAnalysis
from tilth.terms.dashpots import AssembledDashpots
from tilth.variation.record import Record

NEWMARK: dict[str, Any] = {"scheme": "newmark"}
ALPHA: dict[str, Any] = {"scheme": "generalised_alpha", "spectral_radius": 0.7}
KINDS = ["plane_strain", "axisymmetric", "3d"]
DENSITY, YOUNG, POISSON = 2000.0, 1e7, 0.3


def ground(kind: str, boundaries: list[dict[str, Any]], **more: Any) -> Simulation:
    """A block of elastic soil from the origin, 1.5 m wide and 1 m high."""
    dim = 3 if kind == "3d" else 2
    upper = [1.5, 1.0] if dim == 2 else [1.5, 1.0, 1.0]
    entries: dict[str, Any] = {
        "units": {"time": "s"},
        "analysis": {"kind": kind, "inertia": NEWMARK, "tolerance": 1e-12},
        "grid": {"cell_size": 0.25},
        "materials": {
            "soil": {
                "model": "hencky_elastic", "young_modulus": YOUNG, "poisson_ratio": POISSON,
                "density": DENSITY,
            }
        },
        "bodies": [
            {"name": "soil", "material": "soil", "basis": "gimp", "points_per_cell": 2,
             "shape": {"type": "box", "lower": [0.0] * dim, "upper": upper}}
        ],
        "boundaries": boundaries,
        "schedule": {"end": 0.05, "steps": 10},
    }  # fmt: skip
    return Simulation(Model.from_dict(entries | more))


def side(kind: str, turned: bool = False, **more: Any) -> dict[str, Any]:
    """An absorbing boundary at x = 1.5 m, or one that cuts the cells."""
    if not turned:
        found: dict[str, Any] = {"type": "plane", "axis": "x", "at": 1.5}
    else:
        normal = [-0.9, 0.3] if kind != "3d" else [-0.9, 0.3, 0.2]
        point = [1.37, 0.5] if kind != "3d" else [1.37, 0.5, 0.5]
        geometry = {"type": "plane", "point": point, "normal": normal}
        found = {"type": "implicit", "geometry": geometry}
    return {"name": "side", "condition": "absorbing", **found, **more}


def write_record(path: Path, rows: str) -> str:
    path.write_text(rows, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_the_stiffness_of_dashpots_is_the_derivative_of_their_force(
    kind: str, turned: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    simulation = ground(kind, [side(kind, turned)])
    simulation.advance(0.0, 0.005)
    balance = next_balance(simulation, 0.005, 0.012, monkeypatch)
    (term,) = (each for each in balance.terms if isinstance(each, AssembledDashpots))
    random = np.random.default_rng(7)
    shape = (balance.active.nodes, balance.active.grid.dim)
    u, direction = 1e-3 * random.normal(size=shape), random.normal(size=shape)
    if kind == "axisymmetric":
        direction[balance.active.position[:, 0] == 0.0, 0] = 0.0
    blocks = np.zeros((len(balance.active.column), shape[1], shape[1]))
    term.add_stiffness(u, blocks)
    rows = np.repeat(np.arange(shape[0]), np.diff(balance.active.row_start))
    product = np.zeros(shape)
    np.add.at(product, rows, np.einsum("bij,bj->bi", blocks, direction[balance.active.column]))
    difference = term.force(u + direction) - term.force(u)
    assert np.abs(difference).max() > 0.0
    np.testing.assert_allclose(product, difference, rtol=0, atol=1e-9 * np.abs(difference).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_soil_that_moves_evenly_meets_the_impedance_times_its_velocity(kind: str) -> None:
    """On a plane of the grid: rho c_p v along the normal, rho c_s v across, times the area."""
    dim = 3 if kind == "3d" else 2
    across = dim - 1
    velocity = {"body": "soil", "xyz"[across]: 0.02}
    if kind != "axisymmetric":
        velocity["x"] = 0.01
    simulation = ground(kind, [side(kind)], initial={"velocity": [velocity]})
    simulation.state.dynamics.begun = True  # type: ignore[union-attr]
    result = simulation.advance(0.0, 1e-9)
    area = {"plane_strain": 1.0, "axisymmetric": 2.0 * np.pi * 1.5, "3d": 1.0}[kind]
    shear = YOUNG / (2.0 * (1.0 + POISSON))
    constrained = YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    expected = np.zeros(dim)
    expected[across] = -np.sqrt(DENSITY * shear) * 0.02 * area
    if kind != "axisymmetric":
        expected[0] = -np.sqrt(DENSITY * constrained) * 0.01 * area
    np.testing.assert_allclose(result.resultant("side"), expected, rtol=1e-4, atol=1e-9)


def test_the_ground_beyond_may_be_another_one() -> None:
    other = {"density": 2500.0, "p_wave_speed": 900.0, "s_wave_speed": 400.0}
    velocity = {"body": "soil", "x": 0.01, "y": 0.02}
    boundary = side("plane_strain", ground=other)
    simulation = ground("plane_strain", [boundary], initial={"velocity": [velocity]})
    simulation.state.dynamics.begun = True  # type: ignore[union-attr]
    result = simulation.advance(0.0, 1e-9)
    expected = [-2500.0 * 900.0 * 0.01, -2500.0 * 400.0 * 0.02]
    np.testing.assert_allclose(result.resultant("side"), expected, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("inertia", [NEWMARK, ALPHA])
def test_soil_moves_with_its_base_without_strain(inertia: dict[str, Any], tmp_path: Path) -> None:
    """Under the same acceleration as body force and of the base, in steps of different sizes."""
    rows = [(0.0, 0.0, 0.0), (0.02, 3.0, -1.0), (0.035, -5.0, 2.0), (0.05, 1.0, 0.5)]
    text = "time,x,y\n" + "\n".join(",".join(map(str, row)) for row in rows) + "\n"
    file = write_record(tmp_path / "record.csv", text)
    base = {"name": "base", "type": "plane", "axis": "y", "at": 0.0,
            "condition": "base_motion", "acceleration": {"file": file}}  # fmt: skip
    forces = [
        {"type": "body_force", "acceleration": [1.0, 0.0], "factor": [[r[0], r[1]] for r in rows]},
        {"type": "body_force", "acceleration": [0.0, 1.0], "factor": [[r[0], r[2]] for r in rows]},
    ]
    analysis = {"kind": "plane_strain", "inertia": inertia, "tolerance": 1e-12}
    simulation = ground("plane_strain", [base], loads=forces, analysis=analysis)
    simulation.check()
    times = [0.0, 0.004, 0.01, 0.02, 0.023, 0.035, 0.04, 0.05]
    for before, after in pairwise(times):
        simulation.advance(before, after)
    points = simulation.state.points
    np.testing.assert_allclose(
        points.motion[:, 1], np.tile([1.0, 0.5], (len(points), 1)), rtol=1e-6
    )
    assert np.abs(points.stress).max() < 1e-6 * DENSITY * 5.0 * 1.0
    assert np.ptp(points.displacement, axis=0).max() < 1e-9 * np.abs(points.displacement).max()


@pytest.mark.parametrize("turned", [False, True])
def test_energy_that_leaves_is_that_which_is_missing(turned: bool) -> None:
    velocity = {"body": "soil", "x": 0.01, "angular_velocity": 0.02, "centre": [0.7, 0.5]}
    initial = {"velocity": [velocity]}
    simulation = ground("plane_strain", [side("plane_strain", turned)], initial=initial)
    energies = Energies.at_start(simulation.setup, simulation.state)
    for number in range(10):
        energies.add(simulation.advance(0.001 * number, 0.001 * (number + 1)))
    assert energies.radiated > 0.2 * energies.start
    lost = energies.value("numerical_dissipation", simulation.setup, simulation.state, 0.01)
    assert abs(lost) < 0.02 * energies.start


def staged(kind: str, base: str, steps: int = 10, more: int = 0) -> Model:
    """Gravity between rollers without inertia, then absorbing boundaries in their place.

    more: steps of a third stage, which changes nothing.
    """
    dim = 3 if kind == "3d" else 2
    third = [{"name": "more", "schedule": {"end": 0.005 * more, "steps": more}}] if more else []
    upper = [1.5, 1.0] if dim == 2 else [1.0, 1.0, 1.0]
    faces = [("right", "x", upper[0])]
    faces += [("left", "x", 0.0)] if kind != "axisymmetric" else []
    faces += [("front", "y", 0.0), ("back", "y", upper[1])] if dim == 3 else []
    bottom = {"type": "plane", "axis": "xyz"[dim - 1], "at": 0.0}
    before: list[dict[str, Any]] = [
        {"name": f"{name} roller", "type": "plane", "axis": axis, "at": at, "condition": "roller"}
        for name, axis, at in faces
    ]
    after: list[dict[str, Any]] = [
        {"name": name, "type": "plane", "axis": axis, "at": at, "condition": "absorbing"}
        for name, axis, at in faces
    ]
    if base == "absorbing":
        before.append({"name": "bottom roller", "condition": "roller", **bottom})
        after.append({"name": "bottom", "condition": "absorbing", **bottom})
    always = [{"name": "rock", "condition": "fixed", **bottom}] if base == "fixed" else []
    gravity = [0.0] * (dim - 1) + [-9.81]
    shape = {"type": "box", "lower": [0.0] * dim, "upper": upper}
    return Model.from_dict(
        {
            "units": {"time": "s"},
            "analysis": {"kind": kind, "inertia": NEWMARK},
            "grid": {"cell_size": 0.25},
            "materials": {
                "soil": {"model": "hencky_elastic", "young_modulus": YOUNG,
                         "poisson_ratio": POISSON, "density": DENSITY}
            },
            "bodies": [{"name": "soil", "material": "soil", "basis": "gimp",
                        "points_per_cell": 2, "shape": shape}],
            "loads": [{"type": "body_force", "acceleration": gravity}],
            "boundaries": [*always, *before, *after],
            "stages": [
                {"name": "gravity", "inertia": False, "schedule": {"end": 1.0, "steps": 2}},
                {"name": "shaking", "schedule": {"end": 0.05, "steps": steps},
                 "activate": [each["name"] for each in after],
                 "deactivate": [each["name"] for each in before]},
                *third,
            ],
        }
    )  # fmt: skip


@pytest.mark.parametrize("base", ["fixed", "absorbing"])
def test_absorbing_boundaries_keep_the_soil_at_rest_on_another_grid(base: str) -> None:
    """They keep what is in balance with the stress on the nodes of that grid.

    What moves is the fifth of other forces out of balance that the first step releases.
    """
    entries = staged("plane_strain", base, steps=2, more=5).to_dict()
    entries["stages"][2]["grid"] = {"cell_size": 0.2}
    analysis = StagedAnalysis(Model.from_dict(entries))
    analysis.check()
    settled = []
    for _ in analysis.steps():
        points = analysis.simulation.state.points
        settled.append(points.displacement[points.in_order])
        if analysis.number == 2:
            break
    moved = np.abs(settled[-1] - settled[-2]).max()
    assert moved < 2e-3 * np.abs(settled[-1]).max()


@pytest.mark.parametrize("base", ["fixed", "absorbing"])
@pytest.mark.parametrize("kind", KINDS)
def test_absorbing_boundaries_keep_the_soil_at_rest(kind: str, base: str) -> None:
    """What moves is 1e-3 of what gravity did: the soil's own residual on its next grid."""
    analysis = StagedAnalysis(staged(kind, base))
    analysis.check()
    settled, before = np.zeros(0), {}
    for _, result in analysis.steps():
        points = analysis.simulation.state.points
        if analysis.number == 0:
            settled = points.displacement[points.in_order].copy()
            before = {
                name.removesuffix(" roller"): result.resultant(name) for name in result.forces
            }
            assert not points.motion.any()
    for each in analysis.simulation.state.waves.absorbing:
        force, k = result.resultant(each.name), int(np.abs(before[each.name]).argmax())
        if k == len(force) - 1 or kind != "axisymmetric":  # radial forces balance nodes at the axis
            assert force[k] == pytest.approx(before[each.name][k], rel=1e-2, abs=1.0)
    points = analysis.simulation.state.points
    moved = points.displacement[points.in_order] - settled
    assert np.abs(moved).max() < 1e-3 * np.abs(settled).max()
    assert analysis.simulation.services.warnings.texts == []


def test_the_forces_at_rest_are_taken_over_once() -> None:
    """In a next stage, too: the soil's weight still rests on a base that absorbs."""
    analysis = StagedAnalysis(staged("plane_strain", "absorbing", steps=1, more=2))
    analysis.check()
    *_, (_, result) = analysis.steps()
    assert analysis.number == 2
    weight = DENSITY * 9.81 * 1.5
    assert abs(result.resultant("bottom")[1]) == pytest.approx(weight, rel=1e-3)
    fall = 9.81 * 0.01  # velocity that it would have after this stage without what holds it
    assert np.abs(analysis.simulation.state.points.motion[:, 0]).max() < 1e-3 * fall


def test_a_record_is_integrated_exactly() -> None:
    record = Record.of(np.array([0.0, 1.0, 3.0]), np.array([[0.0], [2.0], [-1.0]]))
    np.testing.assert_allclose(record.velocity[:, 0], [0.0, 1.0, 2.0])
    assert record.velocity_at(0.5)[0] == pytest.approx(0.25)
    assert record.velocity_at(2.0)[0] == pytest.approx(1.0 + 0.5 * (2.0 + 0.5))
    assert record.acceleration_at(2.0)[0] == pytest.approx(0.5)
    assert record.acceleration_at(4.0)[0] == 0.0
    assert record.velocity_at(4.0)[0] == 2.0
    assert "100% of its greatest" in record.drift()
    assert Record.of(np.array([0.0, 1.0, 2.0]), np.array([[1.0], [0.0], [-1.0]])).drift() == ""


def test_a_stage_that_changes_nothing_changes_no_motion() -> None:
    """A block that falls, turns and vibrates in two stages, as in a single one.

    The accelerations are found anew at the start of a stage, by a short step: that is the
    difference. Released weight would change the velocity by 0.25 m/s.
    """
    block = {"type": "box", "lower": [0.1, 0.1], "upper": [0.9, 0.9]}
    entries: dict[str, Any] = {
        "units": {"time": "s"},
        "analysis": {"kind": "plane_strain", "inertia": NEWMARK | {"damping": {"mass": 2.0}}},
        "grid": {"cell_size": 0.25},
        "materials": {
            "soil": {"model": "hencky_elastic", "young_modulus": 1e5, "poisson_ratio": 0.3,
                     "density": DENSITY}
        },
        "bodies": [{"name": "soil", "material": "soil", "basis": "linear", "points_per_cell": 2,
                    "shape": block}],
        "initial": {"velocity": [{"body": "soil", "x": 0.1, "angular_velocity": 0.2,
                                  "centre": [0.0, 0.0]}]},
        "loads": [{"type": "body_force", "acceleration": [0.0, -9.81],
                   "factor": [[0, 1], [1, 1]]}],
    }  # fmt: skip
    one = StagedAnalysis(Model.from_dict(entries | {"schedule": {"end": 0.1, "steps": 10}}))
    stages = [{"name": name, "schedule": {"end": 0.05, "steps": 5}} for name in ("one", "two")]
    two = StagedAnalysis(Model.from_dict(entries | {"stages": stages}))
    for analysis in (one, two):
        analysis.check()
        for _ in analysis.steps():
            pass
    order, other = one.simulation.state.points.in_order, two.simulation.state.points.in_order
    velocity = one.simulation.state.points.motion[order, 0]
    np.testing.assert_allclose(
        two.simulation.state.points.motion[other, 0], velocity, rtol=0, atol=5e-5
    )
