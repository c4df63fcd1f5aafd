# SPDX-License-Identifier: BSD-3-Clause
"""Inertia of a rigid body: derivatives, tops, impact, lasting contact."""

from __future__ import annotations

import numpy as np
import pytest

from tilth.arrays import Floats
from tilth.boundaries.contact.body_inertia import BodyInertia
from tilth.boundaries.contact.rotation import rotation_by
from tilth.terms.inertia import TimeIntegration, TimeStep

NEWMARK = TimeIntegration.newmark()
METHODS = [NEWMARK, TimeIntegration.generalised_alpha(0.7)]
FREE = np.zeros(6)


@pytest.mark.parametrize("method", METHODS)
def test_the_stiffness_is_the_derivative_of_the_force(method: TimeIntegration) -> None:
    random = np.random.default_rng(5)
    body = BodyInertia(3.0, np.array([2.0, 5.0, 7.0]), random.normal(size=3), random.normal(size=3))
    step, rotation = TimeStep(method, 0.3), rotation_by(random.normal(size=3))
    body.motion.acceleration[:] = random.normal(size=6)
    increments, load = 0.3 * random.normal(size=6), random.normal(size=6)
    stiffness = body.stiffness(increments, rotation, load, step)
    for j, unit in enumerate(1e-4 * np.eye(6)):
        ahead = body.contact_force(increments + unit, rotation, load, step)
        behind = body.contact_force(increments - unit, rotation, load, step)
        difference = (ahead - behind) / 2e-4
        np.testing.assert_allclose(stiffness[:, j], difference, rtol=1e-6, atol=1e-5)


def moved(
    body: BodyInertia, rotation: Floats, load: Floats, step: TimeStep
) -> tuple[Floats, Floats]:
    """Takes a step without contact; returns increments and rotation after it."""
    increments = body.guess(rotation, step)
    for _ in range(6):
        force = body.contact_force(increments, rotation, load, step)
        increments -= np.linalg.solve(body.stiffness(increments, rotation, load, step), force)
    body.commit(increments, rotation, load, step)
    return increments, rotation_by(increments[3:]) @ rotation


def top(steps: int, method: TimeIntegration = NEWMARK) -> tuple[float, float, float]:
    """A symmetric top for 3 s: errors of its axis, its angular momentum and its energy.

    Its axis turns about its angular momentum at the rate L / I_1 (Euler's equations).
    """
    moments, spin = np.array([2.0, 2.0, 3.0]), np.array([0.3, 0.0, 2.0])
    momentum = moments * spin
    body = BodyInertia(1.0, moments, np.zeros(3), spin.copy())
    acceleration = -np.cross(spin, momentum) / moments
    body.motion.acceleration[3:] = body.motion.algorithmic[3:] = acceleration
    rotation, energy, step = np.eye(3), body.energy(), TimeStep(method, 3.0 / steps)
    for _ in range(steps):
        _, rotation = moved(body, rotation, FREE, step)
    length = float(np.linalg.norm(momentum))
    turned = rotation_by(momentum / moments[0] * 3.0) @ np.array([0.0, 0.0, 1.0])
    after = rotation @ (moments * body.motion.velocity[3:])
    return (
        float(np.linalg.norm(rotation[:, 2] - turned)),
        float(np.linalg.norm(after - momentum)) / length,
        abs(body.energy() / energy - 1.0),
    )


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_a_symmetric_top_precesses(method: TimeIntegration) -> None:
    """With order 2, keeping angular momentum and energy."""
    coarse, fine = np.array(top(75, method)), np.array(top(150, method))
    assert (fine < [2e-4, 2e-4, 1e-5]).all()
    np.testing.assert_allclose(np.log2(coarse[:2] / fine[:2]), 2.0, atol=0.1)
    assert fine[2] < coarse[2] / 3.5 + 1e-12  # the trapezoidal rule keeps it exactly


@pytest.mark.parametrize("method", METHODS)
def test_free_flight_is_exact(method: TimeIntegration) -> None:
    """The parabola, by steps of several sizes."""
    velocity, weight = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, -20.0, 0.0, 0.0, 0.0])
    body = BodyInertia(2.0, np.ones(3), velocity, np.zeros(3))
    body.motion.acceleration[2] = body.motion.algorithmic[2] = -10.0
    place, time = np.zeros(3), 0.0
    for size in (0.1, 0.3, 0.05):
        increments, _ = moved(body, np.eye(3), weight, TimeStep(method, size))
        place, time = place + increments[:3], time + size
    falling = np.array([0.0, 0.0, -10.0])
    np.testing.assert_allclose(place, velocity * time + 0.5 * falling * time**2, atol=1e-12)
    np.testing.assert_allclose(body.motion.velocity[:3], velocity + falling * time, atol=1e-12)


@pytest.mark.parametrize("method", METHODS)
def test_an_impact_has_no_rebound(method: TimeIntegration) -> None:
    """A body that is held from an instant on is at rest after two steps, with its momentum passed
    on; then the contact carries its weight. The formulas of Newmark alone would reflect it.
    """
    size, weight = 0.01, np.array([-20.0, 0.0])
    body = BodyInertia(2.0, np.ones(1), np.array([-3.0]), np.zeros(1))
    body.motion.acceleration[0] = body.motion.algorithmic[0] = -10.0
    step, still = TimeStep(method, size), np.eye(1)
    impulse, energy = 0.0, [body.energy()]
    for increment in (-0.02, 0.0, 0.0, 0.0):
        increments = np.array([increment, 0.0])
        force = body.contact_force(increments, still, weight, step)
        impulse += size * force[0]
        body.commit(increments, still, weight, step)
        energy.append(body.energy())
    assert force[0] == pytest.approx(20.0)
    assert (np.diff(energy) < 1e-12).all()
    lag = 0.5 * size * 10.0
    assert body.motion.velocity[0] == pytest.approx(-lag)
    assert impulse == pytest.approx(2.0 * (3.0 - lag) + 20.0 * 4 * size)


def test_lasting_contact_is_of_order_2_from_the_start() -> None:
    """A constant force of contact from the start on gives the parabola, however large the steps."""
    body = BodyInertia(2.0, np.ones(1), np.array([1.0]), np.zeros(1))
    load, still, size = np.array([4.0, 0.0]), np.eye(1), 0.1
    first = TimeStep(TimeIntegration.backward_euler(), 1e-4, from_rest=True)
    body.start(np.array([-0.5 * 1e-8, 0.0]), still, load, first, size)
    assert body.contact[0] == pytest.approx(-2.5)
    place = 0.0
    for _ in range(5):
        step = TimeStep(NEWMARK, size)
        increments = body.guess(still, step)
        assert body.contact_force(increments, still, load, step)[0] == pytest.approx(-5.0)
        body.commit(increments, still, load, step)
        place += increments[0]
    assert place == pytest.approx(0.5 - 0.5 * 0.5 * 0.25)


@pytest.mark.parametrize("method", METHODS)
def test_a_free_body_keeps_its_angular_momentum(method: TimeIntegration) -> None:
    """Of any shape and place, in a short step: Euler's I w' = -w x (I w) in the body's frame."""
    moments, spin, size = np.array([2.0, 5.0, 7.0]), np.array([0.5, -1.0, 1.5]), 1e-3
    rotation = rotation_by(np.array([0.3, -0.5, 0.8]))
    body = BodyInertia(3.0, moments, np.zeros(3), spin)
    body.begin(FREE, FREE, rotation, size)
    euler = np.array([-2.0 * -1.5, 5.0 * 0.75, -3.0 * -0.5])  # (I_y - I_z) w_y w_z, ...
    np.testing.assert_allclose(moments * body.motion.acceleration[3:], euler, rtol=1e-12)
    momentum = rotation @ (moments * spin)
    for _ in range(3):
        _, rotation = moved(body, rotation, FREE, TimeStep(method, size))
    after = rotation @ (moments * body.motion.velocity[3:])
    np.testing.assert_allclose(after, momentum, rtol=0, atol=1e-6)
