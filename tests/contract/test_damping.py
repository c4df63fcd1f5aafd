# SPDX-License-Identifier: BSD-3-Clause
"""Damping proportional to the elastic stiffness: derivative, rotation, decay, dissipated energy."""

from __future__ import annotations

import numpy as np
import pytest
from contact_terms import product
from small_problems import KINDS, Laboratory, block_entries

from tilth.analysis.energies import Energies
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.model import Model
from tilth.terms.balance import Balance
from tilth.terms.stiffness_damping import AssembledStiffnessDamping, StiffnessDamping

LENGTH, SPEED, DENSITY = 1.0, 100.0, 1e3
PERIOD = 4.0 * LENGTH / SPEED
OMEGA = 2.0 * np.pi / PERIOD


def damped(kind: str, anti_locking: str = "none") -> Balance:
    """The term alone, on deformed plastic soil."""
    random = np.random.default_rng(4)
    (body,) = block_entries(kind, "gimp", "von_mises")["bodies"]
    bodies = [body | {"anti_locking": anti_locking}]
    laboratory = Laboratory.of(kind, "gimp", "von_mises", random, bodies=bodies)
    for _ in range(3):
        laboratory.step(laboratory.random_displacement(random, 0.03))
    return Balance(laboratory.active, [StiffnessDamping(laboratory.soil, 0.02, 0.1)])


@pytest.mark.parametrize("anti_locking", ["none", "f_bar"])
@pytest.mark.parametrize("kind", KINDS)
def test_the_stiffness_of_damping_is_the_derivative_of_its_force(
    kind: str, anti_locking: str
) -> None:
    balance = damped(kind, anti_locking)
    (term,) = balance.terms
    random = np.random.default_rng(2)
    shape = (balance.active.nodes, balance.active.grid.dim)
    u, way = 0.02 * random.normal(size=shape), random.normal(size=shape)
    blocks = np.zeros((len(balance.active.column), shape[1], shape[1]))
    term.force(u)
    term.add_stiffness(u, blocks)
    ahead, behind = term.force(u + 1e-6 * way), term.force(u - 1e-6 * way)
    difference = (ahead - behind) / 2e-6
    found = product(balance, blocks, way)
    np.testing.assert_allclose(found, difference, rtol=0, atol=1e-7 * np.abs(difference).max())


@pytest.mark.parametrize("kind", ["plane_strain", "3d"])
def test_a_rotation_is_not_damped(kind: str) -> None:
    balance = damped(kind)
    (term,) = balance.terms
    position, angle = balance.active.position, 0.4
    turn = np.eye(position.shape[1])
    turn[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    rotation = position @ turn.T - position
    strain = 0.4 * position
    largest = np.abs(term.force(strain)).max()
    assert np.abs(term.force(rotation)).max() < 1e-12 * largest


@pytest.mark.parametrize("kind", KINDS)
def test_a_stretch_is_resisted_by_its_rate(kind: str) -> None:
    """The work of a small uniform stretch e along the last axis is (factor / h) M e^2 V."""
    laboratory = Laboratory.of(kind, "gimp", "hencky_elastic", np.random.default_rng(4))
    points, active, strain = laboratory.points, laboratory.active, 1e-6
    moduli, u = points.elastic_moduli(), np.zeros(active.position.shape)
    u[:, -1] = strain * active.position[:, -1]
    constrained = (moduli.bulk + 4.0 / 3.0 * moduli.shear) @ points.volume
    for factor, size in ((0.02, 0.1), (0.02, 0.025), (0.5, 4.0)):
        (term,) = Balance(active, [StiffnessDamping(laboratory.soil, factor, size)]).terms
        assert isinstance(term, AssembledStiffnessDamping)
        expected = factor / size * constrained * strain**2
        assert term.damping_work(u) == pytest.approx(expected, rel=1e-5)


def bar(damping: dict[str, float], cells: int = 10, steps: int = 80) -> Simulation:
    """A fixed-free bar that begins with the velocity of its first mode."""
    model = Model.from_dict(
        {
            "units": {"time": "s"},
            "analysis": {
                "kind": "plane_strain", "tolerance": 1e-10,
                "inertia": {"scheme": "newmark", "damping": damping},
            },
            "grid": {"cell_size": LENGTH / cells},
            "materials": {
                "steel": {"model": "hencky_elastic", "young_modulus": DENSITY * SPEED**2,
                          "poisson_ratio": 0.0, "density": DENSITY}
            },
            "bodies": [
                {"name": "bar", "material": "steel", "basis": "linear", "points_per_cell": 2,
                 "shape": {"type": "box", "lower": [0.0, 0.0], "upper": [LENGTH, LENGTH / cells]}}
            ],
            "boundaries": [
                {"name": "end", "type": "plane", "axis": "x", "at": 0.0, "condition": "roller"}
            ],
            "schedule": {"end": 4.0 * PERIOD, "steps": 4 * steps},
        }
    )  # fmt: skip
    simulation = Simulation(model)
    points = simulation.state.points
    points.motion[:, 0, 0] = 1e-5 * np.sin(0.5 * np.pi * points.position[:, 0] / LENGTH)
    return simulation


def damping_ratio(value: Floats) -> float:
    """That of a decaying vibration by the logarithmic decrement of its extremes."""
    size, peaks = np.abs(value), []
    for a, b, c in zip(size, size[1:], size[2:], strict=False):
        if b > a and b >= c:  # the vertex of the parabola through them
            peaks.append(b + 0.125 * (a - c) ** 2 / (2.0 * b - a - c))
    decrement = np.log(peaks[0] / peaks[-1]) / (len(peaks) - 1) / np.pi  # of half a period
    return float(decrement / np.sqrt(1.0 + decrement**2))


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "stiffness"), [(0.0, 0.05), (0.05, 0.0), (0.03, 0.02)])
def test_a_bar_has_its_damping_ratio(mass: float, stiffness: float) -> None:
    """Of the first mode: mass / (2 omega) + stiffness omega / 2, within 1 % at 80 steps."""
    damping = {"mass": 2.0 * mass * OMEGA, "stiffness": 2.0 * stiffness / OMEGA}
    simulation = bar(damping)
    points, schedule = simulation.state.points, simulation.setup.model.schedule
    tip = points.point_id[[points.position[:, 0].argmax()]]
    energies, moved = Energies.at_start(simulation.setup, simulation.state), [0.0]
    for number in range(schedule.steps or 0):
        times = schedule.regular_time(number), schedule.regular_time(number + 1)
        energies.add(simulation.advance(*times))
        moved.append(float(points.displacement[points.index_of(tip)[0], 0]))
    assert damping_ratio(np.array(moved)) == pytest.approx(mass + stiffness, rel=0.01)
    lost = energies.value("numerical_dissipation", simulation.setup, simulation.state, 0.0)
    assert abs(lost) < 0.01 * energies.start
    left = points.stored_energy() + points.kinetic_energy(points.mass)
    assert energies.damping == pytest.approx(energies.start - left, rel=0.01)
