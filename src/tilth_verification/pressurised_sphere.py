# SPDX-License-Identifier: BSD-3-Clause
"""Hollow sphere under pressure on its triangulated inner face."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import HenckyElastic
from tilth.surface.tracked_triangles import TrackedSolidSurface
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms.ball import PressurisedShell
from tilth_verification.comparison import Comparison, at_least, relative, vanishing

PROBLEM = "pressurised_sphere"
INNER, OUTER = 1.0, 2.0
"""Radii [m]."""
SMALL_PRESSURE = 1e-4
"""Pressure over Young's modulus at which the closed form of small strains holds to 1e-4."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Displacement of both faces at a small pressure, on finer and finer cells."""
    errors: dict[float, list[float]] = {}
    for h in (0.5, 0.25, 0.125) if long else (0.5, 0.25):
        errors[h] = []
        for name, radius, tolerance in (("inner", INNER, 0.16), ("outer", OUTER, 0.08)):
            moved, closed_form = radial_displacement(h, name, radius)
            errors[h].append(abs(moved / closed_form - 1.0))
            quantity = f"mean radial displacement of the {name} face over pressure, h {h:g} m"
            yield relative(quantity, moved, closed_form, tolerance * h, "Lame", "m")
    sizes = sorted(errors)
    quantity = f"order of the inner face's error from h {sizes[-1]:g} to {sizes[0]:g} m"
    order = np.log2(errors[sizes[-1]][0] / errors[sizes[0]][0]) / (len(sizes) - 1)
    yield at_least(quantity, float(order), 1.0, 0.0, "first order or better")
    yield from follows()


def radial_displacement(h: float, part: str, radius: float) -> tuple[float, float]:
    """Returns the mean radial displacement of a face and that of the closed form [m]."""
    model = example(PROBLEM)
    material = model.materials["wall"]
    assert isinstance(material, HenckyElastic)
    pressure = SMALL_PRESSURE * material.young_modulus
    changes = {"grid.cell_size": h, "loads.0.pressure": pressure, "schedule.steps": 1}
    surface = march(varied(model, {**changes, "schedule.outputs": 1})).state.surfaces["shell"]
    assert isinstance(surface, TrackedSolidSurface)
    now, initial = surface.triangles.current, surface.triangles.initial
    vertex = np.unique(now.triangle[now.in_part(part)])
    outward = initial[vertex] / np.linalg.norm(initial[vertex], axis=1, keepdims=True)
    moved = ((now.vertices - initial)[vertex] * outward).sum(axis=1)
    shell = PressurisedShell(INNER, OUTER, pressure, material)
    return float(moved.mean()), float(shell.displacement(radius))


def follows() -> Iterator[Comparison]:
    """At a tenth of Young's modulus: the area grows, and with it the force; Newton is quadratic."""
    residuals: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        residuals[:] = result.equilibrium.residuals

    surface = march(example(PROBLEM), after_step).state.surfaces["shell"]
    assert isinstance(surface, TrackedSolidSurface)
    now = surface.triangles.current
    force = -now.area_vector[now.in_part("inner")].sum(axis=0)
    radius = np.sqrt(4.0 * np.linalg.norm(force) / np.sqrt(3.0) / np.pi)
    quantity = "radius of the inner face from the resultant of its area, over the initial one"
    yield at_least(quantity, float(radius), 1.05, 0.0, "it widens under the pressure")
    quantity = "last residual over the square of the one before it"
    yield vanishing(quantity, residuals[-1] / residuals[-2] ** 2, 100.0, "quadratic", "")
