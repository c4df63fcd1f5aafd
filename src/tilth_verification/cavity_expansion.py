# SPDX-License-Identifier: BSD-3-Clause
"""Cavities enlarged in clay and in sand: the pressure on their wall."""

from __future__ import annotations

import math
from collections.abc import Iterator

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.model import (
    Box,
    CircleGeometry,
    GivenStress,
    ImplicitBoundary,
    Model,
    MohrCoulomb,
    PlaneGeometry,
    Tresca,
)
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import CavityInClay, CylinderInSoil, Moduli
from tilth_verification.comparison import Comparison, relative

PROBLEM = "cavity_expansion"
FIRST = 1.5
"""Ratio of the wall's radii, now and at the start, from which on a cylinder is compared [-]."""
FIRST_OF_SPHERE = 2.0
"""The same of the sphere, whose cavity has a radius of two cells at the start."""
OF_LIMIT, IN_CLAY, IN_SAND = 0.02, 0.01, 0.005
"""Tolerances: of the limit pressure, which a finite expansion does not reach; on the way."""
CYLINDER, SPHERE = "case.toml", "sphere.toml"


def comparisons(long: bool) -> Iterator[Comparison]:
    """Cylinder and sphere in clay, on the way and at the end; cylinder in sand; other bases."""
    yield from in_clay(example(PROBLEM, CYLINDER))
    yield from in_clay(example(PROBLEM, SPHERE))
    for dilation in (10.0, 0.0, 30.0):
        yield from in_sand(dilation)
    if long:
        for basis in BASES:
            fine = with_basis(with_cells(example(PROBLEM, CYLINDER), 0.125), basis)
            yield from in_clay(fine, f", {basis}, h 0.125 m")
        yield from in_clay(varied(example(PROBLEM, SPHERE), {"grid.cell_size": 0.25}), ", h 0.25 m")


def in_clay(model: Model, at: str = "") -> Iterator[Comparison]:
    """The worst pressure on the way and the last one, against closed forms of unbounded clay."""
    clay = model.materials["clay"]
    assert isinstance(clay, Tresca)
    is_sphere = wall_of(model).radius_change is not None
    shape, first = ("sphere", FIRST_OF_SPHERE) if is_sphere else ("cylinder", FIRST)
    exact = CavityInClay(is_sphere, Moduli.of(clay).shear, clay.undrained_shear_strength)
    curve = enlarge(model)
    on_the_way = {ratio: p for ratio, p in curve.items() if ratio > first}
    worst = max(on_the_way, key=lambda ratio: abs(on_the_way[ratio] / exact.pressure(ratio) - 1.0))
    quantity = f"pressure, {shape} in clay, radius {worst:.3g} times, the worst{at}"
    source = "incompressible clay"
    yield relative(quantity, curve[worst], exact.pressure(worst), IN_CLAY, source, "Pa")
    last = max(curve)
    quantity = f"pressure, {shape} in clay, radius {last:.3g} times{at}"
    source = "limit pressure"
    yield relative(quantity, curve[last], exact.limit_pressure, OF_LIMIT, source, "Pa")


def in_sand(dilation: float) -> Iterator[Comparison]:
    """The pressure at 1.5, 2 and 3 times the first radius, by the angle of dilation [degrees]."""
    change = {"materials.sand.dilation_angle": dilation}
    model = varied(example(PROBLEM, "sand.toml"), change)
    sand, at_rest = model.materials["sand"], model.initial.stress[0]
    box = model.bodies[0].shape
    assert isinstance(sand, MohrCoulomb)
    assert isinstance(at_rest, GivenStress)
    assert isinstance(box, Box)
    inner = wall_radius(model)
    exact = CylinderInSoil(inner, box.upper[0], -at_rest.stress[0], sand)
    curve = enlarge(model)
    for wanted in (FIRST, 2.0, 3.0):
        ratio = min(curve, key=lambda ratio: abs(ratio - wanted))
        quantity = f"pressure, cylinder in sand, psi {dilation:g} degrees, radius {ratio:.3g} times"
        pressure = exact.pressure(ratio * inner)
        yield relative(quantity, curve[ratio], pressure, IN_SAND, "rings of sand", "Pa")


def enlarge(model: Model) -> dict[float, float]:
    """Enlarges the cavity of a model; returns radius over the first one -> pressure [stress]."""
    wall, first, height = wall_of(model), wall_radius(model), float(model.cell_size[1])
    curve: dict[float, float] = {}

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        factor = model.load_curve(wall).factor(time)
        force = result.resultant(wall.name)
        if wall.radius_change is not None:
            radius = first + wall.radius_change * factor
            pressure = force[1] / (math.pi * radius**2)  # of the upper half
        else:
            assert wall.displacement is not None
            radius = first + wall.displacement["x"] * factor
            pressure = force[0] / (2.0 * math.pi * radius * height)
        curve[radius / first] = float(pressure)

    march(model, after_step)
    return curve


def wall_of(model: Model) -> ImplicitBoundary:
    """Returns the boundary that enlarges the cavity."""
    return next(b for b in model.boundaries if isinstance(b, ImplicitBoundary))


def wall_radius(model: Model) -> float:
    """Returns the cavity's radius at the start [length]."""
    geometry = wall_of(model).geometry
    if isinstance(geometry, CircleGeometry):
        return geometry.radius
    assert isinstance(geometry, PlaneGeometry)
    return geometry.point[0]


def with_cells(model: Model, size: float) -> Model:
    """Returns the cylinder's strip with cells of this size, one high, and two points in each."""
    box = model.bodies[0].shape
    assert isinstance(box, Box)
    inner, outer = box.lower[0], box.upper[0]
    changes = {
        "grid.cell_size": size,
        "grid.origin": [inner - 0.3 * size, 0.0],
        "bodies.0.shape.upper": [outer, size],
        "bodies.0.points": [round(2.0 * (outer - inner) / size), 2],
        "boundaries.2.at": size,
        "loads.0.end": [outer, size],
    }
    return varied(model, changes)
