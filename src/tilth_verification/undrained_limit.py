# SPDX-License-Identifier: BSD-3-Clause
"""Flowing water that has no time to flow, against the law with a pore fluid, and limit loads."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import march
from tilth.analysis.simulation import Simulation
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import Model
from tilth.model.laws import EXCESS_PORE_PRESSURE
from tilth.mpm.points import MaterialPoints
from tilth.mpm.pore_water import PRESSURE
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.comparison import Comparison, at_least, relative, vanishing
from tilth_verification.consolidating import Consolidation, consolidate, number
from tilth_verification.convergence import log_slope
from tilth_verification.strip_footing import HALF_WIDTH, LIMIT, TOLERANCE

PROBLEM = "undrained_limit"
FLUID = "the same with `pore_fluid_bulk_modulus`"
EFFECTIVE = 40.0
"""Isotropic effective stress at the start of mohr_coulomb.toml [kPa]."""
PLATEAU = 0.01
"""Largest fall of the load from its peak to the end, over the peak [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """A block that yields, with all bases; a strip footing without and with friction."""
    for basis in BASES:
        yield from block(basis)
    yield from footing("case.toml", "no friction", (0.25, 0.125, 0.0625))
    for size in (0.125, 0.0625) if long else (0.125,):
        yield from footing("mohr_coulomb.toml", "friction", (size,))
    yield drained()


def without_flow(model: Model) -> Model:
    """Returns the model whose law has the water, which cannot flow: K_f = K_w / n."""
    assert model.flow is not None
    assert model.flow.bulk_modulus is not None
    changes: dict[str, Any] = {
        "flow": None,
        "materials.soil.hydraulic_conductivity": None,
        "materials.soil.porosity": None,
        "materials.soil.pore_fluid_bulk_modulus": model.flow.bulk_modulus
        / number(model, "soil", "porosity"),
    }
    return varied(model, changes)


def forces(model: Model, boundary: str) -> tuple[MaterialPoints, Floats]:
    """Returns points at the end and forces along y on a boundary, (steps,)."""
    force: list[float] = []

    def after_step(simulation: Simulation, result: StepResult, time: float) -> None:
        force.append(float(result.resultant(boundary)[1]))

    points = march(model, after_step).state.points
    return points, np.array(force)


def block(basis: str) -> Iterator[Comparison]:
    """Excess pressure and force at the end of a compression far into yield."""
    model = with_basis(example(PROBLEM, "block.toml"), basis)
    with_flow = consolidate(model, [], "plate")
    points, force_with_fluid = forces(without_flow(model), "plate")
    excess = points.state_variable(EXCESS_PORE_PRESSURE)
    assert with_flow.points is not None
    found = with_flow.points.water[:, PRESSURE]
    of = f"block, {basis}"
    yield relative(f"excess pressure, {of}", float(found.mean()), float(excess.mean()), 1e-3, FLUID)
    force = float(with_flow.force[-1][1])
    yield relative(f"force on the plate, {of}", force, force_with_fluid[-1], 1e-3, FLUID)


def footing(file: str, name: str, sizes: tuple[float, ...]) -> Iterator[Comparison]:
    """Limit load over the undrained strength with cells of some sizes, and with the law's fluid."""
    differences = []
    for size in sizes:
        model = varied(example(PROBLEM, file), {"grid.cell_size": size, "track": []})
        strength = undrained_strength(model)
        found = consolidate(model, [], "footing")
        load = pressures(found) / strength
        of = f"{name}, h {size:g} m"
        yield relative(
            f"greatest P / s_u, {of}", load.max(), LIMIT, TOLERANCE * size / 0.1, "2 + pi"
        )
        fall = 1.0 - float(load[-1] / load.max())
        yield vanishing(f"fall of P from its peak to the end, {of}", fall, PLATEAU, "a limit load")
        other = float(-forces(without_flow(model), "footing")[1].min()) / HALF_WIDTH / strength
        differences.append(abs(float(load.max()) - other))
        quantity = f"difference of the greatest P / s_u, {of}"
        yield vanishing(quantity, differences[-1], 0.2 * size / 0.1, FLUID)
    if len(sizes) > 1:
        rate = log_slope(differences[0], differences[-1], sizes[0] / sizes[-1])
        quantity = f"order of this difference, {name}, h {sizes[0]:g} to {sizes[-1]:g} m"
        yield at_least(quantity, rate, 0.8, 0.0, "first order")


def drained() -> Comparison:
    """The other limit: water that flows at once leaves the load of the dry analysis."""
    at_surface = {"name": "surface", "type": "plane", "axis": "y", "at": 1.5}
    changes: dict[str, Any] = {
        "grid.cell_size": 0.25,
        "materials.soil.hydraulic_conductivity": 1e6,
        "flow.boundaries": [at_surface | {"condition": "drained"}],
        "track": [],
    }
    model = varied(example(PROBLEM, "mohr_coulomb.toml"), changes)
    wet = pressures(consolidate(model, [], "footing"))
    dry: dict[str, Any] = {
        "flow": None,
        "materials.soil.hydraulic_conductivity": None,
        "materials.soil.porosity": None,
    }
    _, force = forces(varied(model, dry), "footing")
    worst = float(np.abs(wet + force / HALF_WIDTH).max() / wet.max())
    quantity = "largest difference of P from the dry analysis over P, friction, drained, h 0.25 m"
    return vanishing(quantity, worst, 1e-3, "the analysis without water")


def undrained_strength(model: Model) -> float:
    """Returns s_u = c cos(phi) + s' sin(phi) [kPa], s' the mean effective stress in the plane."""
    phi = math.radians(number(model, "soil", "friction_angle"))
    stress = EFFECTIVE if model.initial.stress else 0.0
    return number(model, "soil", "cohesion") * math.cos(phi) + stress * math.sin(phi)


def pressures(found: Consolidation) -> Floats:
    """Returns the pressure under the footing after each step [kPa]."""
    return np.asarray(-np.array(found.force)[:, 1] / HALF_WIDTH)
