# SPDX-License-Identifier: BSD-3-Clause
"""Free rigid bodies with inertia: derivatives, resume, threads, units, fall, float, energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from contact_terms import branches_compared, next_contact
from free_bodies import GRAVITY, RADIUS, VOLUME, fallen, falling
from readings import long
from resumed_runs import assert_same_results, restored, run_until
from small_problems import KINDS, assert_same_bits

from tilth import Model, _core, resume, run
from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation

SMALL = {"width": 0.3, "depth": 0.2}
every_kind = pytest.mark.parametrize("kind", KINDS)


def entries_of(kind: str, **changed: object) -> dict[str, object]:
    """In space a smaller block."""
    return falling(kind, **((SMALL if kind == "3d" else {}) | changed))  # type: ignore[arg-type]


@pytest.mark.slow
@every_kind
def test_derivatives_with_inertia(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of nodal forces and of the body's equations of motion, by nodes and the body's motion."""
    simulation = fallen(entries_of(kind), 5)
    balance, term = next_contact(simulation, 0.025, 0.03, monkeypatch)
    assert (np.abs(simulation.state.bodies[0].force) > 0.0).any()
    assert branches_compared(balance, term) & {"stick", "slip"}


@pytest.mark.slow
@every_kind
def test_a_restored_state_goes_on_with_the_same_bits(kind: str) -> None:
    """Soil and body, in the air and in contact."""
    for steps in (1, 4):
        one = fallen(entries_of(kind), steps)
        other = restored(one)
        schedule = one.setup.model.schedule
        for number in (steps, steps + 1):
            times = schedule.regular_time(number), schedule.regular_time(number + 1)
            for each in (one, other):
                each.advance(*times)
        assert_same_bits(one.state.points, other.state.points)
        for name, value in one.state.bodies[0].state().items():
            np.testing.assert_array_equal(other.state.bodies[0].state()[name], value, err_msg=name)


@pytest.mark.slow
def test_a_stopped_run_goes_on_with_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also its history with the energies."""
    kinds = ("kinetic", "friction_dissipation", "damping_dissipation", "numerical_dissipation")
    entries = falling("plane_strain", end=0.04, steps=8) | {
        "track": [{"name": kind, "quantity": "energy", "kind": kind} for kind in kinds],
        "output": {"report": False},
    }  # fmt: skip
    entries["analysis"]["inertia"]["damping"] = {"mass": 1.0, "stiffness": 1e-4}
    model = Model.from_dict(entries)
    run(model, tmp_path / "whole", quiet=True)
    run_until(model, tmp_path / "stopped", 5, monkeypatch)
    resume(tmp_path / "stopped", quiet=True)
    assert_same_results(tmp_path / "whole", tmp_path / "stopped")


@pytest.mark.slow
@pytest.mark.usefixtures("every_loop_in_parallel")
@every_kind
def test_same_bits_for_any_number_of_threads(kind: str) -> None:
    entries = entries_of(kind)
    entries["analysis"]["inertia"]["damping"] = {"stiffness": 1e-4}  # type: ignore[index]
    states = []
    for threads in (1, 2, 4):
        _core.set_threads(threads)
        states.append(fallen(entries, 5))
    for each in states[1:]:
        assert_same_bits(each.state.points, states[0].state.points)
        for name, value in states[0].state.bodies[0].state().items():
            np.testing.assert_array_equal(each.state.bodies[0].state()[name], value, err_msg=name)


@pytest.mark.slow
@every_kind
def test_results_do_not_depend_on_the_units(kind: str) -> None:
    """Powers of 2, for the soil ends on the grid's lines."""
    one = fallen(entries_of(kind), 6)
    other = fallen(entries_of(kind, length=1024.0, time=64.0), 6)
    body, scaled = one.state.bodies[0], other.state.bodies[0]
    np.testing.assert_allclose(scaled.displacement / 1024.0, body.displacement, atol=1e-7)
    moved = one.state.points.displacement[one.state.points.in_order]
    again = other.state.points.displacement[other.state.points.in_order]
    np.testing.assert_allclose(again / 1024.0, moved, atol=1e-6)


@every_kind
def test_free_fall_is_exact(kind: str) -> None:
    """Before it meets the soil, with any steps."""
    simulation = fallen(entries_of(kind, gap=0.5, end=0.05, steps=5))
    body = simulation.state.bodies[0]
    assert body.displacement[-1] == pytest.approx(-0.05 - 0.5 * GRAVITY * 0.05**2, rel=1e-9)
    assert not body.force.any()


def test_a_body_is_at_rest_after_a_step_of_equilibrium() -> None:
    """As in a stage without inertia after one with it; a search at one time changes nothing."""
    body = fallen(falling("plane_strain", gap=0.5), 2).state.bodies[0]
    none = np.zeros(0)
    assert body.inertia is not None
    moving = body.inertia.motion.velocity.copy()
    assert moving[1] < -1.0
    still = np.zeros(int(body.free.sum()))
    body.begin(body.time)
    body.commit(still, np.zeros(2), none)
    np.testing.assert_array_equal(body.inertia.motion.velocity, moving)
    body.begin(body.time + 0.1)
    body.commit(still, np.zeros(2), none)
    assert not body.inertia.motion.velocity.any()


def stated(energies: Energies) -> float:
    """What of the numerical dissipation is stated."""
    return energies.integration + energies.stabilisation + energies.gaps


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["plane_strain", *map(long, ("axisymmetric", "3d"))])
def test_a_weight_that_is_dropped_on_clay_comes_to_rest(kind: str) -> None:
    """The soil then carries its weight; it has spent the energy of the fall on the clay.

    Of that energy a tenth at most is not found in the work and in the impacts, and of the work a
    tenth at most is lost beyond what is stated.
    """
    small = {"steps": 100, **SMALL} if kind == "3d" else {"steps": 200}
    entries = falling(kind, end=0.5, **small)
    entries["loads"][0]["factor"] = [[0.0, 1.0], [0.5, 1.0]]
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    schedule, body = simulation.setup.model.schedule, simulation.state.bodies[0]
    mass, energies = (
        body.declared.mass or 0.0,
        Energies.at_start(simulation.setup, simulation.state),
    )
    start, impacts, force = body.inertia.energy(), 0.0, []
    for number in range(schedule.number_of_steps):
        times = schedule.regular_time(number), schedule.regular_time(number + 1)
        energies.add(simulation.advance(*times))
        force.append(body.force[-1])
        resultant = force[-1] - mass * GRAVITY
        impacts += schedule.first_step**2 * force[-1] * resultant / (2.0 * mass)
    late = force[-len(force) // 4 :]
    assert np.mean(late) == pytest.approx(mass * GRAVITY, rel=0.03)
    assert body.inertia.energy() < 2e-3 * start
    assert -0.5 * RADIUS < body.displacement[-1] < -0.02
    spent = start - body.inertia.energy() - mass * GRAVITY * body.displacement[-1]
    assert energies.work + impacts == pytest.approx(spent, rel=0.1)
    lost = energies.value(
        "numerical_dissipation", simulation.setup, simulation.state, schedule.end
    ) - stated(energies)
    assert -0.02 * energies.work < lost < 0.1 * energies.work


@pytest.mark.slow
@pytest.mark.parametrize(("density", "share"), [long(400.0, 0.3), (800.0, 0.05)])
def test_a_light_body_floats_in_weak_clay(density: float, share: float) -> None:
    """Archimedes: the clay that it displaces weighs as much, but for what the strength can carry.

    That is (2 + pi) s_u times the width, 0.4 of the weight of the lighter body. The heavier one
    comes down with a swing, so that little is left for the strength.
    """
    strength = 100.0
    entries = falling(
        "plane_strain", strength=strength, density=density, velocity=0.0, gap=0.0, end=1.0,
        steps=100, width=0.8, depth=0.6, young=3e5,
    )  # fmt: skip
    entries["analysis"]["inertia"]["damping"] = {"mass": 5.0}
    simulation = fallen(entries)
    depth = -simulation.state.bodies[0].displacement[-1]
    weight = GRAVITY * density * VOLUME["plane_strain"]
    carried = weight - GRAVITY * 1600.0 * segment(depth + rise(simulation))
    assert abs(carried) < (2.0 + np.pi) * strength * 2.0 * RADIUS
    assert abs(carried) < share * weight


def rise(simulation: Simulation) -> float:
    """By how much the surface of the soil beside the body has risen."""
    points = simulation.state.points
    top = points.position[:, 1] - points.displacement[:, 1] > -0.05
    beside = top & (np.abs(points.position[:, 0]) > 0.5)
    return float(points.displacement[beside, 1].mean())


def segment(depth: float) -> float:
    """Area of the segment of a circle up to a depth."""
    angle = np.arccos(np.clip(1.0 - depth / RADIUS, -1.0, 1.0))
    return float(RADIUS**2 * (angle - np.sin(angle) * np.cos(angle)))


@pytest.mark.parametrize("rho", [1.0, 0.5])
def test_an_impact_on_elastic_soil_gains_no_energy(rho: float) -> None:
    """Of the body alone, and of body and soil together."""
    entries = falling("plane_strain", strength=None, young=1e7, rho=rho, end=0.05, steps=20)
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    schedule, body, points = (
        simulation.setup.model.schedule,
        simulation.state.bodies[0],
        simulation.state.points,
    )
    mass = body.declared.mass or 0.0
    totals = []
    for number in range(schedule.number_of_steps):
        simulation.advance(schedule.regular_time(number), schedule.regular_time(number + 1))
        of_soil = points.kinetic_energy(points.mass) + points.stored_energy()
        fallen_by = float(points.mass @ points.displacement[:, 1]) + mass * body.displacement[1]
        totals.append(body.inertia.energy() + of_soil + GRAVITY * fallen_by)
    assert body.force[1] == 0.0 or body.displacement[1] < 0.0
    start = 0.5 * mass
    assert max(totals) < 1.02 * start


@pytest.mark.slow
@pytest.mark.parametrize("strength", [5e3, None])
def test_the_soil_gets_the_energy_that_the_body_loses(strength: float | None) -> None:
    """But for that of the impacts, h^2 F^2 / (2 m) in a step, which Moreau's time stepping loses.

    It gets the work of the body but for that on gaps. Of the work a hundredth at most is lost or
    created beyond what is stated.
    """
    entries = falling("plane_strain", strength=strength, end=0.05) | {"loads": []}
    simulation = Simulation(Model.from_dict(entries))
    simulation.check()
    schedule, body = simulation.setup.model.schedule, simulation.state.bodies[0]
    mass, energies = (
        body.declared.mass or 0.0,
        Energies.at_start(simulation.setup, simulation.state),
    )
    assert body.inertia is not None
    start, impacts = body.inertia.energy(), 0.0
    for number in range(schedule.number_of_steps):
        times = schedule.regular_time(number), schedule.regular_time(number + 1)
        energies.add(simulation.advance(*times))
        impacts += (schedule.first_step * body.force[1]) ** 2 / (2.0 * mass)
    lost = start - body.inertia.energy()
    assert energies.work - energies.gaps + impacts == pytest.approx(lost, rel=0.05)
    numerical = energies.value("numerical_dissipation", simulation.setup, simulation.state, 0.05)
    assert abs(numerical - stated(energies)) < 0.01 * energies.work
