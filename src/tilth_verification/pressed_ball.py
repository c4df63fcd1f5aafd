# SPDX-License-Identifier: BSD-3-Clause
"""A cylinder (de Leeuw 1964) and a ball (Cryer 1963) of clay, pressed and drained at their rims.

The rim cuts the cells of the grid anywhere. The series take the steps of backward Euler as the
analysis does, so that the difference is the error of the grid. Beside them are rows of the usual
practice: no excess pressure at the nodes outside the soil.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tilth.algebra.field import Field, GivenChange
from tilth.analysis.clock import Clock
from tilth.analysis.load_steps import load_steps
from tilth.analysis.pore_pressure import PorePressure
from tilth.analysis.setup import InStep
from tilth.analysis.simulation import Simulation
from tilth.arrays import Floats
from tilth.grid.keys import find_keys
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import example, varied, with_basis
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.radial_consolidation import PressedBall
from tilth_verification.comparison import Comparison, at_least, relative
from tilth_verification.consolidating import conductivity, consolidate

CYLINDER, BALL = "de_leeuw", "cryer"
DIMENSION = {CYLINDER: 2, BALL: 3}
LOAD = 1e-3
"""Pressure on the rim [kPa]: a strain of 1e-6."""
END, STEPS, FIRST = 0.2, 40, 1e-4
"""Time over a^2/c, the steps to it, and the first of them [-]."""
POINTS = 5
"""Per cell and direction. Soil along the rim is whole points: with two of them on eight cells the
moment of inertia is up to 0.7 % wrong, and the peak up to 1.6 and 2.4 % too high."""
TOLERANCES = {7.9: 0.01, 8.3: 0.01, 15.9: 0.003, 16.6: 0.003}
"""By the cells in a radius."""
SOURCE = "series with steps of backward Euler"


def cylinder(long: bool) -> Iterator[Comparison]:
    """Pressures on the axis of the cylinder, on one grid or on all."""
    return _comparisons(CYLINDER, long)


def ball(long: bool) -> Iterator[Comparison]:
    """Pressures at the centre of the ball, on one grid or on all."""
    return _comparisons(BALL, long)


def _comparisons(problem: str, long: bool) -> Iterator[Comparison]:
    cases = [("gimp", 8.3)]
    if long:
        cases = [("gimp", cells) for cells in TOLERANCES]
        cases += [(basis, 8.3) for basis in ("linear", "cpdi1", "cpdi2")]
    for basis, cells in cases:
        yield from on_grid(problem, basis, cells)
    yield usual(problem)


def pressed(problem: str, basis: str, cells: float) -> Model:
    """Returns the soil of case.toml, its rim in chords of half a degree, with so many cells."""
    angle = np.linspace(0.0, 0.5 * np.pi, 181)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    rim[0, 1] = rim[-1, 0] = 0.0
    model = example(problem)
    unit = closed_form(model)[1]
    changes = {
        "grid.cell_size": 1.0 / cells,
        "bodies.0.shape.vertices": [[0.0, 0.0], *rim.tolist()],
        "bodies.0.points_per_cell": POINTS,
        "loads.0.start": [1.0, 0.0],
        "loads.0.end": [0.0, 1.0],
        "loads.0.pressure": LOAD,
        "loads.0.factor": [[0, 1], [unit, 1]],
        "schedule": {"end": unit * END, "steps": STEPS, "first_step_size": unit * FIRST},
        "flow.scheme": "backward_euler",
        "analysis.tolerance": 1e-9,
        "track": [],
    }
    return varied(with_basis(model, basis), changes)


def closed_form(model: Model) -> tuple[PressedBall, float]:
    """Returns the series of a model, and a^2/c [hour]."""
    clay = model.materials["clay"]
    assert isinstance(clay, HenckyElastic)
    unit = 1.0 / (conductivity(model, "clay") * Moduli.of(clay).constrained)
    dim = DIMENSION[CYLINDER if model.analysis.kind == "plane_strain" else BALL]
    return PressedBall(dim, clay.parameter("poisson_ratio")), unit


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns distances from the centre [m] and the excess pressure there by the series [kPa].

    For case.toml, shape (n,) each.
    """
    (exact, unit), radius = closed_form(model), np.linspace(0.0, 1.0, 101)
    return radius, np.array([exact.pressure(float(r), time / unit) for r in radius])


def on_grid(problem: str, basis: str, cells: float) -> Iterator[Comparison]:
    """The peak at the centre and the pressure there at the end, on one grid."""
    model = pressed(problem, basis, cells)
    exact, unit = closed_form(model)
    found = consolidate(model, [[0.0, 0.0]])
    sizes = [size / unit for size in found.steps]
    series = [exact.pressure(0.0, time / unit, sizes[: i + 1]) for i, time in enumerate(found.time)]
    pressure, of = np.array(found.pressure)[:, 0] / LOAD, f"{basis}, h = a/{cells:g}"
    tolerance = TOLERANCES[cells]
    peak, end = float(pressure.max()), float(pressure[-1])
    yield relative(
        f"peak of the pressure at the centre, {of}", peak, max(series), tolerance, SOURCE
    )
    quantity = f"pressure at the centre at T = {END:g}, {of}"
    yield relative(quantity, end, series[-1], tolerance, SOURCE)


class OuterNodes(PorePressure):
    """The excess pore pressure, with none at all nodes outside a circle of radius 1."""

    def in_step(self, of: InStep) -> Field:
        """As `PorePressure.in_step`."""
        field = super().in_step(of)
        outside = np.linalg.norm(of.step.active.position, axis=1)[:, None] > 1.0
        given = GivenChange(outside, np.where(outside, -field.first(), 0.0))
        return replace(field, prescribed=given)


def usual(problem: str) -> Comparison:
    """How much the usual practice errs: the rim is then up to a cell too far away."""
    cells = 8.3
    model = varied(pressed(problem, "gimp", cells), {"flow.boundaries": []})
    exact, unit = closed_form(model)
    simulation = Simulation(model)
    simulation.state.pore_pressure = water = OuterNodes(model)
    sizes, errors = [], []
    for size, result in load_steps(simulation, Clock(model.schedule)):
        sizes.append(size / unit)
        centre = int(np.abs(result.active.position).max(axis=1).argmin())
        key = result.active.key[[centre]]
        found = float(water.value[find_keys(water.key, key)[0], 0]) / LOAD
        errors.append(abs(found - exact.pressure(0.0, result.time / unit, sizes)))
    quantity = (
        f"greatest error over the load with no pressure at the nodes outside, h = a/{cells:g}"
    )
    return at_least(quantity, max(errors[len(errors) // 2 :]), 0.05, 0.0, SOURCE)
