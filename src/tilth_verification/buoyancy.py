# SPDX-License-Identifier: BSD-3-Clause
"""Soil in water at rest: columns in closed form, a slope, a drawdown, a wet rotation."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import initial_position, march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth.mpm.wet_mass import effective_stress, total_stress
from tilth_verification.cases import example, varied
from tilth_verification.closed_forms import WetColumn
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.convergence import log_slope
from tilth_verification.self_weight_column import BASES, GIMP, HEIGHT, with_cells

PROBLEM = "buoyancy"
CLOSED_FORM = "closed form"
UNIT_WEIGHT, DENSITY, SATURATED, GRAVITY, MODULUS = 300.0, 80.0, 90.0, 10.0, 1e4
"""Of the columns of `self_weight_column` in water: buoyant unit weight 600 instead of 800 dry."""
LEVELS = {
    "above it": 60.0,
    "at a grid line": 12.5,
    "between grid lines": 18.77,
    "in the lowest cells": 7.3,
}
KINDS = {
    "plane strain": "case.toml",
    "axisymmetric": "axisymmetric.toml",
    "3D": "three_dimensional.toml",
}
RAMP = [[0.0, 0.0], [1.0, 1.0]]


def comparisons(long: bool) -> Iterator[Comparison]:
    """Columns for any level, basis and kind; slope; drawdown; rotation."""
    yield from columns((16, 32, 64, 128) if long else (16, 32))
    yield from under_water()
    yield from drawdown()
    yield from turned()


def columns(grids: tuple[int, ...]) -> Iterator[Comparison]:
    """A column compressed to half its height, its foot in water, against its closed form."""
    for name, level in LEVELS.items():
        error = {cells: column("case.toml", cells, level)[0] for cells in grids}
        quantity = f"effective vertical stress error, level {name}, {grids[-1]} cells"
        yield vanishing(quantity, error[grids[-1]], 1.6e-3, CLOSED_FORM)
        rate = log_slope(error[grids[0]], error[grids[-1]], grids[-1] / grids[0])
        quantity = f"order of this error, {grids[0]} to {grids[-1]} cells"
        yield at_least(quantity, rate, 1.0, 0.0, "first order at least")
    for kind, file in KINDS.items():
        for basis in (GIMP, "CPDI1", "CPDI2"):
            _, height, exact = column(file, 16, LEVELS["between grid lines"], basis)
            quantity = f"final height, level between grid lines, {kind}, {basis}, 16 cells"
            yield relative(quantity, height, exact, 3e-3, CLOSED_FORM, "m")


def column(
    file: str, cells: int, level: float, basis: str = GIMP, **changes: Any
) -> tuple[float, float, float]:
    """Compresses a column of `self_weight_column` in water.

    Returns the mean error of its vertical effective stress over that at the base, its height and
    its exact height [m].
    """
    model = with_cells(varied(example("self_weight_column", file), BASES[basis] | changes), cells)
    points = march(in_water(model, level)).state.points
    exact = WetColumn(HEIGHT, MODULUS, DENSITY * GRAVITY, SATURATED * GRAVITY - UNIT_WEIGHT, level)
    up, volume = model.dimension - 1, points.initial_volume
    stress = exact.vertical_stress(initial_position(points)[:, up])
    error = np.abs(points.stress[:, up] - stress) @ volume / (exact.base_stress * volume.sum())
    height = (points.position[:, up] + points.half_length[:, up]).max()
    return float(error), float(height), exact.final_height


def in_water(model: Model, level: float) -> Model:
    """Returns a column in water whose unit weight grows as the body force does."""
    water = {"level": level, "unit_weight": UNIT_WEIGHT, "factor": RAMP}
    return varied(model, {"water": water, "materials.soil.saturated_density": SATURATED})


def under_water() -> Iterator[Comparison]:
    """A slope of yielding soil under water moves as a dry one of its buoyant weight does."""
    wet = example(PROBLEM)
    assert wet.water is not None
    soil = wet.materials["soil"]
    assert soil.saturated_density is not None
    buoyant = soil.saturated_density - wet.water.unit_weight / GRAVITY
    changes: dict[str, Any] = {"water": None, "materials.soil.saturated_density": None, "track": []}
    changes |= {"materials.soil.density": buoyant, "output.colour_by": None}
    one, other = march(wet).state.points, march(varied(wet, changes)).state.points
    order = other.index_of(one.point_id)
    apart = np.abs(one.displacement - other.displacement[order]).max()
    quantity = "displacement under water less that of the dry slope, over the greatest one"
    size = float(np.abs(other.displacement).max())
    yield vanishing(quantity, float(apart) / size, 1e-9, "dry slope with the buoyant weight")
    quantity = "points that yield under water, share"
    yield at_least(quantity, float((one.plastic[:, 0] > 0.0).mean()), 0.05, 0.0, "not only elastic")


def drawdown() -> Iterator[Comparison]:
    """The base of a layer carries its weight, moist above the level and buoyant below it."""
    model = example(PROBLEM, "drawdown.toml")
    errors: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        wet = min(5.0 - 3.7 * time, 4.0)
        weight = 2.0 * (10.0 * wet + 18.0 * (4.0 - wet))
        errors.append(abs(float(result.resultant("base")[1]) / weight - 1.0))

    march(model, after_step)
    quantity = f"load on the base while the water falls, worst of {len(errors)} levels"
    yield vanishing(quantity, max(errors), 1e-6, "weight less buoyancy")


def turned() -> Iterator[Comparison]:
    """The effective stress turns with the soil; the pore pressure is that of the place."""
    model = example(PROBLEM, "wet_rotation.toml")
    simulation = march(model)
    points, end = simulation.state.points, model.schedule.end
    given = np.array([-60.0, -20.0, -30.0, -8.0, 0.0, 0.0])
    effective = effective_stress(points)
    error = np.abs(effective - given).max() / 60.0
    yield vanishing("effective stress of a block turned by 90 degrees", float(error), 1e-12, "turn")
    pressure = 10.0 * np.maximum(level_of(points.position[:, 0]) - points.position[:, 1], 0.0)
    excess = total_stress(points, simulation.setup.water, end) - effective
    error = np.abs(excess[:, :3] + pressure[:, None]).max() / pressure.max()
    yield vanishing("pore pressure where it is then", float(error), 1e-12, "depth below the level")


def level_of(x: Floats) -> Floats:
    """Returns the level of the water of the wet rotation [m], shape (n,)."""
    return np.asarray(np.interp(x, [-2.0, 0.5, 4.0], [1.2, 1.7, 2.4]))
