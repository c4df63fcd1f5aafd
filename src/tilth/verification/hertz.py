# SPDX-License-Identifier: BSD-3-Clause
"""Rigid bodies on elastic soil, and on clay where their contact is flat."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from tilth.model import HenckyElastic, Model
from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.elastic_contact import (
    Cattaneo,
    HertzCylinder,
    HertzSphere,
    contact_modulus,
    sphere_depth,
)
from tilth.verification.closed_forms.limit_loads import CIRCULAR_FOOTING
from tilth.verification.comparison import Comparison, at_least, relative, vanishing
from tilth.verification.contact_runs import ContactRun, fitted_ellipse, run_contact
from tilth.verification.convergence import log_slope

PROBLEM = "hertz"
RADIUS, EXTENT, CELL = 1.0, 4.0, 0.025
"""Of sphere and cylinder, of the soil, and of the cells [m]."""
FRICTION = 0.3
STRENGTH = 10e3
"""s_u of the clay [Pa]."""
HERTZ, IN_CYLINDER = "Hertz", "Hertz in soil 40 a deep and wide"


def comparisons(long: bool) -> Iterator[Comparison]:
    """The cylinder and the circular footing; long: the sphere, Cattaneo and the clay."""
    yield from cylinder(CELL)
    yield from footing("smooth")
    if long:
        yield from footing("rough")
        yield from sphere()
        yield from tangential()
        yield from sphere_on_clay()


def sphere() -> Iterator[Comparison]:
    """Force, peak pressure and radius, by displacement and by force; the order."""
    model = example(PROBLEM)
    exact = HertzSphere(RADIUS, contact_modulus(elastic(model)))
    run = run_contact(model)
    force = -float(run.force["sphere"][-1, 1])
    yield from sphere_rows(exact, model, run, "displacement given")
    pushed = varied(
        model, {"rigid_bodies.0.displacement": None, "rigid_bodies.0.force": {"y": -force}}
    )
    by_force = run_contact(pushed)
    depth, expected = (-float(each.displacement[-1, 1]) for each in (by_force, run))
    quantity = "depth under the force of the run with the displacement given"
    yield relative(quantity, depth, expected, 1e-6, "the other control", "m")
    coarse = run_contact(varied(model, {"grid.cell_size": 2.0 * CELL}))
    sunk = force_in_cylinder(exact, model)
    errors = [abs(-float(each.force["sphere"][-1, 1]) / sunk - 1.0) for each in (coarse, run)]
    order = log_slope(errors[0], errors[1], 2.0)
    quantity = "order of the force, sphere, 4 and 8 cells across"
    yield at_least(quantity, order, 0.8, 0.0, "first order")


def sphere_rows(
    exact: HertzSphere, model: Model, run: ContactRun, label: str
) -> Iterator[Comparison]:
    """Rows: force, peak pressure and radius of the contact."""
    force = -float(run.force["sphere"][-1, 1])
    expected = force_in_cylinder(exact, model)
    yield relative(f"force, sphere, {label}", force, expected, 0.03, IN_CYLINDER, "N")
    state = run.contacts["sphere"]
    peak, width = fitted_ellipse(state, state.position[:, 0])
    yield relative("p0, sphere", peak, exact.peak_pressure(expected), 0.05, HERTZ, "Pa")
    yield relative("a, sphere", width, exact.half_width(expected), 0.05, HERTZ, "m")


def force_in_cylinder(exact: HertzSphere, model: Model) -> float:
    """Returns the force at the sphere's whole displacement in the finite soil [N]."""
    (body,), material = model.rigid_bodies, elastic(model)
    depth = -float((body.displacement or {})["y"])  # type: ignore[arg-type]
    whole = exact.force(depth)
    return float(
        brentq(lambda p: sphere_depth(exact, p, material, EXTENT) - depth, 0.5 * whole, 2.0 * whole)
    )


def cylinder(cell: float) -> Iterator[Comparison]:
    """Rows: half-width and peak pressure under the applied force."""
    model = varied(example(PROBLEM, "cylinder.toml"), {"grid.cell_size": cell})
    exact = HertzCylinder(RADIUS, contact_modulus(elastic(model)))
    run = run_contact(model)
    force = -2.0 * float(run.force["cylinder"][-1, 1])
    state = run.contacts["cylinder"]
    peak, width = fitted_ellipse(state, state.position[:, 0])
    yield relative("p0, cylinder", peak, exact.peak_pressure(force), 0.05, HERTZ, "Pa")
    yield relative("a, cylinder", width, exact.half_width(force), 0.05, HERTZ, "m")
    applied = -2.0 * model.rigid_bodies[0].applied("y", model.schedule.end, model.schedule.end)
    yield relative("force of the soil, cylinder", force, applied, 1e-8, "the applied force", "N")


def tangential() -> Iterator[Comparison]:
    """Row: the shear under a cylinder pushed sideways by half of what makes it slide, in L2."""
    model = example(PROBLEM, "cattaneo.toml")
    exact = Cattaneo(HertzCylinder(RADIUS, contact_modulus(elastic(model))), FRICTION)
    run = run_contact(model)
    across, down = run.force["cylinder"][-1]
    state = run.contacts["cylinder"]
    middle = 1.0 + run.displacement[-1, 0]
    shear = state.shear_stress[:, 0]
    expected = exact.shear(state.position[:, 0] - middle, -float(down), float(across))
    error = np.sqrt(state.weight @ (shear - expected) ** 2 / (state.weight @ expected**2))
    yield vanishing("error of the shear in L2, Cattaneo, a / h 12", float(error), 0.07, "Cattaneo")


def footing(face: str) -> Iterator[Comparison]:
    """Row: the limit load of a circular footing over its area and s_u."""
    model = varied(
        example(PROBLEM, "circular_footing.toml"), {"rigid_bodies.0.contact.tangential": face}
    )
    run = run_contact(model)
    factor = -float(run.force["footing"][:, 1].min()) / (np.pi * 0.5**2 * STRENGTH)
    quantity = f"P / (A s_u), circular footing, {face}, h R/8"
    yield relative(quantity, factor, CIRCULAR_FOOTING[face], 0.05, "slip lines")


def sphere_on_clay() -> Iterator[Comparison]:
    """Row: the mean pressure under a smooth sphere, which is nearly flat, over s_u."""
    run = run_contact(example(PROBLEM, "sphere_on_clay.toml"))
    factor = -float(run.force["sphere"][-1, 1]) / (run.contacts["sphere"].area * STRENGTH)
    quantity = "P / (A s_u), smooth sphere on clay, A of the points in contact"
    yield relative(quantity, factor, CIRCULAR_FOOTING["smooth"], 0.05, "circular footing")


def elastic(model: Model) -> HenckyElastic:
    """Returns the elastic material of a model."""
    material = model.materials["rubber"]
    assert isinstance(material, HenckyElastic)
    return material
