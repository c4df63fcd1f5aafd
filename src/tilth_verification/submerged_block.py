# SPDX-License-Identifier: BSD-3-Clause
"""Buoyancy: water on a spline lifts a body by the weight of the water that it displaces."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.curves import LocalCubicSpline
from tilth.model import Circle, Model, SurfaceLoad
from tilth.mpm.active_grid import Buffers, locate
from tilth.surface.loads import SurfaceLoads, declared_loads
from tilth.surface.tracked import TrackedSurface
from tilth_verification.cases import example, varied
from tilth_verification.comparison import Comparison, at_least, vanishing

PROBLEM = "submerged_block"
SOURCE = "Archimedes"
ROUND_OFF = 1e-13
"""Error of forces that the quadrature integrates exactly, relative to the buoyancy."""
POSITIONS = 25
"""Number of positions of the grid, from a reproducible sequence."""
LEVELS = 60
"""Number of water levels over the cylinder, likewise."""
NO_CHANGES: Mapping[str, Any] = MappingProxyType({})


def comparisons(long: bool) -> Iterator[Comparison]:
    """A block under water, fixed and pulled through the grid; water rising past a cylinder.

    The block's water is a load on its surface or declared by its level.
    """
    yield from anywhere_over_the_grid()
    yield from pulled(24)
    if long:
        yield from pulled(96)
        yield from pulled(96, 3)
    yield from by_level()
    yield from rising_water()
    yield from level_inside_segments((0.1, 0.05, 0.025, 0.0125) if long else (0.1, 0.025))


def anywhere_over_the_grid() -> Iterator[Comparison]:
    """Force of the water on the undeformed block against its area, for any position of the grid."""
    worst = 0.0
    for share in positions(POSITIONS, 2):
        origin = (0.25 * share).tolist()
        simulation = Simulation(varied(example(PROBLEM), {"grid.origin": origin}))
        buoyancy = unit_weight(simulation.setup.model) * enclosed(simulation, "block")
        error = water(simulation, 1.0) - [0.0, buoyancy]
        worst = max(worst, float(np.abs(error).max()) / buoyancy)
    quantity = f"force of water on the block less its buoyancy, worst of {POSITIONS} positions"
    yield vanishing(quantity, worst, ROUND_OFF, SOURCE)


def pulled(steps: int, points_per_cell: int = 6) -> Iterator[Comparison]:
    """The block is pulled 2 m down over 8 cells and loses 3 % of its area on its way.

    Where the surface crosses an empty cell it moves with the nearest filled one, and not exactly
    with the adjacent pieces: the force in equilibrium is that on a curve with gaps. More points
    give fewer such gaps.
    """
    changes = {"schedule.steps": steps, "bodies.0.points_per_cell": points_per_cell}
    model = varied(example(PROBLEM), changes)
    gravity, gamma = 10.0, unit_weight(model)
    rows: list[tuple[float, float, float, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        if time < 0.5 - 1e-9:
            return  # water and weight are not complete yet
        volume = simulation.state.points.volume.sum()
        weight = gravity * simulation.state.points.initial_volume.sum()  # density 1
        area = enclosed(simulation, "block")
        x, y = water(simulation, time) / (gamma * area)
        carried = np.array([0.0, weight]) - result.resultant("handle")
        error = np.abs(carried / (gamma * area) - [0.0, 1.0]).max()
        rows.append((max(abs(x), abs(y - 1.0)), error, area / volume - 1.0, area))

    march(model, after_step)
    gaps = 1e-4 if points_per_cell > 3 else 2e-3
    remade, carried, tracking, area = np.abs(rows).T
    at = f"{points_per_cell}^2 points a cell, worst of {len(rows)} steps"
    quantity = f"force of water on the moved spline less gamma times its area, {at}"
    yield vanishing(quantity, float(remade.max()), ROUND_OFF, SOURCE)
    quantity = f"force in equilibrium with handle and weight less gamma times the area, {at}"
    yield vanishing(quantity, float(carried.max()), gaps, SOURCE)
    quantity = f"area in the spline over that of the material less 1, {at}"
    yield vanishing(quantity, float(tracking.max()), 5e-4, "the surface stays on the material")
    quantity = "area lost on the way"
    yield at_least(quantity, float(1.0 - area[-1] / area[0]), 0.02, 0.0, "pressure over stiffness")


def by_level() -> Iterator[Comparison]:
    """The block in water that is declared by its level: no surface, and no error of one.

    The stress of the soil is then the effective one, and the water does not compress the block: it
    is lifted by its whole volume. A block stiff enough not to be compressed has the same reactions
    with both.
    """
    model = example(PROBLEM, "water_level.toml")
    factor, lift, volumes = handle(model)
    weight, buoyancy = lift[:, 1] - factor * 10.0 * volumes[0], 10.0 * volumes[0]
    quantity = f"water level: handle less weight and buoyancy, worst of {len(lift)} steps"
    expected = -factor[:, None] * np.column_stack([0.0 * volumes, 10.0 * volumes])
    error = float(np.abs(np.column_stack([lift[:, 0], weight]) - expected).max())
    yield vanishing(quantity, error / buoyancy, 1e-9, SOURCE)
    stiff = {"materials.foam.young_modulus": 5e6, "materials.foam.density": 1.5}
    forces = [
        handle(varied(example(PROBLEM, file), stiff))[1]
        for file in ("case.toml", "water_level.toml")
    ]
    quantity = "handle of a stiff block: water level less load on the surface, over the buoyancy"
    yield vanishing(quantity, float(np.abs(forces[1] - forces[0]).max()) / buoyancy, 1e-4, SOURCE)


def handle(model: Model) -> tuple[Floats, Floats, Floats]:
    """Returns the factor of weight and water, the force of the handle and the volume by step.

    Shapes (steps,), (steps, 2) and (steps,) [-, force, length^2].
    """
    rows: list[tuple[float, Floats, float]] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        volume = float(simulation.state.points.volume.sum())
        rows.append((min(time / 0.5, 1.0), result.resultant("handle"), volume))

    march(model, after_step)
    factor, force, volume = zip(*rows, strict=True)
    return np.array(factor), np.array(force), np.array(volume)


def rising_water() -> Iterator[Comparison]:
    """The reaction of the wire at every level against the closed form of a cylinder's buoyancy."""
    model = example(PROBLEM, "rising_water.toml")
    errors: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        force = result.resultant("wire") / unit_weight(model)
        exact = wet_area(model, 0.25 + 1.5 * time)
        errors.append(float(np.abs(-force - [0.0, exact]).max()) / whole_area(model))

    march(model, after_step)
    quantity = f"force on the cylinder in rising water, worst of {len(errors)} levels"
    yield vanishing(quantity, max(errors), 1e-4, SOURCE)


def level_inside_segments(spacings: tuple[float, ...]) -> Iterator[Comparison]:
    """The kink of the pressure at the water level lies inside a segment of the spline.

    Mean square error of the buoyancy over levels and positions of the grid, for distances of the
    boundary points down to a twentieth of a cell.
    """
    error = [kink_error(spacing) for spacing in spacings]
    quantity = f"RMS error of the cylinder's buoyancy, level anywhere, spacing {spacings[0]:g} m"
    yield vanishing(quantity, error[0], 2e-5, SOURCE)
    order = math.log(error[0] / error[-1]) / math.log(spacings[0] / spacings[-1])
    quantity = f"order of this error, spacing {spacings[0]:g} to {spacings[-1]:g} m"
    yield at_least(quantity, order, 1.7, 0.0, "second order: a kink inside a piece")


def kink_error(spacing: float) -> float:
    """Returns the RMS over levels of the error of the buoyancy over that of the whole cylinder."""
    errors = []
    for share, *shift in positions(LEVELS, 3):
        level = 0.9 + 0.6 * (1.8 * share - 0.9)
        origin = [1.0 + 0.25 * shift[0], 0.25 * shift[1]]
        changes = {
            "grid.origin": origin,
            "boundaries.0.at": origin[0],  # on a grid line; without effect here
            "bodies.0.surface.spacing": spacing,
            "loads.0.hydrostatic.level": level,
        }
        simulation = Simulation(varied(example(PROBLEM, "rising_water.toml"), changes))
        model = simulation.setup.model
        lift = water(simulation, 1.0)[1] / unit_weight(model)
        errors.append((lift - wet_area(model, level)) / whole_area(model))
    return float(np.sqrt(np.mean(np.square(errors))))


def water(simulation: Simulation, time: float) -> Floats:
    """Returns the force of the water on a body at its current surface [force], shape (2,)."""
    active = locate(simulation.state.points, simulation.state.grid, Buffers())
    loads = SurfaceLoads(
        declared_loads(simulation.setup.model),
        simulation.setup.kind,
        simulation.state.surfaces,
        active,
        time,
        time,
    )
    return np.asarray(loads.force_before().sum(axis=0))


def enclosed(simulation: Simulation, body: str) -> float:
    """Returns the area inside the spline around a body [length^2]."""
    surface = simulation.state.surfaces[body]
    assert isinstance(surface, TrackedSurface)
    return LocalCubicSpline(surface.chains[0].current).area


def unit_weight(model: Model) -> float:
    """Returns the unit weight of the water [force/length^3]."""
    load = model.loads[0]
    assert isinstance(load, SurfaceLoad)
    assert load.hydrostatic is not None
    return load.hydrostatic.unit_weight


def wet_area(model: Model, level: float) -> float:
    """Returns the area of the circle below a level [length^2]."""
    circle = model.bodies[0].shape
    assert isinstance(circle, Circle)
    height = min(max((level - circle.centre[1]) / circle.radius, -1.0), 1.0)
    segment = math.pi - math.acos(height) + height * math.sqrt(1.0 - height**2)
    return circle.radius**2 * segment


def whole_area(model: Model) -> float:
    """Returns the area of the circle [length^2]."""
    return wet_area(model, math.inf)


def positions(number: int, dim: int) -> Floats:
    """Returns points that fill the unit cube evenly, shape (number, dim).

    Kronecker's sequence of the roots of 2, 3 and 5.
    """
    step = np.sqrt([2.0, 3.0, 5.0])[:dim]
    return np.asarray(np.modf((1.0 + np.arange(number))[:, None] * step)[0])
