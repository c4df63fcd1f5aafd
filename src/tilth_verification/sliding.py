# SPDX-License-Identifier: BSD-3-Clause
"""The block on an incline with inertia: the way that it slides."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import Model
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, relative, vanishing

FILE = "slide.toml"
GRAVITY, FRICTION = 10.0, 0.3
"""[m/s^2], [-]."""
STEEP, FLAT = 30.0, 10.0
"""Inclines [degrees] on which the block slides, and stays."""


def comparisons(problem: str) -> Iterator[Comparison]:
    """Rows: the way on the steep incline by both schemes; none on the flat one."""
    for scheme in ({"scheme": "generalised_alpha", "spectral_radius": 0.5}, {"scheme": "newmark"}):
        model = varied(example(problem, FILE), {"analysis.inertia": scheme})
        angle, end = math.radians(STEEP), model.schedule.end
        way = 0.5 * GRAVITY * end**2 * (math.sin(angle) - FRICTION * math.cos(angle))
        quantity = f"way on an incline of 30 degrees, {scheme['scheme']}"
        source = "g t^2 (sin - mu cos) / 2"
        yield relative(quantity, slid(inclined(model, STEEP)), way, 0.01, source, "m")
    model = example(problem, FILE)
    way = 0.5 * GRAVITY * model.schedule.end**2 * math.sin(math.radians(FLAT))
    share = slid(inclined(model, FLAT)) / way
    quantity = "way on an incline of 10 degrees over that without friction"
    yield vanishing(quantity, share, 0.01, "tan(theta) < mu; the block is not rigid")


def inclined(model: Model, degrees: float) -> Model:
    """Returns the model on an incline."""
    angle = math.radians(degrees)
    gravity = [GRAVITY * math.sin(angle), -GRAVITY * math.cos(angle)]
    return varied(model, {"loads.0.acceleration": gravity})


def slid(model: Model) -> float:
    """Returns the mean displacement of the block along the incline at the end [m]."""
    found = [0.0]

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        points = simulation.state.points
        found[:] = [float(np.average(points.displacement[:, 0], weights=points.mass))]

    march(model, after_step)
    return found[0]
