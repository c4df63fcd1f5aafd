# SPDX-License-Identifier: BSD-3-Clause
"""Consolidation of layers between a drain and a sealed top, against series at small strain.

The load is so small that the strain is. The series take the steps of backward Euler as the analysis
does, so that the difference is the error of the grid.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tilth.analysis.march import march_stages
from tilth.analysis.staged import StagedAnalysis
from tilth.analysis.step_result import StepResult
from tilth.arrays import Floats
from tilth.model import HenckyElastic, Model
from tilth_verification.cases import BASES, example, varied, with_basis
from tilth_verification.closed_forms import Moduli
from tilth_verification.closed_forms.consolidation import Layer, LayerOnDrain, TwoLayers
from tilth_verification.comparison import (
    Comparison,
    absolute,
    at_least,
    at_most,
    relative,
    vanishing,
)
from tilth_verification.consolidating import conductivity, consolidate
from tilth_verification.convergence import log_slope

PROBLEM = "terzaghi"
HEIGHT = 8.0
"""Of the clay [m]."""
LOAD = 1e-3
"""On its top [kPa]: a strain of 3e-7."""
DECLARED = 20.0
"""The load of case.toml [kPa]."""
LATE = 0.2
"""Time over H^2/c [-] at which most numbers are compared."""
SERIES = "Terzaghi's series"
DISCRETE = f"{SERIES} with steps of backward Euler"
SLOW, SOFT = 0.1, 2.0
"""Conductivity and modulus of the upper of two layers over those of the lower one [-]."""
FIRST = 0.01
"""First step times c over the square of the cell size [-]."""


def comparisons(long: bool) -> Iterator[Comparison]:
    """Bases and grids; in time; the first step; layers; compressible water; stages; 3D."""
    for basis in BASES:
        yield from grids(basis, (8, 16, 32) if long else (8, 16))
    yield from in_time()
    for basis in BASES:
        yield from first_step(basis)
    for basis in BASES if long else ("linear", "gimp"):
        yield from two_layers(basis, 16)
    yield from compressible()
    yield from undrained_stage()
    yield from in_space()


def column(cells: int, steps: int, time: float = LATE, load: float = LOAD) -> Model:
    """Returns the column of case.toml on a number of cells, under a small load.

    time: at the end, over H^2 / c.
    """
    size = HEIGHT / cells
    model = example(PROBLEM)
    end = time * closed_form(model).unit
    changes: dict[str, Any] = {
        "grid.cell_size": size,
        "bodies.0.shape.upper": [size, HEIGHT],
        "boundaries.1.at": size,
        "loads.0.start": [size, HEIGHT],
        "loads.0.pressure": load,
        "loads.0.factor": [[0.0, 1.0], [end, 1.0]],
        "schedule": {"end": end, "steps": steps},
        "analysis.tolerance": 1e-9,
        "track": [],
    }
    return varied(model, changes)


def closed_form(model: Model, storage: float = 0.0) -> LayerOnDrain:
    """Returns the series for a column, storage n/K_w [1/kPa]."""
    return LayerOnDrain(layer(model), storage)


def layer(model: Model) -> Layer:
    """Returns the clay of a model."""
    clay = model.materials["clay"]
    assert isinstance(clay, HenckyElastic)
    return Layer(HEIGHT, conductivity(model, "clay"), Moduli.of(clay).constrained)


def at_top(model: Model) -> tuple[float, ...]:
    """Returns the place at the sealed top [m], shape (dim,)."""
    return (*[0.0] * (model.dimension - 1), HEIGHT)


def isochrone(model: Model, time: float) -> tuple[Floats, Floats]:
    """Returns heights [m] and the excess pressure there by the series [kPa], shape (n,) each.

    For the column of case.toml.
    """
    exact, height = closed_form(model), np.linspace(0.0, HEIGHT, 101)
    return height, DECLARED * np.array([exact.pressure(z, time) for z in height])


def compared(model: Model, storage: float = 0.0) -> tuple[float, float, float, float]:
    """Returns pressure at the top over the load, and degree of consolidation, at the end.

    Each as computed, and as by the series with the same steps.
    """
    found, exact = consolidate(model, [at_top(model)]), closed_form(model, storage)
    area = model.cell_size[0] ** (model.dimension - 1)
    final = LOAD * HEIGHT / exact.layer.modulus
    pressure = float(found.pressure[-1][0]) / LOAD
    degree = float(found.settlement(area)[-1]) / final
    time, steps = found.time[-1], found.steps
    return (
        pressure, exact.pressure(HEIGHT, time, steps), degree, exact.settlement(time, steps)
    )  # fmt: skip


def grids(basis: str, cells: tuple[int, ...]) -> Iterator[Comparison]:
    """Pressure and degree of consolidation on some grids with a basis, and their orders."""
    errors: dict[str, list[float]] = {"pressure at the top": [], "degree of consolidation": []}
    for n in cells:
        pressure, exact, degree, exact_degree = compared(with_basis(column(n, 20), basis))
        for name, one, other in zip(errors, (pressure, degree), (exact, exact_degree), strict=True):
            errors[name].append(abs(one / other - 1.0))
            tolerance = 0.002 * (16 / n) ** 2
            yield relative(f"{name}, {basis}, {n} cells", one, other, tolerance, DISCRETE)
    for name, (coarse, *_, fine) in errors.items():
        quantity = f"order of the {name}, {basis}, {cells[0]} to {cells[-1]} cells"
        rate = log_slope(coarse, fine, cells[-1] / cells[0])
        yield absolute(quantity, rate, 2.0, 0.1, "linear elements")


def in_time() -> Iterator[Comparison]:
    """Without the error of the steps, by extrapolation from steps and half steps; its order."""
    found = [compared(column(16, steps)) for steps in (20, 40, 80)]
    exact = closed_form(example(PROBLEM))
    time = LATE * exact.unit
    quantities = (
        ("pressure at the top", 0, exact.pressure(HEIGHT, time)),
        ("degree of consolidation", 2, exact.settlement(time)),
    )
    for name, place, reference in quantities:
        first, coarse, fine = (each[place] for each in found)
        # first order, then second order of backward Euler
        value = (8.0 * fine - 6.0 * coarse + first) / 3.0
        quantity = f"{name}, gimp, 16 cells, extrapolated to small steps"
        yield relative(quantity, value, reference, 0.002, SERIES)
        rate = log_slope(abs(first - value), abs(fine - value), 4.0)
        quantity = f"order in time of the {name}, gimp, 20 to 80 steps"
        yield absolute(quantity, rate, 1.0, 0.1, "backward Euler")


def first_step(basis: str) -> Iterator[Comparison]:
    """Least and greatest pressure over the load after a first step much too short for the grid."""
    cells = 16
    model = with_basis(column(cells, 1, FIRST / cells**2), basis)
    found = consolidate(model, [at_top(model)])
    over, under = (0.02, 0.02) if basis == "linear" else (0.10, 0.05)
    of = f"after a step c dt = {FIRST:g} h^2, {basis}"
    source = "maximum principle"
    yield at_most(f"greatest pressure {of}", found.greatest[-1] / LOAD, 1.0, over, source)
    yield at_least(f"least pressure {of}", found.least[-1] / LOAD, 0.0, under, source)


def two_layers(basis: str, cells: int) -> Iterator[Comparison]:
    """A slower layer on the clay, each half of the height; the interface is a line of the grid."""
    model = with_basis(column(cells, 20), basis)
    entries = model.to_dict()
    clay, half, size = entries["materials"]["clay"], 0.5 * HEIGHT, HEIGHT / cells
    upper = clay | {
        "young_modulus": SOFT * clay["young_modulus"],
        "hydraulic_conductivity": SLOW * clay["hydraulic_conductivity"],
    }
    body = entries["bodies"][0]
    top = body | {
        "name": "upper", "material": "upper",
        "shape": {"type": "box", "lower": [0.0, half], "upper": [size, HEIGHT]},
    }  # fmt: skip
    changes: dict[str, Any] = {
        "materials.upper": upper,
        "bodies": [body, top],
        "bodies.0.shape.upper": [size, half],
        "bodies.0.surface": None,
        "loads.0.body": "upper",
    }
    model = varied(model, changes)
    below = layer(model)
    below = Layer(half, below.conductivity, below.modulus)
    exact = TwoLayers(below, Layer(half, SLOW * below.conductivity, SOFT * below.modulus))
    found = consolidate(model, [[0.0, half], [0.0, HEIGHT]])
    time, steps = found.time[-1], found.steps
    source = "series for two layers with steps of backward Euler"
    for name, place, number in (("interface", half, 0), ("top", HEIGHT, 1)):
        quantity = f"pressure at the {name} of two layers, {basis}, {cells} cells"
        value = float(found.pressure[-1][number]) / LOAD
        yield relative(quantity, value, exact.pressure(place, time, steps), 0.005, source)
    final = LOAD * half * (1.0 + 1.0 / SOFT) / below.modulus
    degree = float(found.settlement(size)[-1]) / final
    quantity = f"degree of consolidation of two layers, {basis}, {cells} cells"
    yield relative(quantity, degree, exact.settlement(time, steps), 0.005, source)


def compressible() -> Iterator[Comparison]:
    """Water as stiff as the soil: the pressure right after the load, and later."""
    bulk, porosity = 8000.0, 0.5
    storage = porosity / bulk
    exact = closed_form(example(PROBLEM), storage)
    end = 0.1 * exact.unit
    changes: dict[str, Any] = {"flow.bulk_modulus": bulk, "schedule.end": end}
    for steps, name in ((1, "at once"), (20, "at T = 0.1")):
        model = varied(column(16, steps), changes)
        if steps == 1:
            model = varied(model, {"schedule.end": 1e-5 * exact.unit})
        found = consolidate(model, [at_top(model)])
        value = float(found.pressure[-1][0]) / LOAD
        reference = exact.pressure(HEIGHT, found.time[-1], found.steps)
        quantity = f"pressure at the top, compressible water, {name}, gimp, 16 cells"
        yield relative(quantity, value, reference, 0.002, DISCRETE)


def undrained_stage() -> Iterator[Comparison]:
    """The load comes in a stage in which no water flows; then it flows."""
    entries = column(16, 20).to_dict()
    schedule = entries.pop("schedule")
    entries["loads"][0].pop("factor")  # grows over its stage, then stays
    entries["stages"] = [
        {"name": "fill", "flow": False, "schedule": {"end": 1.0, "steps": 2}},
        {"name": "rest", "schedule": schedule},
    ]
    pressure: list[Floats] = []

    def after_step(analysis: StagedAnalysis, result: StepResult) -> None:
        water = analysis.simulation.state.pore_pressure
        assert water is not None
        pressure.append(water.value[:, 0] / LOAD)

    model = Model.from_dict(entries)
    march_stages(model, after_step)
    worst = float(np.abs(pressure[1] - 1.0).max())
    quantity = "largest difference of the pressure from the load after a stage without flow"
    yield vanishing(quantity, worst, 1e-6, "no water leaves")
    end, exact = float(schedule["end"]), closed_form(model)
    reference = exact.pressure(HEIGHT, end, [end / 20] * 20)
    quantity = "pressure at the top, gimp, 16 cells, after a stage without flow"
    yield relative(quantity, float(pressure[-1].max()), reference, 0.002, DISCRETE)


def in_space() -> Iterator[Comparison]:
    """The same column in 3D, with the bases linear and CPDI1."""
    file = "three_dimensional.toml"
    flat = column(8, 20)
    for basis in ("linear", "cpdi1"):
        changes = {
            "schedule": {"end": flat.schedule.end, "steps": 20},
            "loads.0.pressure": LOAD,
            "analysis.tolerance": 1e-9,
            "track": [],
        }
        model = with_basis(varied(example(PROBLEM, file), changes), basis)
        pressure, exact, degree, exact_degree = compared(model)
        quantity = f"pressure at the top, 3D, {basis}, 8 cells"
        yield relative(quantity, pressure, exact, 0.008, DISCRETE)
        quantity = f"degree of consolidation, 3D, {basis}, 8 cells"
        yield relative(quantity, degree, exact_degree, 0.008, DISCRETE)
