# SPDX-License-Identifier: BSD-3-Clause
"""Implicit boundaries in 3D: a cube on an inclined plane, and a ball in a sphere."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import BodyForce, Box, HenckyElastic, ImplicitBoundary, Model, SphereGeometry
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import ConstrainedBall, Moduli
from tilth_verification.comparison import Comparison, at_least, relative, vanishing

BALANCE = "equilibrium"
BALL = "(a^2 - r^2) b / (2 (lambda + 4 mu))"
SQUEEZED = "uniform compression of Hencky material"
SQUEEZE = -0.3
"""Change of the ball's radius [m]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Reaction and moment of the cube; displacement of the ball, and the pressure on it."""
    cube = example("cube_on_inclined_plane")
    for basis, rule in (("linear", None), ("gimp", "right_stretch")):
        changes = {"bodies.0.basis": basis, "bodies.0.domain_update": rule}
        force, moment = unbalanced(varied(cube, changes))
        quantity = f"reaction against the weight, relative, {basis}"
        yield vanishing(quantity, force, 1e-6, BALANCE)
        quantity = f"its moment against the weight's, relative, {basis}"
        # the stored forces of ghost stabilisation have a moment of second order (decision 8)
        yield vanishing(quantity, moment, 1e-5, BALANCE)
    ball = example("cube_on_inclined_plane", "ball_in_sphere.toml")
    sizes = (0.25, 0.125, 0.1) if long else (0.25, 0.125)
    errors = [sag_error(varied(ball, {"grid.cell_size": size})) for size in sizes]
    for size, error, tolerance in zip(sizes, errors, (0.12, 0.03, 0.02), strict=False):
        yield vanishing(f"displacement error, ball, cell {size:g} m", error, tolerance, BALL)
    rate = math.log(errors[0] / errors[-1]) / math.log(sizes[0] / sizes[-1])
    yield at_least("convergence rate of the displacement, ball", rate, 2.0, 0.0, "linear elements")
    quantity = f"pressure on the ball, radius changed by {SQUEEZE:g} m"
    yield relative(quantity, *pressure(squeezed(ball)), 0.01, SQUEEZED, "Pa")


def unbalanced(cube: Model) -> tuple[float, float]:
    """Returns the largest residual force and moment about the lower edge in any step, relative.

    The weight's moment is that of the points at their current positions.
    """
    plane, load, material = cube.boundaries[0], cube.loads[0], cube.materials["soil"]
    box = cube.bodies[0].shape
    assert isinstance(box, Box)
    assert isinstance(plane, ImplicitBoundary)
    assert isinstance(load, BodyForce)
    assert material.density is not None
    edge = np.array(box.lower) + (box.upper[0] - box.lower[0]) * np.array(box.axes[0])
    density, gravity = material.density, np.array(load.acceleration)
    residuals = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        points = simulation.state.points
        weight = time * density * points.initial_volume[:, None] * gravity
        turning = np.cross(points.position - edge, weight).sum(axis=0)
        total = weight.sum(axis=0)
        force = np.linalg.norm(result.resultant(plane.name) + total) / np.linalg.norm(total)
        moment = np.linalg.norm(result.moment(plane.name, edge) + turning)
        residuals.append((force, moment / np.linalg.norm(turning)))

    march(cube, after_step)
    force, moment = np.max(residuals, axis=0)
    return float(force), float(moment)


def sag_error(ball: Model) -> float:
    """Returns the relative RMS error of the points' displacement [-]."""
    load, material = ball.loads[0], ball.materials["soil"]
    assert isinstance(load, BodyForce)
    assert isinstance(material, HenckyElastic)
    assert material.density is not None
    sphere = sphere_of(ball)
    weight = material.density * np.array(load.acceleration)
    points = march(ball).state.points
    form = ConstrainedBall(sphere.centre, sphere.radius, tuple(weight), material)
    exact, volume = form.displacement(initial_position(points)), points.initial_volume
    squared_error = ((points.displacement - exact) ** 2).sum(axis=1) @ volume
    return math.sqrt(squared_error / ((exact**2).sum(axis=1) @ volume))


def squeezed(ball: Model) -> Model:
    """Returns the ball without weight, its surface moved inwards in two steps, on a coarse grid."""
    changes = {
        "loads": [],
        "boundaries.0.radius_change": SQUEEZE,
        "bodies.0.points_per_cell": 3,
        "grid.cell_size": 0.25,
        "schedule.steps": 2,
    }
    return varied(ball, changes)


def pressure(ball: Model) -> tuple[float, float]:
    """Returns the mean pressure on a squeezed ball, computed and exact [stress].

    The integral of traction times position is three times pressure times volume; the nodal forces
    give it exactly.
    """
    sphere, shell, material = sphere_of(ball), ball.boundaries[0], ball.materials["soil"]
    assert isinstance(shell, ImplicitBoundary)
    assert shell.radius_change is not None
    assert isinstance(material, HenckyElastic)
    stretch = 1.0 + shell.radius_change / sphere.radius
    volume = 4.0 / 3.0 * math.pi * (stretch * sphere.radius) ** 3
    found = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        position = result.active.position + result.equilibrium.displacement
        arm = position - np.array(sphere.centre)
        found.append(-float((result.forces[shell.name] * arm).sum()) / (3.0 * volume))

    march(ball, after_step)
    exact = -3.0 * Moduli.of(material).bulk * math.log(stretch) / stretch**3
    return found[-1], exact


def sphere_of(ball: Model) -> SphereGeometry:
    """Returns the sphere around the ball."""
    shell = ball.boundaries[0]
    assert isinstance(shell, ImplicitBoundary)
    assert isinstance(shell.geometry, SphereGeometry)
    return shell.geometry
