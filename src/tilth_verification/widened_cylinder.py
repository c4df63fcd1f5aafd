# SPDX-License-Identifier: BSD-3-Clause
"""A thick cylinder widened to twice its inner radius by an implicit boundary, at large strain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.boundaries.surfaces.boundary import Implicit
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import WidenedCylinder
from tilth_verification.comparison import Comparison, at_least, relative, vanishing

SOURCE = "equilibrium of rings of Hencky material"
INNER, OUTER = 1.0, 2.0
CELLS = 10
STEP = 0.05
"""Displacement of the inner face in one step [m]; that of the nearly incompressible one below."""
WIDENINGS = (0.1, 0.25, 0.5, 1.0)
"""Displacements of the inner face at which pressure and outer displacement are compared [m]."""
NEARLY_INCOMPRESSIBLE, FINE_STEP = 0.49, 0.01
LOCKED_CELLS, LOCKED_STEP = 5, 0.1
"""Through the wall, and displacement in the only step [m], where the standard method locks."""
LINEAR_POINTS = 8
"""Points per cell and direction of the linear basis, whose points are crude quadrature."""


@dataclass(frozen=True)
class Outcome:
    """The state when the inner face has moved by `widening` [length]."""

    widening: float
    pressure: float
    outer_displacement: float
    outer_traction: float
    displacement_error: float
    exact: WidenedCylinder

    @property
    def pressure_error(self) -> float:
        """Relative error of the pressure."""
        return abs(self.pressure / self.exact.pressure - 1.0)

    @property
    def outer_error(self) -> float:
        """Relative error of the outer displacement."""
        return abs(self.outer_displacement / self.exact.outer_displacement - 1.0)


def comparisons(long: bool) -> Iterator[Comparison]:
    """Pressure and outer displacement, plane strain and axisymmetric; outer face driven too."""
    quarter, ring = example("thick_cylinder", "widened.toml"), axisymmetric(CELLS)
    for nu in (0.3, 0.0, NEARLY_INCOMPRESSIBLE):
        for outcome in solve(with_poisson_ratio(quarter, nu), widenings(nu)):
            at = f"nu {nu:g}, inner face moved by {outcome.widening:g}"
            yield pressure_row(f"pressure, {at}", outcome)
            yield outer_row(f"outer displacement, {at}", outcome)
    yield from linear_basis(quarter)
    yield from convergence(quarter, long)
    for outcome in solve(with_outer_face(quarter), WIDENINGS):
        at = f"both faces moved, inner one by {outcome.widening:g}"
        yield pressure_row(f"pressure, {at}", outcome)
        share = outcome.outer_traction / outcome.exact.pressure
        yield vanishing(f"outer traction over pressure, {at}", share, 0.01, SOURCE)
    for nu in (0.3, 0.0, NEARLY_INCOMPRESSIBLE):
        outcomes = solve(with_poisson_ratio(ring, nu), widenings(nu))
        worst = max(outcome.pressure_error for outcome in outcomes)
        yield vanishing(
            f"largest error of the pressure, axisymmetric, nu {nu:g}", worst, 2e-3, SOURCE
        )
        worst = max(outcome.outer_error for outcome in outcomes)
        quantity = f"largest error of the outer displacement, axisymmetric, nu {nu:g}"
        yield vanishing(quantity, worst, 1e-3, SOURCE)
    yield from assumed_strain(quarter, ring)
    outcomes = solve(with_outer_face(ring), WIDENINGS)
    worst = max(abs(o.outer_traction) / o.exact.pressure for o in outcomes)
    quantity = "outer traction over pressure, axisymmetric, both faces moved"
    yield vanishing(quantity, worst, 1e-3, SOURCE)


def pressure_row(quantity: str, outcome: Outcome) -> Comparison:
    """Returns a row: the pressure within 1 %."""
    return relative(quantity, outcome.pressure, outcome.exact.pressure, 0.01, SOURCE, "Pa")


def outer_row(quantity: str, outcome: Outcome) -> Comparison:
    """Returns a row: the outer displacement within 1 %."""
    computed, exact = outcome.outer_displacement, outcome.exact.outer_displacement
    return relative(quantity, computed, exact, 0.01, SOURCE, "m")


def linear_basis(quarter: Model) -> Iterator[Comparison]:
    """Standard MPM, up to the widening at which its points are still good quadrature."""
    changes = {
        "bodies.0.basis": "linear",
        "bodies.0.domain_update": None,
        "bodies.0.points_per_cell": LINEAR_POINTS,
    }
    for outcome in solve(varied(quarter, changes), WIDENINGS[:3]):
        at = f"linear, inner face moved by {outcome.widening:g}"
        yield pressure_row(f"pressure, {at}", outcome)
        yield outer_row(f"outer displacement, {at}", outcome)


def assumed_strain(quarter: Model, ring: Model) -> Iterator[Comparison]:
    """F-bar at nu 0.49: the same numbers within 1 %, in axisymmetry after long steps too."""
    nu, method = NEARLY_INCOMPRESSIBLE, {"bodies.0.anti_locking": "f_bar"}
    for kind, model, step in (("plane strain", quarter, FINE_STEP), ("axisymmetric", ring, STEP)):
        for outcome in solve(with_poisson_ratio(varied(model, method), nu), widenings(nu), step):
            at = f"F-bar, {kind}, nu {nu:g}, inner face moved by {outcome.widening:g}"
            yield pressure_row(f"pressure, {at}", outcome)
            yield outer_row(f"outer displacement, {at}", outcome)
    coarse = with_poisson_ratio(axisymmetric(LOCKED_CELLS), nu)
    coarse = varied(coarse, {"bodies.0.basis": "linear", "bodies.0.domain_update": None})
    at = f"linear, axisymmetric, {LOCKED_CELLS} cells, nu {nu:g}, one step of {LOCKED_STEP:g}"
    requested = (LOCKED_STEP,)
    locked = solve(coarse, requested, LOCKED_STEP)[0]
    yield at_least(f"error of the pressure, {at}", locked.pressure_error, 0.04, 0.0, "it locks")
    yield pressure_row(
        f"pressure, F-bar, {at}", solve(varied(coarse, method), requested, LOCKED_STEP)[0]
    )


def convergence(quarter: Model, long: bool) -> Iterator[Comparison]:
    """Rates from 5 cells through the wall on, at the least widening, where errors are largest."""
    cells = (5, 10, 20) if long else (5, 10)
    least = WIDENINGS[:1]
    for name, make in (
        ("plane strain", lambda n: refined(quarter, n)),
        ("axisymmetric", axisymmetric),
    ):
        coarse, *_, fine = (solve(make(n), least)[0] for n in cells)
        halvings = math.log2(cells[-1] / cells[0])
        for quantity in ("displacement", "pressure"):
            error = [getattr(outcome, f"{quantity}_error") for outcome in (coarse, fine)]
            rate = math.log2(error[0] / error[1]) / halvings
            at = f"{name}, {cells[0]} to {cells[-1]} cells"
            yield at_least(f"rate of the {quantity}, {at}", rate, 1.0, 0.0, "first order at least")


def widenings(nu: float) -> Sequence[float]:
    """Returns the widenings for which a Poisson's ratio has reference numbers."""
    return WIDENINGS[:3] if nu == NEARLY_INCOMPRESSIBLE else WIDENINGS


def with_poisson_ratio(model: Model, nu: float) -> Model:
    """Returns the model with another Poisson's ratio."""
    return varied(model, {"materials.rubber.poisson_ratio": nu})


def refined(quarter: Model, cells: int) -> Model:
    """Returns the quarter with this number of cells through its wall."""
    size = (OUTER - INNER) / cells
    return varied(quarter, {"grid.cell_size": size, "grid.origin": [-0.5 * size, -0.5 * size]})


def axisymmetric(cells: int) -> Model:
    """Returns the axisymmetric case with this number of cells through the wall, one high."""
    size = (OUTER - INNER) / cells
    changes = {
        "grid.cell_size": size,
        "grid.origin": [INNER - 0.3 * size, 0.0],
        "bodies.0.shape.upper": [OUTER, size],
        "bodies.0.points": [3 * cells, 3],
        "boundaries.2.at": size,
    }
    return varied(example("thick_cylinder", "widened_axisymmetric.toml"), changes)


def elastic(model: Model) -> HenckyElastic:
    """Returns the material of the wall."""
    material = model.materials["rubber"]
    assert isinstance(material, HenckyElastic)
    return material


@cache
def closed_form(material: HenckyElastic, widening: float) -> WidenedCylinder:
    """Returns the closed form; cached, as each is used many times."""
    return WidenedCylinder(INNER, OUTER, widening, material)


def with_outer_face(model: Model) -> Model:
    """Returns the model with an implicit boundary that moves as the free outer face would."""
    material = elastic(model)
    last = max(WIDENINGS)
    steps = round(last / STEP)
    moved = [0.0]
    moved += [
        closed_form(material, last * (step + 1) / steps).outer_displacement for step in range(steps)
    ]
    face: dict[str, Any] = {"type": "implicit", "name": "outer face", "condition": "roller"}
    face["factor"] = [[step / steps, u / moved[-1]] for step, u in enumerate(moved)]
    if model.analysis.kind == "axisymmetric":
        face["geometry"] = {"type": "plane", "point": [OUTER, 0.0], "normal": [-1.0, 0.0]}
        face["displacement"] = {"x": moved[-1]}
    else:
        circle = {"type": "circle", "centre": [0.0, 0.0], "radius": OUTER, "soil": "inside"}
        face |= {"geometry": circle, "radius_change": moved[-1]}
    entries = model.to_dict()
    entries["boundaries"].append(face)
    return Model.from_dict(entries)


def solve(model: Model, requested: Sequence[float], step: float | None = None) -> list[Outcome]:
    """Widens a cylinder; returns its state at the requested widenings.

    step: displacement of the inner face in a load step [m]; if not given, by Poisson's ratio.
    """
    ring = model.analysis.kind == "axisymmetric"
    nu = elastic(model).poisson_ratio
    if step is None:
        step = FINE_STEP if nu == NEARLY_INCOMPRESSIBLE else STEP
    steps = round(max(requested) / step)
    key = "displacement.x" if ring else "radius_change"
    changes: dict[str, Any] = {f"boundaries.0.{key}": max(requested)}
    changes |= {"schedule.steps": steps, "schedule.outputs": 1}
    outcomes = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        widening = max(requested) * time
        for each in requested:
            if math.isclose(each, widening, rel_tol=1e-9):
                outcomes.append(state(simulation, result, each))

    march(varied(model, changes), after_step)
    return outcomes


def state(simulation: Simulation, result: StepResult, widening: float) -> Outcome:
    """Returns the outcome of a widened cylinder in its current state."""
    model, points = simulation.setup.model, simulation.state.points
    ring = model.analysis.kind == "axisymmetric"
    exact = closed_form(elastic(model), widening)
    if ring:
        at, now = initial_position(points)[:, 0], points.position[:, 0]
    else:
        at, now = (np.hypot(*x.T) for x in (initial_position(points), points.position))

    def normal_traction(boundary: Implicit, radius: float) -> float:
        force = result.resultant(boundary.name)
        if ring:
            height = float(result.active.grid.cell_size[1])
            return float(force[0]) / (2.0 * math.pi * radius * height)
        return float(force.sum()) / (2.0 * radius)  # pressure times radius in both directions

    moved, volume = exact.radial_displacement(at), points.initial_volume
    squared_error = (now - at - moved) ** 2 @ volume / (moved**2 @ volume)
    # no point lies on the face: a parabola through those of the last two cells
    last = at > OUTER - 2.0 * float(result.active.grid.cell_size[0])
    parabola = np.polyfit(at[last] - OUTER, now[last] - at[last], 2)
    traction = 0.0
    for boundary in simulation.state.implicit:
        if boundary.name == "outer face":
            traction = normal_traction(boundary, OUTER + exact.outer_displacement)
    return Outcome(
        widening=widening,
        pressure=normal_traction(simulation.state.implicit[0], INNER + widening),
        outer_displacement=float(parabola[-1]),
        outer_traction=traction,
        displacement_error=math.sqrt(squared_error),
        exact=exact,
    )
