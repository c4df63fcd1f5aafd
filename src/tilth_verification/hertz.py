# SPDX-License-Identifier: BSD-3-Clause
"""A rigid cylinder and a rigid sphere on elastic soil (Hertz); circular footing, sphere on clay."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import example, varied
from tilth_verification.cattaneo import drawn_cylinder
from tilth_verification.closed_forms.elastic_contact import (
    HertzCylinder,
    HertzSphere,
    contact_modulus,
    sphere_depth,
)
from tilth_verification.closed_forms.limit_loads import CIRCULAR_FOOTING, shallow_sphere
from tilth_verification.comparison import Comparison, at_least, relative
from tilth_verification.contact_runs import ContactRun, fitted_ellipse, run_contact
from tilth_verification.convergence import log_slope

PROBLEM = "hertz"
RADIUS, SPHERE_RADIUS, EXTENT, CELL = 1.0, 5.0, 4.0, 0.025
"""Of the cylinder, of the sphere, of the soil around it, and of the cells [m]."""
FOOTING_RADIUS, CLAY_SPHERE_RADIUS, STRENGTH = 0.5, 3.0, 10e3
"""Of the circular footing and of the sphere on clay [m]; s_u of the clay [Pa]."""
LATE = 0.75
"""Share of its last radius from which on the contact of the sphere on clay counts."""
HERTZ, FINITE = "Hertz", "Hertz, less the depth lost in finite soil"
SLIP_LINES = "slip lines, a / R as in the run"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Half-width and peak pressure under the cylinder; smooth footing and smooth sphere on clay.

    In the long form also the rough ones, the sphere on elastic soil, the cylinder on half the
    cells, and the cylinder that is pressed and drawn.
    """
    yield from cylinder(CELL)
    yield from footing("smooth")
    yield from sphere_on_clay("smooth", long)
    if long:
        yield from sphere_on_clay("rough", long)
        yield from footing("rough")
        yield from cylinder(0.5 * CELL)
        yield from sphere()
        yield from drawn_cylinder()


def sphere() -> Iterator[Comparison]:
    """Rows: force, peak pressure and radius of the contact; the order; both controls the same."""
    model = example(PROBLEM, "sphere.toml")
    exact = HertzSphere(SPHERE_RADIUS, contact_modulus(elastic(model)))
    run = run_contact(model)
    force, depth = -float(run.force["sphere"][-1, 1]), -float(run.displacement[-1, 1])
    expected = force_at(exact, model, depth)
    yield relative("force, sphere", force, expected, 0.03, FINITE, "N")
    state = run.contacts["sphere"]
    peak, width = fitted_ellipse(state, state.position[:, 0])
    yield relative("p0, sphere", peak, exact.peak_pressure(expected), 0.05, HERTZ, "Pa")
    yield relative("a, sphere", width, exact.half_width(expected), 0.05, HERTZ, "m")
    coarse = run_contact(varied(model, {"grid.cell_size": 2.0 * CELL}))
    errors = [float(np.abs(force_errors(each, exact, model)).mean()) for each in (coarse, run)]
    order = log_slope(errors[0], errors[1], 2.0)
    quantity = "order of the force's mean error, sphere, 4 and 8 cells across"
    yield at_least(quantity, order, 1.0, 0.0, "first order")
    change = {"rigid_bodies.0.displacement": None, "rigid_bodies.0.force": {"y": -force}}
    pushed = run_contact(varied(model, change))
    quantity = "depth of the sphere under that force, in proportional steps"
    reached = -float(pushed.displacement[-1, 1])
    yield relative(quantity, reached, depth, 1e-3, "displacement given", "m")


def force_at(exact: HertzSphere, model: Model, depth: float) -> float:
    """Returns the force on the sphere at a depth [length] in the finite soil [N]."""
    material, whole = elastic(model), exact.force(depth)

    def too_deep(force: float) -> float:
        return sphere_depth(exact, force, material, EXTENT) - depth

    return float(brentq(too_deep, 0.5 * whole, 2.0 * whole))


def force_errors(run: ContactRun, exact: HertzSphere, model: Model) -> Floats:
    """Returns the relative errors of the force in the second half of a run's steps, shape (k,)."""
    half = len(run.time) // 2
    depth, force = -run.displacement[half:, 1], -run.force["sphere"][half:, 1]
    expected = np.array([force_at(exact, model, float(each)) for each in depth])
    return np.asarray(force / expected - 1.0)


def footing(face: str) -> Iterator[Comparison]:
    """Row: the mean pressure under a circular footing at its limit load, 12 mm deep, over s_u."""
    changes = {"rigid_bodies.0.contact.tangential": face}
    run = run_contact(varied(example(PROBLEM, "circular_footing.toml"), changes))
    factor = -float(run.force["footing"][-1, 1]) / (np.pi * FOOTING_RADIUS**2 * STRENGTH)
    quantity = f"P / (A s_u), circular footing, {face}, h R/8.5"
    yield relative(quantity, factor, CIRCULAR_FOOTING[face], 0.05, "slip lines")


def sphere_on_clay(face: str, long: bool) -> Iterator[Comparison]:
    """Rows: the factor of a smooth sphere on cells of a/8 against that of slip lines.

    In the long form, smooth or rough, that on cells of a/12 against slip lines and a flat footing;
    the coarse cells against these; steps halved; under a force in place of the displacement.
    """
    fine = varied(
        example(PROBLEM, "sphere_on_clay.toml"), {"rigid_bodies.0.contact.tangential": face}
    )
    coarse = varied(fine, {"grid.cell_size": 1.5 * CELL})
    run = run_contact(coarse)
    quantity = f"P / (pi a^2 s_u), {face} sphere on clay, h a/"
    on_coarse, expected = factors(run, face)
    if face == "smooth":
        yield relative(f"{quantity}8", on_coarse, expected, 0.05, SLIP_LINES)
    if not long:
        return
    factor, expected = factors(run_contact(fine), face)
    yield relative(f"{quantity}12", factor, expected, 0.05, SLIP_LINES)
    yield relative(f"{quantity}12", factor, CIRCULAR_FOOTING[face], 0.05, "flat footing")
    yield relative(f"{quantity}8", on_coarse, factor, 0.03, "h a/12")
    halved, _ = factors(run_contact(varied(coarse, {"schedule.steps": 80})), face)
    yield relative(f"{quantity}8, steps halved", halved, on_coarse, 0.02, "whole steps")
    force, depth = -float(run.force["sphere"][-1, 1]), -float(run.displacement[-1, 1])
    control = {"rigid_bodies.0.displacement": None, "rigid_bodies.0.force": {"y": -force}}
    reached = -float(run_contact(varied(coarse, control)).displacement[-1, 1])
    quantity = f"depth of the {face} sphere on clay under that force"
    yield relative(quantity, reached, depth, 0.02, "displacement given", "m")


def factors(run: ContactRun, face: str) -> tuple[float, float]:
    """Returns the mean P / (pi a^2 s_u) of the late steps, and that of slip lines at their a / R.

    pi a^2 is the circle at the rim of the cap that is in contact. Its radius grows cell by cell;
    the mean is over the last quarter of it.
    """
    circle = run.area - run.area**2 / (4.0 * np.pi * CLAY_SPHERE_RADIUS**2)
    late = circle > LATE**2 * circle[-1]
    force = -float(run.force["sphere"][late, 1].mean())
    area = float(circle[late].mean())
    ratio = float(np.sqrt(area / np.pi)) / CLAY_SPHERE_RADIUS
    return force / (area * STRENGTH), shallow_sphere(ratio, face)


def cylinder(cell: float) -> Iterator[Comparison]:
    """Rows: half-width and peak pressure under the applied force."""
    model = varied(example(PROBLEM), {"grid.cell_size": cell})
    exact = HertzCylinder(RADIUS, contact_modulus(elastic(model)))
    run = run_contact(model)
    force = -2.0 * float(run.force["cylinder"][-1, 1])
    state = run.contacts["cylinder"]
    peak, width = fitted_ellipse(state, state.position[:, 0])
    yield relative("p0, cylinder", peak, exact.peak_pressure(force), 0.05, HERTZ, "Pa")
    yield relative("a, cylinder", width, exact.half_width(force), 0.05, HERTZ, "m")
    applied = -2.0 * model.rigid_bodies[0].applied("y", model.schedule.end, model.schedule.end)
    yield relative("force of the soil, cylinder", force, applied, 1e-8, "the applied force", "N")


def elastic(model: Model) -> HenckyElastic:
    """Returns the elastic material of a model."""
    material = model.materials["rubber"]
    assert isinstance(material, HenckyElastic)
    return material
