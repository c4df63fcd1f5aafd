# SPDX-License-Identifier: BSD-3-Clause
"""A rigid sphere and a rigid cylinder on an inclined base of stiff soil: they roll, or slip."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative

PROBLEM = "rolling_sphere"
GRAVITY, FRICTION, RADIUS = 10.0, 0.3, 0.3
"""[m/s^2], [-], [m]."""
TOLERANCE = 0.01
ROLLS, SLIPS = 20.0, 60.0
"""Inclines [degrees] at which they roll, and slip."""
SHARE = {"case.toml": 0.4, "circle.toml": 0.5}
"""Moment of inertia over mass times radius squared, of the sphere and of the cylinder."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Distance and turn of the sphere that rolls and of the one that slips; of the cylinder.

    In the long form also distances on both sides of the incline from which they slip, where they
    tell one from the other, and half the step. The turn is not compared there: what friction loses
    in the impacts of the start is 1 to 3 % of it.
    """
    for file in SHARE:
        yield from rows(file, ROLLS)
        yield from rows(file, SLIPS)
    if long:
        for file, share in SHARE.items():
            limit = (1.0 + 1.0 / share) * FRICTION
            for factor in (0.9, 1.1):
                yield next(rows(file, math.degrees(math.atan(factor * limit))))
            yield from rows(file, ROLLS, 120)
            yield from rows(file, SLIPS, 120)


def rows(file: str, degrees: float, steps: int = 60) -> Iterator[Comparison]:
    """Rows: distance, and turn times radius over the distance, on an incline."""
    model = inclined(example(PROBLEM, file), degrees, steps)
    share, end = SHARE[file], model.schedule.end
    name = model.rigid_bodies[0].name
    acceleration, spin = exact(degrees, share)
    distance, turn = moved(model)
    label = f"{name}, {degrees:.3g} degrees, {steps} steps"
    source = "slips" if slips(degrees, share) else "rolls"
    way = 0.5 * acceleration * end**2
    yield relative(f"distance, {label}", distance, way, TOLERANCE, source, "m")
    ratio = spin / acceleration
    quantity = f"turn times radius over distance, {label}"
    yield relative(quantity, turn * RADIUS / distance, ratio, TOLERANCE, source)


def inclined(model: Model, degrees: float, steps: int) -> Model:
    """Returns the model on an incline, in a number of steps."""
    angle = math.radians(degrees)
    gravity = np.zeros(model.dimension)
    gravity[0], gravity[-1] = GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle)
    changes = {"loads.0.acceleration": gravity.tolist(), "schedule.steps": steps}
    return varied(model, changes)


def slips(degrees: float, share: float) -> bool:
    """Returns whether it slips: from tan = (1 + 1/share) mu on, 3.5 mu for a sphere."""
    return math.tan(math.radians(degrees)) > (1.0 + 1.0 / share) * FRICTION


def exact(degrees: float, share: float) -> tuple[float, float]:
    """Returns acceleration and angular acceleration times the radius [m/s^2]."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
    if slips(degrees, share):
        return GRAVITY * (sine - FRICTION * cosine), GRAVITY * FRICTION * cosine / share
    rolling = GRAVITY * sine / (1.0 + share)
    return rolling, rolling


def moved(model: Model) -> tuple[float, float]:
    """Returns distance [m] and turn [rad] of the body at the end."""
    name, found = model.rigid_bodies[0].name, [0.0, 0.0]

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        body = simulation.state.rigid_bodies[name]
        turn = body.rotation[1] if model.dimension == 3 else -body.rotation[2]
        found[:] = [float(body.displacement[0]), float(turn)]

    march(model, after_step)
    return found[0], found[1]
