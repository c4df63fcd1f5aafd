# SPDX-License-Identifier: BSD-3-Clause
"""A rigid cylinder on elastic soil (Hertz)."""

from __future__ import annotations

from collections.abc import Iterator

from tilth.model import HenckyElastic, Model
from tilth.verification.cases import example, varied
from tilth.verification.closed_forms.elastic_contact import (
    HertzCylinder,
    contact_modulus,
)
from tilth.verification.comparison import Comparison, relative
from tilth.verification.contact_runs import fitted_ellipse, run_contact

PROBLEM = "hertz"
RADIUS, CELL = 1.0, 0.025
"""Of the cylinder and of the cells [m]."""
HERTZ = "Hertz"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Half-width and peak pressure of the contact, in the long form also on half the cells."""
    yield from cylinder(CELL)
    if long:
        yield from cylinder(0.5 * CELL)


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
