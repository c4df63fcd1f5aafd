# SPDX-License-Identifier: BSD-3-Clause
"""Patch test of contact: uniform pressure and shear through a turned boundary across the cells."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from tilth.model import Model
from tilth.verification.cases import example, varied
from tilth.verification.comparison import Comparison, at_least, relative, vanishing
from tilth.verification.contact_runs import run_contact, spread
from tilth.verification.convergence import log_slope

PROBLEM = "contact_patch"
PRESSURE, SHEAR = 1000.0, 300.0
"""On the floor [Pa]."""
LATERAL = PRESSURE * 0.3 / (1.0 - 0.3)
"""Pressure on the sides [Pa] with which the block, nu 0.3, does not widen: the floor holds it."""
SOURCE = "uniform stress"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Mean and spread of pressure and shear at several angles and places; long: more, the order."""
    angles = (0.0, 17.0, 30.0, 45.0) if long else (0.0, 17.0)
    for angle in angles:
        for shift in (0.0, 0.37):
            yield from uniform(turned(example(PROBLEM), angle, shift, 0.125), angle, shift)
    if long:
        sizes = (0.125, 0.0625, 0.03125)
        found = [errors(turned(example(PROBLEM), 17.0, 0.0, size)) for size in sizes]
        for number, name in enumerate(("pressure", "shear")):
            order = log_slope(found[0][number], found[-1][number], sizes[0] / sizes[-1])
            yield at_least(f"order of the spread of the {name}, 17 degrees", order, 0.8, 0.0, "1")


def uniform(model: Model, angle: float, shift: float) -> Iterator[Comparison]:
    """Rows: the resultants, and the spreads of pressure and shear over the floor."""
    label = f"{angle:g} degrees, moved by {shift:g} cells"
    run = run_contact(model)
    normal, tangent = directions(angle)
    force = run.force["floor"][-1]
    for name, along, exact in (("normal", normal, PRESSURE), ("tangential", -tangent, SHEAR)):
        quantity = f"{name} force on the floor, {label}"
        yield relative(quantity, float(force @ along), exact, 1e-8, "equilibrium", "N")
    state = run.contacts["floor"]
    touching = state.in_contact
    weight = state.weight[touching]
    along_floor = -state.shear_stress[touching] @ tangent
    for name, value in (("pressure", -state.normal_stress[touching]), ("shear", along_floor)):
        yield vanishing(f"spread of the {name}, {label}", spread(value, weight), 0.01, SOURCE)


def errors(model: Model) -> tuple[float, float]:
    """Returns the spreads of pressure and shear over the floor [-]."""
    state = run_contact(model).contacts["floor"]
    touching = state.in_contact
    weight = state.weight[touching]
    size = np.linalg.norm(state.shear_stress[touching], axis=1)
    return spread(state.normal_stress[touching], weight), spread(size, weight)


def directions(angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns normal and tangent of the floor at an angle [degrees], shape (2,) each."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return np.array([-s, c]), np.array([c, s])


def turned(model: Model, angle: float, shift: float, cell: float) -> Model:
    """Returns the model at an angle [degrees], moved by a share of its cell along both axes."""
    normal, tangent = directions(angle)
    corner = np.array([0.43, 0.17]) + shift * cell
    a, b, c, d = corner, corner + tangent, corner + tangent + normal, corner + normal
    top = -PRESSURE * normal + SHEAR * tangent
    right = SHEAR * normal - LATERAL * tangent
    changes = {
        "grid.cell_size": cell,
        "bodies.0.shape.lower": a.tolist(),
        "bodies.0.shape.upper": (a + 1.0).tolist(),
        "bodies.0.shape.angle": angle,
        "bodies.0.surface.spacing": 0.5 * cell,
        "boundaries.0.geometry.point": a.tolist(),
        "boundaries.0.geometry.normal": normal.tolist(),
    }
    for number, (start, end, traction) in enumerate(((c, d, top), (b, c, right), (d, a, -right))):
        changes[f"loads.{number}.start"] = start.tolist()
        changes[f"loads.{number}.end"] = end.tolist()
        changes[f"loads.{number}.traction"] = traction.tolist()
    return varied(model, changes)
